"""CSV files that a campaign names: in any mapping with the key `csv`, the table replaces the name of the file.

A campaign is untrusted input, so it can only name plain files in its folder and below. In a run folder the copies in `inputs/`
are read, so that the run does not depend on the original files.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import Any

from rvjax.campaign.csv_text import CsvFile, RefusedFile, decoded, parsed
from rvjax.campaign.plain_values import Place, describe, is_list, is_mapping
from rvjax.campaign.source import Source
from rvjax.campaign.yaml_document import NOT_PRINTABLE
from rvjax.errors import Finding

INPUTS = "inputs"
"""Folder inside a run folder, with copies of the files that the campaign names."""

KEY = "csv"
MOST_BYTES = 16 * 1024 * 1024
"""Total size of the files that a campaign names."""


def attach(source: Source) -> Source:
    """The source with every CSV file that it names: table and bytes, or a finding at the key `csv` where a file cannot be read.
    Files that the source already holds are not read again."""
    if source.value is None:
        return source
    reading = _Reading(Path(source.name).parent)
    findings: list[Finding] = []
    for place, mapping in list(_named(source.value, ())):
        try:
            mapping[KEY] = reading.table(mapping[KEY], source.inputs)
        except RefusedFile as refused:
            findings.append(source.finding((*place, KEY), refused.message, refused.accepted, key=True))
            mapping[KEY] = CsvFile(describe(mapping[KEY]), readable=False)
    return replace(source, findings=(*source.findings, *findings), inputs=reading.inputs)


def _named(value: Any, place: Place) -> Iterator[tuple[Place, dict[str, Any]]]:
    """(place, mapping) of every mapping with the key `csv`."""
    if is_mapping(value):
        if KEY in value:
            yield place, value
        for key, item in value.items():
            yield from _named(item, (*place, key))
    elif is_list(value):
        for index, item in enumerate(value):
            yield from _named(item, (*place, index))


@dataclass
class _Reading:
    """Reads each file once. folder: of the campaign; inputs: bytes of the files, by name."""

    folder: Path
    inputs: dict[str, bytes] = field(default_factory=dict[str, bytes])
    tables: dict[str, CsvFile | RefusedFile] = field(default_factory=dict[str, "CsvFile | RefusedFile"])

    def table(self, given: object, known: Mapping[str, bytes]) -> CsvFile:
        if isinstance(given, CsvFile):
            self.inputs[given.name] = known[given.name]
            return given
        name = _plain(given)
        if name not in self.tables:
            try:
                self.tables[name] = self._read(name)
            except RefusedFile as refused:
                self.tables[name] = refused
        table = self.tables[name]
        if isinstance(table, RefusedFile):
            raise table
        return table

    def _read(self, name: str) -> CsvFile:
        data = self._bytes(name)
        self.inputs[name] = data
        return parsed(name, decoded(name, data))

    def _bytes(self, name: str) -> bytes:
        """The bytes of a file: of the copy in a run folder, or else of the file in the campaign's folder."""
        home = os.path.realpath(self.folder)
        places = [os.path.join(home, INPUTS, name), os.path.join(home, name)]
        try:
            path = next((place for place in places if os.path.lexists(place)), places[-1])
            if not os.path.realpath(path).startswith(home + os.sep):
                raise RefusedFile(f"{name} is outside the campaign's folder", _ACCEPTED)
            if os.path.lexists(path) and not os.path.isfile(path):
                raise RefusedFile(f"{name} is not a plain file", _ACCEPTED)
            room = MOST_BYTES - sum(map(len, self.inputs.values()))
            with open(path, "rb") as file:
                data = file.read(room + 1)
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise RefusedFile(f"{name} cannot be read: {reason}", _ACCEPTED) from None
        if len(data) > room:
            raise RefusedFile(f"{name} is too large", f"accepted: up to {MOST_BYTES // 1024**2} MiB for all CSV files together")
        return data


_ACCEPTED = "accepted: the name of a CSV file in the campaign's folder or below it"
_DRIVE = re.compile(r"[A-Za-z]:")


def _plain(given: object) -> str:
    """The relative path of a file in the campaign's folder or below, without `./`."""
    if not isinstance(given, str) or not given or len(given) > 255:
        raise RefusedFile(f"found {describe(given)}", _ACCEPTED)
    path = PurePosixPath(given)
    odd = "\\" in given or NOT_PRINTABLE.search(given) or _DRIVE.match(given) or given != given.strip()
    if path.is_absolute() or ".." in path.parts or not path.parts or odd:
        raise RefusedFile(f"found {describe(given)}, which is not a plain relative path", _ACCEPTED)
    return path.as_posix()
