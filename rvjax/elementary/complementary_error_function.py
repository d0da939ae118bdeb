"""Complementary error function by arithmetic only, with all digits of its tail.

    erfcx x = e^(x²) erfc x = P((x − 4)/(x + 4))/(1 + 2x)                x ≥ 0
    erfc x  = e^(−h²) e^(−(x − h)(x + h)) erfcx x,  2 − erfc |x| below 0

h: x without its last bits, so that h² has no rounding error. P: Chebyshev fit over x ≥ 0, relative error 5e-17;
tests/elementary/test_normal.py. The form is that of M. Shepherd, J. Laframboise, Math. Comp. 36 (1981) 249. float64 only.
"""

from __future__ import annotations

from rvjax.elementary.exponential import exp
from rvjax.elementary.formats import Real, arithmetic, head, namespace, only_float64, polynomial

_FIT = (
    1.2329951186255526,
    -0.1396211168405625,
    0.015379652102610162,
    0.0680970542546862,
    -0.10103906603585294,
    0.09373283499865172,
    -0.06633036582050367,
    0.0371675155318432,
    -0.01619773397992426,
    0.005031970032548695,
    -0.0007577737141838885,
    -0.00019925700412184815,
    0.0001506231178516207,
    -2.439811794207995e-05,
    -1.1225140354449658e-05,
    5.707239573693257e-06,
    2.980596055322769e-07,
    -8.218020654813044e-07,
    7.111912428010423e-08,
    1.0683442926744586e-07,
    -1.6357383982124768e-08,
    -1.2544825403855518e-08,
    1.5712153638319064e-09,
    9.655408225482863e-10,
)
"""Coefficients of P, from the lowest."""

_FARTHEST = 30.0
"""erfc is 0 beyond."""


@arithmetic
def erfc(x: Real) -> Real:
    """erfc x = 1 − erf x = (2/√π) ∫ₓ^∞ e^(−t²) dt. Error: at most 4.8 units in the last place."""
    only_float64(x)
    xp = namespace(x)
    size = xp.minimum(xp.abs(x), _FARTHEST)
    beyond = decay(size, 1.0) * erfcx(size)
    return xp.where(x < 0.0, 2.0 - beyond, beyond)


@arithmetic
def erfcx(x: Real) -> Real:
    """e^(x²) erfc x for x ≥ 0. Error: at most 4.6 units in the last place."""
    only_float64(x)
    xp = namespace(x)
    t = xp.where(x < 2.0**60, (x - 4.0) / (x + 4.0), 1.0)
    return polynomial(t, _FIT) / (1.0 + 2.0 * x)


def decay(size: Real, share: float) -> Real:
    """e^(−share x²) of x ≥ 0; share: a power of two."""
    h = head(size, (27, 12))
    return exp(-share * (h * h)) * exp(-share * ((size - h) * (size + h)))
