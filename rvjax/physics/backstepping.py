"""Backstepping of the rendezvous errors: virtual velocity, the plant linear in its parameters, projected adaptation.

    α_ν = −k₁ρ/√(1+(k₁|ρ|/v_max)²) (shaped) or −k₁ρ,   α_ω = −k_σσ,   z₂ = (ν, ω) − (α_ν, α_ω)
    M ż₂ = Yθ + u + d,   θ = (m, J),   Yθ = (m a_ν, J a_ω − Ω×JΩ)
    a_ν = −Ω×ν + n − α̇_ν,   a_ω = ω×Rω_t − Rω̇_t − α̇_ω

The term of the first error is −Cα₁: V₁ = C_f (v_max²/k₁)(√(1+(k₁|ρ|/v_max)²) − 1) + 2C_τ k_σ ln(1+σᵀσ) has V̇₁ = −(Cα₁)ᵀ(ν, ω), so
u = −(Yθ + K₂z₂ − Cα₁) makes V = V₁ + ½z₂ᵀMz₂ fall as V̇ = −α₁ᵀCα₁ − z₂ᵀK₂z₂. C = 0: a cascade.

A default that `follows` the mass or the inertia is for 100 kg or 21.67 kg·m², in proportion to the campaign's nominal body
(`rvjax.campaign.nominal_body`). γ_D, which force and torque channels share, follows the mass.

M. Krstić, I. Kanellakopoulos, P. Kokotović, "Nonlinear and adaptive control design", 1995, ch. 3–4.
"""

from __future__ import annotations

from typing import NamedTuple, Self

import jax.numpy as jnp
from pydantic import model_validator

from rvjax.campaign import Model, Quantity, scalar
from rvjax.campaign.plain_values import exact
from rvjax.campaign.problems import Problem, refuse
from rvjax.physics.dynamics import Relative, measured_relative
from rvjax.physics.state import Measurement, Numbers
from rvjax.physics.vectors import (
    Channels,
    Scalar,
    Symmetric,
    Vector,
    apply,
    cross,
    dot,
    each,
    largest,
    mrp_rate,
    symmetric_gradient,
)


class GuidanceGains(Model):
    """Gains of the virtual velocity."""

    k1: Quantity = scalar("1/s", default=0.1, above=0.0, doc="position gain k₁")
    v_max_m_s: Quantity = scalar("m/s", default=0.6, above=0.0, doc="largest virtual approach speed (shaped law)")
    k_sigma: Quantity = scalar("rad/s", default=0.4, above=0.0, doc="attitude gain k_σ per unit of MRP")


class TrackingGains(GuidanceGains):
    """Gains of the virtual velocity and of the feedback of z₂."""

    k2_force: Quantity = scalar("N·s/m", default=40.0, follows="mass", above=0.0, doc="velocity gain K₂ of the force channels")
    k2_torque: Quantity = scalar("N·m·s", default=15.0, follows="inertia", above=0.0, doc="rate gain K₂ of the torque channels")


class FirstErrorGains(Model):
    """Gains of the virtual velocity in the virtual wrench."""

    c_force: Quantity = scalar("N·s/m", default=0.0, follows="mass", at_least=0.0, doc="first-error gain C of the force channels")
    c_torque: Quantity = scalar(
        "N·m·s", default=0.0, follows="inertia", at_least=0.0, doc="first-error gain C of the torque channels"
    )


class NominalGains(Model):
    """The nominal plant of a controller."""

    mass_guess_kg: Quantity = scalar("kg", default=100.0, follows="mass", above=0.0, doc="nominal mass m₀")
    inertia_guess_kgm2: Quantity = scalar(
        "kg·m²", default=21.7, follows="inertia", above=0.0, doc="nominal inertia J₀ = this · I"
    )


class RobustGains(Model):
    """Gains of the robust term D̂ ∘ z/√(z² + ε²), where D̂ is the adaptive bound of all unknown disturbances."""

    gamma_bound: Quantity = scalar(
        "N/m, N·m", default=6.0, follows="mass", at_least=0.0, doc="rate γ_D of the disturbance bounds D̂"
    )
    bound_share: Quantity = scalar("1", default=0.5, at_least=0.0, doc="ceiling of D̂ as a share of the mean limit")
    leak_bound: Quantity = scalar("1/s", default=0.0, at_least=0.0, doc="leak λ_D of the disturbance bounds D̂")
    epsilon_force: Quantity = scalar("m/s", default=1e-3, above=0.0, doc="width ε of the force channels")
    epsilon_torque: Quantity = scalar("rad/s", default=5e-4, above=0.0, doc="width ε of the torque channels")


