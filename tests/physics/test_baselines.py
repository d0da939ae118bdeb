"""Controllers: what holds for every member of the family, and what the theory of each baseline says of it."""

from __future__ import annotations

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from pydantic import ValidationError

from rvjax.components.controllers import anti_windup, command_filtered, disturbance_observer, nominal_backstepping, sliding_mode
from rvjax.components.controllers.interface import DiscreteController
from rvjax.components.registry import component, members
from rvjax.physics import backstepping
from rvjax.physics.dynamics import relative
from rvjax.physics.saturation import saturate
from rvjax.physics.state import Numbers, State
from rvjax.physics.vectors import Channels, Symmetric, Vector, dot, each, mrp_rate
from rvjax.simulation import closed_loop, rk4
from tests import flights
from tests.flights import SATURATIONS

PUSH = Channels.of((0.05, -0.08, 0.06, 0.01, -0.02, 0.015))
"""A constant unknown wrench [N, N·m]."""


SOFT = {"k1": 0.06, "k_sigma": 0.25, "k2_force": 40.0, "k2_torque": 15.0, "c_force": 7.0, "c_torque": 3.0}
"""Gains with which what the tests call near is far from every limit, whatever the defaults are."""


def scene(name: str, known: bool = True, **gains: float) -> Any:
    """One sample. known: the plant is the nominal one of the gains, its limits the nominal ones. gains: others than `SOFT`."""
    defaults = flights.gains(name)
    soft = {gain: value for gain, value in SOFT.items() if gain in defaults and name != "pd-plus"}
    one = flights.lane(flights.draw(defaults | soft | gains, 300.0, 0.05), 0)
    if known:
        mass, inertia = backstepping.nominal(one.gains)
        inverse = Symmetric.of(1.0 / one.gains.inertia_guess_kgm2, 0.0)
        plant = one.plant._replace(mass=mass, inertia=inertia, inertia_inverse=inverse, upper=one.upper, lower=one.lower)
        one = one._replace(plant=plant)
    return jax.tree.map(jnp.asarray, one)


def look(one: Any, motion: Any = None) -> Any:
    """What the controller sees."""
    alpha_t = closed_loop.alpha(one.target, one.plant)
    return closed_loop.measurement(jnp.asarray(0.0), one.motion if motion is None else motion, one.target, alpha_t, one)


def actuators(one: Any, saturation: str = "hard-clip") -> Any:
    return partial(saturate, SATURATIONS[saturation], upper=one.plant.upper, lower=one.plant.lower)


def rates(one: Any, control: Any, law: Any, push: Channels = PUSH * 0.0, saturation: str = "hard-clip") -> tuple[Any, Any]:
    """(motion, target, control)˙ of the closed loop under a constant wrench, and the controller's response."""
    measurement = look(one)
    response = law.respond(measurement, control, actuators(one, saturation), one.gains)
    wrench = actuators(one, saturation)(response.command)[0] + push
    motion = closed_loop.motion_rate(
        one.motion, relative(one.motion, one.target, measurement.alpha_t, measurement.port), one.plant, wrench
    )
    return (motion, closed_loop.target_rate(one.target, measurement.alpha_t), response.rate), response


def slope(function: Any, one: Any, control: Any, rate: Any) -> Any:
    """d/dt of function(sample with the motion and target of that time, control) along a rate."""
    _, found = jax.jvp(lambda m, t, c: function(one._replace(motion=m, target=t), c), (one.motion, one.target, control), rate)
    return found


def product(a: Channels, b: Channels) -> Any:
    return dot(a.force, b.force) + dot(a.torque, b.torque)


def near(one: Any) -> Any:
    """A sample so close to its goal that no command of it is near a limit."""
    motion = one.motion
    return one._replace(motion=motion._replace(rho=motion.rho * 0.02, nu=motion.nu * 0.02, sigma=motion.sigma * 0.05))


def far(one: Any) -> Any:
    """A sample so fast that some commands of it are beyond their limits."""
    return one._replace(motion=one.motion._replace(nu=one.motion.nu * 8.0, omega=one.motion.omega * 10.0))


def kinetic(one: Any, z: Channels) -> Any:
    """½zᵀMz."""
    now = backstepping.tracking(True, look(one), one.gains)
    weighted = backstepping.model(
        now._replace(accel=z.force, turn=z.torque, omega=z.torque * 0.0), one.plant.mass, one.plant.inertia
    )
    return 0.5 * product(z, weighted)


