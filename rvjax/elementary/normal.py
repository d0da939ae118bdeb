"""Standard normal law by arithmetic only: Φ, ln Φ and Φ⁻¹, with all digits of both tails.

    Φ(−x) = ½ e^(−x²/2) erfcx(x/√2),  Φ(x) = 1 − Φ(−x)             x ≥ 0
    Φ⁻¹(½ + q) = q A(0.425² − q²)                                  |q| ≤ 0.425
    Φ⁻¹(1 − p) = −Φ⁻¹(p) = C(r − 1.6) or E(r − 5),  r = √(−ln p)   r ≤ 5 or beyond, p ≥ 1e-316

A, C, E: quotients of polynomials of degree 7, relative error 1e-16; M. Wichura, "Algorithm AS 241: the percentage points of the
normal distribution", Applied Statistics 37 (1988) 477, PPND16. float64 only.
"""

from __future__ import annotations

from rvjax.elementary.complementary_error_function import decay, erfcx
from rvjax.elementary.exponential import exp, expm1
from rvjax.elementary.formats import LN2, Real, arithmetic, namespace, only_float64, polynomial
from rvjax.elementary.logarithms import log, log1p

_ROOT_HALF = 0.7071067811865476

_FARTHEST = 40.0
"""Φ is 0 or 1 beyond."""

_WIDE = 0.425

Quotient = tuple[tuple[float, ...], tuple[float, ...]]
"""Coefficients above and below the line, from the lowest."""

_CENTRE: Quotient = (
    (
        3.3871328727963666080e0,
        1.3314166789178437745e2,
        1.9715909503065514427e3,
        1.3731693765509461125e4,
        4.5921953931549871457e4,
        6.7265770927008700853e4,
        3.3430575583588128105e4,
        2.5090809287301226727e3,
    ),
    (
        1.0,
        4.2313330701600911252e1,
        6.8718700749205790830e2,
        5.3941960214247511077e3,
        2.1213794301586595867e4,
        3.9307895800092710610e4,
        2.8729085735721942674e4,
        5.2264952788528545610e3,
    ),
)
_BESIDE: Quotient = (
    (
        1.42343711074968357734e0,
        4.63033784615654529590e0,
        5.76949722146069140550e0,
        3.64784832476320460504e0,
        1.27045825245236838258e0,
        2.41780725177450611770e-1,
        2.27238449892691845833e-2,
        7.74545014278341407640e-4,
    ),
    (
        1.0,
        2.05319162663775882187e0,
        1.67638483018380384940e0,
        6.89767334985100004550e-1,
        1.48103976427480074590e-1,
        1.51986665636164571966e-2,
        5.47593808499534494600e-4,
        1.05075007164441684324e-9,
    ),
)
_FAR: Quotient = (
    (
        6.65790464350110377720e0,
        5.46378491116411436990e0,
        1.78482653991729133580e0,
        2.96560571828504891230e-1,
        2.65321895265761230930e-2,
        1.24266094738807843860e-3,
        2.71155556874348757815e-5,
        2.01033439929228813265e-7,
    ),
    (
        1.0,
        5.99832206555887937690e-1,
        1.36929880922735805310e-1,
        1.48753612908506148525e-2,
        7.86869131145613259100e-4,
        1.84631831751005468180e-5,
        1.42151175831644588870e-7,
        2.04426310338993978564e-15,
    ),
)


@arithmetic
def ndtr(x: Real) -> Real:
    """Φ(x), the normal distribution function. Error: at most 5.0 units in the last place."""
    xp = namespace(x)
    beyond = _beyond(xp.minimum(xp.abs(x), _FARTHEST))
    return xp.where(x < 0.0, beyond, 1.0 - beyond)


@arithmetic
def log_ndtr(x: Real) -> Real:
    """ln Φ(x). Error: at most 5.4 units in the last place."""
    xp = namespace(x)
    size = xp.abs(x)
    below = log(0.5 * erfcx(size * _ROOT_HALF)) - 0.5 * (size * size)
    return xp.where(x < 0.0, below, log1p(-_beyond(xp.minimum(size, _FARTHEST))))


@arithmetic
def ndtri(p: Real) -> Real:
    """Φ⁻¹(p); ∓∞ at 0 and 1, NaN beyond. Error: at most 4.6 units in the last place."""
    xp = namespace(p)
    q = p - 0.5
    return _quantile(q, -log(xp.where(q < 0.0, p, 1.0 - p)))


@arithmetic
def ndtri_centred(q: Real) -> Real:
    """Φ⁻¹(½ + q), with all digits near q = 0; ±∞ at ±½, NaN beyond. Error: at most 4.1 units in the last place."""
    return _quantile(q, -log(0.5 - namespace(q).abs(q)))


@arithmetic
def ndtri_exp(y: Real) -> Real:
    """Φ⁻¹(e^y) for y ≤ 0, also where e^y is 0 or 1, down to y = −728. Error: at most 4 units in the last place, of 1
    where the quantile is smaller."""
    xp = namespace(y)
    low = y < -LN2
    return _quantile(exp(y) - 0.5, xp.where(low, -y, -log(-expm1(xp.where(low, -1.0, y)))))


def _beyond(size: Real) -> Real:
    """Φ(−x) of 0 ≤ x ≤ 40."""
    return 0.5 * decay(size, 0.5) * erfcx(size * _ROOT_HALF)


def _quantile(q: Real, depth: Real) -> Real:
    """Φ⁻¹(½ + q); depth: −ln of the smaller one of ½ + q and ½ − q."""
    only_float64(q)
    xp = namespace(q)
    r = xp.sqrt(depth)
    size = xp.where(r > 5.0, _quotient(r - 5.0, _FAR), _quotient(r - 1.6, _BESIDE))
    size = xp.where(r < xp.inf, size, r)
    near = xp.abs(q) <= _WIDE
    inside = xp.where(near, q, 0.0)
    return xp.where(near, inside * _quotient(_WIDE * _WIDE - inside * inside, _CENTRE), xp.where(q < 0.0, -size, size))


def _quotient(x: Real, coefficients: Quotient) -> Real:
    above, below = coefficients
    return polynomial(x, above) / polynomial(x, below)
