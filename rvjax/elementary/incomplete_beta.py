"""Quantiles of the beta law by arithmetic only: x with I_x(a, b) = u, and 1 − x, both with all their digits.

    I_x(a, b) = x^a (1 − x)^b/(B(a, b) K),   K = β₀ + α₁/(β₁ + α₂/(β₂ + …))        x ≤ (a + 1)/(a + b + 2); else 1 − I_{1−x}(b, a)
    α_m = (a + m − 1)(a + b + m − 1) m (b − m) x²/(a + 2m − 1)²
    β_m = m + m (b − m) x/(a + 2m − 1) + (a + m)(a (1 − x) − b x + 1 + m (2 − x))/(a + 2m + 1)

The fraction is that of A. DiDonato, A. Morris, "Algorithm 708", ACM Trans. Math. Softw. 18 (1992) 360, summed by the method of
Lentz. ln of the factor before it is a ln(x/c) + b ln((1 − x)/(1 − c)) + D about the mean c, where its terms are small; D is
computed in decimal arithmetic.

The smaller one of x and 1 − x is found by Halley's method on ln I (or ln(1 − I), whichever is smaller) as a function of ln x,
between bounds that close in. Each number is refined until it no longer moves, by itself: other numbers of an array change no bit.
float64 of NumPy only.
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rvjax.elementary.exponential import exp
from rvjax.elementary.log_gamma import DIGITS, log_beta
from rvjax.elementary.logarithms import log, log1p
from rvjax.elementary.normal import ndtri

Values = NDArray[np.float64]

_MOST_TERMS = 20_000
"""Terms of the fraction; shapes of 1e6 need some thousands."""

_MOST_STEPS = 200

_TINY = 1e-300
"""In place of 0, which must not divide (Lentz); also the smallest x."""

_ENOUGH = 1e-7
"""A relative step as small is the last one: it leaves less than a unit in the last place."""


class _Side(NamedTuple):
    """The law of x or of 1 − x. a, b: shapes; centre, rest: c and 1 − c; level: D; beta: ln B."""

    a: float
    b: float
    centre: float
    rest: float
    level: float
    beta: float


def beta_quantile(a: float, b: float, u: Values) -> tuple[Values, Values]:
    """(x, 1 − x) with I_x(a, b) = u, u in (0, 1), for shapes from 0.1 to 1e6; (0, 1) and (1, 0) at the ends.

    Error: at most 2e-13 of each of the two.
    """
    left, right, half = _sides(float(a), float(b))
    flat = np.asarray(u, np.float64).reshape(-1)
    x, rest = np.where(flat >= 1.0, 1.0, 0.0), np.where(flat >= 1.0, 0.0, 1.0)
    inside = (flat > 0.0) & (flat < 1.0)
    below = inside & (flat <= half)
    above = inside & ~below
    with np.errstate(all="ignore"):
        x[below] = _solved(left, flat[below], 1.0 - flat[below])
        rest[above] = _solved(right, 1.0 - flat[above], flat[above])
    rest[below], x[above] = 1.0 - x[below], 1.0 - rest[above]
    return x.reshape(np.shape(u)), rest.reshape(np.shape(u))


@lru_cache(maxsize=256)
def _sides(a: float, b: float) -> tuple[_Side, _Side, float]:
    """The laws of x and of 1 − x, and I_½(a, b)."""
    left, right = _side(a, b), _side(b, a)
    with np.errstate(all="ignore"):
        lower, _, _ = _logarithms(left, np.array([0.5]))
    return left, right, float(exp(lower)[0])


def _side(a: float, b: float) -> _Side:
    c = a / (a + b)
    with localcontext(DIGITS):
        centre, beta = Decimal(c), log_beta(Decimal(a), Decimal(b))
        level = Decimal(a) * centre.ln() + Decimal(b) * (1 - centre).ln() - beta
        return _Side(a, b, c, float(1 - centre), float(level), float(beta))


def _solved(side: _Side, lower: Values, upper: Values) -> Values:
    """x ≤ ½ with I_x = lower = 1 − upper."""
    rising = lower <= upper
    wanted = log(np.where(rising, lower, upper))
    x = _start(side, lower, upper)
    least, most = np.zeros_like(x), np.full_like(x, 0.5)
    going = np.ones(x.shape, np.bool_)
    for _ in range(_MOST_STEPS):
        now = np.flatnonzero(going)
        if not now.size:
            break
        old, up = x[now], rising[now]
        below, above, density = _logarithms(side, old)
        level = np.where(up, below, above)
        slope = np.where(up, 1.0, -1.0) * exp(density - level)
        newton = (wanted[now] - level) / slope
        bend = side.a - (side.b - 1.0) * old / (1.0 - old) - slope
        step = newton / np.minimum(np.maximum(1.0 + 0.5 * newton * bend, 0.5), 2.0)
        least[now], most[now] = np.where(step > 0.0, old, least[now]), np.where(step > 0.0, most[now], old)
        new = np.maximum(old * exp(step), _TINY)
        outside = np.where(step > 0.0, most[now], least[now])
        beyond = np.where(step > 0.0, new > outside, new < outside)
        x[now] = np.where(beyond, np.sqrt(old) * np.sqrt(outside), new)
        going[now] = (np.abs(step) > _ENOUGH) & (x[now] != old)
    return x


def _start(side: _Side, lower: Values, upper: Values) -> Values:
    """Near the quantile: from the first term of the power series, or from the normal law (M. Abramowitz, I. Stegun, "Handbook of
    mathematical functions", 26.5.22)."""
    a, b = side.a, side.b
    first = exp(np.minimum((log(lower) + float(log(a)) + side.beta) / a, 0.0))
    spread = 3.0 * float(np.sqrt(a)) + 3.0
    x = np.minimum(first, (a + spread) / (a + b + spread))
    if min(a, b) > 1.0:
        y = np.where(lower < upper, -ndtri(lower), ndtri(upper))
        left, right = 1.0 / (2.0 * a - 1.0), 1.0 / (2.0 * b - 1.0)
        h, curved = 2.0 / (left + right), (y * y - 3.0) / 6.0
        w = y * np.sqrt(np.maximum(h + curved, 0.0)) / h - (right - left) * (curved + 5.0 / 6.0 - 2.0 / (3.0 * h))
        x = np.where(first * (b - 1.0) < 0.1 * (a + 1.0), x, a / (a + b * exp(2.0 * w)))
    return np.minimum(np.maximum(x, _TINY), 0.5)


def _logarithms(side: _Side, x: Values) -> tuple[Values, Values, Values]:
    """(ln I, ln(1 − I), ln(x dI/dx)) at 0 < x ≤ ½."""
    a, b = side.a, side.b
    off = x - side.centre
    near = (x > 0.5 * side.centre) & (x < 2.0 * side.centre)
    along = np.where(near, log1p(np.where(near, off / side.centre, 0.0)), log(x / side.centre))
    factor = side.level + (a * along + b * log1p(-off / side.rest))
    swapped = x > (a + 1.0) / (a + b + 2.0)
    y = 1.0 - x
    fraction = _fraction(np.where(swapped, b, a), np.where(swapped, a, b), np.where(swapped, y, x), np.where(swapped, x, y))
    own = np.minimum(factor - log(fraction), -(2.0**-53))
    other = log1p(-exp(own))
    return np.where(swapped, other, own), np.where(swapped, own, other), factor - log1p(-x)


def _fraction(a: Values, b: Values, x: Values, y: Values) -> Values:
    """K; y = 1 − x. Element by element: one that no longer moves stays."""
    value = a * (a * y - b * x + 1.0) / (a + 1.0)
    above, below = value, np.zeros_like(value)
    going = np.arange(len(value))
    result = value.copy()
    for m in range(1, _MOST_TERMS):
        double = a + 2.0 * m
        alpha = (a + (m - 1.0)) * (a + b + (m - 1.0)) / (double - 1.0) * (m * (b - m) * x / (double - 1.0)) * x
        beta = m + m * (b - m) * x / (double - 1.0) + (a + m) * (a * y - b * x + 1.0 + m * (1.0 + y)) / (double + 1.0)
        above = beta + alpha / above
        below = beta + alpha * below
        above, below = np.where(above == 0.0, _TINY, above), np.where(below == 0.0, _TINY, below)
        below = 1.0 / below
        change = above * below
        value = value * change
        moving = np.abs(change - 1.0) > 2.0**-52
        if not moving.all():
            result[going[~moving]] = value[~moving]
            going, value, above, below = going[moving], value[moving], above[moving], below[moving]
            a, b, x, y = a[moving], b[moving], x[moving], y[moving]
            if not going.size:
                return result
    result[going] = value
    return result
