"""Adaptive saturated fault-tolerant controller: augmented system, Nussbaum gains, robust differentiator.

    1  virtual velocity   (α_ν, α_ω), z₂ and the model Yθ of `rvjax.physics.backstepping`
    2  virtual wrench     α₂ = −[Ŷθ + K₂z₂ + D̂ ∘ z₂/√(z₂²+ε²)], clipped to 0.95 of the nominal limits when shaped
       adaptation         θ̂̇ = Γ Yᵀz₂,  D̂̇ = γ_D z₂²/√(z₂²+ε²) − λ_D D̂,  projected, frozen on clipped channels
       direction          α₂ times N(η) before the clip with `direction: unknown` (`rvjax.physics.control_direction`)
    3  augmented system   v̇ = −κv + w,  z₃ = h(v) − α₂,  w̄ = −K₃z₃ + κ h'(v) v + α̂̇₂,  w = N(χ) w̄
       Nussbaum           χ̇ = γ_χ (z₃/u)(w̄/u) − λ_χ χ  (`rvjax.physics.augmented_system`); `modification: none`: λ_χ = 0
    4  differentiator     α̂̇₂ from α₂ (`rvjax.physics.differentiators`)

ε(t) = ε, or ε e^{−at} with `epsilon: decaying`. u: mean of the nominal limits. The leaks λ are the σ-modification of P. Ioannou,
J. Sun, "Robust adaptive control", 1996, ch. 8: all signals stay bounded, but errors no longer converge to zero.

The smooth asymmetric saturation, the augmented system, the Nussbaum matrix and the Levant differentiator are from K. Xia, W. Huo,
ISA Transactions, 2018; the formulas here are reconstructions that agree with it. The controller knows the commanded wrench h(v)
and its slope, but not mass, inertia, faults or disturbances. Limits of the theory: docs/model.md.
"""

from __future__ import annotations

from functools import partial
from typing import Any, Literal, NamedTuple

import jax
import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, flag, option, part, scalar
from rvjax.columns import Column
from rvjax.components.controllers.interface import ESTIMATES, WRENCH, Controller, Response, Saturate
from rvjax.components.registry import Component
from rvjax.physics import augmented_system, control_direction
from rvjax.physics.augmented_system import AugmentedGains, Wanted
from rvjax.physics.backstepping import (
    AdaptationGains,
    RobustGains,
    TrackingGains,
    adaptation,
    bound_rate,
    direction,
    drift,
    feedback,
    mean_limit,
    model,
    nominal,
    tracking,
)
from rvjax.physics.control_direction import Direction, DirectionGains
from rvjax.physics.differentiators import DIFFERENTIATORS
from rvjax.physics.elementary import exp
from rvjax.physics.state import Measurement, Numbers, Report
from rvjax.physics.vectors import Channels, Scalar, Symmetric, each, split


class Gains(AugmentedGains, DirectionGains, RobustGains, TrackingGains, AdaptationGains):
    """Gains of the controller. Adaptation rates have the units that follow from the equations."""

    epsilon_decay: Quantity = scalar("1/s", default=0.01, above=0.0, doc="decay rate a of ε(t) = ε e^{−at} if decaying")
    levant_share: Quantity = scalar("1/s²", default=0.05, above=0.0, doc="Levant's L as a share of the mean limit")
    filter_rad_s: Quantity = scalar("rad/s", default=5.0, above=0.0, doc="bandwidth of the filtered derivative")
    clip_share: Quantity = scalar("1", default=0.95, above=0.0, at_most=1.0, doc="clip of α₂ as a share of the nominal limits")


class Parameters(Model):
    """Parts of the controller and gains."""

    shaped: bool = flag(default=True, doc="keep virtual velocity and wrench inside the limits (false: textbook backstepping)")
    nussbaum: Literal["exp-cos", "quadratic-cos", "none"] = option(default="exp-cos", doc="Nussbaum gain N(χ)")
    modification: Literal["leakage", "none"] = option(default="leakage", doc="of the rate of χ (none: textbook form)")
    direction: Literal["known", "unknown"] = option(default="known", doc="direction of the channels: unknown adds the gain N(η)")
    derivative: Literal["levant", "filtered", "none"] = option(default="levant", doc="differentiator of the virtual wrench")
    epsilon: Literal["constant", "decaying"] = option(default="constant", doc="width ε of the robust term over time")
    adapt_parameters: bool = flag(default=True, doc="adapt m̂ and Ĵ")
    adapt_bound: bool = flag(default=True, doc="adapt the disturbance bounds D̂")
    gains: Gains = part(default={}, doc="gains")


