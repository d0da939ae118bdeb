"""Cube root by arithmetic only.

    |x| = 2^(3q) m,  √2/4 ≤ m ≤ 2√2
    t = P(m) at first, then t ← t + t (m/t² − t)/(2t + m/t²), which triples the digits
    ∛|x| = 2^q t

Before the last step t is cut to a head, whose square has no rounding error. P: Chebyshev fit of ∛m over √½ ≤ m ≤ √2, error 1e-5,
times ∛2 or ∛½; tests/physics/test_elementary_fits.py. The step is that of FreeBSD's cbrt.
"""

from __future__ import annotations

from rvjax.elementary.formats import (
    FLOAT32,
    Real,
    arithmetic,
    either,
    format_of,
    head,
    namespace,
    polynomial,
    power_of_two,
    with_sign,
)
from rvjax.elementary.logarithms import split_normal

_FIT = (0.45368850939437955, 0.8967392149830209, -0.5237666939876867, 0.2093460512115113, -0.03600019208330247)
"""Coefficients of P, from the lowest."""

_ROOTS = (1.2599210498948732, 0.7937005259840998)
"""∛2, ∛½."""


@arithmetic
def cbrt(x: Real) -> Real:
    """The cube root, odd in every bit. Error: at most 0.7 (float64) or 0.9 (float32) units in the last place."""
    xp = namespace(x)
    form = format_of(x)
    size = xp.abs(x)
    small = size < form.tiny
    thirds = 18.0 if form is not FLOAT32 else 8.0
    k, f, _ = split_normal(xp.where(small, size * 2.0 ** (3.0 * thirds), size))
    q = xp.round(k * (1.0 / 3.0))
    over = k - 3.0 * q
    m = 1.0 + f
    t = polynomial(m, _FIT) * either(over > 0.0, _ROOTS[0], xp.where(over < 0.0, _ROOTS[1], 1.0), m)
    m = m * either(over > 0.0, 2.0, xp.where(over < 0.0, 0.5, 1.0), m)
    t = t if form is FLOAT32 else _closer(t, m)
    t = _closer(head(t, (30, 12)), m) * power_of_two(xp.where(small, q - thirds, q))
    return xp.where(size > 0.0, xp.where(size < xp.inf, with_sign(t, x), x), x)


def _closer(t: Real, m: Real) -> Real:
    """The next approximation of the cube root of m."""
    quotient = m / (t * t)
    return t + t * ((quotient - t) / (t + t + quotient))
