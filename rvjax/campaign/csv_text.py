"""The text of a CSV file as a table: names in the first line, numbers below them.

Cells stand between commas, semicolons or tabs. The line of names decides, or a line `sep=;` before it, as spreadsheets write it.
Between semicolons or tabs, a comma inside a number is a decimal comma.
"""

from __future__ import annotations

import codecs
import csv
import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from rvjax.campaign import units
from rvjax.campaign.named_files import RefusedFile
from rvjax.campaign.plain_values import describe, shorten
from rvjax.campaign.yaml_document import FLOAT, LARGEST, NOT_FINITE, NOT_PRINTABLE

MOST_CELLS = 2_000_000

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs"}
"""What may stand between cells, and its name in messages."""

_SEPARATOR_LINE = re.compile(r"\s*\"?sep=(.?)\"?[;,\t]*\s*", re.IGNORECASE)
_QUOTED = re.compile(r'"[^"]*"')
_DECIMAL_COMMA = re.compile(r"[-+]?([0-9]+,[0-9]*|,[0-9]+)([eE][-+]?[0-9]+)?")
_SYMBOLS = {word for suffix, unit in units.UNITS.items() for word in (suffix, unit.symbol)}

Rows = list[tuple[int, tuple[str, ...]]]
"""(line on which the row ends, cells) of every row."""


@dataclass(frozen=True)
class CsvFile:
    """A CSV file. name: as in the campaign; names: of the columns; rows: (line on which the row ends, cells), decimal points in
    the numbers; line: of the names; separator: between the cells.

    Two files with the same cells are equal, whatever their names and separators.
    """

    name: str = field(compare=False)
    names: tuple[str, ...] = ()
    rows: tuple[tuple[int, tuple[str, ...]], ...] = field(default=(), repr=False)
    readable: bool = True
    line: int = field(default=1, compare=False)
    separator: str = field(default=",", compare=False)

    def column(self, name: str) -> tuple[float, ...]:
        """The numbers of a column. ValueError with a text for the user where a cell is not a number."""
        place = self.names.index(name)
        return tuple(self._number(line, name, cells[place]) for line, cells in self.rows)

    def without(self, name: str) -> str:
        """The message that a column is missing, with the columns that are there and what separates them."""
        columns = ", ".join(map(shorten, self.names[:8])) + (", …" if len(self.names) > 8 else "")
        return f"{self.name} line {self.line} has no column {shorten(name)}, its columns between {self._between} are {columns}"

    @property
    def _between(self) -> str:
        return SEPARATORS[self.separator]

    def _number(self, line: int, name: str, cell: str) -> float:
        text = cell.strip()
        if not FLOAT.fullmatch(text):
            kind = "is not a finite number" if NOT_FINITE.fullmatch(text) or text.lower() == "nan" else "is not a number"
            content = describe(shorten(cell)) if text else "an empty cell"
            raise ValueError(f"{self.name} line {line}, column {name}: {content} {kind}{self._hint(line, text)}")
        value = float(text)
        if abs(value) > LARGEST:
            raise ValueError(f"{self.name} line {line}, column {name}: {text} is too large")
        return value

    def _hint(self, line: int, text: str) -> str:
        """Why a text may stand where a number is expected; empty if nothing is likely."""
        if _DECIMAL_COMMA.fullmatch(text):
            return ", a decimal comma needs semicolons or tabs between the cells"
        if line == self.rows[0][0] and text.strip("[]()") in _SYMBOLS:
            return ", a unit belongs in the name of the column"
        return ""

    def __str__(self) -> str:
        return f"the file {self.name}"


def decoded(name: str, data: bytes) -> str:
    """The text of a file: UTF-8, or UTF-16 with a byte order mark."""
    wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        return data.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        kind = "UTF-16" if wide else "UTF-8"
        raise RefusedFile(f"{name} line {line}: byte 0x{data[error.start]:02x} is not {kind}", "accepted: UTF-8") from None


