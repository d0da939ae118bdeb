"""Error function by arithmetic only.

    |x| < 1     erf x = x + x P(x²)
    |x| ≥ 1     erf |x| = 1 − e^(−x²) Q(1/(|x| + 2))

P: Chebyshev fit, relative error 4e-17 (float64) or 1e-9 (float32). Q: least largest error of erf on 1 ≤ x ≤ 6 (float64) or
1 ≤ x ≤ 4 (float32), 3e-17 or 4e-11; erf is 1 beyond. Coefficients: tests/physics/test_elementary_fits.py.
"""

from __future__ import annotations

from typing import NamedTuple

from rvjax.elementary.exponential import exp
from rvjax.elementary.formats import Real, arithmetic, by_format, namespace, polynomial, with_sign


class _Tables(NamedTuple):
    """near, far: coefficients of P and Q, from the lowest."""

    near: tuple[float, ...]
    far: tuple[float, ...]


_FLOAT64 = _Tables(
    near=(
        0.12837916709551256,
        -0.37612638903183543,
        0.11283791670945006,
        -0.02686617064323777,
        0.0052239776071164225,
        -0.0008548325975389692,
        0.00012055294904839707,
        -1.492473690741966e-05,
        1.6447424703317362e-06,
        -1.6208483801871705e-07,
        1.3720064546777686e-08,
        -7.795898827002142e-10,
    ),
    far=(
        2.845532537162766e-05,
        0.562948701416901,
        1.152787684180108,
        1.6899580288074727,
        4.993065119825395,
        -8.54533178944583,
        38.67586715997442,
        -91.79257459046202,
        72.4840465804535,
        41.242202081283196,
        -103.7898605390273,
        50.21128967447198,
    ),
)
_FLOAT32 = _Tables(
    near=(
        0.12837916584835093,
        -0.37612626666720334,
        0.11283594715160218,
        -0.026854212010626412,
        0.005189087423433974,
        -0.000801686428716587,
        7.875875062685488e-05,
    ),
    far=(
        0.00182479347787691,
        0.5193610035526198,
        1.5874870139339088,
        -0.5166465999044773,
        10.188532452013542,
        -7.386784456615342,
    ),
)
_tables = by_format(_FLOAT64, _FLOAT32)


@arithmetic
def erf(x: Real) -> Real:
    """erf x = (2/√π) ∫₀ˣ e^(−t²) dt. Error: at most 1.4 units in the last place in both types."""
    xp = namespace(x)
    tables = _tables(x)
    size, square = xp.abs(x), x * x
    near = size + size * polynomial(square, tables.near)
    far = 1.0 - exp(-square) * polynomial(1.0 / (size + 2.0), tables.far)
    return with_sign(xp.where(size < 1.0, near, far), x)
