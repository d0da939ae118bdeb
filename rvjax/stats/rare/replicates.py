"""Intervals from independent unbiased estimates p̂_r ≥ 0 of a probability p.

    nominal    p̂ ± t s/√R, Student's t with R − 1 degrees of freedom; replicates are skewed, so it errs more often than it says
    proved     L = inf {m : Σ_k w_k Π_r (1 + λ_k (p̂_r/m − 1)) < 1/α},   0 < λ_k ≤ 1 on a fixed grid, Σ w_k = 1

For m ≥ p each product is a nonnegative supermartingale that begins at 1, so P(L > p) ≤ α for every law of p̂_r with mean p and
for every rule that ends the replicates (Ville). Each factor falls as m grows, so L is the only crossing.

Source: I. Waudby-Smith, A. Ramdas, "Estimating means of bounded random variables by betting", JRSS B 86 (2024) 1 (here without
the upper bound, which the proof does not need).
"""

from __future__ import annotations

import math

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]
from numpy.typing import ArrayLike, NDArray

from rvjax.stats._binomial import check_share
from rvjax.stats.binomial import Estimate

BETS = (0.1, 0.25, 0.5, 0.75, 0.9, 1.0)
"""λ_k, with equal weights."""

FEWEST_POSITIVE = 10
"""Replicates above 0 that an interval needs."""

NOMINAL = "Student's t over independent replicates, nominal (approximate)"


def student_interval(estimates: ArrayLike, confidence: float) -> Estimate:
    """The mean with its two-sided interval, not below 0. Without two replicates the interval is [0, 1]."""
    check_share("confidence", confidence)
    p = _estimates(estimates)
    if p.size < 2:
        return Estimate(float(p[0]) if p.size else math.nan, 0.0, 1.0, p.size, confidence, NOMINAL)
    half = float(scipy.special.stdtrit(p.size - 1, (1.0 + confidence) / 2.0)) * float(np.std(p, ddof=1)) / math.sqrt(p.size)
    mean = float(np.mean(p))
    return Estimate(mean, max(mean - half, 0.0), min(mean + half, 1.0), p.size, confidence, NOMINAL)


def log_e_value(estimates: ArrayLike, mean: float) -> float:
    """ln Σ_k w_k Π_r (1 + λ_k (p̂_r/m − 1)): the evidence against "the mean is at most m"."""
    p = _estimates(estimates)
    with np.errstate(divide="ignore"):
        logs = np.log1p(np.outer(BETS, p / mean - 1.0)).sum(axis=1)
    return float(scipy.special.logsumexp(logs) - math.log(len(BETS)))


def proved_lower_bound(estimates: ArrayLike, confidence: float) -> float:
    """The lower bound L with P(L > p) ≤ 1 − confidence, whatever the law of the replicates; 0 without evidence."""
    check_share("confidence", confidence)
    p = _estimates(estimates)
    needed = -math.log1p(-confidence)
    if not np.any(p > 0.0):
        return 0.0
    low, high = math.log(float(np.max(p))) - 60.0, math.log(float(np.max(p)))  # no evidence against the largest
    if log_e_value(p, math.exp(low)) < needed:
        return 0.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if log_e_value(p, math.exp(middle)) >= needed else (low, middle)
    return math.exp(low)


def variation(estimates: ArrayLike) -> float:
    """The coefficient of variation of a replicate, s/p̂; NaN where it has no meaning."""
    p = _estimates(estimates)
    return float(np.std(p, ddof=1) / np.mean(p)) if p.size > 1 and np.any(p > 0.0) else math.nan


def lopsided(estimates: ArrayLike) -> str:
    """Why Student's interval says nothing: fewer than FEWEST_POSITIVE replicates above 0, or one that is most of their sum. Empty
    where nothing speaks against it."""
    p = _estimates(estimates)
    positive, total = int(np.count_nonzero(p)), float(p.sum())
    if positive < FEWEST_POSITIVE:
        return f"only {positive} of {p.size} replicates reached a failure"
    if float(p.max()) > 0.5 * total:
        return f"one of {p.size} replicates is {100 * float(p.max()) / total:.0f} % of their sum"
    return ""


def _estimates(estimates: ArrayLike) -> NDArray[np.float64]:
    p = np.asarray(estimates, dtype=np.float64).ravel()
    if not np.all((p >= 0.0) & np.isfinite(p)):
        raise ValueError(f"estimates must be finite and not negative; found {p[~((p >= 0.0) & np.isfinite(p))][:3].tolist()}")
    return p
