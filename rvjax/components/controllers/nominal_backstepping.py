"""Nominal adaptive backstepping with a hard clip: estimates mass and inertia, ignores faults and limits.

    u = −[Yθ̂ + K₂z₂ − Cα₁],   v = min(max(u, −u⁻), u⁺) at the nominal limits
    θ̂̇ = Γ Yᵀz₂, projected into bounds, and never frozen

α₁, z₂, Y: `rvjax.physics.backstepping`. With no faults, disturbances or limits, V = V₁ + ½z₂ᵀMz₂ + ½θ̃ᵀΓ⁻¹θ̃ falls as
V̇ = −α₁ᵀCα₁ − z₂ᵀK₂z₂ for any mass and inertia. With the clip, this proof does not hold: while z₂ is large because
the actuators are at their limit, the estimates keep changing (wind-up).

M. Krstić, I. Kanellakopoulos, P. Kokotović, "Nonlinear and adaptive control design", 1995, ch. 3–4. Baseline of this project;
gains: docs/controllers.md. Does not bound or estimate disturbances, compensate the clip, or tolerate faults.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp

from rvjax.campaign import Model, part, with_defaults
from rvjax.components.controllers.interface import ESTIMATES, Controller, Response, Saturate
from rvjax.components.registry import Component
from rvjax.physics.backstepping import (
    AdaptationGains,
    FirstErrorGains,
    TrackingGains,
    adaptation,
    certainty_equivalence,
    drift,
    nominal,
    tracking,
)
from rvjax.physics.state import Measurement, Numbers, Report
from rvjax.physics.vectors import Scalar, Symmetric, each


class Gains(
    with_defaults(TrackingGains, k1=0.3, k_sigma=0.64, k2_force=200.0, k2_torque=69.0),
    with_defaults(FirstErrorGains, c_force=3.8, c_torque=7.2),
    AdaptationGains,
):
    """Gains of the controller."""


class Parameters(Model):
    """The gains."""

    gains: Gains = part(default={}, doc="gains")


class Control(NamedTuple):
    """m̂ [kg], Ĵ [kg·m²]."""

    mass: Scalar
    inertia: Symmetric


def start(measurement: Measurement, gains: Numbers) -> Control:
    """θ̂(0) from the gains."""
    del measurement
    return Control(*nominal(gains))


def respond(measurement: Measurement, state: Control, saturate: Saturate, gains: Numbers) -> Response:
    """v, and the rate of θ̂."""
    del saturate
    now = tracking(True, measurement, gains)
    wanted = certainty_equivalence(now, state.mass, state.inertia, gains)
    command = each(jnp.clip, wanted, -measurement.lower, measurement.upper)
    rate = Control(*adaptation(now, now.z2, state.mass, state.inertia, gains))
    signals = {"mass_kg": state.mass, "inertia_kgm2": state.inertia}
    return Response(command, rate, Report(command * 0.0, drift(state.mass, state.inertia, gains), signals))


def build(parameters: Parameters) -> Controller:
    """The controller."""
    del parameters
    return Controller(start, respond, ESTIMATES)


COMPONENT = Component(Parameters, build)
