"""The files of a run folder that are made from its data: the report, its figures, the summary."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rvjax.campaign.named_files import INPUTS
from rvjax.errors import FolderError
from rvjax.places import Place
from rvjax.run_folder import atomic_files, checksums
from rvjax.run_folder.atomic_files import plain_parts
from rvjax.run_folder.entries_file import is_entries_file
from rvjax.run_folder.entry import PARTS
from rvjax.run_folder.manifest import json_bytes
from rvjax.run_folder.storage import LEASE, MANIFEST, Storage

CAMPAIGN = "campaign.yaml"
"""The campaign file in a run folder."""

_DATA = {*PARTS, atomic_files.QUARANTINE, INPUTS, CAMPAIGN, MANIFEST, LEASE, checksums.NAME}


class MadeFiles:
    """Writes and reads these files. path: the run folder."""

    def __init__(self, storage: Storage) -> None:
        self.path: Place = storage.place
        self._storage = storage
        self._written: dict[str, str] = {}

    def write_summary(self, summary: Mapping[str, Any]) -> Place:
        """Writes `summary.json`, strict JSON; numbers that are not finite become null."""
        return self.write_bytes("summary.json", json_bytes(summary))

    def write_text(self, name: str, text: str) -> Place:
        """Writes a text file (UTF-8) atomically; bytes of a path that are not UTF-8 are escaped."""
        return self.write_bytes(name, text.encode(errors="backslashreplace"))

    def write_bytes(self, name: str, data: bytes) -> Place:
        """Writes a file that is made from the data, atomically, over an older version; returns its path.

        `seal` records the SHA-256 of all these files. FolderError if `name` leads out of the folder or names data.
        """
        parts = plain_parts(self.path, name)
        if parts[0] in {*_DATA, self._storage.log.name} or is_entries_file(parts[0]):
            raise FolderError(f"{self.path / name}: holds data of the run, which rvjax never overwrites; accepted: another name")
        plain_name = "/".join(parts)
        self._storage.replace(plain_name, data)
        self._written[plain_name] = atomic_files.sha256(data)
        return self.path / plain_name

    def read_bytes(self, name: str) -> bytes:
        """A file that is made from the data; FolderError if it is not there."""
        return self._storage.read(name)

    def seal(self) -> None:
        """Records the SHA-256 of every file from `write_bytes`, `write_text` and `write_summary`."""
        checksums.seal(self._storage, self._written)
