"""The storage of a place: local files, or objects behind a URL."""

from __future__ import annotations

from pathlib import Path

from rvjax.places import ObjectPath, place_of
from rvjax.run_folder.local_storage import LocalStorage
from rvjax.run_folder.storage import MANIFEST, Storage


def storage_of(place: str | Path | ObjectPath) -> Storage:
    """Gives access to the files of a run folder; UsageError if nothing here can reach the place."""
    known = place_of(place)
    if isinstance(known, Path):
        return LocalStorage(known)
    from rvjax.run_folder.object_storage import ObjectStorage  # only where a URL is given
    from rvjax.run_folder.s3_client import client_of

    return ObjectStorage(known, client_of(known))


def is_run_folder(place: str | Path | ObjectPath) -> bool:
    """Whether there is a run folder: a place with a manifest."""
    return storage_of(place).exists(MANIFEST)
