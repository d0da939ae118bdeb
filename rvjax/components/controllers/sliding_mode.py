"""Sliding-mode controller with a boundary layer: nominal feed-forward, a bounded switching term, no adaptation.

    s = z₂ = (ν, ω) − (α_ν, α_ω)                     sliding variable about the shaped virtual velocity
    v = −[Yθ₀ + M₀K sat(s/φ)],   sat(x) = min(max(x, −1), 1),   θ₀ = (m₀, J₀ I),   M₀ = diag(m₀ I, J₀ I)

α, Y: `physics.backstepping`. On s = 0 the errors fall as ρ̇ = α_ν − Ω×ρ and σ̇ = G(σ)α_ω. With the nominal plant and an unknown
wrench d, M₀ṡ = d − M₀K sat(s/φ): |s| falls outside the boundary layer |s| ≤ φ as long as |d| < M₀K, and inside it comes to
rest at |s| = φ|d|/(M₀K). A constant d leaves an error, which falls with the slope of the layer; without a layer v would chatter.

J.-J. Slotine, W. Li, "Applied nonlinear control", 1991, ch. 7. Baseline of this project; gains: docs/controllers.md.
Does not estimate anything or use the actuators' state.
"""

from __future__ import annotations

import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, part, scalar, with_defaults
from rvjax.columns import Column
from rvjax.components.controllers.interface import Controller, Response, Saturate
from rvjax.components.registry import Component
from rvjax.physics.backstepping import GuidanceGains, NominalGains, model, nominal, tracking
from rvjax.physics.state import Measurement, Numbers, Report
from rvjax.physics.vectors import Channels, each


class Gains(with_defaults(GuidanceGains, k1=0.3, k_sigma=1.1), NominalGains):
    """Size of the switching term as an acceleration, and the boundary layer."""

    k_force: Quantity = scalar("m/s²", default=0.039, above=0.0, doc="switching gain K of the force channels")
    k_torque: Quantity = scalar("rad/s²", default=0.036, above=0.0, doc="switching gain K of the torque channels")
    phi_force: Quantity = scalar("m/s", default=0.02, above=0.0, doc="boundary layer φ of the force channels")
    phi_torque: Quantity = scalar("rad/s", default=0.01, above=0.0, doc="boundary layer φ of the torque channels")


class Parameters(Model):
    """The gains."""

    gains: Gains = part(default={}, doc="gains")


def respond(measurement: Measurement, state: tuple[()], saturate: Saturate, gains: Numbers) -> Response:
    """v."""
    del saturate
    now = tracking(True, measurement, gains)
    depth = now.z2 / Channels.pair(gains.phi_force, gains.phi_torque)
    reach = Channels.pair(gains.mass_guess_kg * gains.k_force, gains.inertia_guess_kgm2 * gains.k_torque)
    command = -(model(now, *nominal(gains)) + reach * each(lambda x: jnp.clip(x, -1.0, 1.0), depth))
    nothing = command * 0.0
    return Response(command, state, Report(nothing, nothing.force.x, {"depth": depth}))


SIGNALS = {"depth": Column("depth", "1", "sliding variable as a share of the boundary layer")}


def build(parameters: Parameters) -> Controller:
    """The controller, which has no state."""
    del parameters
    return Controller(lambda measurement, gains: (), respond, SIGNALS)


COMPONENT = Component(Parameters, build)
