"""Named columns of numbers from a CSV file, for components that read a table."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from pydantic_core import core_schema

from rvjax.campaign.csv_files import CsvFile
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.plain_values import shorten
from rvjax.campaign.problems import Problem, refuse, unexpected


@dataclass(frozen=True)
class Series:
    """names: of the columns; values: of each column, in the order of the rows; lines: line of the file on which each row ends."""

    names: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]
    lines: tuple[int, ...] = field(default=(), compare=False)

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
            refuse()  # there is a finding about it already
        known = (*self.columns, *self.optional)
        missing = [name for name in self.columns if name not in raw.names]
        unknown = [] if self.others else [name for name in raw.names if name not in known]
        problems = [Problem(f"{raw.name} has no column {name}", f"accepted: {', '.join(known)}", at_key=True) for name in missing]
        problems += [
            Problem(f"{raw.name} has an unknown column {shorten(name)}", did_you_mean(name, known), at_key=True)
            for name in unknown
        ]
        if problems:
            refuse(*problems)
        try:
            return Series(raw.names, tuple(raw.column(name) for name in raw.names), tuple(line for line, _ in raw.rows))
        except ValueError as error:
            refuse(Problem(str(error), "accepted: a number in every row", at_key=True))

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        return {"type": "string"}
