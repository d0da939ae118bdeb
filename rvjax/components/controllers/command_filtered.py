"""Command-filtered adaptive backstepping: a second-order filter differentiates the virtual velocity; its error is compensated.

    α = A(z̄₁) + A(ξ₁),   A(x) = (−k₁x_ρ/√(1+(k₁|x_ρ|/v_max)²), −k_σx_σ)        virtual velocity
    α̈_f = −2ζω_n α̇_f − ω_n² (α_f − α),   z₂ = (ν, ω) − α_f                      command filter
    v = u = −[Yθ̂ + K₂z₂ + P],   P = (−C_f A_ρ(z̄_ρ), 4C_τk_σ G(σ)ᵀz̄_σ),   Y with α̇_f
    ξ̇_ρ = −Ω×ξ_ρ + A(ξ_ρ) + (α_f − α)_ν + ξ_ν,   ξ̇_σ = G(σ) [A(ξ_σ) + (α_f − α)_ω + ξ_ω],   z̄₁ = (ρ, σ) − ξ₁
    M₀ξ̇₂ = −K₂ξ₂ + h(u) − u,   z̄₂ = z₂ − ξ₂,   θ̂̇ = Γ Yᵀz̄₂, projected

G, Ω, h: `physics.vectors`, `physics.state`, the simulated saturation. M₀ = diag(m₀ I, J₀ I), the initial θ̂. The filter follows a
ramp of slope a with the error 2ζ/ω_n · a. ξ follows the errors of the filter and the saturation, so neither enters the
compensated errors: with M = M₀, without faults and disturbances, V = V₁(z̄₁) + ½z̄₂ᵀMz̄₂ + ½θ̃ᵀΓ⁻¹θ̃ falls as V̇ = −C_f|A(z̄_ρ)|²
− 4C_τk_σ² z̄_σᵀG z̄_σ − z̄₂ᵀK₂z̄₂ for any ω_n. With A linear and no saturation this is the controller of the paper. The filter
needs no derivative of α; it replaces the analytic α̇₁ and the Levant differentiator of saturated-adaptive.

J. Farrell, M. Polycarpou, M. Sharma, W. Dong, "Command filtered backstepping", IEEE Trans. Automatic Control, 2009; ξ₂ as in
their constrained form of 2005. Baseline of this project; gains: docs/controllers.md. Does not bound or estimate
disturbances, or tolerate faults. At an MRP switch (|σ| > 1) ξ_σ does not switch with σ.
"""

from __future__ import annotations

from typing import NamedTuple, Self

from pydantic import model_validator

from rvjax.campaign import Model, Quantity, part, scalar, with_defaults
from rvjax.campaign.plain_values import exact
from rvjax.campaign.problems import Problem, refuse
from rvjax.columns import Column
from rvjax.components.controllers.interface import ESTIMATES, Controller, Response, Saturate
from rvjax.components.registry import Component
from rvjax.physics.backstepping import (
    AdaptationGains,
    FirstErrorGains,
    TrackingGains,
    adaptation,
    drift,
    feedback,
    following,
    model,
    nominal,
    virtual_velocity,
)
from rvjax.physics.dynamics import Relative, measured_relative
from rvjax.physics.state import Measurement, Numbers, Report
from rvjax.physics.vectors import Channels, Scalar, Symmetric, cross, mrp_rate


class Gains(
    with_defaults(TrackingGains, k1=0.25, k_sigma=1.2, k2_force=200.0, k2_torque=56.0),
    with_defaults(FirstErrorGains, c_force=2.0, c_torque=2.8),
    AdaptationGains,
):
    """Gains of the controller."""

    filter_rad_s: Quantity = scalar("rad/s", default=25.0, above=0.0, doc="natural frequency ω_n of the command filter")
    filter_damping: Quantity = scalar("1", default=1.0, above=0.0, doc="damping ζ of the command filter")

    @model_validator(mode="after")
    def _fast_enough(self) -> Self:
        """The filter must be faster than the loop whose command it filters."""
        ((slowest, _),), ((_, loop),) = self.filter_rad_s.supports, self.k1.supports
        if slowest <= loop:
            words = "the command filter is not faster than the position loop"
            refuse(Problem(words, f"accepted: above k1, {exact(loop)} rad/s, in every draw", ("filter_rad_s",)))
        return self


