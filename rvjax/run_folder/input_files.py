"""The files that a campaign names, copied to `inputs/` of a run folder."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from rvjax.campaign.named_files import INPUTS
from rvjax.errors import FolderError
from rvjax.run_folder import atomic_files
from rvjax.run_folder.store import compared


def foreign(root: Path, inputs: Mapping[str, bytes]) -> list[str]:
    """Files below `inputs/` that are not in `inputs`, in a folder that is not a run folder yet."""
    names: list[str] = []
    for folder, _, files in os.walk(root / INPUTS):
        finished = [name for name in files if not atomic_files.is_temporary(name)]
        names += [(Path(folder) / name).relative_to(root / INPUTS).as_posix() for name in finished]
    return [name for name in names if name not in inputs]


def write(root: Path, inputs: Mapping[str, bytes]) -> dict[str, str]:
    """Writes the files; returns their SHA-256 by name."""
    for name, data in inputs.items():
        atomic_files.replace(atomic_files.inside(root, f"{INPUTS}/{name}"), data)
    return {name: atomic_files.sha256(data) for name, data in sorted(inputs.items())}


def complaints(root: Path, digests: Mapping[str, str]) -> list[str]:
    """A message for each file that is missing or has another SHA-256 than in `digests`."""
    messages: list[str] = []
    for name, sha256 in digests.items():
        try:
            compared(root, f"{INPUTS}/{name}", sha256)
        except FolderError as error:
            messages.append(str(error))
    return messages
