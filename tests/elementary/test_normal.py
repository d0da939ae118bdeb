"""The normal law against 50-digit arithmetic: Φ, ln Φ, Φ⁻¹, and the complementary error function under them."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import Any

import mpmath
import numpy as np
import pytest

from rvjax import elementary
from rvjax.elementary import complementary_error_function, normal
from tests.oracles.last_place import errors

Array = np.ndarray[Any, Any]


@pytest.fixture(autouse=True)
def digits() -> Any:
    """50 digits."""
    with mpmath.workdps(50):
        yield


def erfcx(x: Any) -> Any:
    """e^(x²) erfc x, of large x by its asymptotic series (DLMF 7.12.1)."""
    if x < 100:
        return mpmath.exp(x * x) * mpmath.erfc(x)
    terms = [mpmath.fac2(2 * n - 1) / (-2 * x * x) ** n if n else mpmath.mpf(1) for n in range(16)]
    return mpmath.fsum(terms) / (x * mpmath.sqrt(mpmath.pi))


def phi(x: Any) -> Any:
    """Φ(x)."""
    return mpmath.erfc(-x / mpmath.sqrt(2)) / 2


def quantile(p: Any, near: float) -> Any:
    """Φ⁻¹(p) for p ≤ ½, by Newton's method on ln Φ from a number near it."""
    z = mpmath.mpf(near)
    for _ in range(5):
        z -= phi(z) / mpmath.npdf(z) * mpmath.log(phi(z) / p)
    return z


def of_tail(p: Any, rest: Any, near: float) -> Any:
    """Φ⁻¹(p) from the smaller one of p and 1 − p."""
    if p == 0 or rest == 0:
        return mpmath.mpf(near)
    return quantile(p, near) if p <= 0.5 else -quantile(rest, -near)


FUNCTIONS: dict[str, tuple[tuple[tuple[float, float], ...], tuple[float, float] | None, Callable[[Any, float], Any]]] = {
    "erfc": (((-6, 26), (-1, 1)), None, lambda x, near: mpmath.erfc(x)),
    "erfcx": (((0, 5),), (-8, 300), lambda x, near: erfcx(x)),
    "ndtr": (((-37, 9), (-1, 1)), None, lambda x, near: phi(x)),
    "log_ndtr": (((-60, 9), (-1, 1)), None, lambda x, near: mpmath.log(phi(x))),
    "ndtri": (((0, 1),), (-300, 0), lambda p, near: of_tail(p, 1 - p, near)),
    "ndtri_centred": (((-0.5, 0.5),), (-20, -0.302), lambda q, near: of_tail(0.5 + q, 0.5 - q, near)),
}
"""By name: ranges of arguments that are drawn from evenly, decimal exponents of others, and the exact function."""


def arguments(name: str, count: int) -> Array:
    """`count` arguments of each range."""
    generator = np.random.default_rng(5)
    ranges, exponents, _ = FUNCTIONS[name]
    drawn = [generator.uniform(low, high, count) for low, high in ranges]
    return np.concatenate([*drawn, *([10.0 ** generator.uniform(*exponents, count)] if exponents else [])])


def check(name: str, count: int, most: float) -> None:
    """Errors of a function in units in the last place."""
    x = arguments(name, count)
    found = getattr(elementary, name)(x)
    error = errors(found, [FUNCTIONS[name][2](mpmath.mpf(float(v)), float(z)) for v, z in zip(x, found, strict=True)])
    print(f"{name} {error.max():.2f}")
    assert error.max() <= most, (name, error.max(), x[np.argmax(error)])


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_digit_is_there(name: str) -> None:
    """In both tails. Kills: a wrong coefficient, x² without its last digits, 1 − p where p is known."""
    check(name, 250, 7.0)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_digit_is_there_at_many_numbers(name: str) -> None:
    """`pytest -s --slow -k many_numbers` prints the errors of the docstrings."""
    check(name, 10000, 8.0)