class Control(NamedTuple):
    """v [N, N·m], χ, m̂ [kg], Ĵ [kg·m²], D̂ [N, N·m], ζ₀ and ζ₁ of the differentiator; direction: of an unknown one."""

    v: Channels
    chi: Channels
    mass: Scalar
    inertia: Symmetric
    bound: Channels
    zeta0: Channels
    zeta1: Channels
    direction: Direction | tuple[()] = ()


def start(options: Parameters, measurement: Measurement, gains: Numbers) -> Control:
    """v = χ = D̂ = ζ₁ = η = 0, m̂ and Ĵ = Ĵ₀ I from the gains, ζ₀ = α₂(0)."""
    zero = measurement.upper * 0.0
    state = Control(zero, zero, *nominal(gains), zero, zero, zero)
    if options.direction == "unknown":
        state = state._replace(direction=control_direction.start(tracking(options.shaped, measurement, gains).z2, gains))
    return state._replace(zeta0=virtual_wrench(options, measurement, state, gains)[0])


def virtual_wrench(options: Parameters, measurement: Measurement, state: Control, gains: Numbers) -> tuple[Channels, Control]:
    """α₂, and the rates of m̂, Ĵ, D̂ and the direction (the other rates zero)."""
    now = tracking(options.shaped, measurement, gains)
    fade = exp(-gains.epsilon_decay * measurement.t) if options.epsilon == "decaying" else 1.0
    width = Channels.pair(gains.epsilon_force, gains.epsilon_torque) * fade
    smooth_sign = direction(now.z2, width)
    raw = -(model(now, state.mass, state.inertia) + (feedback(now.z2, gains) + state.bound * smooth_sign))
    rates = jax.tree.map(lambda x: x * 0.0, state)
    if isinstance(state.direction, Direction):
        rates = rates._replace(direction=control_direction.rate(state.direction, now.z2, raw, mean_limit(measurement), gains))
        raw = raw * each(control_direction.gain, state.direction.eta)
    alpha2, free = raw, now.z2
    if options.shaped:
        alpha2 = each(jnp.clip, raw, measurement.lower * -gains.clip_share, measurement.upper * gains.clip_share)
        free = each(lambda z, a, b: jnp.where(a == b, z, 0.0), now.z2, raw, alpha2)

    if options.adapt_parameters:
        mass_rate, inertia_rate = adaptation(now, free, state.mass, state.inertia, gains)
        rates = rates._replace(mass=mass_rate, inertia=inertia_rate)
    if options.adapt_bound:
        rates = rates._replace(bound=bound_rate(free * smooth_sign, state.bound, mean_limit(measurement), gains))
    return alpha2, rates


def respond(options: Parameters, measurement: Measurement, state: Control, saturate: Saturate, gains: Numbers) -> Response:
    """v, and the rate of (v, χ, θ̂, D̂, ζ, η)."""
    alpha2, rates = virtual_wrench(options, measurement, state, gains)
    limit = mean_limit(measurement)
    differentiator, bound = DIFFERENTIATORS[options.derivative], limit * gains.levant_share
    derivative, zeta0, zeta1 = split(differentiator, alpha2, state.zeta0, state.zeta1, bound, gains.filter_rad_s)
    wanted, leaks = Wanted(alpha2, derivative, limit), options.modification == "leakage"
    v, chi = augmented_system.rates(options.nussbaum, leaks, state.v, state.chi, *saturate(state.v), wanted, gains)
    rate = rates._replace(v=v, chi=chi, zeta0=zeta0, zeta1=zeta1)
    signals: dict[str, Any] = {"alpha2": alpha2, "bound": state.bound, "mass_kg": state.mass, "inertia_kgm2": state.inertia}
    signals |= {"eta": state.direction.eta} if isinstance(state.direction, Direction) else {}
    return Response(state.v, rate, Report(state.chi, drift(state.mass, state.inertia, gains), signals))


SIGNALS = {
    "alpha2": Column("alpha2", WRENCH, "virtual wrench"),
    "bound": Column("bound", WRENCH, "estimated bound of the disturbance"),
    **ESTIMATES,
}


def build(parameters: Parameters) -> Controller:
    """The controller with these options."""
    signals = SIGNALS if parameters.direction == "known" else {**SIGNALS, **control_direction.SIGNALS}
    return Controller(partial(start, parameters), partial(respond, parameters), signals)


COMPONENT = Component(Parameters, build)
