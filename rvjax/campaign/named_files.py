"""Files that a campaign names, by their names in it.

A campaign is untrusted input: it can only name plain files in its folder and below. In a run folder the copies in `inputs/` are
read, so that the run does not depend on the original files.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from rvjax.campaign.plain_values import describe
from rvjax.campaign.yaml_document import NOT_PRINTABLE

INPUTS = "inputs"
"""Folder inside a run folder, with copies of the files that the campaign names."""

MOST_BYTES = 16 * 1024 * 1024
"""Total size of the files that a campaign names."""

_DRIVE = re.compile(r"[A-Za-z]:")


class RefusedFile(Exception):
    """The file is not accepted. message: what is wrong with it; accepted: what would be right; where: `file:line` where the
    mistake is in the file itself, else empty."""

    def __init__(self, message: str, accepted: str, where: str = "") -> None:
        super().__init__(message)
        self.message, self.accepted, self.where = message, accepted, where


@dataclass
class NamedFiles:
    """Reads each file once. folder: of the campaign; known: bytes that need no reading; inputs: bytes of the files that were
    asked for, by name."""

    folder: Path
    known: Mapping[str, bytes]
    inputs: dict[str, bytes] = field(default_factory=dict[str, bytes])

    def exists(self, name: str) -> bool:
        """Whether there is a plain file with this name."""
        return name in self.known or os.path.isfile(self.path(name))

    def path(self, name: str) -> str:
        """Where a file is: in `inputs/` of a run folder, or else in the campaign's folder."""
        copy = os.path.join(self.folder, INPUTS, name)
        return copy if os.path.lexists(copy) else os.path.join(self.folder, name)

    def read(self, name: str, accepted: str) -> bytes:
        """The bytes of a file. Errors: RefusedFile."""
        if name not in self.inputs:
            self.inputs[name] = self.known[name] if name in self.known else self._bytes(name, accepted)
        return self.inputs[name]

    def _bytes(self, name: str, accepted: str) -> bytes:
        path = self.path(name)
        try:
            home = os.path.realpath(self.folder)
            if not os.path.realpath(path).startswith(home + os.sep):
                raise RefusedFile(f"{name} is outside the campaign's folder", accepted)
            if os.path.lexists(path) and not os.path.isfile(path):
                raise RefusedFile(f"{name} is not a plain file", accepted)
            room = MOST_BYTES - sum(map(len, self.inputs.values()))
            with open(path, "rb") as file:
                data = file.read(room + 1)
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise RefusedFile(f"{name} cannot be read: {reason}", accepted) from None
        if len(data) > room:
            raise RefusedFile(f"{name} is too large", f"accepted: up to {MOST_BYTES // 1024**2} MiB for all files together")
        return data


def plain_path(given: object, accepted: str) -> str:
    """The relative path of a file in the campaign's folder or below, without `./`. Errors: RefusedFile."""
    if not isinstance(given, str) or not given or len(given) > 255:
        raise RefusedFile(f"found {describe(given)}", accepted)
    path = PurePosixPath(given)
    odd = "\\" in given or NOT_PRINTABLE.search(given) or _DRIVE.match(given) or given != given.strip()
    if path.is_absolute() or ".." in path.parts or not path.parts or odd:
        raise RefusedFile(f"found {describe(given)}, which is not a plain relative path", accepted)
    return path.as_posix()
