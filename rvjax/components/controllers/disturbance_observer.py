"""Disturbance-observer fault-tolerant controller: estimates the lumped disturbance and compensates it.

    M₀ẋ₂ = Y₀θ₀ + h(v) + D,   x₂ = (ν, ω)             D: faults, disturbances, mismatch of m₀ and J₀
    D̂ = p + L M₀x₂,   ṗ = −L [Y₀θ₀ + h(v) + D̂]        observer; D̂(0) = 0
    v = −[Yθ₀ + K₂z₂ − Cα₁ + D̂]

Y₀: Y about zero virtual velocity, so that Y₀θ₀ = (m₀(n − Ω×ν), J₀(ω×Rω_t − Rω̇_t) − Ω×J₀Ω); α₁, z₂, Y: `physics.backstepping`;
M₀ = diag(m₀ I, J₀ I). Then D̂̇ = L (D − D̂): D̂ is D after a first-order lag of bandwidth L, and the error of a constant D falls
as e^{−Lt}. The electronics report h(v), so saturation does not count as a disturbance and D̂ does not grow with it.
A loss of effectiveness, D = (e − 1)h(v), depends on v: D̂ then follows at the rate eL (m₀/m), which is stable for every e > 0.

W.-H. Chen, D. Ballance, P. Gawthrop, J. O'Reilly, "A nonlinear disturbance observer for robotic manipulators", IEEE Trans.
Industrial Electronics, 2000. Baseline of this project; gains: docs/controllers.md. Does not distinguish faults
from disturbances, or adapt mass and inertia. D̂ follows a measured velocity, so its noise is amplified by L M₀.
"""

from __future__ import annotations

from typing import NamedTuple

from rvjax.campaign import Model, Quantity, part, scalar, with_defaults
from rvjax.columns import Column
from rvjax.components.controllers.interface import WRENCH, Controller, Response, Saturate
from rvjax.components.registry import Component
from rvjax.physics.backstepping import (
    FirstErrorGains,
    NominalGains,
    Tracking,
    TrackingGains,
    certainty_equivalence,
    following,
    model,
    nominal,
    tracking,
)
from rvjax.physics.dynamics import measured_relative
from rvjax.physics.state import Measurement, Numbers, Report
from rvjax.physics.vectors import Channels


class Gains(
    with_defaults(TrackingGains, k1=0.19, k_sigma=0.089, k2_force=61.0, k2_torque=28.0),
    with_defaults(FirstErrorGains, c_force=3.4, c_torque=5.8),
    NominalGains,
):
    """Gains of the controller."""

    observer_force_rad_s: Quantity = scalar("rad/s", default=0.99, above=0.0, doc="bandwidth L of the force channels")
    observer_torque_rad_s: Quantity = scalar("rad/s", default=0.91, above=0.0, doc="bandwidth L of the torque channels")


class Parameters(Model):
    """The gains."""

    gains: Gains = part(default={}, doc="gains")


class Control(NamedTuple):
    """p [N, N·m]."""

    p: Channels


def free(measurement: Measurement) -> Tracking:
    """Tracking with zero virtual velocity: x₂ for z₂ and Y₀ for Y."""
    zero = measurement.upper * 0.0
    return following(measurement, measured_relative(measurement), zero, zero)


def momentum(now: Tracking, gains: Numbers) -> Channels:
    """L M₀x₂."""
    slope = (gains.observer_force_rad_s * gains.mass_guess_kg, gains.observer_torque_rad_s * gains.inertia_guess_kgm2)
    return Channels.pair(*slope) * now.z2


def start(measurement: Measurement, gains: Numbers) -> Control:
    """D̂ = 0."""
    return Control(-momentum(free(measurement), gains))


def respond(measurement: Measurement, state: Control, saturate: Saturate, gains: Numbers) -> Response:
    """v, and the rate of p."""
    theta, plant = nominal(gains), free(measurement)
    estimate = state.p + momentum(plant, gains)
    command = certainty_equivalence(tracking(True, measurement, gains), *theta, gains) - estimate
    h, _ = saturate(command)
    speed = Channels.pair(gains.observer_force_rad_s, gains.observer_torque_rad_s)
    rate = -(speed * (model(plant, *theta) + h + estimate))
    nothing = command * 0.0
    return Response(command, Control(rate), Report(nothing, nothing.force.x, {"disturbance": estimate}))


SIGNALS = {"disturbance": Column("disturbance", WRENCH, "estimated lumped disturbance")}


def build(parameters: Parameters) -> Controller:
    """The controller."""
    del parameters
    return Controller(start, respond, SIGNALS)


COMPONENT = Component(Parameters, build)