def test_quantiles_of_logarithms() -> None:
    """Φ⁻¹(e^y), also where e^y is 0 or 1 in double precision. Kills: the wrong tail, ln(1 − e^y) without digits."""
    generator = np.random.default_rng(5)
    y = np.concatenate([-(10.0 ** generator.uniform(-17, 2.86, 500)), generator.uniform(-3, 0, 500)])
    found = elementary.ndtri_exp(y)
    for given, z in zip(y, found, strict=True):
        wanted = of_tail(mpmath.exp(mpmath.mpf(given)), -mpmath.expm1(mpmath.mpf(given)), z)
        assert abs(mpmath.mpf(z) - wanted) <= 2.0**-50 * max(abs(wanted), 1), given


def test_special_values() -> None:
    """Ends, beyond them, and NaN. Kills: NaN for an infinite quantile, a number for NaN."""
    inf, nan = np.inf, np.nan
    for name, given, wanted in (
        ("erfc", [-inf, 0.0, inf, nan], [2.0, 1.0, 0.0, nan]),
        ("erfcx", [0.0, inf, nan], [1.0, 0.0, nan]),
        ("ndtr", [-inf, 0.0, inf, nan], [0.0, 0.5, 1.0, nan]),
        ("log_ndtr", [-inf, -1e200, inf, nan], [-inf, -inf, 0.0, nan]),
        ("ndtri", [0.0, 0.5, 1.0, -0.1, 1.1, nan], [-inf, 0.0, inf, nan, nan, nan]),
        ("ndtri_centred", [-0.5, 0.0, 0.5, 0.6, nan], [-inf, 0.0, inf, nan, nan]),
        ("ndtri_exp", [-inf, -np.log(2.0), 0.0, nan], [-inf, 0.0, inf, nan]),
    ):
        np.testing.assert_allclose(getattr(elementary, name)(np.array(given)), wanted, atol=1e-16, err_msg=name)


@pytest.mark.parametrize("name", [*FUNCTIONS, "ndtri_exp"])
def test_types_and_shapes(name: str) -> None:
    """Numbers and arrays of any shape, float64 alone. Kills: float32 numbers with the digits of float64 that they do not have."""
    function = getattr(elementary, name)
    given = -0.25 if name == "ndtri_exp" else 0.25
    assert type(function(given)) is np.float64
    np.testing.assert_array_equal(function(np.full((2, 3), given)), np.full((2, 3), function(given)))
    with pytest.raises(TypeError, match="float32 numbers: float64 is accepted"):
        function(np.full(2, given, np.float32))


def test_the_polynomial_is_that_of_the_function() -> None:
    """Relative error 5e-17 over x ≥ 0. Kills: a coefficient with a wrong digit."""
    points = [mpmath.cos(mpmath.pi * (i + 0.5) / 101) for i in range(101)]
    for t in points:
        x = 4 * (1 + t) / (1 - t)
        found = reduce(lambda total, c, t=t: total * t + c, reversed(complementary_error_function._FIT))
        assert abs(found / ((1 + 2 * x) * erfcx(x)) - 1) <= 5e-17


def test_the_quotients_are_those_of_as_241() -> None:
    """Relative error 2e-16 in all three, in exact arithmetic. Kills: a coefficient with a wrong digit."""

    def value(x: Any, quotient: normal.Quotient) -> Any:
        above, below = (reduce(lambda total, c: total * x + c, reversed(part)) for part in quotient)
        return above / below

    for i in range(1, 60):
        q = mpmath.mpf(425) * i / 60000
        wanted = -quantile(0.5 - q, float(-q * 2.5))
        assert abs(q * value(mpmath.mpf("0.180625") - q * q, normal._CENTRE) / wanted - 1) <= 2e-16
    for low, high, shift, quotient in ((1.61, 5.0, 1.6, normal._BESIDE), (5.0, 27.0, 5.0, normal._FAR)):
        for i in range(40):
            r = mpmath.mpf(low) + (mpmath.mpf(high) - mpmath.mpf(low)) * i / 39
            found = value(r - mpmath.mpf(str(shift)), quotient)
            assert abs(found / -quantile(mpmath.exp(-r * r), float(-found)) - 1) <= 2e-16, r
