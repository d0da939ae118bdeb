"""What is exported: a table with the unit and the description of each column, and where it comes from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.analysis.trace_frames import vectors
from rvjax.columns import Column

Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class Exported:
    """name: `samples` or `trace`. facts: of the run, by name: campaign, samples, seed, identity, version, and of a trace its
    sample and its outcome."""

    name: str
    frame: pd.DataFrame
    columns: Mapping[str, Column]
    facts: Mapping[str, str | int]

    def vector(self, form: str) -> Numbers:
        """(rows, 3) of a trace; form as of `vectors`."""
        return vectors(self.frame, form)

    def only(self, rows: NDArray[np.bool_]) -> Exported:
        """Some of the rows."""
        return Exported(self.name, self.frame.loc[rows].reset_index(drop=True), self.columns, self.facts)
