"""Shared by the bounds: the binomial distribution, a search over counts, checks of arguments."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second
from numpy.typing import ArrayLike, NDArray

STRIDE = 8
"""Ratio of the strides of two successive passes of `largest`."""

Holds = Callable[[NDArray[np.int64], NDArray[np.int64]], NDArray[np.bool_]]
"""(counts, sizes) -> whether something holds there."""


def binomial_cdf(k: ArrayLike, n: ArrayLike, p: ArrayLike) -> NDArray[np.float64]:
    """P(Bin(n, p) <= k) = I_{1-p}(n - k, k + 1), for any k; broadcasts."""
    count, size = np.asarray(k, dtype=float), np.asarray(n, dtype=float)
    inside = (count >= 0) & (count < size)
    below = scipy.special.betainc(
        np.where(inside, size - count, 1.0), np.where(inside, count, 0.0) + 1, 1 - np.asarray(p, dtype=float)
    )
    return np.where(inside, below, count >= 0)


def binomial_pmf(n: int, p: float) -> NDArray[np.float64]:
    """P(Bin(n, p) = k) for k = 0..n, from logarithms: only probabilities below 1e-308 become 0."""
    k = np.arange(n + 1.0)
    chosen = -scipy.special.betaln(n - k + 1, k + 1) - np.log(n + 1)
    law = np.exp(chosen + scipy.special.xlogy(k, p) + scipy.special.xlog1py(n - k, -p))
    return law / law.sum()


def largest(holds: Holds, sizes: ArrayLike) -> NDArray[np.int64]:
    """The largest count k in 0..n at which `holds`, for every size n; -1 if there is none. Has the shape of `sizes`.

    `holds` must be true up to some k and false above it, and that k must not fall with n. So the answers for every 8th size
    enclose those between them: for most sizes no count is left to try, for the others two or three.
    """
    n, place = np.unique(np.asarray(sizes, dtype=np.int64), return_inverse=True)
    counts = np.full(n.size, -1, dtype=np.int64)
    if not n.size:
        return counts.reshape(np.shape(sizes))
    stride, last = 1, n.size - 1
    while stride <= last:
        stride *= STRIDE
    low, high = np.full(1, -1, dtype=np.int64), n[-1:]
    while True:
        here = np.arange(0, n.size, stride, dtype=np.int64)
        counts[here] = _bisect(holds, n[here], low, np.minimum(high, n[here]))
        if stride == 1:
            return counts[place].reshape(np.shape(sizes))
        finer = np.arange(0, n.size, stride // STRIDE, dtype=np.int64)
        before = finer - finer % stride
        low, high = counts[before], np.where(before + stride <= last, counts[np.minimum(before + stride, last)], n[-1])
        stride //= STRIDE


def _bisect(holds: Holds, n: NDArray[np.int64], low: NDArray[np.int64], high: NDArray[np.int64]) -> NDArray[np.int64]:
    """The largest count in low..high at which `holds`, given that it holds at `low` (or low = -1)."""
    low, high = low.copy(), np.maximum(low, high)
    while (open_ := np.flatnonzero(low < high)).size:
        middle = (low[open_] + high[open_] + 1) // 2
        true = holds(middle, n[open_])
        low[open_] = np.where(true, middle, low[open_])
        high[open_] = np.where(true, high[open_], middle - 1)
    return low


def ranked(values: ArrayLike, worst: float) -> NDArray[np.float64]:
    """The values in ascending order, NaN replaced by the worst."""
    x = np.asarray(values, dtype=float).ravel()
    return np.sort(np.where(np.isnan(x), worst, x))


def invalid(rule: str, value: object) -> ValueError:
    """The error about an argument: the rule that it breaks, and its value."""
    return ValueError(f"{rule}; found {value}")


def check_share(name: str, value: float) -> None:
    """ValueError unless 0 < value < 1."""
    if not 0 < value < 1:
        raise invalid(f"{name} must be between 0 and 1, both excluded", value)


def whole(name: str, values: ArrayLike, least: int = 0) -> NDArray[np.int64]:
    """The values as whole numbers >= least; ValueError for any other values."""
    given: NDArray[Any] = np.asarray(values)
    number = given.astype(np.int64) if given.size == 0 or np.all(np.isfinite(given)) else np.zeros(0, np.int64)
    if number.shape != given.shape or np.any(number != given) or np.any(number < least):
        raise invalid(f"{name} must be whole numbers >= {least}", values)
    return number