class AdaptationGains(Model):
    """Start, rates and bounds of the estimates m̂ and Ĵ."""

    gamma_mass: Quantity = scalar("kg·s²/m²", default=200.0, follows="mass", at_least=0.0, doc="rate Γ of the mass estimate")
    gamma_inertia: Quantity = scalar(
        "kg·m²·s²", default=200.0, follows="inertia", at_least=0.0, doc="rate Γ of the inertia estimate"
    )
    mass_guess_kg: Quantity = scalar("kg", default=70.0, follows="mass", above=0.0, doc="m̂(0)")
    mass_min_kg: Quantity = scalar("kg", default=20.0, follows="mass", above=0.0, doc="lower bound of m̂")
    mass_max_kg: Quantity = scalar("kg", default=300.0, follows="mass", above=0.0, doc="upper bound of m̂")
    inertia_guess_kgm2: Quantity = scalar("kg·m²", default=15.0, follows="inertia", above=0.0, doc="Ĵ(0) = this · I")
    moment_min_kgm2: Quantity = scalar("kg·m²", default=3.0, follows="inertia", above=0.0, doc="lower bound of the diagonal of Ĵ")
    moment_max_kgm2: Quantity = scalar(
        "kg·m²", default=60.0, follows="inertia", above=0.0, doc="upper bound of the diagonal of Ĵ"
    )
    product_max_kgm2: Quantity = scalar(
        "kg·m²", default=5.0, follows="inertia", at_least=0.0, doc="bound of the off-diagonal entries of Ĵ"
    )

    @model_validator(mode="after")
    def _start_inside(self) -> Self:
        """Projection keeps an estimate between its bounds only if it starts there."""
        checks = (
            _outside("mass", "mass_guess_kg", self.mass_min_kg, self.mass_guess_kg, self.mass_max_kg),
            _outside("inertia", "inertia_guess_kgm2", self.moment_min_kgm2, self.inertia_guess_kgm2, self.moment_max_kgm2),
        )
        if problems := [problem for problem in checks if problem]:
            refuse(*problems)
        return self


def _outside(what: str, key: str, low: Quantity, start: Quantity, high: Quantity) -> Problem | None:
    ((_, floor),), ((least, most),), ((ceiling, _),) = low.supports, start.supports, high.supports
    if floor <= least and most <= ceiling:
        return None
    return Problem(
        f"the estimated {what} starts outside its bounds",
        f"accepted: from {exact(floor)} to {exact(ceiling)} in every draw",
        (key,),
    )


class Tracking(NamedTuple):
    """alpha1: α₁, z2: z₂ [m/s, rad/s]; accel: a_ν [m/s²]; turn: a_ω [rad/s²]; omega: Ω [rad/s]."""

    alpha1: Channels
    z2: Channels
    accel: Vector
    turn: Vector
    omega: Vector


def tracking(shaped: bool, measurement: Measurement, gains: Numbers) -> Tracking:
    """z₂ and the known factors of Y. Gains used: k1, k_sigma, v_max_m_s (shaped only)."""
    known = measured_relative(measurement)
    return following(measurement, known, *virtual_velocity(shaped, measurement, known, gains))


def following(measurement: Measurement, known: Relative, alpha1: Channels, alpha1_rate: Channels) -> Tracking:
    """`tracking` for a given virtual velocity and its rate. For zero, z₂ is (ν, ω) and M ż₂ = Yθ + u + d."""
    return Tracking(
        alpha1=alpha1,
        z2=Channels(measurement.motion.nu, measurement.motion.omega) - alpha1,
        accel=known.accel - cross(known.omega_p, measurement.motion.nu) - alpha1_rate.force,
        turn=known.alpha - alpha1_rate.torque,
        omega=known.omega_p,
    )


def virtual_velocity(shaped: bool, measurement: Measurement, known: Relative, gains: Numbers) -> tuple[Channels, Channels]:
    """((α_ν, α_ω), their rates), with ρ̇ = ν − Ω×ρ and σ̇ = G(σ)ω."""
    rho, sigma = measurement.motion.rho, measurement.motion.sigma
    rho_rate = measurement.motion.nu - cross(known.omega_p, rho)
    alpha, rate = rho * -gains.k1, rho_rate * -gains.k1
    if shaped:
        slope = (gains.k1 / gains.v_max_m_s) ** 2
        stretch = 1.0 + slope * dot(rho, rho)
        inverse = 1.0 / jnp.sqrt(stretch)
        alpha = alpha * inverse
        rate = rate * inverse - alpha * (slope * dot(rho, rho_rate) * (inverse * inverse))
    turn = mrp_rate(sigma, measurement.motion.omega)
    return Channels(alpha, sigma * -gains.k_sigma), Channels(rate, turn * -gains.k_sigma)


