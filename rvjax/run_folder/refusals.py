"""A command that is refused, or that breaks off before a flight is kept, leaves no folder."""

from __future__ import annotations

import os
import shutil
from collections.abc import Generator, Iterable
from contextlib import contextmanager, suppress
from pathlib import Path

from rvjax.errors import IncompleteError
from rvjax.run_folder.entry import PARTS


@contextmanager
def leaves_no_folder(place: Path) -> Generator[None, None, None]:
    """Removes the run folder that is made inside, and the folders above it that are made with it, where an error ends
    the command before any data file is written: a refusal, or an error in a component of the user when it is first traced. What
    was there before stays, and so does a folder that a message says how to resume (IncompleteError, an interrupt)."""
    absent = [path for path in (place, *place.parents) if not os.path.lexists(path)]
    empty = bool(absent) or not any(_names(place))
    try:
        yield
    except IncompleteError:
        raise
    except Exception:
        if empty and not any(name for part in PARTS for name in _names(place / part)):
            for name in _names(place):
                _remove(place / name)
            for path in absent:
                with suppress(OSError):
                    path.rmdir()
        raise


def _names(folder: Path) -> Iterable[str]:
    """The names in a folder; none where there is no such folder."""
    return os.listdir(folder) if os.path.isdir(folder) else []


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with suppress(OSError):
            path.unlink()
