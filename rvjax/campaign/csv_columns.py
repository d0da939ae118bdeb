"""Named columns of numbers from a CSV file, for components that read a table."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from pydantic_core import core_schema

from rvjax.campaign.csv_text import CsvFile
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.plain_values import shorten
from rvjax.campaign.problems import Problem, refuse, unexpected
from rvjax.campaign.units import UNITS

_BRACKETED = re.compile(r"(.*?)[ _]*[\[(]([^\])]+)[\])]")
"""A name with its unit in brackets."""


@dataclass(frozen=True)
class Series:
    """names: of the columns; values: of each column, in the order of the rows; lines: line of the file on which each row ends;
    file: its name; header: line of the names."""

    names: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]
    lines: tuple[int, ...] = field(default=(), compare=False)
    file: str = field(default="", compare=False)
    header: int = field(default=1, compare=False)

    def __getitem__(self, name: str) -> tuple[float, ...]:
        return self.values[self.names.index(name)]

    def __contains__(self, name: object) -> bool:
        return name in self.names

    @property
    def rows(self) -> int:
        """The number of rows, at least 1."""
        return len(self.values[0])


@dataclass(frozen=True)
class DeclaredSeries:
    """columns: required; optional: allowed; others: whether any further columns are allowed; absent: whether the file may be left
    out."""

    columns: tuple[str, ...]
    optional: tuple[str, ...]
    others: bool
    absent: bool = False

    def read(self, raw: Any) -> Series | None:
        """The columns in the order of the file, or every problem at once; None only where the file may be left out."""
        if raw is None and self.absent:
            return None
        if not isinstance(raw, CsvFile):
            refuse(unexpected(raw, "accepted: the name of a CSV file"))
        if not raw.readable:
            refuse()
        known = (*self.columns, *self.optional)
        names = {_with_suffix(name, known): name for name in raw.names}
        missing = [name for name in self.columns if name not in names]
        unknown = [] if self.others else [name for name in names if name not in known]
        problems = [Problem(raw.without(name), f"accepted: {', '.join(known)}", at_key=True) for name in missing]
        problems += [
            Problem(f"{raw.name} line {raw.line} has an unknown column {shorten(name)}", did_you_mean(name, known), at_key=True)
            for name in unknown
        ]
        if len(names) < len(raw.names):
            twice = next(name for name in names.values() if (short := _with_suffix(name, known)) != name and short in raw.names)
            problems.append(Problem(f"{raw.name} line {raw.line} has two columns {twice}", "accepted: one of them", at_key=True))
        if problems:
            refuse(*problems)
        try:
            values = tuple(raw.column(name) for name in names.values())
        except ValueError as error:
            refuse(Problem(str(error), "accepted: a number in every row", at_key=True))
        return Series(tuple(names), values, tuple(line for line, _ in raw.rows), raw.name, raw.line)

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        return {"type": "string"}


def _with_suffix(name: str, known: Sequence[str]) -> str:
    """`t [s]` and `t (s)` → `t_s`, where this is a known column; any other name stays."""
    if (parts := _BRACKETED.fullmatch(name)) is None:
        return name
    for suffix, unit in UNITS.items():
        if parts[2].strip() in (suffix, unit.symbol) and (short := f"{parts[1]}_{suffix}") in known:
            return short
    return name
