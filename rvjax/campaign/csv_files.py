"""CSV files that a campaign names: in any mapping with the key `csv`, the table replaces the name of the file.

A campaign is untrusted input, so it can only name plain files in its folder and below. In a run folder the copies in `inputs/`
are read, so that the run does not depend on the original files.
"""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import Any

from rvjax.campaign.plain_values import Place, describe, is_list, is_mapping, shorten
from rvjax.campaign.source import Source
from rvjax.campaign.yaml_document import FLOAT, LARGEST, NOT_FINITE, NOT_PRINTABLE
from rvjax.errors import Finding

INPUTS = "inputs"
"""Folder inside a run folder, with copies of the files that the campaign names."""

KEY = "csv"
MOST_BYTES = 16 * 1024 * 1024
"""Total size of the files that a campaign names."""

MOST_CELLS = 2_000_000


@dataclass(frozen=True)
class CsvFile:
    """A CSV file. name: as in the campaign; names: of the columns; rows: (line on which the row ends, cells).

    Two files with the same cells are equal, whatever their names.
    """

    name: str = field(compare=False)
    names: tuple[str, ...] = ()
    rows: tuple[tuple[int, tuple[str, ...]], ...] = field(default=(), repr=False)
    readable: bool = True

    def column(self, name: str) -> tuple[float, ...]:
        """The numbers of a column. ValueError with a text for the user where a cell is not a number."""
        place = self.names.index(name)
        return tuple(self._number(line, name, cells[place]) for line, cells in self.rows)

    def _number(self, line: int, name: str, cell: str) -> float:
        text = cell.strip()
        if not FLOAT.fullmatch(text):
            kind = "is not a finite number" if NOT_FINITE.fullmatch(text) or text.lower() == "nan" else "is not a number"
            content = describe(shorten(cell)) if text else "an empty cell"
            raise ValueError(f"{self.name} line {line}, column {name}: {content} {kind}")
        value = float(text)
        if abs(value) > LARGEST:
            raise ValueError(f"{self.name} line {line}, column {name}: {text} is too large")
        return value

    def __str__(self) -> str:
        return f"the file {self.name}"


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
        except _Refused as refused:
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


class _Refused(Exception):
    """The file is not accepted. message: what is wrong with it; accepted: what would be right."""

    def __init__(self, message: str, accepted: str) -> None:
        super().__init__(message)
        self.message, self.accepted = message, accepted


@dataclass
class _Reading:
    """Reads each file once. folder: of the campaign; inputs: bytes of the files, by name."""

    folder: Path
    inputs: dict[str, bytes] = field(default_factory=dict[str, bytes])
    tables: dict[str, CsvFile | _Refused] = field(default_factory=dict[str, "CsvFile | _Refused"])

    def table(self, given: object, known: Mapping[str, bytes]) -> CsvFile:
        if isinstance(given, CsvFile):
            self.inputs[given.name] = known[given.name]
            return given
        name = _plain(given)
        if name not in self.tables:
            try:
                self.tables[name] = self._read(name)
            except _Refused as refused:
                self.tables[name] = refused
        table = self.tables[name]
        if isinstance(table, _Refused):
            raise table
        return table

    def _read(self, name: str) -> CsvFile:
        data = self._bytes(name)
        self.inputs[name] = data
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = data[: error.start].count(b"\n") + 1
            raise _Refused(f"{name} line {line}: byte 0x{data[error.start]:02x} is not UTF-8", "accepted: UTF-8") from None
        return _parsed(name, text)

    def _bytes(self, name: str) -> bytes:
        """The bytes of a file: of the copy in a run folder, or else of the file in the campaign's folder."""
        home = os.path.realpath(self.folder)
        places = [os.path.join(home, INPUTS, name), os.path.join(home, name)]
        try:
            path = next((place for place in places if os.path.lexists(place)), places[-1])
            if not os.path.realpath(path).startswith(home + os.sep):
                raise _Refused(f"{name} is outside the campaign's folder", _ACCEPTED)
            if os.path.lexists(path) and not os.path.isfile(path):
                raise _Refused(f"{name} is not a plain file", _ACCEPTED)
            room = MOST_BYTES - sum(map(len, self.inputs.values()))
            with open(path, "rb") as file:
                data = file.read(room + 1)
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise _Refused(f"{name} cannot be read: {reason}", _ACCEPTED) from None
        if len(data) > room:
            raise _Refused(f"{name} is too large", f"accepted: up to {MOST_BYTES // 1024**2} MiB for all CSV files together")
        return data


_ACCEPTED = "accepted: the name of a CSV file in the campaign's folder or below it"
_DRIVE = re.compile(r"[A-Za-z]:")


def _plain(given: object) -> str:
    """The relative path of a file in the campaign's folder or below, without `./`."""
    if not isinstance(given, str) or not given or len(given) > 255:
        raise _Refused(f"found {describe(given)}", _ACCEPTED)
    path = PurePosixPath(given)
    odd = "\\" in given or NOT_PRINTABLE.search(given) or _DRIVE.match(given) or given != given.strip()
    if path.is_absolute() or ".." in path.parts or not path.parts or odd:
        raise _Refused(f"found {describe(given)}, which is not a plain relative path", _ACCEPTED)
    return path.as_posix()


def _parsed(name: str, text: str) -> CsvFile:
    """The table in a text: names in the first line, commas between cells, rows of equal length."""
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    names: Sequence[str] | None = None
    rows: list[tuple[int, tuple[str, ...]]] = []
    try:
        for cells in reader:
            line = reader.line_num
            if not any(cell.strip() for cell in cells):
                continue
            if names is None:
                names = [cell.strip() for cell in cells]
                _check_names(name, line, names)
                continue
            if len(cells) != len(names):
                raise _Refused(f"{name} line {line}: {len(cells)} cells", f"accepted: {len(names)} cells, as in the first line")
            if (len(rows) + 1) * len(names) > MOST_CELLS:
                raise _Refused(f"{name} line {line}: too many cells", f"accepted: at most {MOST_CELLS:,}")
            rows.append((line, tuple(cells)))
    except csv.Error as error:
        raise _Refused(f"{name} line {reader.line_num}: this is not CSV: {error}", "accepted: commas between cells") from None
    if names is None or not rows:
        raise _Refused(f"{name}: no rows", "accepted: names in the first line, numbers below them")
    return CsvFile(name, tuple(names), tuple(rows))


def _check_names(name: str, line: int, names: Sequence[str]) -> None:
    if any(not column or NOT_PRINTABLE.search(column) for column in names):
        raise _Refused(f"{name} line {line}: a column without a name", "accepted: names in the first line")
    first: set[str] = set()
    for twice in (column for column in names if column in first or first.add(column)):
        raise _Refused(f"{name} line {line}: the column {shorten(twice)} occurs twice", "accepted: names that differ")
