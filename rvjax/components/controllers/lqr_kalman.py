"""Discrete-time LQR with a steady-state Kalman filter: position and attitude as double integrators about the nominal
feed-forward.

    x = (ρ, ν) or (4σ, ω), per axis:   x_{k+1} = A x_k + B a_k,   A = [1 T; 0 1],   B = [T²/2; T]
    x̂_k = x̄_k + L (y_k − x̄_k),   x̄_{k+1} = A x̂_k + B a_k        in the frame of P, which turns by ΩT meanwhile
    f = m₀ (−n − K x̂),   τ = J₀ (−(ω×Rω_t − Rω̇_t) − K x̂) + Ω×J₀Ω

K = (R + BᵀSB)⁻¹BᵀSA with S = Q + AᵀSA − AᵀSB(R + BᵀSB)⁻¹BᵀSA, Q and R by Bryson's rule: 1/(largest accepted value)².
L = P(P + N)⁻¹ with P = W + A(P − P(P + N)⁻¹P)Aᵀ: N = diag of the sensors' variances, W = BBᵀ · (variance of the acceleration).
a_k: acceleration that the command gives the nominal body behind the saturation.

A. E. Bryson, Y.-C. Ho, "Applied optimal control", 1975, ch. 5 and 12. The Riccati equations: `rvjax.physics.riccati`.
Baseline of this project. Does not adapt, estimate disturbances, or tolerate faults; a constant disturbance leaves an error.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from rvjax.campaign import Model, Quantity, number, part, scalar
from rvjax.columns import Column
from rvjax.components.controllers.interface import DiscreteController, Saturate
from rvjax.components.registry import Component
from rvjax.physics.backstepping import NominalGains
from rvjax.physics.dynamics import measured_relative
from rvjax.physics.riccati import filtered, regulator
from rvjax.physics.state import Measurement, Motion, Numbers, Report
from rvjax.physics.vectors import Channels, Vector, cross, mrp_rate, rotate, rotation


class Gains(NominalGains):
    """Weights of the regulator, noise of the filter, and the nominal plant."""

    error_m: Quantity = scalar("m", default=1.0, above=0.0, doc="accepted position error")
    speed_m_s: Quantity = scalar("m/s", default=0.035, above=0.0, doc="accepted velocity error")
    acceleration: Quantity = scalar("m/s²", default=0.0025, above=0.0, doc="accepted acceleration")
    error_rad: Quantity = scalar("rad", key="error_deg", default=57.3, above=0.0, doc="accepted attitude error")
    rate_rad_s: Quantity = scalar("rad/s", key="rate_deg_s", default=8.0, above=0.0, doc="accepted rate error")
    angular_acceleration: Quantity = scalar("rad/s²", default=0.04, above=0.0, doc="accepted angular acceleration")
    sensor_m: Quantity = scalar("m", default=0.01, above=0.0, doc="standard deviation of the measured position")
    sensor_m_s: Quantity = scalar("m/s", default=0.002, above=0.0, doc="standard deviation of the measured velocity")
    sensor_rad: Quantity = scalar(
        "rad", key="sensor_deg", default=0.05, above=0.0, doc="standard deviation of the measured attitude"
    )
    sensor_rad_s: Quantity = scalar(
        "rad/s", key="sensor_deg_s", default=0.01, above=0.0, doc="standard deviation of the measured rate"
    )
    unknown: Quantity = scalar("m/s²", default=0.005, above=0.0, doc="standard deviation of the unknown acceleration")
    unknown_angular: Quantity = scalar(
        "rad/s²", default=0.005, above=0.0, doc="standard deviation of the unknown angular acceleration"
    )


class Parameters(Model):
    """Period and gains."""

    period_s: float = number("s", default=0.5, above=0.0, doc="period T, a whole number of steps")
    gains: Gains = part(default={}, doc="gains")


class Memory(NamedTuple):
    """Predicted motion at the next instant, and the gains of regulators and filters: k for position and attitude, (2,); l for
    position and attitude, (2, 2)."""

    expected: Motion
    k: tuple[Any, Any]
    l: tuple[Any, Any]  # noqa: E741


def _corrected(gain: Any, x: Vector, v: Vector, dx: Vector, dv: Vector) -> tuple[Vector, Vector]:
    """(x̂, v̂) from a prediction and the differences of the measurement from it."""
    return x + dx * gain[0, 0] + dv * gain[0, 1], v + dx * gain[1, 0] + dv * gain[1, 1]


def build(parameters: Parameters) -> DiscreteController:
    """The controller with its period."""
    period = parameters.period_s

    def start(measurement: Measurement, gains: Numbers) -> Memory:
        k = regulator(period, gains.error_m, gains.speed_m_s, gains.acceleration)
        turn = regulator(period, gains.error_rad, gains.rate_rad_s, gains.angular_acceleration)
        l = filtered(period, gains.sensor_m, gains.sensor_m_s, gains.unknown)  # noqa: E741
        look = filtered(period, gains.sensor_rad, gains.sensor_rad_s, gains.unknown_angular)
        return Memory(measurement.motion, (k, turn), (l, look))

    def update(measurement: Measurement, memory: Memory, saturate: Saturate, gains: Numbers) -> tuple[Channels, Memory, Report]:
        y, x = measurement.motion, memory.expected
        rho, nu = _corrected(memory.l[0], x.rho, x.nu, y.rho - x.rho, y.nu - x.nu)
        angle, omega = _corrected(memory.l[1], x.sigma * 4.0, x.omega, (y.sigma - x.sigma) * 4.0, y.omega - x.omega)
        seen = Motion(rho, nu, angle * 0.25, omega)
        known = measured_relative(measurement, seen)
        (k, turn), momentum = memory.k, known.omega_p * gains.inertia_guess_kgm2
        gyro = cross(known.omega_p, momentum)
        force = (-known.accel - rho * k[0] - nu * k[1]) * gains.mass_guess_kg
        torque = (-known.alpha - angle * turn[0] - omega * turn[1]) * gains.inertia_guess_kgm2 + gyro
        command = Channels(force, torque)
        h, _ = saturate(command)
        accel, spin = h.force / gains.mass_guess_kg + known.accel, (h.torque - gyro) / gains.inertia_guess_kgm2
        alpha = spin + known.alpha
        turned = rotation((known.omega_p + spin * (0.5 * period)) * (0.25 * period))
        expected = Motion(
            rho=rotate(turned, rho + nu * period + accel * (0.5 * period * period)),
            nu=rotate(turned, nu + accel * period),
            sigma=seen.sigma + mrp_rate(seen.sigma, omega + alpha * (0.5 * period)) * period,
            omega=omega + alpha * period,
        )
        nothing = command * 0.0
        return command, memory._replace(expected=expected), Report(nothing, nothing.force.x, {"expected_rho_m": expected.rho})

    return DiscreteController(start, update, SIGNALS, period)


SIGNALS = {"expected_rho_m": Column("expected_rho_m", "m", "position expected at the next instant, in P then")}

COMPONENT = Component(Parameters, build)
