"""Table with a row for each sample, from a CSV file: the input of the samplers `plan` and `points`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign import Series
from rvjax.campaign.plain_values import exact
from rvjax.campaign.problems import Problem
from rvjax.components.samplers.interface import PLACE, Samples, Setting, Values

CSV = (*PLACE, "csv")
"""Place of the file name in a campaign."""


@dataclass(frozen=True)
class SampleTable:
    """columns: (rows,) values by name; rows: number of rows; lines: line of each row in the file; file: its name; header: line of
    the names."""

    columns: Mapping[str, Values]
    rows: int
    lines: tuple[int, ...]
    file: str
    header: int

    @classmethod
    def of(cls, table: Series, prefix: str = "") -> SampleTable:
        """The columns of a file; `prefix` is removed from their names."""
        names = (name.removeprefix(prefix) for name in table.names)
        columns = {name: np.array(values) for name, values in zip(names, table.values, strict=True)}
        return cls(columns, table.rows, table.lines, table.file, table.header)

    def length_problems(self, setting: Setting) -> Iterable[Problem]:
        """A number of samples that differs from the number of rows."""
        if self.rows != setting.samples:
            accepted = f"accepted: {self.rows}, a sample for each row of the table ({self.file} lines {self.span})"
            yield Problem(f"{setting.samples:,} samples", accepted, ("samples",))

    @property
    def span(self) -> str:
        """The lines of the first and the last row."""
        return f"{self.lines[0]} to {self.lines[-1]}"

    def name_problem(self, message: str, accepted: str) -> Problem:
        """What is wrong with the names of the columns."""
        return Problem(f"{self.file} line {self.header}: {message}", accepted, CSV, at_key=True)

    def missing_problems(self, names: Sequence[str], why: str = "") -> Iterable[Problem]:
        """Columns that are missing although others of `names` are there."""
        missing = [name for name in names if name not in self.columns]
        if missing and len(missing) < len(names):
            yield self.name_problem(f"{', '.join(missing)} is missing", f"accepted: all of {', '.join(names)}{why}")

    def value_problems(self, name: str, columns: Sequence[str], valid: NDArray[np.bool_], accepted: str) -> Iterable[Problem]:
        """The first row that is not valid. name: of what the columns hold; valid: (rows,)."""
        for row in np.flatnonzero(~valid)[:1]:
            values = ", ".join(exact(float(self.columns[column][row])) for column in columns)
            message = f"{self.file} line {self.lines[row]}, {name}: {values}"
            yield Problem(message, f"accepted: {accepted}", CSV, at_key=True)


def rows_of(values: Mapping[str, Values], samples: Samples) -> dict[str, Values]:
    """The row of each sample; samples after the last row start again at the first."""
    return {name: rows[samples % len(rows)] for name, rows in values.items()}
