"""Pairing: the samples of two run folders side by side, after a check that their draws are the same, bit for bit.

Both folders are read chunk by chunk; their chunks may differ in size. Only the values that a comparison needs stay in memory,
about 100 bytes a pair; draws are compared and dropped.
"""

# pyright: reportMissingTypeStubs=false

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.analysis.run_totals import Ledger, metric, worst_value
from rvjax.analysis.verdicts.compliance import complies
from rvjax.campaign import Requirement
from rvjax.campaign.plain_values import exact, is_list, is_mapping
from rvjax.columns import DRAW, FAILED, OUTCOMES, Column, drawn_columns, metric_column
from rvjax.errors import FolderError, IncompleteError, UsageError
from rvjax.places import Place, place_of
from rvjax.run_folder import RunFolder

BLOCK = 16_384
"""Rows of each folder that are compared at a time."""

NAMED = 3
"""The largest number of differing columns that an error names."""

RANKED = ("outcome_time_s", metric_column("window_position_error_m"), metric_column("settling_time_s"))
"""Columns that decide, after the outcome, which of two samples is worse."""


@dataclass
class Side:
    """The data of a single folder that a comparison needs; n common samples.

    outcome: (n,) index into `OUTCOMES`. success: (n,) for each requirement. values: (n,) by metric, in SI; a sample that is not
    finite has the worst value. ranked: (n,) by column of `RANKED`.
    """

    columns: dict[str, Column]
    outcome: NDArray[np.int8]
    success: list[NDArray[np.bool_]]
    values: dict[str, NDArray[np.float64]]
    ranked: dict[str, NDArray[np.float64]] = field(default_factory=dict[str, NDArray[np.float64]])

    def rows(self, samples: NDArray[np.int64]) -> pd.DataFrame:
        """A table of some samples with the columns that rank them from worst to best."""
        outcome = np.array(OUTCOMES, dtype=object)[self.outcome[samples]]
        return pd.DataFrame({"sample": samples, "outcome": outcome} | {name: x[samples] for name, x in self.ranked.items()})


@dataclass(frozen=True)
class Paired:
    """Two folders on the same draws. only_a, only_b: draws that only A, only B has, without `draw.` in their names."""

    n: int
    a: Side
    b: Side
    only_a: tuple[str, ...]
    only_b: tuple[str, ...]


class _Reader:
    """Reads the rows of a folder in the order of their samples, any number at a time."""

    def __init__(self, folder: RunFolder) -> None:
        self.path = folder.path
        self._tables = folder.tables()
        self._ledger = Ledger()
        self._left = pd.DataFrame()
        self._read(1)

    @property
    def columns(self) -> dict[str, Column]:
        """Unit and description of every column."""
        return self._ledger.columns

    def _read(self, count: int) -> None:
        parts = [self._left] if len(self._left) else []
        rows = len(self._left)
        while rows < count and (table := next(self._tables, None)) is not None:
            chunk, frame, columns = table
            before = self._ledger.n
            self._ledger.add(chunk, frame, columns)
            if frame["sample"].iloc[0] != before or set(frame["outcome"]) - set(OUTCOMES):
                raise FolderError(
                    f"{self.path}: chunk {chunk} has wrong sample numbers or unknown outcomes; fly the campaign again"
                )
            parts.append(frame)
            rows += len(frame)
        self._left = pd.concat(parts, ignore_index=True) if len(parts) > 1 else parts[0]

    def take(self, count: int) -> pd.DataFrame:
        """The next `count` rows."""
        self._read(count)
        taken, self._left = self._left.iloc[:count], self._left.iloc[count:]
        return taken.reset_index(drop=True)


def pair(
    a: RunFolder,
    b: RunFolder,
    requirements: Sequence[Requirement],
    metrics: Callable[[Mapping[str, Column], Mapping[str, Column]], Sequence[str]],
    common: bool = False,
) -> Paired:
    """The samples that both folders have, side by side.

    requirements: the successes of each side are kept for these. metrics: takes the columns of both sides and returns the names
    of the metrics whose values are kept. common: compare folders of different size on the samples that both have.

    Errors: UsageError if the numbers of samples or the draws differ (it names the first columns), or a metric is missing;
    IncompleteError if samples are missing; FolderError if a folder is damaged.
    """
    n = _size(a, b, common)
    readers = _Reader(a), _Reader(b)
    names = metrics(readers[0].columns, readers[1].columns)
    drawn = [drawn_columns(reader.columns) for reader in readers]
    shared = [name for name in drawn[0] if name in drawn[1]]
    if not shared and any(drawn):
        raise UsageError(f"{a.path} and {b.path}: no draw in common, so nothing shows that their samples are the same")
    sides = [_empty(reader.columns, n, len(requirements), names) for reader in readers]
    for first in range(0, n, BLOCK):
        frames = [reader.take(min(BLOCK, n - first)) for reader in readers]
        _same_draws(a, b, frames[0], frames[1], shared)
        for side, frame in zip(sides, frames, strict=True):
            _keep(side, slice(first, first + len(frame)), frame, requirements, sides[0].columns)
    unshared = [tuple(name.removeprefix(DRAW) for name in names if name not in shared) for names in drawn]
    return Paired(n, sides[0], sides[1], only_a=unshared[0], only_b=unshared[1])


