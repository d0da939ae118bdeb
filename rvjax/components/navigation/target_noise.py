"""White noise of what the controller knows of the target's angular rate, new in every step and held during it.

    ω_t + s ξ_k         in T, ξ: standard normal, independent

s is the standard deviation of a single value for any step; a sampled controller reads it only at its sampling instants. ω̇_t has
no noise. Constant errors of what is known of the target: `target-knowledge`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from rvjax.campaign import Model, Quantity, vector
from rvjax.components.effect import zero
from rvjax.components.navigation.interface import Known, NavigationError
from rvjax.components.registry import Component
from rvjax.physics.noise import normals
from rvjax.physics.state import Motion, Numbers, Tick
from rvjax.physics.vectors import Scalar, Vector, each


class Parameters(Model):
    """Standard deviation."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"rate_deg_s": 0.01},)

    rate_rad_s: Quantity = vector(
        "rad/s", key="rate_deg_s", at_least=0.0, doc="standard deviation s of the target's angular rate, per axis of T"
    )


def start(motion: Motion, numbers: Numbers) -> Vector:
    """Zero before the flight; the first step draws."""
    del motion
    return numbers.rate_rad_s * 0.0


def keep(tick: Tick, motion: Motion, memory: Vector, numbers: Numbers) -> Vector:
    """s ξ_k."""
    del motion, memory
    return each(lambda s, xi: s * xi, numbers.rate_rad_s, Vector(*normals(numbers.noise, tick.k, 3)))


def see(t: Scalar, motion: Motion, memory: Vector, numbers: Numbers) -> Motion:
    """The motion as it is."""
    del t, memory, numbers
    return motion


def knows(t: Scalar, known: Known, memory: Vector, numbers: Numbers) -> Known:
    """ω_t + s ξ_k."""
    del t, numbers
    return known._replace(target=known.target._replace(w=known.target.w + memory))


COMPONENT = Component(
    Parameters, lambda parameters: NavigationError(see, start, keep, knows), noisy=True, neutral=(zero("rate_rad_s"),)
)
