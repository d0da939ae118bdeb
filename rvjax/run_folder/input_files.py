"""The files that a campaign names, as they were given, below `inputs/` of a run folder."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from rvjax.campaign.csv_files import INPUTS
from rvjax.errors import FolderError
from rvjax.run_folder import atomic_files
from rvjax.run_folder.store import compared


def foreign(root: Path, inputs: Mapping[str, bytes]) -> list[str]:
    """Files below `inputs/` that are none of these, in a folder that is not a run folder yet."""
    found: list[str] = []
    for place, _, names in os.walk(root / INPUTS):
        own = [
            (Path(place) / name).relative_to(root / INPUTS).as_posix() for name in names if not atomic_files.is_temporary(name)
        ]
        found += [name for name in own if name not in inputs]
    return found


def write(root: Path, inputs: Mapping[str, bytes]) -> dict[str, str]:
    """Writes the files; their SHA-256 by name."""
    for name, data in inputs.items():
        atomic_files.replace(atomic_files.inside(root, f"{INPUTS}/{name}"), data)
    return {name: atomic_files.sha256(data) for name, data in sorted(inputs.items())}


def complaints(root: Path, noted: Mapping[str, str]) -> list[str]:
    """One for each file that is missing or is not what was noted."""
    found: list[str] = []
    for name, sha256 in noted.items():
        try:
            compared(root, f"{INPUTS}/{name}", sha256)
        except FolderError as error:
            found.append(str(error))
    return found
