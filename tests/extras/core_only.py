"""Runs commands in this process, from which the packages of the extras are hidden, and prints how they ended.

    python -m tests.extras.core_only PACKAGE... < commands.json

stdin: a list of command lines. stdout: for each, exit code, stdout and stderr. Without a PACKAGE nothing is hidden.
"""

from __future__ import annotations

import io
import json
import sys
from collections.abc import Iterable
from contextlib import redirect_stderr, redirect_stdout
from importlib.machinery import ModuleSpec, PathFinder
from importlib.metadata import Distribution
from typing import Any

HIDDEN = frozenset(sys.argv[1:])


class Core(PathFinder):
    """Finds what is installed, without the hidden packages."""

    @classmethod
    def find_spec(cls, fullname: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        return None if fullname.partition(".")[0] in HIDDEN else super().find_spec(fullname, path, target)

    @classmethod
    def find_distributions(cls, *arguments: Any, **named: Any) -> Iterable[Distribution]:
        return (each for each in super().find_distributions(*arguments, **named) if each.metadata["Name"] not in HIDDEN)


def ended(words: list[str]) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of a command."""
    from rvjax.cli import main

    out, err = io.StringIO(), io.StringIO()
    sys.argv = ["rvjax", *words]
    with redirect_stdout(out), redirect_stderr(err):
        try:
            main()
        except SystemExit as end:
            return int(end.code or 0), out.getvalue(), err.getvalue()


if __name__ == "__main__":
    sys.meta_path[sys.meta_path.index(PathFinder)] = Core
    print(json.dumps([ended(words) for words in json.load(sys.stdin)]))