class Parameters(Model):
    """The gains."""

    gains: Gains = part(default={}, doc="gains")


class Control(NamedTuple):
    """m̂ [kg], Ĵ [kg·m²], α_f and α̇_f [m/s, rad/s, per s], ξ₁ [m, 1], ξ₂ [m/s, rad/s]."""

    mass: Scalar
    inertia: Symmetric
    filtered: Channels
    filtered_rate: Channels
    xi1: Channels
    xi2: Channels


def start(measurement: Measurement, gains: Numbers) -> Control:
    """θ̂(0) from the gains, α_f = α, α̇_f = ξ = 0."""
    zero = measurement.upper * 0.0
    known = measured_relative(measurement)
    alpha = virtual(measurement, known, Channels(measurement.motion.rho, measurement.motion.sigma), gains)
    return Control(*nominal(gains), alpha, zero, zero, zero)


def virtual(measurement: Measurement, known: Relative, x: Channels, gains: Numbers) -> Channels:
    """A(x)."""
    there = measurement._replace(motion=measurement.motion._replace(rho=x.force, sigma=x.torque))
    return virtual_velocity(True, there, known, gains)[0]


def respond(measurement: Measurement, state: Control, saturate: Saturate, gains: Numbers) -> Response:
    """v, and the rate of (θ̂, α_f, α̇_f, ξ)."""
    known = measured_relative(measurement)
    sigma = measurement.motion.sigma
    z1 = Channels(measurement.motion.rho, sigma) - state.xi1
    pulled, lagging = virtual(measurement, known, z1, gains), virtual(measurement, known, state.xi1, gains)
    alpha = pulled + lagging
    now = following(measurement, known, state.filtered, state.filtered_rate)
    turn = mrp_rate(-sigma, z1.torque) * (4.0 * gains.c_torque * gains.k_sigma)  # G(σ)ᵀ = G(−σ)
    first = Channels(pulled.force * -gains.c_force, turn)
    command = -(model(now, state.mass, state.inertia) + feedback(now.z2, gains) + first)
    h, _ = saturate(command)

    missed = lagging + (state.filtered - alpha) + state.xi2
    mass_rate, inertia_rate = adaptation(now, now.z2 - state.xi2, state.mass, state.inertia, gains)
    omega = gains.filter_rad_s
    rate = Control(
        mass=mass_rate,
        inertia=inertia_rate,
        filtered=state.filtered_rate,
        filtered_rate=state.filtered_rate * (-2.0 * gains.filter_damping * omega) - (state.filtered - alpha) * (omega * omega),
        xi1=Channels(missed.force - cross(known.omega_p, state.xi1.force), mrp_rate(sigma, missed.torque)),
        xi2=(h - command - feedback(state.xi2, gains)) / Channels.pair(gains.mass_guess_kg, gains.inertia_guess_kgm2),
    )
    signals = {"mass_kg": state.mass, "inertia_kgm2": state.inertia, "xi_rho_m": state.xi1.force, "xi_sigma": state.xi1.torque}
    return Response(command, rate, Report(command * 0.0, drift(state.mass, state.inertia, gains), signals))


SIGNALS = {
    **ESTIMATES,
    "xi_rho_m": Column("xi_rho_m", "m", "compensating signal of the position error"),
    "xi_sigma": Column("xi_sigma", "1", "compensating signal of the attitude error"),
}


def build(parameters: Parameters) -> Controller:
    """The controller."""
    del parameters
    return Controller(start, respond, SIGNALS)


COMPONENT = Component(Parameters, build)
