"""What a user's controller measures at an instant, on plain arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp

from rvjax.components.controllers.interface import Saturate
from rvjax.components.forms import arrays
from rvjax.physics.state import Measurement, PointMotion
from rvjax.physics.vectors import Channels


@dataclass(frozen=True)
class Measured:
    """What a controller measures at an instant, as arrays. Frames: P fixed in the pursuer, T fixed in the target.

    t: time [s]. rho: pursuer minus reference point, in P [m]. nu: difference of their inertial velocities, in P [m/s]. sigma:
    modified Rodrigues parameters of P with respect to T. omega: angular velocity of P relative to T, in P [rad/s]. target_r,
    target_v, target_w: inertial position [m], velocity [m/s] and angular velocity [rad/s] of the target, in T. target_alpha: its
    angular acceleration, in T [rad/s²]. port: the reference point, in T [m]; port_velocity, port_acceleration: how it moves in T
    [m/s, m/s²]. It is the docking point, at rest in T, unless the campaign has a guidance. upper, lower: nominal limits of the
    channels [N, N·m]. exact: the same values as `Measurement`, for the functions of `rvjax.physics`.
    """

    t: Any
    rho: Any
    nu: Any
    sigma: Any
    omega: Any
    target_r: Any
    target_v: Any
    target_w: Any
    target_alpha: Any
    port: Any
    port_velocity: Any
    port_acceleration: Any
    upper: Any
    lower: Any
    exact: Measurement
    saturate: Saturate

    NAMES = ("t", "rho", "nu", "sigma", "omega", "target_r", "target_v", "target_w", "target_alpha", "port",
             "port_velocity", "port_acceleration", "upper", "lower", "quaternion", "saturated")  # fmt: skip

    @classmethod
    def of(cls, measurement: Measurement, saturate: Saturate, plain: bool) -> Measured:
        """The measurement; plain: as arrays."""
        form = arrays.array if plain else lambda value: value
        motion, target = measurement.motion, measurement.target
        still = PointMotion(measurement.port * 0.0, measurement.port * 0.0)
        moving = measurement.moving if isinstance(measurement.moving, PointMotion) else still
        limits = (measurement.upper, measurement.lower)
        known = (*motion, *target, measurement.alpha_t, measurement.port, *moving, *limits)
        values: list[Any] = [measurement.t, *map(form, known), measurement, saturate]
        return cls(*values)

    @property
    def quaternion(self) -> Any:
        """(w, x, y, z) of P with respect to T, w ≥ 0 where |σ| ≤ 1: ((1 − σᵀσ), 2σ)/(1 + σᵀσ)."""
        sigma = arrays.array(self.exact.motion.sigma)
        square = sigma @ sigma
        return jnp.concatenate([(1.0 - square)[None], 2.0 * sigma]) / (1.0 + square)

    def saturated(self, force: Any, torque: Any) -> Any:
        """(6,) what the actuators are told of a command, h(v), as the drive electronics report it [N, N·m]."""
        h, _ = self.saturate(Channels(arrays.vector(force, "the force"), arrays.vector(torque, "the torque")))
        return arrays.array(h)
