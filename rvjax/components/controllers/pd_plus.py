"""PD+ controller: proportional-derivative feedback with nominal feed-forward; neither adaptive nor fault-tolerant.

    f = m₀ (−n − k_ρ ρ − k_ν ν)
    τ = J₀ (−(ω×Rω_t − Rω̇_t) − k_σ σ − k_ω ω) + Ω×J₀Ω

With m = m₀, J = J₀, no limits, faults or disturbances: V = ½k_ρρᵀρ + ½νᵀν falls as V̇ = −k_ν νᵀν, since ρᵀ(Ω×ρ) = νᵀ(Ω×ν) = 0,
and W = 2k_σ ln(1+σᵀσ) + ½ωᵀω falls as Ẇ = −k_ω ωᵀω (B. Paden, R. Panja, "Globally asymptotically stable PD+ controller for
robot manipulators", Int. J. Control, 1988; MRP form: P. Tsiotras, 1996). Baseline of this project.
"""

from __future__ import annotations

from rvjax.campaign import Model, Quantity, part, scalar
from rvjax.components.controllers.interface import Controller, Response, Saturate
from rvjax.components.registry import Component
from rvjax.physics.backstepping import NominalGains
from rvjax.physics.dynamics import measured_relative
from rvjax.physics.state import Measurement, Numbers, Report
from rvjax.physics.vectors import Channels, cross


class Gains(NominalGains):
    """Natural frequency² and damping of each loop, and the nominal plant."""

    k_rho: Quantity = scalar("1/s²", default=0.0025, above=0.0, doc="position stiffness k_ρ")
    k_nu: Quantity = scalar("1/s", default=0.1, above=0.0, doc="velocity damping k_ν")
    k_sigma: Quantity = scalar("1/s²", default=0.16, above=0.0, doc="attitude stiffness k_σ")
    k_omega: Quantity = scalar("1/s", default=0.4, above=0.0, doc="rate damping k_ω")


class Parameters(Model):
    """The gains."""

    gains: Gains = part(default={}, doc="gains")


def respond(measurement: Measurement, state: tuple[()], saturate: Saturate, gains: Numbers) -> Response:
    """v = (f, τ)."""
    del saturate
    motion = measurement.motion
    known = measured_relative(measurement)
    accel = -known.accel - motion.rho * gains.k_rho - motion.nu * gains.k_nu
    turn = -known.alpha - motion.sigma * gains.k_sigma - motion.omega * gains.k_omega
    momentum = known.omega_p * gains.inertia_guess_kgm2
    command = Channels(accel * gains.mass_guess_kg, turn * gains.inertia_guess_kgm2 + cross(known.omega_p, momentum))
    nothing = command * 0.0
    return Response(command, state, Report(nothing, nothing.force.x, {}))


def build(parameters: Parameters) -> Controller:
    """The controller, which has no state."""
    del parameters
    return Controller(lambda measurement, gains: (), respond)


COMPONENT = Component(Parameters, build)
