"""The four saturations: their range, their slope, their smoothness at zero, both limits of an asymmetric channel."""

from __future__ import annotations

import math
from typing import Any

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest

from rvjax.physics.saturation import saturate
from rvjax.physics.vectors import Channels
from tests.flights import SATURATIONS

UPPER, LOWER = 4.0, 3.0
SMOOTH = ("smooth-tanh", "shifted-tanh", "erf")
THROUGH_ZERO = ("smooth-tanh", "erf", "hard-clip")
COMMANDS = np.array([-300.0, -7.0, -3.1, -2.9, -1.0, -1e-6, 1e-6, 0.5, 2.0, 3.9, 4.1, 9.0, 300.0])


def value(name: str, v: float) -> float:
    return float(SATURATIONS[name](jnp.asarray(v), UPPER, LOWER)[0])


def slope(name: str, v: float) -> float:
    return float(SATURATIONS[name](jnp.asarray(v), UPPER, LOWER)[1])


def exact(name: str, v: Any) -> Any:
    """h(v) by its definition, with mpmath."""
    limit = UPPER if v >= 0 else LOWER
    centre, span = 0.5 * (UPPER - LOWER), 0.5 * (UPPER + LOWER)
    return {
        "smooth-tanh": lambda: limit * mpmath.tanh(v / limit),
        "shifted-tanh": lambda: span * mpmath.tanh((v - centre) / span) + centre,
        "erf": lambda: limit * mpmath.erf(mpmath.sqrt(mpmath.pi) * v / (2 * limit)),
        "hard-clip": lambda: min(max(v, -LOWER), UPPER),
    }[name]()


@pytest.mark.parametrize("name", SATURATIONS)
@pytest.mark.parametrize("v", COMMANDS)
def test_value_and_slope(name: str, v: float) -> None:
    """h against mpmath, h' against jax.grad and mpmath's derivative; kills swapped limits and a wrong slope."""
    assert value(name, v) == pytest.approx(float(exact(name, mpmath.mpf(v))), rel=1e-13, abs=1e-15)
    assert -LOWER <= value(name, v) <= UPPER
    derivative = jax.grad(lambda x: SATURATIONS[name](x, UPPER, LOWER)[0])(jnp.asarray(v))
    assert slope(name, v) == pytest.approx(float(derivative), rel=1e-9, abs=1e-14)
    with mpmath.workdps(30):
        assert slope(name, v) == pytest.approx(float(mpmath.diff(lambda x: exact(name, x), mpmath.mpf(v), h=1e-12)), abs=1e-9)


@pytest.mark.parametrize("name", SATURATIONS)
def test_each_side_reaches_its_own_limit(name: str) -> None:
    """h(+∞) = u⁺ and h(−∞) = −u⁻; kills swapped limits."""
    assert value(name, 1e4) == pytest.approx(UPPER, rel=1e-12)
    assert value(name, -1e4) == pytest.approx(-LOWER, rel=1e-12)


@pytest.mark.parametrize("name", THROUGH_ZERO)
def test_small_commands_pass_unchanged(name: str) -> None:
    """h(0) = 0 and h'(0) = 1; the shifted tanh is the one that does not pass through zero."""
    assert value(name, 0.0) == 0.0
    assert slope(name, 0.0) == 1.0
    assert abs(value("shifted-tanh", 0.0)) > 1e-3


@pytest.mark.parametrize("name", SMOOTH)
def test_twice_continuously_differentiable_at_zero(name: str) -> None:
    """h, h' and h'' have one limit from both sides of v = 0, where the limit changes; the third derivative need not."""
    second = jax.grad(jax.grad(lambda x: SATURATIONS[name](x, UPPER, LOWER)[0]))
    for of in (lambda v: value(name, v), lambda v: slope(name, v), lambda v: float(second(jnp.asarray(v)))):
        assert of(1e-9) == pytest.approx(of(-1e-9), abs=1e-8)


def test_channels_have_their_own_limits() -> None:
    """Six channels at once: each with its own u⁺ and u⁻."""
    v = Channels.of(tuple(100.0 * (-1) ** i for i in range(6)))
    upper, lower = Channels.of(tuple(1.0 + i for i in range(6))), Channels.of(tuple(0.1 + i for i in range(6)))
    h, _ = saturate(SATURATIONS["smooth-tanh"], v, upper, lower)
    expected = [1.0 + i if i % 2 == 0 else -(0.1 + i) for i in range(6)]
    np.testing.assert_allclose([float(x) for x in h.parts()], expected, rtol=1e-12)
    assert math.isclose(float(h.torque.z), -5.1, rel_tol=1e-12)
