"""Sine and cosine against 50-digit arithmetic."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest

from rvjax.elementary import trigonometric
from rvjax.physics import elementary

FUNCTIONS: tuple[tuple[str, Callable[[Any], Any]], ...] = (("sin", trigonometric.sin), ("cos", trigonometric.cos))


@pytest.fixture(autouse=True)
def digits() -> Any:
    """50 digits."""
    with mpmath.workdps(50):
        yield


def arguments(kind: type[np.floating[Any]], reach: float) -> np.ndarray[Any, Any]:
    """Arguments of every size up to reach, of both signs, and the numbers next to multiples of π/2, where all digits cancel."""
    generator = np.random.default_rng(20181)
    sizes = 10.0 ** generator.uniform(-9, np.log10(reach), 1500)
    multiples = np.rint(10.0 ** generator.uniform(0, np.log10(reach / 1.6), 1500)) * (0.5 * np.pi)
    signs = generator.choice([-1.0, 1.0], 1500)
    return np.concatenate([sizes * signs, multiples * signs]).astype(kind)


@pytest.mark.parametrize(("kind", "reach"), [(np.float64, 2e8), (np.float32, 1e4)])
def test_sine_and_cosine_have_every_digit(kind: type[np.floating[Any]], reach: float) -> None:
    """Within 2.5 units in the last place. Kills a missing part of π/2, a missing term, a wrong sign of a quadrant."""
    x = arguments(kind, reach)
    for name, function in FUNCTIONS:
        found = np.asarray(jax.jit(function)(x))
        assert found.dtype == kind
        exact = [getattr(mpmath, name)(mpmath.mpf(float(value))) for value in x]
        unit = np.spacing(np.abs(np.array([kind(float(value)) for value in exact])))
        error = [
            abs(float((mpmath.mpf(float(a)) - b) / mpmath.mpf(float(u)))) for a, b, u in zip(found, exact, unit, strict=True)
        ]
        assert max(error) <= 2.5, (name, x[np.argmax(error)])


def test_beyond_its_range_it_stays_a_sine() -> None:
    """Kills: a polynomial that runs away where the reduction has no digits left; a finite number for ∞."""
    for _, function in FUNCTIONS:
        far = np.asarray(function(jnp.asarray([1e9, -1e12, 7e15, 1e16, -1e100, 1e300])))
        assert np.all(np.abs(far) <= 1.0)
        assert np.isnan(np.asarray(function(jnp.asarray([np.nan, np.inf, -np.inf])))).all()
    for x in (1e12, -3e14):
        near = float(trigonometric.sin(jnp.asarray(x)))
        assert near == pytest.approx(float(mpmath.sin(mpmath.mpf(x))), abs=np.spacing(abs(x)))


def test_derivatives_are_those_of_the_functions() -> None:
    """Kills: a derivative with the sign of the other."""
    x = jnp.linspace(-20.0, 20.0, 401)
    np.testing.assert_allclose(jax.vmap(jax.grad(elementary.sin))(x), np.cos(x), rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(jax.vmap(jax.grad(elementary.cos))(x), -np.sin(x), rtol=0.0, atol=1e-13)


@pytest.mark.filterwarnings("ignore:Descending:DeprecationWarning")  # mpmath 1.4 has another order to offer
@pytest.mark.parametrize(("tables", "tolerance"), [("_FLOAT64", 1e-15), ("_FLOAT32", 1e-7)])
def test_where_the_numbers_come_from(tables: str, tolerance: float) -> None:
    """P is the Chebyshev fit of (sin r/r − 1)/r² in r²; the parts add up to π/2 and are short."""
    parts, fit = getattr(trigonometric, tables)

    def wanted(square: Any) -> Any:
        r = mpmath.sqrt(square)
        return (mpmath.sin(r) / r - 1) / square if square > 1e-12 else mpmath.mpf(-1) / 6 + square / 120

    found = mpmath.chebyfit(wanted, [0, (mpmath.pi / 2) ** 2 * mpmath.mpf("1.0001")], len(fit))[::-1]
    for ours, theirs in zip(fit, found, strict=True):
        assert abs(ours - float(theirs)) * (np.pi / 2) ** 2 <= tolerance
    short = 26 if tables == "_FLOAT64" else 8
    assert abs(sum(map(mpmath.mpf, parts)) - mpmath.pi / 2) <= parts[-1] * 2.0**-23
    for part in parts[:-1]:
        mantissa, _ = np.frexp(part)
        assert (mantissa * 2.0**short) % 1.0 == 0.0
