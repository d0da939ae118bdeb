"""The samples table: a row per sample, each with exactly one outcome. No sample is ever dropped."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from rvjax.columns import OUTCOMES, Column
from rvjax.errors import FolderError

KEYS = {
    "sample": Column("sample", "", "number of the sample, from 0"),
    "outcome": Column("outcome", "", f"what became of the sample: {', '.join(OUTCOMES)}"),
}
"""The columns that every samples table has."""


@dataclass(frozen=True)
class Samples:
    """The samples table in ascending order of `sample`, and its columns by name."""

    frame: pd.DataFrame
    columns: dict[str, Column]


@dataclass(frozen=True)
class Account:
    """Numbers of samples: requested = captured + not_settled + collided + not_finite + missing; FolderError otherwise."""

    requested: int
    captured: int
    not_settled: int
    collided: int
    not_finite: int
    missing: int

    def __post_init__(self) -> None:
        parts = (self.captured, self.not_settled, self.collided, self.not_finite, self.missing)
        if min(parts) < 0 or sum(parts) != self.requested:
            raise FolderError(
                f"the samples do not add up: {self.requested} requested, but {self.captured} captured + {self.not_settled} not "
                f"settled + {self.collided} collided + {self.not_finite} not finite + {self.missing} missing; "
                "fly the campaign again with another --out"
            )


def check_chunk(chunk: int, sample: np.ndarray, outcome: np.ndarray) -> None:
    """ValueError unless the samples of a chunk are consecutive and have known outcomes."""
    if not sample.size or sample[0] < 0 or not np.array_equal(sample, sample[0] + np.arange(sample.size)):
        raise ValueError(f"chunk {chunk}: samples must be consecutive from a number >= 0; found {sample}")
    if unknown := set(outcome.tolist()) - set(OUTCOMES):
        raise ValueError(f"chunk {chunk}: outcomes must be of {OUTCOMES}; found {sorted(map(str, unknown))}")


def join(tables: Mapping[str, tuple[pd.DataFrame, dict[str, Column]]], requested: int) -> Samples:
    """Joins the tables of all chunks. tables: table and columns by file name.

    FolderError if their columns differ, or a sample is there twice or was never requested.
    """
    first, columns = next((name, columns) for name, (_, columns) in tables.items())
    for name, (_, others) in tables.items():
        if odd := sorted(key for key in others.keys() | columns if others.get(key) != columns.get(key)):
            raise FolderError(f"{name}: other columns than in {first}: {', '.join(odd)}; fly the campaign again")
    frame = pd.concat([frame for frame, _ in tables.values()], ignore_index=True)
    if not frame["sample"].is_monotonic_increasing:  # a copy of all
        frame = frame.sort_values("sample", kind="stable", ignore_index=True)
    sample = frame["sample"].to_numpy()
    different = len(np.unique(sample))
    if different != len(sample) or sample[-1] >= requested:
        raise FolderError(
            f"{first}: with the other chunks {len(sample)} rows of {different} different samples up to number "
            f"{sample[-1]}, but {requested} were requested; fly the campaign again with another --out"
        )
    return Samples(frame, columns)
