"""A notebook without a browser: it keeps and executes cells as IPython does, each statement for itself."""

from __future__ import annotations

import ast
import linecache
import sys
from types import ModuleType
from typing import Any

import pytest


class Notebook:
    """A notebook, whose module is in `sys.modules` until the test ends."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.module = ModuleType("notebook_of_a_test")
        monkeypatch.setitem(sys.modules, self.module.__name__, self.module)
        self._monkeypatch, self._cells = monkeypatch, 0

    def run_cell(self, text: str, *, kept: bool = True) -> dict[str, Any]:
        """Executes a cell; returns the names of the notebook. kept: whether its source is in `linecache`."""
        self._cells += 1
        name = f"<ipython-input-{self._cells}>"
        if kept:
            self.keep(name, text)
        for statement in ast.parse(text, name).body:
            exec(compile(ast.Module([statement], []), name, "exec"), vars(self.module))
        return vars(self.module)

    def keep(self, name: str, text: str) -> None:
        """Keeps the source of a cell as IPython does."""
        self._monkeypatch.setitem(linecache.cache, name, (len(text), None, text.splitlines(keepends=True), name))
