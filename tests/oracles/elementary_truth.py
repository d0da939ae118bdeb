"""Elementary functions by mpmath, and the arguments at which they are hard. Imports nothing of what it checks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import mpmath
import numpy as np
from numpy.typing import NDArray


class Truth(NamedTuple):
    """exact: by mpmath. ranges: (float64, float32) intervals of x, drawn from evenly. sizes: binary exponents of |x|, both signs.

    near: (a, lowest exponent): numbers a ± 2^e, from 2^-2 down. inside: where the function is real.
    """

    exact: Callable[[Any], Any]
    ranges: tuple[tuple[tuple[float, float], ...], tuple[tuple[float, float], ...]]
    near: float | None = None
    inside: tuple[float, float] = (-np.inf, np.inf)


def _both(*ranges: tuple[float, float]) -> tuple[tuple[tuple[float, float], ...], tuple[tuple[float, float], ...]]:
    return ranges, ranges


TRUTHS: dict[str, Truth] = {
    "exp": Truth(mpmath.exp, (((-2, 2), (-746, 710.5), (-746, -707)), ((-2, 2), (-104.5, 89), (-104.5, -87)))),
    "expm1": Truth(mpmath.expm1, (((-2, 2), (-50, 710.5), (0.346, 0.5)), ((-2, 2), (-30, 89), (0.346, 0.5)))),
    "tanh": Truth(mpmath.tanh, _both((-1.5, 1.5), (-22, 22), (0.25, 1.2))),
    "log": Truth(mpmath.log, _both((0.4, 2.5), (0, 1000)), 1.0, (0, np.inf)),
    "log1p": Truth(mpmath.log1p, _both((-0.6, 1.5), (0, 1000)), -1.0, (-1, np.inf)),
    "log2": Truth(lambda x: mpmath.log(x, 2), _both((0.4, 2.5), (0, 1000)), 1.0, (0, np.inf)),
    "erf": Truth(mpmath.erf, _both((-1.5, 1.5), (-7, 7), (0.5, 2.5))),
}


def arguments(truth: Truth, kind: type[np.floating[Any]], count: int) -> NDArray[Any]:
    """`count` numbers of each of the ranges, of all exponents, of moderate exponents and of those next to `near`."""
    generator, info = np.random.default_rng(7), np.finfo(kind)
    ranges = truth.ranges[0 if kind is np.float64 else 1]
    drawn = [generator.uniform(low, high, count) for low, high in ranges]

    def sized(low: int, high: int) -> NDArray[np.float64]:
        exponents = generator.integers(low, high, count)
        return np.ldexp(generator.choice([-1.0, 1.0], count) * generator.uniform(1, 2, count), exponents)

    drawn += [sized(int(info.minexp - info.nmant), int(info.maxexp)), sized(-info.nmant - 8, 3)]
    if truth.near is not None:
        drawn.append(truth.near + sized(-info.nmant, -2))
    with np.errstate(over="ignore"):
        x = np.concatenate(drawn).astype(kind)
    return x[np.isfinite(x) & (x > truth.inside[0]) & (x < truth.inside[1])]


INF, NAN = np.inf, np.nan

SPECIAL_VALUES: tuple[tuple[str, float, float], ...] = (
    *(("exp", x, y) for x, y in ((0.0, 1.0), (-0.0, 1.0), (INF, INF), (-INF, 0.0), (1e30, INF), (-1e30, 0.0))),
    *(("expm1", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (INF, INF), (-INF, -1.0), (1e30, INF), (-1e30, -1.0))),
    *(("tanh", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (INF, 1.0), (-INF, -1.0), (1e30, 1.0), (-30.0, -1.0))),
    *(("log", x, y) for x, y in ((1.0, 0.0), (0.0, -INF), (-0.0, -INF), (INF, INF), (-INF, NAN), (-1.0, NAN))),
    *(("log1p", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (-1.0, -INF), (INF, INF), (-INF, NAN), (-2.0, NAN))),
    *(("log2", x, y) for x, y in ((1.0, 0.0), (0.0, -INF), (-0.0, -INF), (INF, INF), (-INF, NAN), (8.0, 3.0), (0.125, -3.0))),
    *(("erf", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (INF, 1.0), (-INF, -1.0), (8.0, 1.0), (-1e30, -1.0))),
)
"""(function, x, f(x)) as C99 has them, annex F.10."""
