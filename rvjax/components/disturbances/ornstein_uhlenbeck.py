"""Coloured noise on the pursuer: an independent Ornstein-Uhlenbeck process in every channel, fixed in P.

    x_{k+1} = e^{−h/τ} x_k + s √(1 − e^{−2h/τ}) ξ_k,   x₀ = s ξ₀,   ξ: standard normal, independent

The exact discretisation of ẋ = −x/τ + s √(2/τ) · white noise, stationary from the start: variance s² at every step and
correlation e^{−|t−t'|/τ} for any step h. The wrench is held during a step (D. Gillespie, "Exact numerical simulation of the
Ornstein-Uhlenbeck process and its integral", Physical Review E, 1996).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, channels, vector
from rvjax.components.disturbances.interface import Disturbance, without_silent
from rvjax.components.effect import zero
from rvjax.components.registry import Component
from rvjax.physics.dynamics import Relative
from rvjax.physics.elementary import expm1
from rvjax.physics.noise import normals
from rvjax.physics.state import Numbers, Plant, State, Tick
from rvjax.physics.vectors import Channels, Scalar, each


class Parameters(Model):
    """Standard deviation and time constant, per channel."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"force_N": 0.01, "time_constant_s": 20},)

    force_N: Quantity = vector("N", default=0.0, at_least=0.0, doc="standard deviation s of the force channels")
    torque_Nm: Quantity = vector("N·m", default=0.0, at_least=0.0, doc="standard deviation s of the torque channels")
    time_constant_s: Quantity = channels("s", above=0.0, doc="time constant τ; the correlation is e^{−1} after τ")

    def _quantities(self, prefix: str) -> Iterator[tuple[str, Quantity]]:
        return without_silent(super()._quantities(prefix), self.force_N, self.torque_Nm)


def start(numbers: Numbers) -> Channels:
    """Zero before the flight; the first step draws x₀."""
    return Channels(numbers.force_N * 0.0, numbers.torque_Nm * 0.0)


def keep(tick: Tick, y: State, memory: Channels, numbers: Numbers) -> Channels:
    """x_k; s ξ₀ in the first step."""
    del y

    def following(x: Scalar, sd: Scalar, tau: Scalar, xi: Scalar) -> Scalar:
        fall = jnp.where(tick.k == 0, -1.0, expm1(-tick.h / tau))  # e^{−h/τ} − 1
        return (1.0 + fall) * x + sd * jnp.sqrt(-fall * (2.0 + fall)) * xi

    xi = Channels.of(normals(numbers.noise, tick.k, 6))
    return each(following, memory, Channels(numbers.force_N, numbers.torque_Nm), numbers.time_constant_s, xi)


def push(t: Scalar, y: State, known: Relative, plant: Plant, memory: Channels, numbers: Numbers) -> Channels:
    """x_k."""
    del t, y, known, plant, numbers
    return memory


COMPONENT = Component(
    Parameters, lambda parameters: Disturbance(push, start, keep), noisy=True, neutral=(zero("force_N", "torque_Nm"),)
)
