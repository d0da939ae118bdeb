"""What a stopped command prints: what is kept, and the command that resumes it."""

from __future__ import annotations

import shlex
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rvjax.cli._app import Terminated
from rvjax.cli._output import Output, say
from rvjax.errors import IncompleteError


@contextmanager
def resumable(
    words: Sequence[str], values: Sequence[str], output: Output, more: Sequence[str] = ()
) -> Iterator[Callable[[Path], None]]:
    """Prints the time of what runs inside, or where it is stopped the command that resumes it. Gives the function to call with
    the run folder. words: the command and its file; values: those of --set; more: further options."""
    started = time.monotonic()
    folders: list[Path] = []
    try:
        yield folders.append
    except (KeyboardInterrupt, Terminated, IncompleteError):
        if folders:
            sets = [word for value in values for word in ("--set", value)]
            command = ["rvjax", *words, "--out", str(folders[0]), *sets, *more]
            say(f"stopped; what was flown is kept in {folders[0]}. Resume with\n  {shlex.join(command)}", sys.stderr)
            output.document({"stopped": str(folders[0]), "go_on_with": command})
        raise
    output.note(f"done in {time.monotonic() - started:.0f} s")