def model(now: Tracking, mass: Scalar, inertia: Symmetric) -> Channels:
    """Yθ = (m a_ν, J a_ω − Ω×JΩ) [N, N·m]."""
    return Channels(now.accel * mass, apply(inertia, now.turn) - cross(now.omega, apply(inertia, now.omega)))


def gradient(now: Tracking, z: Channels) -> tuple[Scalar, Symmetric]:
    """Yᵀz = (a_νᵀz_ν, ∂(z_ωᵀJa_ω + (Ω×z_ω)ᵀJΩ)/∂J), since −z_ωᵀ(Ω×JΩ) = (Ω×z_ω)ᵀJΩ."""
    swing = symmetric_gradient(cross(now.omega, z.torque), now.omega)
    return dot(now.accel, z.force), symmetric_gradient(z.torque, now.turn) + swing


def adaptation(now: Tracking, z: Channels, mass: Scalar, inertia: Symmetric, gains: Numbers) -> tuple[Scalar, Symmetric]:
    """The rates of (m̂, Ĵ): θ̂̇ = Γ Yᵀz, projected into bounds. Gains used: gamma_… and the bounds …_min_…, …_max_…."""
    mass_rate, inertia_rate = gradient(now, z)
    product = gains.product_max_kgm2
    low, high = Symmetric.of(gains.moment_min_kgm2, -product), Symmetric.of(gains.moment_max_kgm2, product)
    return (
        project(mass, gains.gamma_mass * mass_rate, gains.mass_min_kg, gains.mass_max_kg),
        each(project, inertia, inertia_rate * gains.gamma_inertia, low, high),
    )


def feedback(z: Channels, gains: Numbers) -> Channels:
    """K₂ z [N, N·m]. Gains used: k2_force, k2_torque."""
    return Channels.pair(gains.k2_force, gains.k2_torque) * z


def first_error(now: Tracking, gains: Numbers) -> Channels:
    """−Cα₁ [N, N·m]. Gains used: c_force, c_torque."""
    return -Channels.pair(gains.c_force, gains.c_torque) * now.alpha1


def certainty_equivalence(now: Tracking, mass: Scalar, inertia: Symmetric, gains: Numbers) -> Channels:
    """−(Yθ + K₂z₂ − Cα₁) with the assumed or estimated θ [N, N·m]."""
    return -(model(now, mass, inertia) + (feedback(now.z2, gains) + first_error(now, gains)))


def nominal(gains: Numbers) -> tuple[Scalar, Symmetric]:
    """(m₀, J₀ I). Gains used: mass_guess_kg, inertia_guess_kgm2."""
    moment = gains.inertia_guess_kgm2
    return gains.mass_guess_kg, Symmetric.of(moment, moment * 0.0)


def direction(z: Channels, width: Channels) -> Channels:
    """z/√(z² + ε²), a smooth sign of z; width: ε."""
    return each(lambda a, e: a / jnp.sqrt(a * a + e * e), z, width)


def bound_rate(growth: Channels, bound: Channels, limit: Channels, gains: Numbers) -> Channels:
    """The rate of D̂: γ_D times the growth z²/√(z² + ε²), less λ_D D̂, projected into [0, share · limit]. Gains used:
    gamma_bound, leak_bound, bound_share."""
    return each(project, bound, growth * gains.gamma_bound - bound * gains.leak_bound, 0.0, limit * gains.bound_share)


def mean_limit(measurement: Measurement) -> Channels:
    """u = (u⁺ + u⁻)/2 of the nominal limits [N, N·m]."""
    return (measurement.upper + measurement.lower) * 0.5


def drift(mass: Scalar, inertia: Symmetric, gains: Numbers) -> Scalar:
    """Largest change of (m̂, Ĵ) from its start (m₀, J₀ I), relative to m₀ and J₀."""
    start = gains.inertia_guess_kgm2
    away = each(jnp.abs, (inertia - Symmetric.of(start, 0.0)) * (1.0 / start))
    return jnp.maximum(jnp.abs(mass * (1.0 / gains.mass_guess_kg) - 1.0), largest(away))


def project(x: Scalar, rate: Scalar, low: Scalar, high: Scalar) -> Scalar:
    """The rate, or 0 where it would carry x out of [low, high]."""
    outward = ((x >= high) & (rate > 0)) | ((x <= low) & (rate < 0))
    return jnp.where(outward, 0.0, rate)
