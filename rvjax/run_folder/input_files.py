"""The files that a campaign names, copied to `inputs/` of a run folder."""

from __future__ import annotations

from collections.abc import Mapping

from rvjax.campaign.named_files import INPUTS
from rvjax.errors import FolderError
from rvjax.run_folder import atomic_files
from rvjax.run_folder.storage import Storage
from rvjax.run_folder.store import compared


def foreign(storage: Storage, inputs: Mapping[str, bytes]) -> list[str]:
    """Files below `inputs/` that are not in `inputs`, in a folder that is not a run folder yet."""
    return [name for name in storage.below(INPUTS) if name not in inputs]


def write(storage: Storage, inputs: Mapping[str, bytes]) -> dict[str, str]:
    """Writes the files; returns their SHA-256 by name."""
    for name, data in inputs.items():
        storage.replace(f"{INPUTS}/{name}", data)
    return {name: atomic_files.sha256(data) for name, data in sorted(inputs.items())}


def complaints(storage: Storage, digests: Mapping[str, str]) -> list[str]:
    """A message for each file that is missing or has another SHA-256 than in `digests`."""
    messages: list[str] = []
    for name, sha256 in digests.items():
        try:
            compared(storage, f"{INPUTS}/{name}", sha256)
        except FolderError as error:
            messages.append(str(error))
    return messages