def potential(one: Any) -> Any:
    """V₁ = C_f (v_max²/k₁)(√(1+(k₁|ρ|/v_max)²) − 1) + 2C_τ k_σ ln(1+σᵀσ)."""
    return bowl(one.motion.rho, one.gains) + 2.0 * one.gains.c_torque * one.gains.k_sigma * jnp.log1p(
        dot(one.motion.sigma, one.motion.sigma)
    )


def bowl(rho: Vector, gains: Any) -> Any:
    stretch = jnp.sqrt(1.0 + (gains.k1 / gains.v_max_m_s) ** 2 * dot(rho, rho))
    return gains.c_force * gains.v_max_m_s**2 / gains.k1 * (stretch - 1.0)


def doubt(one: Any, control: Any) -> Any:
    """½θ̃ᵀΓ⁻¹θ̃."""
    gap = control.inertia - one.plant.inertia
    squares = sum(x * x for x in gap.parts())
    return 0.5 * (control.mass - one.plant.mass) ** 2 / one.gains.gamma_mass + 0.5 * squares / one.gains.gamma_inertia


def first(one: Any) -> Channels:
    """C."""
    return Channels.pair(one.gains.c_force, one.gains.c_torque)


def damped(z: Channels, gains: Any) -> Any:
    """zᵀK₂z."""
    return product(z, Channels.pair(gains.k2_force, gains.k2_torque) * z)


WRONG = Symmetric(12.0, 18.0, 15.0, 1.0, -0.5, 0.7)
"""An estimate of the inertia that is not the plant's."""


@pytest.mark.parametrize("name", members("controllers"))
def test_what_a_controller_gives(name: str) -> None:
    """Finite, of the kind and in the type of what it was given, also at the goal itself; signals as declared, the same again.

    Kills: a float64 constant in float32, a rate that is no rate of the state, 0/0 at zero error, a signal without its unit.
    """
    law = component("controllers", name).build(component("controllers", name).parameters())
    for kind in (jnp.float32, jnp.float64):
        one = jax.tree.map(lambda x, kind=kind: jnp.asarray(x, kind), scene(name, known=False))
        goal = one._replace(motion=jax.tree.map(jnp.zeros_like, one.motion))
        for here in (one, goal):
            measurement = look(here)._replace(t=jnp.asarray(0.0, kind))
            control = jax.tree.map(lambda x, kind=kind: jnp.asarray(x, kind), law.start(measurement, here.gains))
            answer = law.update if isinstance(law, DiscreteController) else law.respond
            response = answer(measurement, control, actuators(here, "smooth-tanh"), here.gains)
            command, rate, report = response
            assert jax.tree.structure(rate) == jax.tree.structure(control)
            assert isinstance(command, Channels)
            assert isinstance(report.chi, Channels)
            assert report.signals.keys() == law.signals.keys()
            for x in jax.tree.leaves(response):
                assert jnp.asarray(x).dtype == kind
                assert np.all(np.isfinite(x))
            assert all(jnp.shape(x) == () for x in jax.tree.leaves((command, report)))
            again = answer(measurement, control, actuators(here, "smooth-tanh"), here.gains)
            jax.tree.map(np.testing.assert_array_equal, response, again)


@pytest.mark.parametrize("share", [0.5, -0.2, 3.0, -7.0])
def test_the_sliding_variable_falls_to_its_boundary_layer(share: float) -> None:
    """M₀ṡ = d − M₀K sat(s/φ), so that |s| = φ|d|/(M₀K) is where it rests under a constant d. s by the flown motion, ṡ by jax.jvp.

    Kills: a sign of the switching term, φ that multiplies, an unbounded term, a missing feed-forward.
    """
    one = scene("sliding-mode")
    one = one._replace(plant=one.plant._replace(upper=one.plant.upper * 1e3, lower=one.plant.lower * 1e3))
    law = sliding_mode.build(sliding_mode.Parameters())
    width = Channels.pair(one.gains.phi_force, one.gains.phi_torque)
    inertia = Channels.pair(one.plant.mass, one.gains.inertia_guess_kgm2)
    force = Channels.pair(one.gains.k_force, one.gains.k_torque) * inertia

    def sliding(sample: Any, control: Any = ()) -> Channels:
        return backstepping.tracking(True, look(sample), sample.gains).z2

    def at(s: Channels) -> Any:
        gap = s - sliding(one)
        return one._replace(motion=one.motion._replace(nu=one.motion.nu + gap.force, omega=one.motion.omega + gap.torque))

    placed = at(width * share)
    rate, response = rates(placed, (), law, PUSH, "hard-clip")
    np.testing.assert_allclose(response.report.signals["depth"].parts(), [share] * 6, rtol=1e-9)
    found = slope(sliding, placed, (), rate) * inertia
    np.testing.assert_allclose(found.parts(), (PUSH - force * float(np.clip(share, -1, 1))).parts(), rtol=1e-9, atol=1e-12)
    rest = at(width * PUSH / force)
    still = slope(sliding, rest, (), rates(rest, (), law, PUSH, "hard-clip")[0]) * inertia
    np.testing.assert_allclose(still.parts(), [0.0] * 6, atol=1e-12)


