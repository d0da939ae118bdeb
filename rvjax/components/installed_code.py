"""Components of installed packages: which code of them a process executes.

Python imports a module once. A file that changes afterwards is not executed in this process, so its digest would name other code
than what flies. Such a package is refused; a new process imports the new code.
"""

from __future__ import annotations

import hashlib
import os
import sys
import time
from importlib import import_module
from importlib.metadata import packages_distributions, version
from pathlib import Path
from types import ModuleType

from rvjax.errors import FolderError, UsageError

_digests: dict[str, str] = {}
"""Top package or module → digest of its files when it was imported."""


def imported(name: str) -> ModuleType:
    """A module of an installed package. UsageError where it cannot be imported."""
    top, here = name.partition(".")[0], sys.modules.get(name)
    before = _digest(top) if here is None else ""
    try:
        module = import_module(name)
    except Exception as error:
        reason = str(error).partition("\n")[0]
        raise UsageError(f"the installed module {name} cannot be imported: {type(error).__name__}: {reason}") from error
    if top not in _digests:
        now = _digest(top)
        if before not in ("", now) or (here is not None and _newest(top) > _process_start()):
            raise _changed(top)
        _digests[top] = now
    return module


def identity(name: str) -> dict[str, str]:
    """Version of the distribution of a module and digest of the code of its package, as this process executes it. FolderError
    where a file has changed since it was imported."""
    top = name.partition(".")[0]
    if _digest(top) != _digests.get(top, ""):
        raise _changed(top)
    distributions = packages_distributions().get(top, ())
    return {"code": _digests[top]} | {distribution: version(distribution) for distribution in sorted(set(distributions))}


def _changed(top: str) -> FolderError:
    return FolderError(f"the files of {top} have changed since this process imported them; accepted: a new process")


def _files(top: str) -> list[Path]:
    """The Python files of a top package, or of a module that is no package."""
    module = sys.modules.get(top)
    if module is None:
        from importlib.util import find_spec

        spec = find_spec(top)
        places = list(spec.submodule_search_locations or ()) if spec else []
        file = spec.origin if spec else None
    else:
        places, file = list(getattr(module, "__path__", ())), getattr(module, "__file__", None)
    if places:
        return sorted(path for place in places for path in Path(place).rglob("*.py"))
    return [Path(file)] if file else []


def _digest(top: str) -> str:
    digest = hashlib.sha256()
    for path in _files(top):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def _newest(top: str) -> float:
    return max((path.stat().st_mtime for path in _files(top)), default=0.0)


_LOADED = time.time()


def _process_start() -> float:
    """When this process began; where the system does not say, when this module was imported."""
    try:
        return os.stat(f"/proc/{os.getpid()}").st_ctime
    except OSError:
        return _LOADED
