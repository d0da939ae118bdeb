"""A command that is refused leaves no folder."""

from __future__ import annotations

import os
import shutil
from collections.abc import Generator, Iterable
from contextlib import contextmanager, suppress
from pathlib import Path

from rvjax.errors import CampaignError, UsageError
from rvjax.run_folder.store import PARTS


@contextmanager
def leaves_no_folder(place: Path) -> Generator[None, None, None]:
    """Removes the run folder that is made inside, and the folders above it that are made with it, where a CampaignError or a
    UsageError ends the command before any data file is written. What was there before stays."""
    absent = [path for path in (place, *place.parents) if not os.path.lexists(path)]
    empty = bool(absent) or not any(_names(place))
    try:
        yield
    except (CampaignError, UsageError):
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
