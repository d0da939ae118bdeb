"""The Python file that a component object stands for: the file of its module, or the notebook cell that made it.

A notebook keeps the source of each cell in `linecache`. This source is the file `./cell_<8 digits of its SHA-256>.py`.
"""

from __future__ import annotations

import ast
import inspect
import linecache
import os
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from rvjax.campaign.python_files import PythonFile, read_cell, read_file
from rvjax.errors import UsageError

_WRITE = "a notebook writes a file with %%writefile my_law.py"
_FOUND = "an IPython command"
_COMMAND = ("%", "!", "?")
_SHELL = "get_ipython"
"""The function that IPython calls in the source of a cell where the user has written a command."""


def file_of(component: Any) -> PythonFile:
    """The file of a component object, with its name in it. Errors: UsageError where there is none; CampaignError where it cannot
    be read."""
    made_in, module = _origin(component)
    names = [name for name, value in vars(module).items() if value is component] if module is not None else []
    path = getattr(module, "__file__", None)
    if (path is None or os.path.realpath(path) != os.path.realpath(made_in)) and (cell := _cell(made_in)):
        return read_cell(cell, _name_in(cell, names, component), Path.cwd())
    if path is None or not names or not Path(path).exists():
        raise UsageError(
            f"a component of {component.family} that is in no Python file and no notebook cell: a run could not keep its code; "
            f"accepted: a component from a file or a cell; {_WRITE}"
        )
    file = read_file(f"{path}:{names[0]}")
    return PythonFile(f"./{file.file}:{names[0]}", file.file, names[0], file.folder, file.sources)


def _origin(component: Any) -> tuple[str, ModuleType | None]:
    """(file, module) of the code that made a component; of its first function where that is not noted."""
    if hasattr(component, "made_in"):
        made_in, name = component.made_in
        return made_in, sys.modules.get(name)
    functions = [value for value in getattr(component, "__dict__", {}).values() if inspect.isfunction(value)]
    return (functions[0].__code__.co_filename, sys.modules.get(functions[0].__module__)) if functions else ("", None)


def _cell(name: str) -> str:
    """The source of a notebook cell; empty where the name is none of a cell. Entries of files have a time of change."""
    entry = linecache.cache.get(name)
    return "".join(entry[2]) if entry is not None and len(entry) == 4 and entry[1] is None else ""


def _name_in(cell: str, names: list[str], component: Any) -> str:
    """The name that a cell gives to its component. UsageError where there is none, or where the cell is not plain Python."""
    tree = _parsed(cell)
    bound = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    for name in names:
        if name in bound:
            return name
    raise UsageError(
        f"a component of {component.family} without a name in the cell that makes it; accepted: a name, such as CONTROLLER = …; "
        f"{_WRITE}"
    )


def _parsed(cell: str) -> ast.Module:
    """The syntax tree of a cell. UsageError where it is not plain Python."""
    try:
        tree = ast.parse(cell)
    except SyntaxError as error:
        commands = [number for number, line in enumerate(cell.splitlines(), start=1) if _is_command(line.strip())]
        where, found = (commands[0], _FOUND) if commands else (error.lineno or 1, f"syntax error: {error.msg}")
        raise _refusal(cell, where, found) from None
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id == _SHELL:
            raise _refusal(cell, node.lineno, _FOUND)
    return tree


def _is_command(line: str) -> bool:
    return line.startswith(_COMMAND) or line.endswith(_COMMAND[-1])


def _refusal(cell: str, line: int, found: str) -> UsageError:
    text = (cell.splitlines() or [""])[line - 1].strip()
    return UsageError(
        f"line {line} of the cell of a component, {text!r}: {found}; accepted: Python without %, ! and ? commands; {_WRITE}"
    )