def test_nominal_backstepping_falls_as_its_proof_says() -> None:
    """V̇ = −α₁ᵀCα₁ − z₂ᵀK₂z₂ inside the limits, for a plant that it does not know; V = V₁ + ½z₂ᵀMz₂ + ½θ̃ᵀΓ⁻¹θ̃.

    Kills: a sign or a missing term of the law, of Yᵀ, of the adaptation, of the first error's term.
    """
    one = near(scene("nominal-backstepping", known=False))
    law = nominal_backstepping.build(nominal_backstepping.Parameters())
    control = nominal_backstepping.Control(jnp.asarray(88.0), jax.tree.map(jnp.asarray, WRONG))

    def energy(sample: Any, own: Any) -> Any:
        z2 = backstepping.tracking(True, look(sample), sample.gains).z2
        return potential(sample) + kinetic(sample, z2) + doubt(sample, own)

    now = backstepping.tracking(True, look(one), one.gains)
    squared = product(now.alpha1, first(one) * now.alpha1)
    rate, _ = rates(one, control, law)
    assert float(slope(energy, one, control, rate)) == pytest.approx(-float(squared + damped(now.z2, one.gains)), rel=1e-9)


def test_nominal_backstepping_stays_inside_the_nominal_limits_and_winds_up() -> None:
    """Far out the command is the nominal limit of that side, and the estimates go on moving.

    Kills: no clip, swapped limits, the flown limits in the place of the nominal ones, a frozen adaptation.
    """
    one = far(scene("nominal-backstepping", known=False))
    law = nominal_backstepping.build(nominal_backstepping.Parameters())
    response = law.respond(look(one), law.start(look(one), one.gains), actuators(one), one.gains)
    command = np.array(response.command.parts())
    at_limit = np.where(command > 0, one.upper.parts(), -np.array(one.lower.parts()))
    assert (command == at_limit).all()
    assert all(float(x) != 0.0 for x in (response.rate.mass, *response.rate.inertia.parts()))


def test_anti_windup_takes_the_saturation_out_of_the_error() -> None:
    """V̇ = −α₁ᵀCα₁ − z̄ᵀK₂z̄ − α₁ᵀC M₀⁻¹ζ, deep in saturation as well.

    Kills: ζ with the other sign, an auxiliary system that is not fed back, no leak in the law, adaptation by z₂.
    """
    one = far(scene("anti-windup"))
    law = anti_windup.build(anti_windup.Parameters())
    zeta = Channels.of((3.0, -2.0, 1.5, 0.2, -0.1, 0.3))
    control = jax.tree.map(jnp.asarray, anti_windup.Control(jnp.asarray(88.0), WRONG, zeta))
    inertia = Channels.pair(one.plant.mass, one.gains.inertia_guess_kgm2)

    def error(sample: Any, own: Any) -> Channels:
        return backstepping.tracking(True, look(sample), sample.gains).z2 - own.zeta / inertia

    def energy(sample: Any, own: Any) -> Any:
        return potential(sample) + kinetic(sample, error(sample, own)) + doubt(sample, own)

    rate, response = rates(one, control, law, saturation="smooth-tanh")
    lost = actuators(one, "smooth-tanh")(response.command)[0] - response.command
    assert max(abs(float(x)) for x in lost.parts()) > 1.0
    alpha1 = backstepping.tracking(True, look(one), one.gains).alpha1
    pulled = product(first(one) * alpha1, alpha1 + control.zeta / inertia)
    expected = -(pulled + damped(error(one, control), one.gains))
    assert float(slope(energy, one, control, rate)) == pytest.approx(float(expected), rel=1e-9)


def test_anti_windup_rests_while_nothing_is_saturated() -> None:
    """ζ = 0 stays 0 inside the limits, and the law is the nominal one then; beyond them ζ̇ is what the saturation withholds.

    Kills: an auxiliary system that is fed by the command itself.
    """
    law = anti_windup.build(anti_windup.Parameters())
    one = near(scene("anti-windup", known=False))
    start = law.start(look(one), one.gains)
    response = law.respond(look(one), start, actuators(one), one.gains)
    assert not np.array(response.rate.zeta.parts()).any()
    plain = nominal_backstepping.respond(look(one), nominal_backstepping.Control(start.mass, start.inertia), None, one.gains)
    np.testing.assert_allclose(response.command.parts(), plain.command.parts(), rtol=1e-12)
    one = far(one)
    response = law.respond(look(one), start, actuators(one), one.gains)
    withheld = actuators(one)(response.command)[0] - response.command
    assert np.array(withheld.parts()).any()
    np.testing.assert_array_equal(response.rate.zeta.parts(), withheld.parts())


