"""Where the coefficients of the elementary functions come from: their polynomials against the functions that they replace.

All but the far part of erf are Chebyshev fits: mpmath.chebyfit of the function below over its interval.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from types import ModuleType
from typing import Any, NamedTuple

import mpmath
import pytest

from rvjax.elementary import (
    cube_root,
    error_function,
    exponential,
    hyperbolic,
    inverse_trigonometric,
    logarithms,
    powers,
    tangent,
)

LN2 = mpmath.log(2)


class Fit(NamedTuple):
    """wanted: the function of the polynomial's argument. weight: of its error. errors: in (float64, float32)."""

    home: ModuleType
    field: str
    wanted: Callable[[Any], Any]
    interval: tuple[Any, Any] | tuple[tuple[Any, Any], tuple[Any, Any]]
    weight: Callable[[Any], Any]
    errors: tuple[float, float]


def _of_square(function: Callable[[Any], Any], power: int = 0) -> Callable[[Any], Any]:
    """z ↦ function(√z)/z^power."""
    return lambda z: function(mpmath.sqrt(z)) / z**power


FITS = (
    Fit(exponential, "fit", lambda r: (mpmath.expm1(r) - r) / r**2, (-LN2 / 2, LN2 / 2), lambda r: r**2, (1.3e-17, 8e-9)),
    Fit(hyperbolic, "fit", _of_square(lambda t: mpmath.tanh(t) / t - 1, 1), (0, (3 * LN2 / 8) ** 2), lambda z: z, (3e-17, 2e-8)),
    Fit(
        logarithms,
        "fit",
        _of_square(lambda s: 2 * mpmath.atanh(s) / s - 2, 1),
        (0, (3 - 2 * mpmath.sqrt(2)) ** 2),
        lambda z: z / 2,
        (5e-18, 3e-9),
    ),
    Fit(exponential, "base_two", lambda g: (mpmath.power(2, g) - 1) / g, (-0.5, 0.5), lambda g: g, (3e-17, 5e-9)),
    Fit(hyperbolic, "sine", _of_square(lambda x: mpmath.sinh(x) / x - 1, 1), (0, 1), lambda z: z, (2e-17, 3e-10)),
    Fit(tangent, "fit", _of_square(lambda r: mpmath.tan(r) / r - 1, 1), (0, (mpmath.pi / 8) ** 2), lambda z: z, (1.3e-17, 8e-9)),
    Fit(
        inverse_trigonometric, "tangent", _of_square(lambda t: mpmath.atan(t) / t - 1, 1), (0, 0.25), lambda z: z, (1e-17, 1.2e-9)
    ),
    Fit(inverse_trigonometric, "sine", _of_square(lambda s: mpmath.asin(s) / s - 1, 1), (0, 0.25), lambda z: z, (1e-17, 1.2e-9)),
    Fit(
        powers,
        "fit",
        _of_square(lambda s: 3 * (mpmath.atanh(s) / s - 1 - s**2 / 3), 2),
        (0, (5 - 2 * mpmath.sqrt(6)) ** 2),
        lambda z: z**2 / 3,
        (1e-20, 2e-10),
    ),
    Fit(error_function, "near", _of_square(lambda x: mpmath.erf(x) / x - 1), (0, 1), lambda z: 1, (4e-17, 1.4e-9)),
    Fit(
        error_function,
        "far",
        lambda t: mpmath.exp((1 / t - 2) ** 2) * mpmath.erfc(1 / t - 2),
        ((mpmath.mpf(1) / 8, mpmath.mpf(1) / 3), (mpmath.mpf(1) / 6, mpmath.mpf(1) / 3)),
        lambda t: mpmath.exp(-((1 / t - 2) ** 2)),
        (4e-17, 4.5e-11),
    ),
)


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("fit", FITS, ids=lambda fit: f"{fit.home.__name__.rpartition('.')[2]}-{fit.field}")
def test_polynomials_are_those_of_the_functions(fit: Fit, single: bool) -> None:
    """Largest weighted error over the interval as the docstrings have it. Kills a coefficient with a wrong digit."""
    coefficients = getattr(getattr(fit.home, "_FLOAT32" if single else "_FLOAT64"), fit.field)
    ends: Any = fit.interval[single] if isinstance(fit.interval[0], tuple) else fit.interval
    with mpmath.workdps(40):
        middle, half = (ends[0] + ends[1]) / mpmath.mpf(2), (ends[1] - ends[0]) / mpmath.mpf(2)
        points = [middle + half * mpmath.cos(mpmath.pi * (i + 0.5) / 101) for i in range(101)]
        found = [reduce(lambda total, c, v=v: total * v + c, reversed(coefficients)) for v in points]
        error = max(abs((ours - fit.wanted(v)) * fit.weight(v)) for ours, v in zip(found, points, strict=True))
    assert error <= fit.errors[single]


def test_the_cube_root_begins_near_it() -> None:
    """Error 1.2e-5 on √½ ≤ m ≤ √2. Kills a coefficient with a wrong digit, which the steps would hide."""
    points = [mpmath.sqrt(0.5) * 2 ** (mpmath.mpf(i) / 100) for i in range(101)]
    found = [reduce(lambda total, c, m=m: total * m + c, reversed(cube_root._FIT)) for m in points]
    assert max(abs(ours - mpmath.cbrt(m)) for ours, m in zip(found, points, strict=True)) <= 1.2e-5
