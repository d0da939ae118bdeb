"""Table with a row for each sample, from a CSV file: the input of the samplers `plan` and `points`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign import Series
from rvjax.campaign.problems import Problem
from rvjax.components.samplers.interface import PLACE, Samples, Setting, Values

CSV = (*PLACE, "csv")
"""Place of the file name in a campaign."""


@dataclass(frozen=True)
class SampleTable:
    """columns: (rows,) values by name; rows: number of rows; lines: line of each row in the file."""

    columns: Mapping[str, Values]
    rows: int
    lines: tuple[int, ...]

    @classmethod
    def of(cls, table: Series, prefix: str = "") -> SampleTable:
        """The columns of a file; `prefix` is removed from their names."""
        names = (name.removeprefix(prefix) for name in table.names)
        columns = {name: np.array(values) for name, values in zip(names, table.values, strict=True)}
        return cls(columns, table.rows, table.lines)

    def length_problems(self, setting: Setting) -> Iterable[Problem]:
        """A number of samples that differs from the number of rows."""
        if self.rows != setting.samples:
            accepted = f"accepted: {self.rows:,}, a sample for each row of the table"
            yield Problem(f"{setting.samples:,} samples", accepted, ("samples",))

    def missing_problems(self, names: Sequence[str], why: str = "") -> Iterable[Problem]:
        """Columns that are missing although others of `names` are there."""
        missing = [name for name in names if name not in self.columns]
        if missing and len(missing) < len(names):
            yield Problem(f"{', '.join(missing)} is missing", f"accepted: all of {', '.join(names)}{why}", CSV, at_key=True)

    def value_problems(self, name: str, columns: Sequence[str], valid: NDArray[np.bool_], accepted: str) -> Iterable[Problem]:
        """The first row that is not valid. name: of what the columns hold; valid: (rows,)."""
        for row in np.flatnonzero(~valid)[:1]:
            values = ", ".join(f"{self.columns[column][row]:g}" for column in columns)
            yield Problem(f"line {self.lines[row]}, {name}: {values}", f"accepted: {accepted}", CSV, at_key=True)


def rows_of(values: Mapping[str, Values], samples: Samples) -> dict[str, Values]:
    """The row of each sample; samples after the last row start again at the first."""
    return {name: rows[samples % len(rows)] for name, rows in values.items()}
