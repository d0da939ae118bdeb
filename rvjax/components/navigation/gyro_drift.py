"""Gyro drift: bias random walk of the measured angular rate.

    ω + b_k,   b_{k+1} = b_k + q √h ξ_k,   ξ: standard normal, independent

The exact discretisation of ḃ = q · white noise: after a time t, the standard deviation of the change is q √t for any step h. b₀:
bias at t = 0. The bias is held during a step. The rate random walk of a gyro (E. Lefferts, F. Markley, M. Shuster, "Kalman
filtering for spacecraft attitude estimation", J. Guidance, Control, and Dynamics, 1982).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, vector
from rvjax.components.effect import zero
from rvjax.components.navigation.interface import NavigationError
from rvjax.components.registry import Component
from rvjax.physics.noise import normals
from rvjax.physics.state import Motion, Numbers, Tick
from rvjax.physics.vectors import Scalar, Vector, each


class Parameters(Model):
    """Initial bias and random walk, per axis of P."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"walk_deg_s": 0.001},)

    bias_rad_s: Quantity = vector("rad/s", key="bias_deg_s", default=0.0, doc="bias b₀ at t = 0")
    walk_rad_s: Quantity = vector(
        "rad/s",
        key="walk_deg_s",
        at_least=0.0,
        doc="standard deviation q of the change of the bias in 1 s; it grows with √t",
    )


def start(motion: Motion, numbers: Numbers) -> Vector:
    """b₀."""
    del motion
    return numbers.bias_rad_s


def keep(tick: Tick, motion: Motion, memory: Vector, numbers: Numbers) -> Vector:
    """b_k; b₀ in the first step."""
    del motion
    root = jnp.where(tick.k == 0, 0.0, jnp.sqrt(tick.h))
    xi = Vector(*normals(numbers.noise, tick.k, 3))
    return each(lambda b, q, x: b + q * root * x, memory, numbers.walk_rad_s, xi)


def see(t: Scalar, motion: Motion, memory: Vector, numbers: Numbers) -> Motion:
    """ω + b_k."""
    del t, numbers
    return motion._replace(omega=motion.omega + memory)


COMPONENT = Component(
    Parameters,
    lambda parameters: NavigationError(see, start, keep),
    noisy=True,
    neutral=(zero("bias_rad_s", "walk_rad_s"),),
)
