"""Distributions of width zero are fixed numbers: `{uniform: [a, a]}`, `{normal: [m, 0]}`, `{ball: 0}` and all others alike.

A fixed number is not drawn, so it has no column and no stream, and other draws do not change.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence


def _ends(low: float, high: float) -> float | None:
    return low if low == high else None


def _spread(middle: float, spread: float) -> float | None:
    return middle if spread == 0.0 else None


def _size(size: float, *shape: float) -> float | None:
    return 0.0 if size == 0.0 and all(number > 0.0 for number in shape) else None


def _truncated(mean: float, sd: float, low: float, high: float) -> float | None:
    if low == high and sd >= 0.0:
        return low
    return mean if sd == 0.0 and low <= mean <= high else None


def _above_zero(low: float, high: float) -> float | None:
    return _ends(low, high) if low > 0.0 else None


def _median(median: float, sigma: float) -> float | None:
    return _spread(median, sigma) if median > 0.0 else None


def _three(low: float, mode: float, high: float) -> float | None:
    return low if low == mode == high else None


def _shaped(a: float, b: float, low: float, high: float) -> float | None:
    return _ends(low, high) if a > 0.0 and b > 0.0 else None


NUMBERS: dict[str, Callable[..., float | None]] = {
    "uniform": _ends,
    "normal": _spread,
    "truncated_normal": _truncated,
    "log_uniform": _above_zero,
    "half_normal": _size,
    "log_normal": _median,
    "triangular": _three,
    "beta": _shaped,
    "exponential": _size,
    "weibull": _size,
    "poisson": _size,
}
"""By the word in a campaign: the number that the parameters leave, or None if the distribution has a width or is not valid."""


def only_number(word: str, parameters: Sequence[float]) -> float | None:
    """The number that a distribution of width zero is; None for every other distribution."""
    return NUMBERS[word](*parameters)