def test_command_filter_lags_a_ramp_by_its_time() -> None:
    """Behind a ramp of slope a the filter rests at the lag 2ζ/ω_n · a, with α̇_f = a; behind a step it starts with ω_n² times it.

    Kills: a missing 2, ω_n for ω_n² or the other way round, a filter that starts at zero.
    """
    one = scene("command-filtered", filter_rad_s=4.0, filter_damping=0.7)
    law = command_filtered.build(command_filtered.Parameters())
    control = law.start(look(one), one.gains)
    np.testing.assert_array_equal(control.filtered.parts(), virtual(one, control).parts())
    ramp = Channels.of((0.02, -0.01, 0.03, 1e-3, -2e-3, 5e-4))
    behind = control._replace(filtered=control.filtered - ramp * (2.0 * 0.7 / 4.0), filtered_rate=ramp)
    rate = law.respond(look(one), behind, actuators(one), one.gains).rate
    np.testing.assert_allclose(rate.filtered.parts(), ramp.parts(), rtol=1e-12)
    np.testing.assert_allclose(rate.filtered_rate.parts(), [0.0] * 6, atol=1e-15)
    ahead = control._replace(filtered=control.filtered - ramp, filtered_rate=ramp * 0.0)
    rate = law.respond(look(one), ahead, actuators(one), one.gains).rate
    np.testing.assert_allclose(rate.filtered_rate.parts(), (ramp * 16.0).parts(), rtol=1e-9)


def virtual(one: Any, control: Any) -> Channels:
    """α = A(z̄₁) + A(ξ₁)."""
    measurement = look(one)
    known = relative(one.motion, one.target, measurement.alpha_t, measurement.port)
    z1 = Channels(one.motion.rho, one.motion.sigma) - control.xi1
    return command_filtered.virtual(measurement, known, z1, one.gains) + command_filtered.virtual(
        measurement, known, control.xi1, one.gains
    )


def test_compensated_errors_know_of_neither_filter_nor_saturation() -> None:
    """V̇ = −C_f|A(z̄_ρ)|² − 4C_τk_σ² z̄_σᵀG z̄_σ − z̄₂ᵀK₂z̄₂ in saturation, wherever the filter is.

    Kills: a sign or a missing term of either compensating signal, G for Gᵀ, no Ω×ξ_ρ, adaptation by z₂, an α̇_f that is not used.
    """
    one = far(scene("command-filtered"))
    law = command_filtered.build(command_filtered.Parameters())
    spread = (0.3, -0.2, 0.25, 0.03, -0.02, 0.04)
    control = command_filtered.Control(
        jnp.asarray(88.0),
        WRONG,
        Channels.of(tuple(x / 3.0 for x in spread)),
        Channels.of(tuple(-x / 9.0 for x in spread)),
        Channels.of(tuple(-2.0 * x for x in reversed(spread))),
        Channels.of(tuple(x / 2.0 for x in spread)),
    )
    control = jax.tree.map(jnp.asarray, control)
    gains = one.gains

    def compensated(sample: Any, own: Any) -> tuple[Channels, Channels]:
        x2 = Channels(sample.motion.nu, sample.motion.omega)
        return Channels(sample.motion.rho, sample.motion.sigma) - own.xi1, x2 - own.filtered - own.xi2

    def energy(sample: Any, own: Any) -> Any:
        z1, z2 = compensated(sample, own)
        spring = 2.0 * gains.c_torque * gains.k_sigma * dot(z1.torque, z1.torque)
        return bowl(z1.force, gains) + spring + kinetic(sample, z2) + doubt(sample, own)

    rate, response = rates(one, control, law, saturation="smooth-tanh")
    lost = actuators(one, "smooth-tanh")(response.command)[0] - response.command
    assert max(abs(float(x)) for x in lost.parts()) > 1.0
    z1, z2 = compensated(one, control)
    pull = command_filtered.virtual(look(one), relative(one.motion, one.target, look(one).alpha_t, one.plant.port), z1, gains)
    turning = dot(z1.torque, mrp_rate(one.motion.sigma, z1.torque))
    expected = gains.c_force * dot(pull.force, pull.force) + 4.0 * gains.c_torque * gains.k_sigma**2 * turning
    assert float(slope(energy, one, control, rate)) == pytest.approx(-float(expected + damped(z2, gains)), rel=1e-9)


