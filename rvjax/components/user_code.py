"""Executes the Python files that a campaign names, and says where in them a mistake is.

A file is executed from the bytes that were read with the campaign, once in a process for the same bytes. Its modules get names of
their own in `sys.modules`, so two campaigns with different files of the same name do not meet. An import finds the modules beside
the file among these bytes, and anything else where Python finds it.
"""

from __future__ import annotations

import builtins
import hashlib
import linecache
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping, Set
from contextlib import contextmanager
from dataclasses import replace
from functools import wraps
from pathlib import PurePosixPath
from threading import RLock
from types import ModuleType
from typing import Any

from rvjax.campaign.python_files import PythonFile, is_cell
from rvjax.components.user_mistakes import words_of
from rvjax.components.user_watch import watched
from rvjax.errors import CampaignError, Finding

PREFIX = "rvjax_user_"
"""Beginning of the names of executed modules in `sys.modules`; a digest of the sources and their folder follows."""

_executing = RLock()
_executed: dict[tuple[str, str], ModuleType] = {}


def module_of(file: PythonFile) -> ModuleType:
    """The executed module of a file. CampaignError with the line of the user's mistake where it cannot be executed."""
    key = (file.digest, file.folder)
    with _executing:
        if key not in _executed:
            with mistakes(file):
                _executed[key] = _Modules(file).executed(file.file)
        return _executed[key]


@contextmanager
def mistakes(file: PythonFile) -> Iterator[None]:
    """Turns any error of the user's code into a CampaignError with its line."""
    before = frozenset(sys.modules)
    try:
        with watched({file.path(source) for source in file.sources}):
            yield
        if len(sys.modules) != len(before):
            _check_imports(file, before)
    except CampaignError:
        raise
    except (Exception, SystemExit) as error:  # noqa: BLE001
        raise CampaignError([finding(error, file)]) from None


def finding(error: BaseException, file: PythonFile) -> Finding:
    """What is wrong, at the last line of the user's code that took part; else at the function that gave it (`given_by`)."""
    paths = {file.path(source) for source in file.sources}
    what = getattr(error, "function", None)
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename in paths]
    if isinstance(error, SyntaxError) and error.filename in paths:
        where, function = f"{error.filename}:{error.lineno or 1}", ""
    elif frames:
        where, function = f"{frames[-1].filename}:{frames[-1].lineno}", frames[-1].name.replace("<module>", "")
    else:
        where, function = _place_of(what, file), getattr(what, "__name__", "")
    found, accepted = words_of(error)
    if type(error) is NameError and is_cell(file.file):
        accepted = "accepted: a name that this notebook cell defines or imports; it flies without the other cells"
    return Finding(where, function, found.replace(f"{_package(file)}.", ""), accepted)


def _package(file: PythonFile) -> str:
    """The name of its modules in `sys.modules`. The same code in another folder has other modules: their lines are elsewhere."""
    return PREFIX + hashlib.sha256(f"{file.digest} {file.folder}".encode()).hexdigest()[:16]


def _called_back(file: PythonFile, search: Callable[..., None]) -> Callable[..., None]:
    """A search method of a user. It calls functions of this package, whose errors are not mistakes of the user."""

    def call(*arguments: Any) -> None:
        try:
            search(*arguments)
        except Exception as error:
            last = traceback.extract_tb(error.__traceback__)[-1]
            if last.filename not in {file.path(source) for source in file.sources}:
                raise
            raise CampaignError([finding(error, file)]) from None

    return call


def _place_of(what: Any, file: PythonFile) -> str:
    """`file:line` of a function or class of the user, else of the beginning of the file."""
    code = getattr(getattr(what, "__wrapped__", what), "__code__", None)
    if code is None or code.co_filename not in {file.path(source) for source in file.sources}:
        return f"{file.path(file.file)}:1"
    return f"{code.co_filename}:{code.co_firstlineno}"


def _check_imports(file: PythonFile, before: Set[str]) -> None:
    """Refuses a module that was imported from the campaign's folder past the sources: it would fly without being recorded."""
    home = file.path(file.file).removesuffix(file.file)
    for name in sys.modules.keys() - before:
        path = getattr(sys.modules[name], "__file__", None)
        if path and home and not name.startswith(PREFIX) and path.startswith(home) and "site-packages" not in path:
            del sys.modules[name]
            raise ImportError(f"{name} was imported by a call; write it as `import {name}`, so that the run keeps its code")


