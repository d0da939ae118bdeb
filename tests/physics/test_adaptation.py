"""The controller's parts: Nussbaum gains, differentiators, regressor and gradient, projection, the Lyapunov-like identity."""

from __future__ import annotations

import math
from functools import partial
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rvjax.columns import CHANNELS
from rvjax.components.controllers import pd_plus, saturated_adaptive
from rvjax.physics import backstepping
from rvjax.physics.differentiators import DIFFERENTIATORS
from rvjax.physics.nussbaum import GAINS
from rvjax.physics.saturation import saturate
from rvjax.physics.state import Measurement, Numbers
from rvjax.physics.vectors import Channels, Symmetric, Vector, dot
from rvjax.simulation import closed_loop
from tests import flights
from tests.flights import SATURATIONS, Recorder

CHI = np.linspace(-4.0, 4.0, 33)


@pytest.mark.parametrize("name", GAINS)
def test_nussbaum_gains_are_even(name: str) -> None:
    """N(−χ) = N(χ)."""
    np.testing.assert_array_equal(GAINS[name](jnp.asarray(CHI)), GAINS[name](jnp.asarray(-CHI)))


def test_nussbaum_gains_by_definition() -> None:
    """e^{χ²}cos(πχ/2), χ²cosχ and 1; N(0) = 1, 0, 1; the mean over [0, χ] swings to both sides. Kills a sign."""
    np.testing.assert_allclose(
        GAINS["exp-cos"](jnp.asarray(CHI)), np.exp(CHI**2) * np.cos(np.pi * CHI / 2), rtol=1e-12, atol=1e-9
    )
    np.testing.assert_allclose(GAINS["quadratic-cos"](jnp.asarray(CHI)), CHI**2 * np.cos(CHI), rtol=1e-13, atol=1e-13)
    assert [float(GAINS[name](jnp.asarray(0.0))) for name in ("exp-cos", "quadratic-cos", "none")] == [1.0, 0.0, 1.0]
    grid = np.linspace(0.0, 12.0, 4001)
    mean = np.cumsum(GAINS["quadratic-cos"](jnp.asarray(grid)))[1:] * grid[1] / grid[1:]
    assert mean.min() < -5.0
    assert mean.max() > 5.0


@pytest.mark.parametrize(("name", "after_s", "allowed"), [("levant", 3.0, 5e-3), ("filtered", 3.0, 0.15)])
def test_differentiators_find_the_derivative(name: str, after_s: float, allowed: float) -> None:
    """α = 2 sin(0.6 t), |α̈| ≤ 0.72 < L = 1: Levant's is exact after a finite time, up to the step; the filter lags.

    Kills the signs of both of Levant's gains.
    """
    h, bound, omega = 1e-3, 1.0, 10.0
    law = DIFFERENTIATORS[name]

    def advance(state: tuple[Any, Any], k: Any) -> tuple[tuple[Any, Any], Any]:
        t = k * h
        estimate, rate0, rate1 = law(2.0 * jnp.sin(0.6 * t), *state, bound, omega)
        return (state[0] + h * rate0, state[1] + h * rate1), estimate - 1.2 * jnp.cos(0.6 * t)

    _, error = jax.lax.scan(advance, (jnp.asarray(0.0), jnp.asarray(0.0)), jnp.arange(20_000))
    assert abs(float(error[0])) > 1.0, "it starts wrong"
    assert float(jnp.abs(error[round(after_s / h) :]).max()) <= allowed


@pytest.fixture(scope="module")
def one() -> Any:
    """One sample of the scene."""
    return flights.lane(flights.draw(flights.gains("saturated-adaptive") | flights.GENTLE, 300.0, 0.05), 0)


def measurement(one: Any) -> Measurement:
    plant = one.plant
    alpha_t = closed_loop.target_alpha(one.target.w, plant.target_inertia, plant.target_inertia_inverse)
    return closed_loop.measurement(jnp.asarray(0.0), one.motion, one.target, alpha_t, one)


