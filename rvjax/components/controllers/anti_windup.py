"""Adaptive backstepping with an anti-windup auxiliary system, which removes the effect of saturation from the error.

    ζ̇ = −K_ζζ + h(u) − u                             auxiliary system [N·s, N·m·s]
    z̄ = z₂ − M₀⁻¹ζ,   M₀ = diag(m₀ I, J₀ I)          error without the saturation's part
    v = u = −[Yθ̂ + K₂z̄ − Cα₁ + K_ζζ],   θ̂̇ = Γ Yᵀz̄, projected

α₁, z₂, Y: `physics.backstepping`; h(u): the simulated saturation, as the drive electronics report it; m₀, J₀: initial θ̂.
M z̄̇ = −Yθ̃ − K₂z̄ + Cα₁ + d − (M − M₀)ζ̇: except for the mismatch of M₀, saturation does not enter the error, so it neither winds
up the estimates nor raises the command. With M = M₀, without faults and disturbances,
V = V₁ + ½z̄ᵀMz̄ + ½θ̃ᵀΓ⁻¹θ̃ falls as V̇ = −α₁ᵀCα₁ − z̄ᵀK₂z̄ − α₁ᵀC M₀⁻¹ζ, in saturation too; unsaturated, ζ = 0.

M. Chen, S. S. Ge, B. Ren, "Adaptive tracking control of uncertain MIMO nonlinear systems with input constraints", Automatica,
2011 (auxiliary design system). Baseline of this project; gains: docs/controllers.md.
Does not bound or estimate disturbances, or tolerate faults; h(u) does not contain the loss of a failed actuator.
"""

from __future__ import annotations

from typing import NamedTuple

from rvjax.campaign import Model, Quantity, part, scalar, with_defaults
from rvjax.columns import Column
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
from rvjax.physics.vectors import Channels, Scalar, Symmetric


class Gains(
    with_defaults(TrackingGains, k1=0.3, k_sigma=1.2, k2_force=200.0, k2_torque=75.0),
    with_defaults(FirstErrorGains, c_force=11.0, c_torque=0.8),
    AdaptationGains,
):
    """Gains of the controller."""

    k_zeta_force: Quantity = scalar("1/s", default=0.16, above=0.0, doc="leak K_ζ of the force channels")
    k_zeta_torque: Quantity = scalar("1/s", default=0.55, above=0.0, doc="leak K_ζ of the torque channels")


class Parameters(Model):
    """The gains."""

    gains: Gains = part(default={}, doc="gains")


class Control(NamedTuple):
    """m̂ [kg], Ĵ [kg·m²], ζ [N·s, N·m·s]."""

    mass: Scalar
    inertia: Symmetric
    zeta: Channels


def start(measurement: Measurement, gains: Numbers) -> Control:
    """θ̂(0) from the gains, ζ = 0."""
    return Control(*nominal(gains), measurement.upper * 0.0)


def respond(measurement: Measurement, state: Control, saturate: Saturate, gains: Numbers) -> Response:
    """v, and the rate of (θ̂, ζ)."""
    now = tracking(True, measurement, gains)
    now = now._replace(z2=now.z2 - state.zeta / Channels.pair(gains.mass_guess_kg, gains.inertia_guess_kgm2))
    leak = Channels.pair(gains.k_zeta_force, gains.k_zeta_torque) * state.zeta
    command = certainty_equivalence(now, state.mass, state.inertia, gains) - leak
    h, _ = saturate(command)
    rate = Control(*adaptation(now, now.z2, state.mass, state.inertia, gains), zeta=h - command - leak)
    signals = {
        "mass_kg": state.mass,
        "inertia_kgm2": state.inertia,
        "zeta_force": state.zeta.force,
        "zeta_torque": state.zeta.torque,
    }
    return Response(command, rate, Report(command * 0.0, drift(state.mass, state.inertia, gains), signals))


SIGNALS = {
    **ESTIMATES,
    "zeta_force": Column("zeta_force", "N·s", "auxiliary state, force channels"),
    "zeta_torque": Column("zeta_torque", "N·m·s", "auxiliary state, torque channels"),
}


def build(parameters: Parameters) -> Controller:
    """The controller."""
    del parameters
    return Controller(start, respond, SIGNALS)


COMPONENT = Component(Parameters, build)