class _Modules:
    """The modules of a file, executed as they are imported."""

    def __init__(self, file: PythonFile) -> None:
        self._file, self._package = file, _package(file)
        self._root = PurePosixPath(file.file).parent
        self._builtins = vars(builtins) | {"__import__": self._import}
        if self._package not in sys.modules:
            package = ModuleType(self._package)
            package.__path__ = []
            sys.modules[self._package] = package

    def executed(self, source: str) -> ModuleType:
        """The module of a source."""
        path = PurePosixPath(source)
        steps = list((path.parent if path.name == "__init__.py" else path.with_suffix("")).relative_to(self._root).parts)
        name = ".".join((self._package, *steps))
        if name in sys.modules:
            return sys.modules[name]
        shown = self._file.path(source)
        module = ModuleType(name)
        module.__file__ = shown
        module.__package__ = name if path.name == "__init__.py" else name.rpartition(".")[0]
        if path.name == "__init__.py":
            module.__path__ = []
        vars(module)["__builtins__"] = self._builtins
        text = self._file.sources[source].decode("utf-8", errors="replace")
        linecache.cache[shown] = (len(text), None, text.splitlines(keepends=True), shown)
        sys.modules[name] = module
        try:
            exec(compile(self._file.sources[source], shown, "exec", dont_inherit=True), vars(module))
        except BaseException:
            del sys.modules[name]
            raise
        if steps:
            parent = sys.modules.get(name.rpartition(".")[0])
            if parent is not None:
                setattr(parent, steps[-1], module)
        return module

    def _import(
        self,
        name: str,
        globals: Mapping[str, Any] | None = None,
        locals: Mapping[str, Any] | None = None,
        fromlist: tuple[str, ...] = (),
        level: int = 0,
    ) -> ModuleType:
        """As `__import__`, with the sources beside the file first."""
        place = self._root
        if level:
            package = str((globals or {}).get("__package__", self._package)).split(".")[1:]
            if level > len(package) + 1:
                raise ImportError("a relative import beyond the campaign's folder")
            place = self._root.joinpath(*package[: len(package) + 1 - level])
        steps = name.split(".") if name else []
        found = [self._source(place.joinpath(*steps[:length])) for length in range(1, len(steps) + 1)]
        if level and not steps:
            for part in fromlist:
                if source := self._source(place / part):
                    self.executed(source)
            return self._package_of(place)
        if not found or found[-1] is None:
            if level:
                raise ImportError(f"there is no module {'.' * level}{name} beside the file")
            return builtins.__import__(name, globals, locals, fromlist, level)
        modules = [self.executed(source) for source in found if source]
        if not fromlist:
            return modules[0]
        for part in fromlist:
            inner = self._source(place.joinpath(*steps, part))
            if inner and not hasattr(modules[-1], part):
                self.executed(inner)
        return modules[-1]

    def _package_of(self, place: PurePosixPath) -> ModuleType:
        steps = place.relative_to(self._root).parts
        return sys.modules[".".join((self._package, *steps))]

    def _source(self, place: PurePosixPath) -> str | None:
        """The source of a module, by its place without a suffix."""
        for candidate in ((place / "__init__.py").as_posix(), f"{place.as_posix()}.py"):
            if candidate in self._file.sources:
                return candidate
        return None


def guarded(file: PythonFile, family: str, component: Any) -> Any:
    """The component of a file with every function that it is built of: an error of the user's code has its line."""

    def build(parameters: Any) -> Any:
        with mistakes(file):
            built: Any = component.build(parameters)
        if family == "searches":
            return _called_back(file, built)
        if family == "allocations":
            return lambda layout: each(guard(built)(layout))
        return guard(built) if callable(built) else each(built)

    def each(built: Any) -> Any:
        tupled = hasattr(built, "_asdict")
        values: dict[str, Any] = built._asdict() if tupled else vars(built)
        changed = {name: guard(value) for name, value in values.items() if callable(value)}
        return built._replace(**changed) if tupled else replace(built, **changed)

    def guard(function: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(function)
        def call(*arguments: Any) -> Any:
            with mistakes(file):
                return function(*arguments)

        return call

    return replace(component, build=build)