@pytest.mark.parametrize("shaped", [True, False])
def test_the_plant_is_linear_in_its_parameters(one: Any, shaped: bool) -> None:
    """M ż₂ = Yθ + u along the motion, with the true θ; kills a sign or a missing term in Yθ, α₁ or α̇₁.

    ż₂ is the derivative of z₂(motion) along the plant's own rate, by jax.jvp.
    """
    wrench = Channels.of((1.0, -2.0, 1.5, 0.2, -0.3, 0.4))
    now = measurement(one)
    known = closed_loop.relative(one.motion, one.target, now.alpha_t, one.plant.port)
    rates = (
        closed_loop.motion_rate(one.motion, known, one.plant, wrench),
        closed_loop.target_rate(one.target, now.alpha_t),
    )

    def z2(motion: Any, target: Any) -> Channels:
        return backstepping.tracking(shaped, now._replace(motion=motion, target=target), one.gains).z2

    _, z2_rate = jax.jvp(z2, (one.motion, one.target), rates)
    model = backstepping.model(backstepping.tracking(shaped, now, one.gains), one.plant.mass, one.plant.inertia) + wrench
    inertia = np.array(flights.matrix(one.plant.inertia))
    np.testing.assert_allclose(z2_rate.force.parts(), [x / one.plant.mass for x in model.force.parts()], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(
        z2_rate.torque.parts(), np.linalg.solve(inertia, np.array(model.torque.parts())), rtol=1e-9, atol=1e-12
    )


def test_gradient_of_the_model(one: Any) -> None:
    """Yᵀz = ∂(zᵀYθ)/∂θ for the seven parameters, against jax.grad; kills a sign in the gradient of −Ω×JΩ."""
    now = backstepping.tracking(True, measurement(one), one.gains)
    z = Channels.of((0.3, -0.2, 0.5, 0.02, -0.04, 0.03))

    def power(mass: Any, inertia: Symmetric) -> Any:
        model = backstepping.model(now, mass, inertia)
        return dot(z.force, model.force) + dot(z.torque, model.torque)

    expected = jax.grad(power, argnums=(0, 1))(jnp.asarray(70.0), jax.tree.map(jnp.asarray, one.plant.inertia))
    for a, b in zip(jax.tree.leaves(backstepping.gradient(now, z)), jax.tree.leaves(expected), strict=True):
        assert float(a) == pytest.approx(float(b), rel=1e-12, abs=1e-15)


def test_projection_stops_at_the_bounds_only() -> None:
    """The rate passes inside the bounds and inwards at them; kills a swapped side."""
    for x, rate, kept in (
        (0.5, 1.0, 1.0),
        (1.0, 1.0, 0.0),
        (1.0, -1.0, -1.0),
        (0.0, -1.0, 0.0),
        (0.0, 1.0, 1.0),
        (1.1, 2.0, 0.0),
    ):
        assert float(backstepping.project(jnp.asarray(x), jnp.asarray(rate), 0.0, 1.0)) == kept


def respond(one: Any, state: Any, **options: Any) -> Any:
    parameters = saturated_adaptive.Parameters(**options)
    actuators = partial(saturate, SATURATIONS["smooth-tanh"], upper=one.plant.upper, lower=one.plant.lower)
    return saturated_adaptive.respond(parameters, measurement(one), state, actuators, one.gains), actuators


def busy(one: Any, **options: Any) -> Any:
    """A state of the controller in which nothing is zero."""
    state = saturated_adaptive.start(saturated_adaptive.Parameters(**options), measurement(one), one.gains)
    spread = [0.6, -1.1, 0.9, 0.15, -0.2, 0.12]
    return state._replace(
        v=Channels.of(tuple(spread)),
        chi=Channels.of(tuple(0.3 * x for x in spread)),
        bound=Channels.of(tuple(abs(x) / 5.0 for x in spread)),
        zeta0=state.zeta0 + Channels.of(tuple(0.01 * x for x in spread)),
        zeta1=Channels.of(tuple(0.02 * x for x in spread)),
    )


@pytest.mark.parametrize("modification", ["none", "leakage"])
@pytest.mark.parametrize("nussbaum", GAINS)
def test_lyapunov_like_identity(one: Any, nussbaum: str, modification: str) -> None:
    """z₃ż₃ = (u²/γ)(h' N χ̇ − χ̇) − K₃z₃² where ż₃ = h'v̇ − ν_L; kills the sign of K₃, of χ̇, of κ and of the derivative.

    This is the bracket of the paper's Lemma 1, scaled by the channel's limit u; with leakage it has χ̇ + λχ for χ̇. Kills: a leak
    of the wrong sign or in the textbook form. Without a Nussbaum gain χ stays, and z₃w̄ = z₃(v̇ + κv) takes the place of (u²/γ)χ̇.
    """
    options = {"nussbaum": nussbaum, "derivative": "filtered", "modification": modification}
    state = busy(one, **options)
    response, actuators = respond(one, state, **options)
    h, slope = actuators(state.v)
    z3 = h - response.report.signals["alpha2"]
    z3_rate = slope * response.rate.v - state.zeta1
    limit = (one.upper + one.lower) * 0.5
    leak = one.gains.leak_chi if modification == "leakage" and nussbaum != "none" else 0.0
    work = (response.rate.chi + state.chi * leak) * limit * limit / one.gains.gamma_chi
    if nussbaum == "none":
        assert not np.array(work.parts()).any()
        work = z3 * (response.rate.v + state.v * one.gains.kappa)
    gain = Channels.of(tuple(GAINS[nussbaum](jnp.asarray(x)) for x in state.chi.parts()))
    expected = slope * gain * work - work - z3 * z3 * one.gains.k3
    np.testing.assert_allclose((z3 * z3_rate).parts(), expected.parts(), rtol=1e-10, atol=1e-13)


def test_adaptation_follows_the_gradient(one: Any) -> None:
    """θ̂̇ = Γ Yᵀz₂ and D̂̇ = γ_D z₂²/√(z₂²+ε²): with them d/dt of ½z₂ᵀMz₂ loses its terms in θ̂. Kills a sign of adaptation.

    α₂ = −(Ŷθ + K₂z₂ + D̂∘z₂/√(z₂²+ε²)) by the same token.
    """
    response, _ = respond(one, state := busy(one), derivative="filtered")
    now = backstepping.tracking(True, measurement(one), one.gains)
    mass, inertia = backstepping.gradient(now, now.z2)
    assert float(response.rate.mass) == pytest.approx(float(one.gains.gamma_mass * mass), rel=1e-12)
    np.testing.assert_allclose(response.rate.inertia.parts(), (inertia * one.gains.gamma_inertia).parts(), rtol=1e-12)
    model = backstepping.model(now, state.mass, state.inertia)
    for i, channel in enumerate(CHANNELS):
        z, kind = float(now.z2.parts()[i]), "force" if channel.startswith("f") else "torque"
        reach = math.hypot(z, one.gains[f"epsilon_{kind}"])
        assert float(response.rate.bound.parts()[i]) == pytest.approx(one.gains.gamma_bound * z * z / reach, rel=1e-12)
        raw = -(model.parts()[i] + one.gains[f"k2_{kind}"] * z + state.bound.parts()[i] * z / reach)
        assert float(response.report.signals["alpha2"].parts()[i]) == pytest.approx(float(raw), rel=1e-12)


def test_bounds_leak(one: Any) -> None:
    """D̂̇ loses λ_D D̂ with `leak_bound`. Kills: a leak that is not there, or of the wrong sign."""
    leaky = one._replace(gains=Numbers({**one.gains, "leak_bound": jnp.asarray(0.3)}))
    (kept, _), (leaked, _) = (respond(numbers, busy(numbers)) for numbers in (one, leaky))
    lost = np.array(kept.rate.bound.parts()) - np.array(leaked.rate.bound.parts())
    np.testing.assert_allclose(lost, 0.3 * np.array(busy(one).bound.parts()), rtol=1e-9)


def test_the_shaped_law_clips_and_freezes(one: Any) -> None:
    """Far out every α₂ is 0.95 of the nominal limit, and nothing adapts on a clipped channel; unshaped nothing is clipped."""
    far = one._replace(motion=one.motion._replace(nu=one.motion.nu * 500.0, omega=one.motion.omega * 100.0))
    response, _ = respond(far, busy(far))
    alpha2 = np.array(response.report.signals["alpha2"].parts())
    limits = np.where(alpha2 > 0, far.upper.parts(), far.lower.parts())
    np.testing.assert_allclose(np.abs(alpha2), 0.95 * limits, rtol=1e-12)
    for frozen in (response.rate.mass, *response.rate.inertia.parts(), *response.rate.bound.parts()):
        assert float(frozen) == 0.0
    wild, _ = respond(far, busy(far), shaped=False)
    assert np.all(np.abs(np.array(wild.report.signals["alpha2"].parts())) > limits)


def test_estimates_stay_inside_their_bounds(levant: Recorder) -> None:
    """The projection bounds the drift of the estimates even with absurd rates of adaptation; kills a missing projection."""
    numbers = flights.gains("saturated-adaptive") | {"gamma_mass": 1e6, "gamma_inertia": 1e6}
    record = levant(flights.draw(numbers, 150.0, 0.05), 1)
    room = max(300.0 / 70.0 - 1.0, 60.0 / 15.0 - 1.0)
    assert np.all(record.values["peak_estimate_drift"] <= 1.5 * room)
    assert np.all(record.values["peak_estimate_drift"] > 0.5)


def test_pd_plus_lyapunov_function_falls(one: Any) -> None:
    """V̇ = −k_ν νᵀν and Ẇ = −k_ω ωᵀω for the known plant without limits; kills a wrong feed-forward or sign.

    V = ½k_ρρᵀρ + ½νᵀν, W = 2k_σ ln(1+σᵀσ) + ½ωᵀω, the derivative along the plant's own rate by jax.jvp.
    """
    gains = Numbers({name: jnp.asarray(x) for name, x in flights.gains("pd-plus").items()})
    mass, moment = gains.mass_guess_kg, gains.inertia_guess_kgm2
    inertia, inverse = Symmetric.of(moment, 0.0), Symmetric.of(1.0 / moment, 0.0)
    plant = one.plant._replace(mass=mass, inertia=inertia, inertia_inverse=inverse)
    now = measurement(one)
    wrench = pd_plus.respond(now, (), SimpleNamespace(), gains).command
    known = closed_loop.relative(one.motion, one.target, now.alpha_t, plant.port)
    rate = closed_loop.motion_rate(one.motion, known, plant, wrench)

    def energies(motion: Any) -> tuple[Any, Any]:
        v = 0.5 * gains.k_rho * dot(motion.rho, motion.rho) + 0.5 * dot(motion.nu, motion.nu)
        w = 2.0 * gains.k_sigma * jnp.log1p(dot(motion.sigma, motion.sigma)) + 0.5 * dot(motion.omega, motion.omega)
        return v, w

    _, (v_rate, w_rate) = jax.jvp(energies, (one.motion,), (rate,))
    assert float(v_rate) == pytest.approx(-float(gains.k_nu * dot(one.motion.nu, one.motion.nu)), rel=1e-9)
    assert float(w_rate) == pytest.approx(-float(gains.k_omega * dot(one.motion.omega, one.motion.omega)), rel=1e-9)


def test_shaped_virtual_speed_is_bounded(one: Any) -> None:
    """|α_ν| ≤ v_max however far away, along −ρ; unshaped it grows with ρ."""
    far = measurement(one)._replace(motion=one.motion._replace(rho=Vector(1e4, -2e4, 3e4)))
    for shaped, low, high in ((True, 0.99, 1.0), (False, 100.0, math.inf)):
        z2 = backstepping.tracking(shaped, far, one.gains).z2
        speed = np.linalg.norm(np.array((far.motion.nu - z2.force).parts()))
        assert low <= speed / one.gains.v_max_m_s <= high
