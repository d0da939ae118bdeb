"""Means: a bound that holds for every distribution of a bounded metric, and an approximate bootstrap.

Sources: A. Maurer & M. Pontil, Empirical Bernstein bounds and sample-variance penalization, COLT (2009), theorem 4;
B. Efron, J. Am. Stat. Assoc. 82 (1987) 171 (BCa).
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rvjax.stats._binomial import check_share, invalid, ranked
from rvjax.stats.binomial import Estimate

RESAMPLES = 2000
"""Bootstrap resamples per interval."""

CORRECTED = 5_000
"""Largest number of values with a corrected bootstrap (BCa): its time grows with n², the correction falls with 1/n."""

AT_ONCE = 10**7
"""Most numbers that are resampled at once, unless a single resample has more."""

Statistic = Callable[..., NDArray[Any]]
"""(values, axis) -> their summary along the axis, as np.mean has it."""


def empirical_bernstein_upper(values: ArrayLike, low: float, high: float, confidence: float) -> float:
    """mean + (high - low) (sqrt(2 V L / n) + 7 L / (3 (n - 1))), L = ln(2 / (1 - confidence)).

    One-sided: P(bound >= true mean) >= confidence for independent values of any distribution on [low, high] and every n; V is the
    variance (denominator n - 1) over (high - low)^2. At most `high`, which it is for n < 2. NaN and infinities count as `high`.
    ValueError if low >= high or a finite value lies outside. Source: Maurer & Pontil (2009), theorem 4.
    """
    x = _bounded(values, low, high, worst=high)
    return min(high, float(np.mean(x)) + _margin(x, low, high, 1 - confidence)) if x.size > 1 else high


def empirical_bernstein_lower(values: ArrayLike, low: float, high: float, confidence: float) -> float:
    """The mirror image of `empirical_bernstein_upper`; at least `low`. NaN and infinities count as `low`."""
    x = _bounded(values, low, high, worst=low)
    return max(low, float(np.mean(x)) - _margin(x, low, high, 1 - confidence)) if x.size > 1 else low


def empirical_bernstein(values: ArrayLike, low: float, high: float, confidence: float = 0.95) -> Estimate:
    """The mean with its lower and upper bound, each one-sided at (1 + confidence) / 2.

    For independent values of any distribution on [low, high].
    Not-finite values count as the end that makes the interval wider: as `low` below, as `high` above and in the mean.
    Without values the mean is NaN and the interval [low, high]. ValueError as in `empirical_bernstein_upper`.
    """
    side = (1 + confidence) / 2
    least, most = (bound(values, low, high, side) for bound in (empirical_bernstein_lower, empirical_bernstein_upper))
    x = _bounded(values, low, high, worst=high)
    return Estimate(float(np.mean(x)) if x.size else math.nan, least, most, x.size, confidence, "empirical Bernstein")


def bernstein_bounds(n: int, mean: float, variance: float, low: float, high: float, confidence: float) -> tuple[float, float]:
    """The lower and upper bound, each one-sided at `confidence`, from the moments of n values on [low, high]; variance over
    n - 1.

    As `empirical_bernstein_lower` and `empirical_bernstein_upper`; (low, high) for n < 2.
    """
    check_share("confidence", confidence)
    if n < 2:
        return low, high
    half = _half_width(n, variance, low, high, 1 - confidence)
    return max(low, mean - half), min(high, mean + half)


def bootstrap_interval(
    values: ArrayLike,
    statistic: Statistic,
    confidence: float = 0.95,
    *,
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> Estimate:
    """statistic(values) with its BCa bootstrap interval: approximate, for smooth summaries only, never for a verdict.

    `statistic(values, axis=...)` reduces an axis. Above `CORRECTED` values the interval is that of percentiles; also if the
    correction is undefined (leaving out any value changes nothing). NaN counts as +inf. If a value is not finite, or all
    values are the same, both ends are the statistic. Fewer than two values: (-inf, inf).
    Source: Efron (1987).
    """
    check_share("confidence", confidence)
    x = ranked(values, math.inf)
    method = "bootstrap, approximate, {} resamples"
    if not x.size:
        return Estimate(math.nan, -math.inf, math.inf, 0, confidence, "BCa " + method.format(resamples))
    value = float(statistic(x, axis=-1))
    if x.size < 2 and math.isfinite(value):
        return Estimate(value, -math.inf, math.inf, x.size, confidence, "BCa " + method.format(resamples))
    if not np.isfinite(x).all() or x[0] == x[-1]:
        return Estimate(value, value, value, x.size, confidence, "BCa " + method.format(resamples))
    # imported here: it takes half a second, and a verdict does not need it
    from scipy.stats import bootstrap  # pyright: ignore[reportMissingTypeStubs, reportUnknownVariableType]

    for kind in ("BCa", "percentile") if x.size <= CORRECTED else ("percentile",):
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # of degenerate data, which are handled below
            interval: Any = bootstrap(
                (x,),
                statistic,
                n_resamples=resamples,
                batch=max(1, AT_ONCE // x.size),
                vectorized=True,
                confidence_level=confidence,
                method=kind,
                rng=rng,
            ).confidence_interval
        low, high = float(interval.low), float(interval.high)
        if math.isfinite(low) and math.isfinite(high):
            return Estimate(value, min(low, value), max(high, value), x.size, confidence, f"{kind} {method.format(resamples)}")
    return Estimate(value, -math.inf, math.inf, x.size, confidence, f"percentile {method.format(resamples)}")


def mean_interval(values: ArrayLike, confidence: float = 0.95) -> Estimate:
    """The mean with its BCa bootstrap interval: approximate, never for a verdict.

    On skewed values the bound on the side of the long tail errs several times as often as stated: for 20 values of a log-normal
    law with σ = 1 in 13 % of cases, where 2.5 % are meant (`tests/stats/test_means.py`). The resampling generator is fixed, so
    the same values always give the same interval. A value that is not finite makes the mean infinite; fewer than two values have
    the interval (-inf, inf).
    """
    return bootstrap_interval(values, np.mean, confidence, rng=np.random.Generator(np.random.Philox(key=0)))


def _bounded(values: ArrayLike, low: float, high: float, worst: float) -> NDArray[np.float64]:
    """(n,) values, all in [low, high]; values that are not finite become the worst."""
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise invalid("low must be below high, both finite", f"{low} and {high}")
    x = np.asarray(values, dtype=float).ravel()
    x = np.where(np.isfinite(x), x, worst)
    if x.size and not (low <= x.min() and x.max() <= high):
        raise invalid(f"values must be between {low} and {high}", f"{x.min()} to {x.max()}")
    return x


def _margin(x: NDArray[np.float64], low: float, high: float, risk: float) -> float:
    """The half-width of the bound, with probability of error `risk`."""
    check_share("confidence", 1 - risk)
    return _half_width(x.size, float(np.var(x, ddof=1)), low, high, risk)


def _half_width(n: int, variance: float, low: float, high: float, risk: float) -> float:
    log = math.log(2 / risk)
    return math.sqrt(2 * variance * log / n) + (high - low) * 7 * log / (3 * (n - 1))
