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
    reach: largest |x| at which digits are promised, (float64, float32).
    """

    exact: Callable[[Any], Any]
    ranges: tuple[tuple[tuple[float, float], ...], tuple[tuple[float, float], ...]]
    near: float | None = None
    inside: tuple[float, float] = (-np.inf, np.inf)
    reach: tuple[float, float] = (np.inf, np.inf)


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
    "exp2": Truth(lambda x: mpmath.power(2, x), (((-2, 2), (-1076, 1024.5)), ((-2, 2), (-151, 128.5)))),
    "sinh": Truth(mpmath.sinh, (((-2, 2), (-711, 711), (0.9, 1.5)), ((-2, 2), (-89.5, 89.5), (0.9, 1.5)))),
    "cosh": Truth(mpmath.cosh, (((-2, 2), (-711, 711)), ((-2, 2), (-89.5, 89.5)))),
    "tan": Truth(mpmath.tan, (((-1.6, 1.6), (-20, 20), (-1e8, 1e8)), ((-1.6, 1.6), (-20, 20), (-1e4, 1e4))), reach=(1e8, 1e4)),
    "atan": Truth(mpmath.atan, _both((-3, 3), (0.3, 0.7), (-100, 100))),
    "asin": Truth(mpmath.asin, _both((-1, 1), (0.4, 0.6)), 1.0, (-1, 1)),
    "acos": Truth(mpmath.acos, _both((-1, 1), (-0.6, 0.6)), -1.0, (-1, 1)),
    "asinh": Truth(mpmath.asinh, _both((-2, 2), (-100, 100))),
    "acosh": Truth(mpmath.acosh, _both((1, 1.2), (1, 100)), 1.0, (1, np.inf)),
    "atanh": Truth(mpmath.atanh, _both((-1, 1), (-0.4, 0.4)), 1.0, (-1, 1)),
    "cbrt": Truth(lambda x: mpmath.sign(x) * mpmath.cbrt(abs(x)), _both((-8, 8), (0.9, 1.1))),
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
    reach = truth.reach[0 if kind is np.float64 else 1]
    return x[np.isfinite(x) & (np.abs(x) <= reach) & (x > truth.inside[0]) & (x < truth.inside[1])]


INF, NAN = np.inf, np.nan

SPECIAL_VALUES: tuple[tuple[str, float, float], ...] = (
    *(("exp", x, y) for x, y in ((0.0, 1.0), (-0.0, 1.0), (INF, INF), (-INF, 0.0), (1e30, INF), (-1e30, 0.0))),
    *(("expm1", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (INF, INF), (-INF, -1.0), (1e30, INF), (-1e30, -1.0))),
    *(("tanh", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (INF, 1.0), (-INF, -1.0), (1e30, 1.0), (-30.0, -1.0))),
    *(("log", x, y) for x, y in ((1.0, 0.0), (0.0, -INF), (-0.0, -INF), (INF, INF), (-INF, NAN), (-1.0, NAN))),
    *(("log1p", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (-1.0, -INF), (INF, INF), (-INF, NAN), (-2.0, NAN))),
    *(("log2", x, y) for x, y in ((1.0, 0.0), (0.0, -INF), (-0.0, -INF), (INF, INF), (-INF, NAN), (8.0, 3.0), (0.125, -3.0))),
    *(("erf", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (INF, 1.0), (-INF, -1.0), (8.0, 1.0), (-1e30, -1.0))),
    *(("exp2", x, y) for x, y in ((0.0, 1.0), (-0.0, 1.0), (INF, INF), (-INF, 0.0), (10.0, 1024.0), (-1e30, 0.0))),
    *(("sinh", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (INF, INF), (-INF, -INF), (1e30, INF))),
    *(("cosh", x, y) for x, y in ((0.0, 1.0), (-0.0, 1.0), (INF, INF), (-INF, INF), (-1e30, INF))),
    *(("tan", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (INF, NAN), (-INF, NAN))),
    *(("atan", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (INF, np.pi / 2), (-INF, -np.pi / 2), (1e30, np.pi / 2))),
    *(("asin", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (1.0, np.pi / 2), (-1.0, -np.pi / 2), (1.5, NAN), (-INF, NAN))),
    *(("acos", x, y) for x, y in ((1.0, 0.0), (-1.0, np.pi), (0.0, np.pi / 2), (-0.0, np.pi / 2), (1.5, NAN), (-INF, NAN))),
    *(("asinh", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (INF, INF), (-INF, -INF))),
    *(("acosh", x, y) for x, y in ((1.0, 0.0), (INF, INF), (0.5, NAN), (-INF, NAN), (-1e9, NAN))),
    *(("atanh", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (1.0, INF), (-1.0, -INF), (1.5, NAN), (-INF, NAN), (1e30, NAN))),
    *(("cbrt", x, y) for x, y in ((0.0, 0.0), (-0.0, -0.0), (INF, INF), (-INF, -INF), (-27.0, -3.0), (1e-30, 1e-10))),
)
"""(function, x, f(x)) as C99 has them, annex F.10."""

PI = np.pi

SPECIAL_PAIRS: tuple[tuple[str, float, float, float], ...] = (
    *(("power", x, y, 1.0) for x in (0.0, -0.0, 1.0, -2.0, INF, -INF, NAN) for y in (0.0, -0.0)),
    *(("power", 1.0, y, 1.0) for y in (INF, -INF, NAN, 3.5)),
    *(
        ("power", x, y, z)
        for x, y, z in ((0.0, -3.0, INF), (-0.0, -3.0, -INF), (-0.0, -2.0, INF), (-0.0, -0.5, INF), (0.0, -INF, INF))
    ),
    *(
        ("power", x, y, z)
        for x, y, z in ((-0.0, 3.0, -0.0), (0.0, 3.0, 0.0), (-0.0, 2.0, 0.0), (-0.0, 0.5, 0.0), (-0.0, INF, 0.0))
    ),
    *(("power", -1.0, y, z) for y, z in ((INF, 1.0), (-INF, 1.0), (3.0, -1.0), (4.0, 1.0), (0.5, NAN), (NAN, NAN))),
    *(
        ("power", x, y, z)
        for x, y, z in ((0.5, -INF, INF), (2.0, -INF, 0.0), (-0.5, INF, 0.0), (-2.0, INF, INF), (0.5, 1e30, 0.0))
    ),
    *(("power", -INF, y, z) for y, z in ((-3.0, -0.0), (-2.0, 0.0), (-0.5, 0.0), (3.0, -INF), (2.0, INF), (0.5, INF))),
    *(("power", INF, y, z) for y, z in ((-0.5, 0.0), (0.5, INF), (NAN, NAN), (INF, INF), (-INF, 0.0))),
    *(
        ("power", x, y, z)
        for x, y, z in ((-2.0, 3.0, -8.0), (-2.0, 0.5, NAN), (NAN, 2.0, NAN), (-2.0, -1.0, -0.5), (9.0, 0.5, 3.0))
    ),
    *(("atan2", y, x, z) for y, x, z in ((0.0, -0.0, PI), (-0.0, -0.0, -PI), (0.0, 0.0, 0.0), (-0.0, 0.0, -0.0))),
    *(("atan2", y, x, z) for y, x, z in ((0.0, -2.0, PI), (-0.0, -2.0, -PI), (0.0, 2.0, 0.0), (-0.0, 2.0, -0.0))),
    *(("atan2", y, x, z) for y, x, z in ((-2.0, 0.0, -PI / 2), (-2.0, -0.0, -PI / 2), (2.0, 0.0, PI / 2), (1.0, 1.0, PI / 4))),
    *(("atan2", y, x, z) for y, x, z in ((2.0, -INF, PI), (-2.0, -INF, -PI), (2.0, INF, 0.0), (-2.0, INF, -0.0))),
    *(
        ("atan2", y, x, z)
        for y, x, z in ((INF, 3.0, PI / 2), (-INF, 3.0, -PI / 2), (INF, -INF, 0.75 * PI), (-INF, -INF, -0.75 * PI))
    ),
    *(("atan2", y, x, z) for y, x, z in ((INF, INF, PI / 4), (-INF, INF, -PI / 4), (NAN, 1.0, NAN), (1.0, NAN, NAN))),
)
"""(function, first, second argument, value) as C99 has them, annex F.9."""


def pairs(name: str, kind: type[np.floating[Any]], count: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Arguments of power (x > 0, x^y from 0 to ∞) and atan2 (all octants, sizes from equal to far apart)."""
    generator, info = np.random.default_rng(11), np.finfo(kind)
    low, high, last = int(info.minexp - info.nmant), int(info.maxexp), int(info.nmant)

    def sized(least: int, most: int) -> NDArray[np.float64]:
        return np.ldexp(
            generator.choice([-1.0, 1.0], count) * generator.uniform(1, 2, count), generator.integers(least, most, count)
        )

    if name == "atan2":
        near = sized(-20, 20)
        first = np.concatenate([near, sized(-20, 20), sized(low, high), sized(high - 3, high)])
        second = np.concatenate([near * generator.uniform(0.2, 5.0, count) * generator.choice([-1, 1], count), sized(-20, 20)])
        second = np.concatenate([second, sized(low, high), sized(high - 3, high)])
        return first.astype(kind), second.astype(kind)
    x = np.abs(np.concatenate([sized(low, high - 1), generator.uniform(0.5, 2.0, 2 * count), 1.0 + sized(2 - last, -1)]))
    x = x.astype(kind)
    x = x[(x > 0.0) & (x != 1.0)]
    exponents = np.where(np.arange(x.size) % 3 == 0, generator.uniform(-2, 2, x.size), generator.uniform(low - 2, high, x.size))
    return x, (exponents / np.log2(x.astype(np.float64))).astype(kind)
