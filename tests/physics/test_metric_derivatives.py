"""Metrics that a campaign chooses under `jvp`, as gradients of a search need them: against central differences."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rvjax.components.metrics import contact
from rvjax.components.metrics.passive_safety import nearest
from rvjax.physics.free_motion import FreeMotion
from rvjax.physics.primer import lower_bound
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Vector
from tests import flights
from tests.chosen import step, vector


def check(function: Callable[[Any], Any], size: float) -> None:
    """function(x) → (n,); its derivative at 0 and its central difference."""
    compiled = jax.jit(function)
    slope = jax.jit(lambda: jax.jvp(function, (0.0,), (1.0,))[1])()
    np.testing.assert_allclose(slope, (compiled(size) - compiled(-size)) / (2.0 * size), rtol=1e-6, atol=1e-9)
    assert np.all(np.abs(slope) > 1e-5)


def from_the_right(x: Any) -> FreeMotion:
    """A pursuer that is x farther ahead."""
    return FreeMotion(vector((7e6, 0, 0)), vector((0, 7545, 0)), Vector(100.0 + x, -50.0, 20.0), Vector(-0.3, 0.1, 0.02))


def test_of_free_drift() -> None:
    """Kills: NaN of a root that is not taken, a step whose lowest place does not count."""
    check(lambda x: nearest(from_the_right(x), 90, 60.0)[None], 1e-4)


def test_of_the_bound_on_fuel() -> None:
    """Kills: a derivative that stops at the best of the bounds."""
    end = FreeMotion(vector((0, 7e6, 0)), vector((-7545, 0, 0)), vector((5, 0, 0)), vector((0, 0.02, 0)))
    check(lambda x: lower_bound(from_the_right(x), end, jnp.asarray(1450.0))[None], 1e-4)


def test_of_the_contact() -> None:
    """Kills: NaN of a step without contact, an instant of contact that counts as fixed."""
    metric = contact.COMPONENT.build(contact.Parameters())
    numbers = Numbers({"distance_m": np.float64(0.05), "radius_m": np.float64(1.0), "interface_m": vector((-1, 0.1, 0))})
    scene = flights.lane(flights.draw({}, 3.0, 1.0).context, 0)
    context = scene._replace(axis=vector((1, 0, 0)), numbers=numbers)

    def values(x: Any) -> Any:
        acc = metric.start(context)
        for k in range(4):
            motion = {"nu": (-1.0, 0.1, 0), "sigma": (0.1, 0.05 * k, 0.02), "omega": (0.01, 0.02, 0.03), "w": (0.01, 0, 0.02)}
            now = step(float(k), (2.0 - k, 0.3, 0.1), **motion)
            place = now.motion.rho + Vector(x * (1 + k), x, 2.0 * x)
            now = now._replace(motion=now.motion._replace(rho=place, sigma=now.motion.sigma + Vector(x, 0.0, x)))
            acc = metric.update(acc, now, 1.0, context)
        return jnp.stack(list(metric.finish(acc, context).values()))

    check(values, 1e-6)
    assert values(0.0)[0] == pytest.approx(2.1, abs=0.1)
