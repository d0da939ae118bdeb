"""SamplingDesign: how the samples of a run were chosen, and so which inferences from them are valid.

    Independent     independent draws of the campaign's distributions: intervals of shares and quantiles, verdicts on requirements
    Exploration     a plan that fills the space of the draws: observed values only

The type of a sampler says its design. Only an `Independent` has bounds, so only it has verdicts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second
from numpy.typing import ArrayLike, NDArray

from rvjax import stats
from rvjax.stats import Estimate
from rvjax.stats.quantile_sketch import Sketch


@dataclass(frozen=True)
class Observed:
    """A number observed on the flown samples. It has no interval: it says nothing about other samples."""

    value: float
    n: int


@dataclass(frozen=True)
class Independent:
    """Samples that are independent draws of a distribution."""

    sentence: str = ""

    def bounds(self, successes: int, n: int, confidence: float) -> Estimate:
        """The share of successes with two one-sided bounds, each at the confidence: the base of a verdict."""
        low, high = (bound(successes, n, confidence) for bound in (stats.clopper_pearson_lower, stats.clopper_pearson_upper))
        return Estimate(successes / n if n else math.nan, low, high, n, confidence, "Clopper-Pearson, each bound one-sided")

    def share(self, successes: int, n: int, confidence: float) -> Estimate:
        """The share of successes with its two-sided interval."""
        return stats.clopper_pearson(successes, n, confidence)

    def quantile(self, values: ArrayLike | Sketch, q: float, confidence: float) -> Estimate:
        """A quantile with its interval."""
        return stats.quantile_interval(values, q, confidence)

    def band(self, n: int, confidence: float) -> float:
        """Half-width of the band about a distribution function."""
        return stats.dkw_band(n, confidence)

    def correlation(self, x: NDArray[np.float64], y: NDArray[np.float64], confidence: float) -> Estimate:
        """Spearman's r with the interval tanh(artanh r ± z √((1 + r²/2) / (n − 3))).

        `x`, `y`: (n,), n > 3, any units, infinities too. Without variation in x or y the value is 0, the interval [-1, 1].
        Approximate: D. G. Bonett & T. A. Wright, Psychometrika 65 (2000) 23.
        """
        method = "Spearman rank correlation, Bonett-Wright interval, approximate"
        r = _spearman(x, y)
        if r is None:
            return Estimate(0.0, -1.0, 1.0, x.size, confidence, method)
        centre = math.atanh(min(max(r, -1 + 1e-12), 1 - 1e-12))
        half = float(scipy.special.ndtri((1 + confidence) / 2)) * math.sqrt((1 + r * r / 2) / (x.size - 3))
        low, high = math.tanh(centre - half), math.tanh(centre + half)
        return Estimate(r, min(low, r), max(high, r), x.size, confidence, method)

    def words(self, of_intervals: str) -> str:
        """A remark about intervals, for a report."""
        return of_intervals


@dataclass(frozen=True)
class Exploration:
    """Samples of a plan. sentence: a remark for the report."""

    sentence: str = "exploration: no verdicts"

    def share(self, successes: int, n: int, confidence: float) -> Observed:
        """The share of successes among the samples."""
        del confidence
        return Observed(successes / n if n else math.nan, n)

    def quantile(self, values: ArrayLike | Sketch, q: float, confidence: float) -> Observed:
        """A quantile of the samples."""
        estimate = stats.quantile_interval(values, q, confidence)
        return Observed(estimate.value, estimate.n)

    def band(self, n: int, confidence: float) -> None:
        """None: there is no band, only the empirical distribution function."""

    def correlation(self, x: NDArray[np.float64], y: NDArray[np.float64], confidence: float) -> Observed:
        """Spearman's r of the samples."""
        del confidence
        return Observed(_spearman(x, y) or 0.0, x.size)

    def words(self, of_intervals: str) -> str:
        """Empty: there are no intervals."""
        del of_intervals
        return ""


SamplingDesign: TypeAlias = Independent | Exploration


def _spearman(x: NDArray[np.float64], y: NDArray[np.float64]) -> float | None:
    """Spearman's r; None if x or y does not vary."""
    import pandas as pd  # pyright: ignore[reportMissingTypeStubs]  # imported here: a verdict does not need it

    first, second = (np.asarray(pd.Series(values).rank(), dtype=np.float64) for values in (x, y))
    return None if np.ptp(first) == 0 or np.ptp(second) == 0 else float(np.corrcoef(first, second)[0, 1])
