"""Sinusoidal disturbance wrench on the pursuer, with an amplitude, rate and phase for every channel.

dᵢ(t) = aᵢ sin(wᵢ t + φᵢ),   fixed in P
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

from rvjax.campaign import Model, Quantity, channels, vector
from rvjax.components.disturbances.interface import Disturbance, without_silent
from rvjax.components.effect import zero
from rvjax.components.registry import Component
from rvjax.components.wrench_over_time import fast_sinusoid
from rvjax.physics.dynamics import Relative
from rvjax.physics.elementary import sin
from rvjax.physics.state import Numbers, Plant, State
from rvjax.physics.vectors import Channels, Scalar, each


class Parameters(Model):
    """Amplitude, angular frequency and phase, per channel."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"force_N": [0.01, 0, 0], "rate_rad_s": 0.05},)

    force_N: Quantity = vector("N", default=0.0, doc="amplitude of the force channels")
    torque_Nm: Quantity = vector("N·m", default=0.0, doc="amplitude of the torque channels")
    rate_rad_s: Quantity = channels("rad/s", doc="angular frequency w")
    phase_rad: Quantity = channels("rad", key="phase_deg", default={"uniform": [0.0, 360.0]}, doc="phase φ at t = 0")

    def _quantities(self, prefix: str) -> Iterator[tuple[str, Quantity]]:
        return without_silent(super()._quantities(prefix), self.force_N, self.torque_Nm)


def push(t: Scalar, y: State, known: Relative, plant: Plant, memory: tuple[()], numbers: Numbers) -> Channels:
    """aᵢ sin(wᵢ t + φᵢ)."""
    del y, known, plant, memory
    amplitude = Channels(numbers.force_N, numbers.torque_Nm)
    return each(lambda a, w, phi: a * sin(w * t + phi), amplitude, numbers.rate_rad_s, numbers.phase_rad)


COMPONENT = Component(
    Parameters,
    lambda parameters: Disturbance(push),
    neutral=(zero("force_N", "torque_Nm"),),
    coarse=lambda p, campaign: fast_sinusoid(p.force_N, p.torque_Nm, p.rate_rad_s, campaign),
)