def test_a_filter_slower_than_its_loop_is_refused() -> None:
    """In words that say what is accepted. Kills: a comparison of the wrong ends of the ranges."""
    accepted = command_filtered.Gains.model_validate({"filter_rad_s": 0.07, "k1": {"uniform": [0.05, 0.06]}})
    assert accepted.filter_rad_s.is_fixed
    for said in ({"filter_rad_s": 0.055, "k1": {"uniform": [0.05, 0.06]}}, {"filter_rad_s": {"uniform": [0.01, 5.0]}}):
        with pytest.raises(ValidationError, match="not faster than the position loop"):
            command_filtered.Gains.model_validate(said)


def test_disturbance_observer_is_a_first_order_lag() -> None:
    """D̂̇ = L (D − D̂) with D = M₀ẋ₂ − Y₀θ₀ − h of a plant that is not the nominal one, in saturation; D̂(0) = 0.

    Kills: a sign of p, L that is missing somewhere, v in the place of h(v), a wrong feed-forward.
    """
    one = far(scene("disturbance-observer", known=False))
    law = disturbance_observer.build(disturbance_observer.Parameters())
    gains = one.gains
    inertia = Channels.pair(gains.mass_guess_kg, gains.inertia_guess_kgm2)
    speed = Channels.pair(gains.observer_force_rad_s, gains.observer_torque_rad_s)

    def estimate(sample: Any, own: Any) -> Channels:
        return own.p + disturbance_observer.momentum(disturbance_observer.free(look(sample)), gains)

    start = law.start(look(one), gains)
    np.testing.assert_allclose(estimate(one, start).parts(), [0.0] * 6, atol=1e-12)
    control = disturbance_observer.Control(start.p + PUSH * 3.0)
    rate, response = rates(one, control, law, PUSH, "smooth-tanh")
    np.testing.assert_allclose(response.report.signals["disturbance"].parts(), (PUSH * 3.0).parts(), rtol=1e-9)
    h = actuators(one, "smooth-tanh")(response.command)[0]
    known = backstepping.model(disturbance_observer.free(look(one)), *backstepping.nominal(gains))
    lumped = Channels(rate[0].nu, rate[0].omega) * inertia - known - h
    expected = speed * (lumped - PUSH * 3.0)
    np.testing.assert_allclose(slope(estimate, one, control, rate).parts(), expected.parts(), rtol=1e-9, atol=1e-12)


def test_a_constant_disturbance_is_found_at_the_observers_rate() -> None:
    """With the nominal plant under a constant wrench D, D − D̂ = D e^{−Lt}, and what is left of the velocity error goes with it.

    Flown: RK4 over the closed loop. Kills: an observer of another rate, a D̂ that is added where it should be taken away.
    """
    gains = {"observer_force_rad_s": 0.8, "observer_torque_rad_s": 1.5, "c_force": 0.0, "c_torque": 0.0}
    one = near(scene("disturbance-observer", **gains))
    member = component("controllers", "disturbance-observer")
    loop = flights.loop("disturbance-observer", "hard-clip")._replace(faults=())
    push = Numbers({"force_N": PUSH.force, "torque_Nm": PUSH.torque})
    none = jax.tree.map(jnp.zeros_like, one.disturbances[1])
    one = one._replace(faults=(), disturbances=(push, none))
    law, h, steps = member.build(member.parameters()), 0.05, 240
    y = State(one.motion, one.target, law.start(look(one), one.gains))
    held = closed_loop.start(loop, one)[1]

    def step(y: State, t: Any) -> tuple[State, Any]:
        rate, now, _ = closed_loop.evaluate(loop, one, t, y, held)
        after = rk4.step(lambda s, x: closed_loop.evaluate(loop, one, s, x, held)[0], t, y, h, rate)
        return after, now.report.signals["disturbance"]

    last, found = jax.jit(lambda y: jax.lax.scan(step, y, jnp.arange(steps) * h))(y)
    fall = np.exp(-np.outer([0.8] * 3 + [1.5] * 3, np.arange(steps) * h))
    expected = np.array(PUSH.parts())[:, None] * (1.0 - fall)
    np.testing.assert_allclose(np.array(found.parts()), expected, rtol=1e-5, atol=1e-9)
    z2 = backstepping.tracking(True, look(one._replace(motion=last.motion, target=last.target)), one.gains).z2
    assert max(abs(float(x)) for x in each(jnp.abs, z2).parts()) < 4e-4, "d/K₂ would be 2e-3"
