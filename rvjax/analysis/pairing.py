"""Pairing: the samples of two run folders side by side, once their draws have been found to be the same, bit for bit.

Both folders are read chunk by chunk, whatever the size of their chunks; draws are compared and let go, and of everything else
only what a comparison looks at is kept: about 100 bytes a pair.
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
from rvjax.campaign.plain_values import is_list, is_mapping
from rvjax.columns import DRAW, Column, drawn_columns, metric_column
from rvjax.errors import FolderError, IncompleteError, UsageError
from rvjax.run_folder import OUTCOMES, RunFolder

BLOCK = 16_384
"""Rows that are read of each folder before they are compared and let go."""


NAMED = 3
"""Columns that a refusal names."""

RANKED = ("outcome_time_s", metric_column("window_position_error_m"), metric_column("settling_time_s"))
"""What decides, beside the outcome, which of two samples is worse."""


@dataclass
class Side:
    """What is kept of one folder, row by row of the common samples.

    success: (n,) by the number of the requirement. values: (n,) by metric, in SI, the worst value where not finite.
    """

    columns: dict[str, Column]
    outcome: NDArray[np.int8]
    success: list[NDArray[np.bool_]]
    values: dict[str, NDArray[np.float64]]
    ranked: dict[str, NDArray[np.float64]] = field(default_factory=dict[str, NDArray[np.float64]])

    def rows(self, samples: NDArray[np.int64]) -> pd.DataFrame:
        """The columns of some samples that say which of them is worse."""
        outcome = np.array(OUTCOMES, dtype=object)[self.outcome[samples]]
        return pd.DataFrame({"sample": samples, "outcome": outcome} | {name: x[samples] for name, x in self.ranked.items()})


@dataclass(frozen=True)
class Paired:
    """Two folders on the same draws. only_a, only_b: draws that the other one does not have, by name without `draw.`."""

    n: int
    a: Side
    b: Side
    only_a: tuple[str, ...]
    only_b: tuple[str, ...]


class _Reader:
    """The rows of a folder in the order of their samples, as many at a time as are asked for."""

    def __init__(self, folder: RunFolder) -> None:
        self.path = folder.path
        self._tables = folder.tables()
        self._ledger = Ledger()
        self._left = pd.DataFrame()
        self._read(1)

    @property
    def columns(self) -> dict[str, Column]:
        """The meaning of every column."""
        return self._ledger.columns

    def _read(self, many: int) -> None:
        parts = [self._left] if len(self._left) else []
        there = len(self._left)
        while there < many and (table := next(self._tables, None)) is not None:
            chunk, frame, columns = table
            before = self._ledger.n
            self._ledger.add(chunk, frame, columns)
            if frame["sample"].iloc[0] != before or set(frame["outcome"]) - set(OUTCOMES):
                raise FolderError(f"{self.path}: chunk {chunk} has other samples or outcomes than it should; fly it again")
            parts.append(frame)
            there += len(frame)
        self._left = pd.concat(parts, ignore_index=True) if len(parts) > 1 else parts[0]

    def take(self, many: int) -> pd.DataFrame:
        """The next rows."""
        self._read(many)
        taken, self._left = self._left.iloc[:many], self._left.iloc[many:]
        return taken.reset_index(drop=True)


def pair(
    a: RunFolder,
    b: RunFolder,
    requirements: Sequence[Requirement],
    metrics: Callable[[Mapping[str, Column], Mapping[str, Column]], Sequence[str]],
    common: bool = False,
) -> Paired:
    """The samples that both folders have, side by side.

    requirements: of which each side's successes are kept. metrics: of the columns of both sides, the names of the metrics whose
    values are kept. common: whether folders of different size may be compared at all.

    Errors: UsageError where the numbers of samples or the draws differ, naming the first columns that do, or a metric is not
    there; IncompleteError where samples are missing; FolderError where a folder is damaged.
    """
    n = _size(a, b, common)
    readers = _Reader(a), _Reader(b)
    names = metrics(readers[0].columns, readers[1].columns)
    drawn = [drawn_columns(reader.columns) for reader in readers]
    shared = [name for name in drawn[0] if name in drawn[1]]
    if not shared and any(drawn):
        raise UsageError(f"{a.path} and {b.path}: no draw in common, so nothing shows that their samples are the same ones")
    sides = [_empty(reader.columns, n, len(requirements), names) for reader in readers]
    for first in range(0, n, BLOCK):
        frames = [reader.take(min(BLOCK, n - first)) for reader in readers]
        _same_draws(a, b, frames[0], frames[1], shared)
        for side, frame in zip(sides, frames, strict=True):
            _keep(side, slice(first, first + len(frame)), frame, requirements, sides[0].columns)
    lone = [tuple(name.removeprefix(DRAW) for name in own if name not in shared) for own in drawn]
    return Paired(n, sides[0], sides[1], lone[0], lone[1])


def _size(a: RunFolder, b: RunFolder, common: bool) -> int:
    """How many samples both have."""
    for folder in (a, b):
        if missing := folder.requested - sum(chunk.count for chunk in folder.chunks):
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
    """UsageError unless the columns of two tables are the same, bit for bit."""
    differing: list[str] = []
    for name in columns:
        one, other = first[name].to_numpy(), second[name].to_numpy()
        apart = np.flatnonzero(_apart(one, other))
        if apart.size:
            at = apart[0]
            differing.append(f"{name} (sample {first['sample'].iloc[at]}: {one[at]!s} and {other[at]!s})")
    if differing:
        rest = f" and {len(differing) - NAMED} more" if len(differing) > NAMED else ""
        raise UsageError(
            f"{a.path} and {b.path} are not on the same draws: {', '.join(differing[:NAMED])}{rest} differ; accepted: runs of "
            "one seed and one set of dispersions, which may have other controllers"
        )


def _apart(one: NDArray[Any], other: NDArray[Any]) -> NDArray[np.bool_]:
    """(n,) where two columns differ in a bit."""
    if one.dtype != other.dtype:
        return np.ones(len(one), dtype=bool)
    if one.dtype == object:
        return one != other
    bits = [np.ascontiguousarray(x).view(np.uint8).reshape(len(x), -1) for x in (one, other)]
    return (bits[0] != bits[1]).any(axis=1)


def _empty(columns: Mapping[str, Column], n: int, requirements: int, names: Sequence[str]) -> Side:
    return Side(
        dict(columns),
        np.empty(n, dtype=np.int8),
        [np.empty(n, dtype=bool) for _ in range(requirements)],
        {name: np.empty(n) for name in names},
        {name: np.empty(n) for name in RANKED if name in columns},
    )


def _keep(
    side: Side, rows: slice, frame: pd.DataFrame, requirements: Sequence[Requirement], columns: Mapping[str, Column]
) -> None:
    """Enters a block of rows. columns: whose sense of better is the one of both sides."""
    outcome = frame["outcome"].to_numpy()
    for code, name in enumerate(OUTCOMES):
        side.outcome[rows][outcome == name] = code
    for success, requirement in zip(side.success, requirements, strict=True):
        success[rows] = complies(requirement, frame)
    lost = outcome == "not_finite"
    for name, values in side.values.items():
        values[rows] = np.where(lost, worst_value(columns.get(metric_column(name))), metric(frame, name, columns))
    for name, values in side.ranked.items():
        values[rows] = frame[name].to_numpy(dtype=float)


def folder_of(path: Path) -> RunFolder:
    """The run folder, or UsageError where there is nothing at all."""
    if not path.exists():
        raise UsageError(f"{path}: no such folder; accepted: a run folder, as `rvjax run` makes it")
    return RunFolder.open(path)


def flat(value: Any, place: str) -> Iterator[tuple[str, Any]]:
    """Every plain value of a campaign by its place."""
    if is_mapping(value) or is_list(value):
        for key, part in value.items() if is_mapping(value) else enumerate(value):
            yield from flat(part, f"{place}.{key}".lstrip("."))
    else:
        yield place, value


def said(values: Mapping[str, Any], key: str) -> str:
    """A value of a campaign, or that it says nothing there."""
    return f"{values[key]}" if key in values else "nothing"