def parsed(name: str, text: str) -> CsvFile:
    """The table in a text: names in the first line, rows of equal length below them."""
    separator, announced = _separator(name, text)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    names: Sequence[str] | None = None
    first = 0
    rows: Rows = []
    between = SEPARATORS[separator]
    try:
        for cells in _filled(reader, announced):
            line = reader.line_num
            if names is None:
                names, first = [cell.strip() for cell in cells], line
                _check_names(name, line, names)
                continue
            if len(cells) != len(names):
                accepted = f"accepted: {len(names)} cells, as in line {first}"
                hint = "; decimal commas need semicolons or tabs between the cells" if separator == "," else ""
                raise RefusedFile(f"{name} line {line}: {len(cells)} cells between {between}", accepted + hint)
            if (len(rows) + 1) * len(names) > MOST_CELLS:
                raise RefusedFile(f"{name} line {line}: too many cells", f"accepted: at most {MOST_CELLS:,}")
            rows.append((line, tuple(cells)))
    except csv.Error as error:
        message = f"{name} line {reader.line_num}: this is not CSV: {error}"
        raise RefusedFile(message, f"accepted: {between} between cells") from None
    if names is None or not rows:
        message = f"{name} line {reader.line_num or 1}: no rows"
        raise RefusedFile(message, "accepted: names in the first line, numbers below them")
    return CsvFile(name, tuple(names), tuple(_with_points(name, rows, separator)), True, first, separator)


def _filled(reader: Iterator[list[str]], announced: bool) -> Iterator[list[str]]:
    """The rows that are not blank, without the line `sep=`. announced: whether there is one."""
    filled = (cells for cells in reader if any(cell.strip() for cell in cells))
    if announced:
        next(filled, None)
    yield from filled


def _separator(name: str, text: str) -> tuple[str, bool]:
    """(what stands between the cells, whether a line `sep=` says so)."""
    lines = io.StringIO(text)
    number, line = next(((number, line) for number, line in enumerate(lines, start=1) if line.strip()), (1, ""))
    if said := _SEPARATOR_LINE.fullmatch(line):
        if said[1] not in SEPARATORS:
            accepted = f"accepted: {', '.join(SEPARATORS.values())} between cells, such as sep=;"
            raise RefusedFile(f"{name} line {number}: {shorten(line.strip())}", accepted)
        return said[1], True
    bare = _QUOTED.sub("", line)
    present = [separator for separator in SEPARATORS if separator in bare]
    if len(present) > 1:
        both = " and ".join(SEPARATORS[separator] for separator in present)
        accepted = "accepted: one of them, or a line before it that names the separator, such as sep=;"
        raise RefusedFile(f"{name} line {number}: {both} between the names", accepted)
    return (present or [","])[0], False


def _with_points(name: str, rows: Rows, separator: str) -> Rows:
    """The rows with a decimal point for each decimal comma. Refuses a file that has both."""
    commas = {} if separator == "," else _lines_with(rows, ",", _DECIMAL_COMMA)
    if not commas:
        return rows
    for line, text in _lines_with(rows, ".", FLOAT).items():
        other, instead = next(iter(commas.items()))
        message = f"{name} line {line}: {text} has a decimal point, but {instead} in line {other} has a decimal comma"
        raise RefusedFile(message, "accepted: one of the two in a file")
    return [
        (
            line,
            tuple(cell.replace(",", ".") if "," in cell and _DECIMAL_COMMA.fullmatch(cell.strip()) else cell for cell in cells),
        )
        for line, cells in rows
    ]


def _lines_with(rows: Rows, mark: str, number: re.Pattern[str]) -> dict[int, str]:
    """The first number that has the mark, by its line; empty if there is none."""
    found = ((line, cell.strip()) for line, cells in rows for cell in cells if mark in cell and number.fullmatch(cell.strip()))
    return dict([first]) if (first := next(found, None)) else {}


def _check_names(name: str, line: int, names: Sequence[str]) -> None:
    if any(not column or NOT_PRINTABLE.search(column) for column in names):
        raise RefusedFile(f"{name} line {line}: a column without a name", "accepted: names in the first line")
    first: set[str] = set()
    for twice in (column for column in names if column in first or first.add(column)):
        raise RefusedFile(f"{name} line {line}: the column {shorten(twice)} occurs twice", "accepted: names that differ")