def _size(a: RunFolder, b: RunFolder, common: bool) -> int:
    """The number of samples that both folders have."""
    for folder in (a, b):
        if missing := folder.requested - folder.chunks.total:
            raise IncompleteError(
                f"{folder.path}: {missing} of {folder.requested} samples are missing; `rvjax run` with the same --out flies them"
            )
    if a.requested != b.requested and not common:
        raise UsageError(
            f"{a.path} has {a.requested} samples, {b.path} has {b.requested}; accepted: the same number, or --common to compare "
            f"the first {min(a.requested, b.requested)}"
        )
    return min(a.requested, b.requested)


def _same_draws(a: RunFolder, b: RunFolder, first: pd.DataFrame, second: pd.DataFrame, columns: Sequence[str]) -> None:
    """UsageError unless the given columns of two tables are the same, bit for bit."""
    differing: list[str] = []
    for name in columns:
        x, y = first[name].to_numpy(), second[name].to_numpy()
        rows = np.flatnonzero(_differ(x, y))
        if rows.size:
            row = rows[0]
            differing.append(f"{name} (sample {first['sample'].iloc[row]}: {x[row]!s} and {y[row]!s})")
    if differing:
        rest = f" and {len(differing) - NAMED} more" if len(differing) > NAMED else ""
        raise UsageError(
            f"{a.path} and {b.path} are not on the same draws: {', '.join(differing[:NAMED])}{rest} differ; accepted: runs with "
            "the same seed and dispersions; their controllers may differ"
        )


def _differ(x: NDArray[Any], y: NDArray[Any]) -> NDArray[np.bool_]:
    """(n,) where two columns differ in any bit."""
    if x.dtype != y.dtype:
        return np.ones(len(x), dtype=bool)
    if x.dtype == object:
        return x != y
    bits = [np.ascontiguousarray(column).view(np.uint8).reshape(len(column), -1) for column in (x, y)]
    return (bits[0] != bits[1]).any(axis=1)


def _empty(columns: Mapping[str, Column], n: int, requirements: int, names: Sequence[str]) -> Side:
    return Side(
        columns=dict(columns),
        outcome=np.empty(n, dtype=np.int8),
        success=[np.empty(n, dtype=bool) for _ in range(requirements)],
        values={name: np.empty(n) for name in names},
        ranked={name: np.empty(n) for name in RANKED if name in columns},
    )


def _keep(
    side: Side, rows: slice, frame: pd.DataFrame, requirements: Sequence[Requirement], columns: Mapping[str, Column]
) -> None:
    """Enters a block of rows. columns: of side A; they say for both sides whether a metric should be small or large."""
    outcome = frame["outcome"].to_numpy()
    for code, name in enumerate(OUTCOMES):
        side.outcome[rows][outcome == name] = code
    for success, requirement in zip(side.success, requirements, strict=True):
        success[rows] = complies(requirement, frame)
    lost = np.isin(outcome, FAILED)
    for name, values in side.values.items():
        values[rows] = np.where(lost, worst_value(columns.get(metric_column(name))), metric(frame, name, columns))
    for name, values in side.ranked.items():
        values[rows] = frame[name].to_numpy(dtype=float)


def folder_of(place: str | Place) -> RunFolder:
    """Opens a run folder; UsageError if the path does not exist."""
    path = place_of(place)
    if isinstance(path, Path) and not path.exists():
        raise UsageError(f"{path}: no such folder; accepted: a run folder, written by `rvjax run`")
    return RunFolder.open(path)


def flat(value: Any, place: str) -> Iterator[tuple[str, Any]]:
    """Every scalar of a campaign with its dotted path."""
    if is_mapping(value) or is_list(value):
        for key, part in value.items() if is_mapping(value) else enumerate(value):
            yield from flat(part, f"{place}.{key}".lstrip("."))
    else:
        yield place, value


def value_text(value: object, given: bool) -> str:
    """The value of a campaign key as text. given: the campaign file has the key; else the value is the default, None without."""
    if given:
        return f"{value}"
    return (
        "no value in its file"
        if value is None
        else f"the default {exact(value)}"
        if isinstance(value, float)
        else f"the default {value}"
    )
