"""A requirement on a mean: empirical-Bernstein bounds if the range is stated, otherwise an approximate interval."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd  # pyright: ignore[reportMissingTypeStubs]
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second

from rvjax.analysis.verdicts import sentences
from rvjax.analysis.verdicts.compliance import RequirementEvaluator
from rvjax.analysis.verdicts.verdict import Under, Verdict, Word
from rvjax.columns import Column
from rvjax.run_folder.named_arrays import Record
from rvjax.stats import Estimate, bernstein_bounds, mean_interval

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rvjax.campaign import Requirement

FEW = 5_000
"""Up to this many values, a mean without a range has a bootstrap interval; above, the central limit theorem is as good."""

Moments = tuple[int, float, float]
"""Number of values, their mean, and their sum of squared deviations from the mean."""


class MeanTally:
    """Mean and spread of a metric over a class of samples, chunk by chunk in any order."""

    def __init__(self, requirement: Requirement) -> None:
        self.requirement = requirement
        self.evaluator = RequirementEvaluator(requirement)
        self._moments: dict[int, Moments] = {}
        self._values: dict[int, NDArray[np.float64]] | None = {} if requirement.range is None else None
        self._lost = self._outside = self._complying = self._flown = self._kept = 0

    def add(self, frame: pd.DataFrame, columns: Mapping[str, Column], begins: Sequence[int] = (0,)) -> None:
        """Adds the samples of chunks. A value that is not finite counts as the worse end of the range."""
        values, kept = self.evaluator.values(frame, columns), self.evaluator.kept(frame)
        chosen = kept & self.evaluator.of_class(frame)
        self._flown, self._kept = self._flown + len(frame), self._kept + int(np.count_nonzero(kept))
        samples = frame["sample"].to_numpy()
        for first, behind in pairwise((*begins, len(frame))):
            if behind > first:
                self._add(int(samples[first]), values[first:behind][chosen[first:behind]])

    def _add(self, first: int, values: NDArray[np.float64]) -> None:
        requirement = self.requirement
        self._complying += int(np.count_nonzero(self.evaluator.comply(values)))
        low, high = requirement.range or (-math.inf, math.inf)
        bad = ~np.isfinite(values)
        self._lost += int(np.count_nonzero(bad))
        values = np.where(bad, high if self.evaluator.bound.side == "below" else low, values)
        self._outside += int(np.count_nonzero((values < low) | (values > high)))
        if not values.size:
            return
        if np.isfinite(values).all():
            mean = float(values.mean())
            self._moments[first] = (values.size, mean, float(np.square(values - mean).sum()))
        else:
            self._moments[first] = (values.size, float(values[~np.isfinite(values)][0]), 0.0)
        if self._values is not None:
            self._values[first] = values
            self._drop_many()

    def _drop_many(self) -> None:
        """Drops the values where there are more than `FEW`."""
        if self._values is not None and sum(map(len, self._values.values())) > FEW:
            self._values = None

    def merge(self, other: MeanTally) -> None:
        """Adds the chunks of another tally of the same requirement; ValueError if a chunk is in both."""
        if common := self._moments.keys() & other._moments.keys():
            raise ValueError(f"the chunk from sample {min(common)} on is counted twice")
        self._moments |= other._moments
        self._values = None if self._values is None or other._values is None else self._values | other._values
        self._drop_many()
        self._lost += other._lost
        self._outside += other._outside
        self._complying += other._complying
        self._flown, self._kept = self._flown + other._flown, self._kept + other._kept

    def record(self) -> Record:
        """All of it, for `restore`."""
        firsts = sorted(self._moments)
        size, mean, squares = ([self._moments[first][part] for first in firsts] for part in range(3))
        numbers = {"first": np.array(firsts, np.int64), "size": np.array(size, np.int64)}
        numbers |= {"mean": np.array(mean, np.float64), "squares": np.array(squares, np.float64)}
        if self._values is not None:
            numbers["values"] = np.concatenate([np.empty(0), *(self._values[first] for first in firsts)])
        counts = {"lost": self._lost, "outside": self._outside, "complying": self._complying}
        counts |= {"flown": self._flown, "kept": self._kept}
        return Record.of_numbers(numbers, **counts)

    def restore(self, record: Record, firsts: Sequence[int]) -> None:
        """Takes over all of a record. firsts: the first samples of the chunks that were added; a chunk without samples of the
        class is not in the record. ValueError if it contradicts itself or these."""
        first, size = record.numbers("first"), record.numbers("size")
        mean, squares = record.numbers("mean", np.float64), record.numbers("squares", np.float64)
        if not {*first.tolist()} <= {*firsts} or not np.all(first[1:] > first[:-1]) or not np.all(size > 0):
            raise ValueError("a mean of other chunks")
        moments = zip(size.tolist(), mean.tolist(), squares.tolist(), strict=True)
        self._moments = dict(zip(first.tolist(), moments, strict=True))
        kept = self._values is not None and size.sum() <= FEW
        self._values = None
        if kept:
            values = record.numbers("values", np.float64)
            if values.size != size.sum():
                raise ValueError(f"a mean of {values.size} values for {int(size.sum())} samples")
            self._values = dict(zip(first.tolist(), np.split(values, np.cumsum(size)[:-1]), strict=True)) if size.size else {}
        self._lost, self._outside, self._complying = (int(record.document[name]) for name in ("lost", "outside", "complying"))
        self._flown, self._kept = (int(record.document[name]) for name in ("flown", "kept"))
        if min(self._lost, self._outside, self._complying, self._flown - self._kept, self._kept - int(size.sum())) < 0:
            raise ValueError("a mean whose counts contradict each other")

    def decided(self) -> bool:
        """Never before the end: a mean is judged once."""
        return False

    def verdict(self) -> Verdict:
        """The verdict from the samples added so far."""
        requirement = self.requirement
        bound, estimate = self.evaluator.bound, self._estimate()
        limit = bound.value
        good = estimate.high < limit if bound.side == "below" else estimate.low > limit
        bad = estimate.low >= limit if bound.side == "below" else estimate.high <= limit
        word: Word = "UNDECIDED" if self._outside or not estimate.n else "PASS" if good else "FAIL" if bad else "UNDECIDED"
        law = requirement.under
        under = None if law is None else Under(law=law, kept=self._kept, flown=self._flown)
        unit, counts = self.evaluator.unit, {"outside": self._outside, "lost": self._lost}
        text = sentences.of_mean(requirement, bound, estimate, unit, **counts, under=under)
        return Verdict(
            requirement=requirement,
            verdict=word,
            successes=self._complying,
            n=estimate.n,
            limit=limit,
            estimate=estimate,
            quantity=None,
            more=None,
            text=f"{word}: {text}",
            unit=unit,
            under=under,
        )

    def _estimate(self) -> Estimate:
        confidence = self.requirement.confidence
        n, mean, squares = _merged([self._moments[first] for first in sorted(self._moments)])
        if self.requirement.range is not None:
            low, high = bernstein_bounds(n, mean, squares / (n - 1) if n > 1 else 0.0, *self.requirement.range, confidence)
            return Estimate(mean, low, high, n, confidence, "empirical Bernstein, each bound one-sided")
        if self._values is not None:
            values = [self._values[first] for first in sorted(self._values)]
            interval = mean_interval(np.concatenate(values) if values else np.empty(0), 2.0 * confidence - 1.0)
            return Estimate(interval.value, interval.low, interval.high, n, confidence, f"approximate: {interval.method}")
        if not math.isfinite(mean):
            return Estimate(mean, mean, mean, n, confidence, "approximate: the mean of values that are not finite")
        half = float(scipy.special.ndtri(confidence)) * math.sqrt(squares / (n - 1) / n)
        return Estimate(mean, mean - half, mean + half, n, confidence, "approximate: central limit theorem")


def _merged(parts: list[Moments]) -> Moments:
    """The moments of all parts together. Source: T. F. Chan, G. H. Golub & R. J. LeVeque (1983)."""
    n, mean, squares = 0, math.nan, 0.0
    for count, center, spread in parts:
        if not n:
            n, mean, squares = count, center, spread
            continue
        if not (math.isfinite(mean) and math.isfinite(center)):
            n, mean = n + count, mean if not math.isfinite(mean) else center
            continue
        total, step = n + count, center - mean
        mean, squares, n = mean + step * count / total, squares + spread + step * step * n * count / total, total
    return n, mean, squares
