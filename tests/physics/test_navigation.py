"""Navigation errors: their sizes, their order, and that none of them touches the true motion by itself."""

from __future__ import annotations

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats
from scipy.spatial.transform import Rotation

from rvjax.physics.state import Motion, Tick
from rvjax.physics.vectors import Vector
from rvjax.simulation import closed_loop, flight, tables
from tests import flights
from tests.members import array, built, scene

Array = NDArray[np.float64]

FALSE_ALARM = 1e-6
"""Of each statistical test, over all its comparisons, with a sound program; the seeds are fixed."""

H = 0.05
QUANTITIES = ("rho", "nu", "sigma", "omega")


def drift(k: Any) -> Motion:
    """A motion that is another one at every step."""
    return Motion(*(Vector(*(0.1 * (3 * i + j + 1) / 20 + 0.013 * (i + 1) * k for j in range(3))) for i in range(4)))


def measured(use: str, steps: int, samples: int, **said: Any) -> dict[str, Array]:
    """(samples, steps, 3) of each quantity of `drift`, as measured where each step begins."""
    functions, numbers = built("navigation", use, samples, **said)

    def one(own: Any) -> Any:
        def step(memory: Any, k: Any) -> tuple[Any, Any]:
            memory = functions.keep(Tick(k, k * H, jnp.asarray(H)), drift(k), memory, own)
            return memory, functions.see(k * H, drift(k), memory, own)

        first = jax.tree.map(jnp.asarray, functions.start(drift(0.0), own))
        return jax.lax.scan(step, first, jnp.arange(steps))[1]

    seen = jax.jit(jax.vmap(one))(numbers)
    return {name: array(getattr(seen, name)) for name in QUANTITIES}


def truth(steps: int) -> dict[str, Array]:
    """(steps, 3) of each quantity of `drift`."""
    return {name: array(getattr(drift(np.arange(steps)), name)) for name in QUANTITIES}


def turned(seen: Array, true: Array) -> Array:
    """(…, 3) the rotation from the true attitude to the measured one, as a vector in P [rad]."""
    between = Rotation.from_mrp(true.reshape(-1, 3)).inv() * Rotation.from_mrp(seen.reshape(-1, 3))
    return between.as_rotvec().reshape(seen.shape)


def errors(seen: dict[str, Array]) -> dict[str, Array]:
    """What is measured less what is true: m, m/s, rad, rad/s."""
    true = truth(seen["rho"].shape[1])
    found = {name: seen[name] - true[name] for name in QUANTITIES}
    return found | {"sigma": turned(seen["sigma"], np.broadcast_to(true["sigma"], seen["sigma"].shape))}


SAID = {"position_m": [0.01, 0.02, 0.5], "velocity_m_s": 0.003, "attitude_deg": [0.1, 0.2, 0.05], "rate_deg_s": 0.02}
SIZES = {
    "rho": np.array([0.01, 0.02, 0.5]),
    "nu": np.full(3, 0.003),
    "sigma": np.radians([0.1, 0.2, 0.05]),
    "omega": np.full(3, np.radians(0.02)),
}


def test_noise_is_white_and_of_its_size() -> None:
    """Σe²/s² is χ² for each of the twelve numbers, and no two of them or two steps are correlated; false alarm 1e-6.

    Kills: the attitude's error as an MRP without the quarter, in T for in P, one draw for two quantities, noise that is not
    new at every step.
    """
    samples, steps = 800, 25
    found = errors(measured("noise", steps, samples, **SAID))
    scaled = np.concatenate([found[name] / SIZES[name] for name in QUANTITIES], axis=-1)
    pairs = [(i, j) for i in range(12) for j in range(i)]
    tests = 12 + len(pairs) + 12
    low, high = stats.chi2.ppf([0.5 * FALSE_ALARM / tests, 1.0 - 0.5 * FALSE_ALARM / tests], samples * steps)
    energy = (scaled**2).sum(axis=(0, 1))
    assert ((low <= energy) & (energy <= high)).all(), energy / (samples * steps)
    limit = stats.norm.isf(0.5 * FALSE_ALARM / tests)
    both = [(scaled[..., i], scaled[..., j]) for i, j in pairs] + [(scaled[:, :-1, i], scaled[:, 1:, i]) for i in range(12)]
    assert max(abs((a * b).sum() / np.sqrt((a * a).sum())) for a, b in both) <= limit


def test_what_is_not_named_is_exact_and_changes_nothing_else() -> None:
    """Bit for bit. Kills: random numbers that move up when another quantity is left out."""
    whole, true = measured("noise", 5, 3, **SAID), truth(5)
    for key, name in (("position_m", "rho"), ("attitude_deg", "sigma"), ("rate_deg_s", "omega")):
        alone = measured("noise", 5, 3, **{key: SAID[key]})
        np.testing.assert_allclose(alone[name], whole[name], rtol=0.0, atol=1e-6 * SIZES[name].max())
        for other in set(QUANTITIES) - {name}:
            np.testing.assert_array_equal(alone[other], np.broadcast_to(true[other], alone[other].shape))


def test_a_bias_is_the_one_that_was_drawn() -> None:
    """At every step, each sample its own; the attitude is turned about an axis of P.

    Kills: degrees for radians, compose(σ, b) for compose(b, σ), a bias that grows.
    """
    said = {"position_m": {"box": 1.0}, "velocity_m_s": {"box": 0.1}, "attitude_deg": {"box": 1.0}, "rate_deg_s": {"box": 0.5}}
    _, numbers = built("navigation", "bias", 6, **said)
    found = errors(measured("bias", 4, 6, **said))
    for name, key in zip(QUANTITIES, ("position_m", "velocity_m_s", "attitude_rad", "rate_rad_s"), strict=True):
        drawn = array(numbers[key])[:, None]
        tolerance = 1e-12 + (name == "sigma") * np.abs(drawn).max() ** 3 / 24.0  # φ/4 is the MRP of φ to that
        np.testing.assert_allclose(found[name], np.broadcast_to(drawn, found[name].shape), rtol=0.0, atol=tolerance)
        assert np.abs(drawn).max() > 0.0


@pytest.mark.parametrize("steps", [1, 5, 64])
def test_a_delay_is_exact(steps: int) -> None:
    """Bit for bit the motion n steps ago, before that the one at t = 0. Kills: n − 1, n + 1, a zero before the flight."""
    functions, numbers = built("navigation", "delay", 1, steps=steps)
    memory = functions.start(drift(0), numbers)
    for k in range(steps + 6):
        memory = functions.keep(Tick(k, k * H, H), drift(k), memory, numbers)
        assert functions.see(k * H + 0.01, drift(k + 0.2), memory, numbers) == drift(max(k - steps, 0))


def test_the_bias_of_a_gyro_wanders_by_the_root_of_time() -> None:
    """b − b₀ at t and between two times is normal with variance q² Δt, whatever the axis: χ², false alarm 1e-6; nothing else is
    touched. Kills: q h for q √h, a first step before the flight, b₀ at every step, one axis for all."""
    samples, steps = 4_000, 81
    said = {"bias_deg_s": [0.1, -0.2, 0.3], "walk_deg_s": [0.01, 0.02, 0.05]}
    seen = measured("gyro-drift", steps, samples, **said)
    bias = seen["omega"] - truth(steps)["omega"] - np.radians(said["bias_deg_s"])
    np.testing.assert_allclose(bias[:, 0], 0.0, atol=1e-15)
    pairs = [(0, 1), (0, 16), (16, 80), (0, 80)]
    tests = 3 * (len(pairs) + 3)
    low, high = stats.chi2.ppf([0.5 * FALSE_ALARM / tests, 1.0 - 0.5 * FALSE_ALARM / tests], samples)
    for first, last in pairs:
        spread = ((bias[:, last] - bias[:, first]) ** 2).sum(0) / (np.radians(said["walk_deg_s"]) ** 2 * (last - first) * H)
        assert ((low <= spread) & (spread <= high)).all(), (first, last, spread / samples)
    grown = [(bias[:, 40] - bias[:, 0], bias[:, 80] - bias[:, 40])]
    grown += [(bias[:, 80], np.roll(bias[:, 80], 1, axis=1)), (bias[:, 80], np.roll(bias[:, 80], 1, axis=0))]
    for a, b in grown:
        size = (a * b).sum(0) / np.sqrt((a * a).sum(0)) / b.std(0)
        assert (np.abs(size) <= stats.norm.isf(0.5 * FALSE_ALARM / tests)).all()
    for name in ("rho", "nu", "sigma"):
        np.testing.assert_array_equal(seen[name], np.broadcast_to(truth(steps)[name], seen[name].shape))


NOTHING = {
    "noise": {"position_m": 0.0, "velocity_m_s": 0.0, "attitude_deg": 0.0, "rate_deg_s": 0.0},
    "bias": {"position_m": 0.0, "velocity_m_s": 0.0, "attitude_deg": 0.0, "rate_deg_s": 0.0},
    "gyro-drift": {"bias_deg_s": 0.0, "walk_deg_s": 0.0},
}


@pytest.mark.parametrize("use", NOTHING)
def test_an_error_of_size_zero_is_none(use: str) -> None:
    """Bit for bit. Kills: a rotation that is normalised, a measurement in another frame."""
    seen, true = measured(use, 4, 2, **NOTHING[use]), truth(4)
    for name in QUANTITIES:
        np.testing.assert_array_equal(seen[name], np.broadcast_to(true[name], seen[name].shape))


def loop_of(*uses: str) -> tuple[closed_loop.Loop, closed_loop.Drawn]:
    """One lane of PD+ without faults and disturbances behind some navigation errors, in this order."""
    pairs = [built("navigation", use, flights.LANES, **({"steps": 3} if use == "delay" else {})) for use in uses]
    closed = flights.loop("pd-plus")._replace(faults=(), disturbances=(), navigation=tuple(own for own, _ in pairs))
    drawn = flights.draw(flights.gains("pd-plus"), 1.0, H)
    drawn = drawn._replace(faults=(), disturbances=(), navigation=tuple(numbers for _, numbers in pairs))
    return closed, flights.lane(drawn, 2)


def seen_in_turn(*uses: str, steps: int = 4) -> list[Motion]:
    """What the controller sees where each step begins, in a flight of the closed loop."""
    closed, drawn = loop_of(*uses)
    evaluate = partial(closed_loop.evaluate, closed)
    carry, found = flight.begin(closed, (), drawn), list[Motion]()
    for k in range(steps):
        found.append(flight.observe(evaluate, drawn, carry, k).measured)
        carry = flight.step(evaluate, (), drawn, carry, k)
    return found


def test_errors_act_in_the_order_of_the_campaign() -> None:
    """What stands before the delay is delayed with it: noise behind a delay of three steps is new from the start on, before it
    the noise of step 0 comes at step 3. Kills: an error that is given the true motion, a delay that forgets what came before."""
    true, before, behind = seen_in_turn(), seen_in_turn("noise", "delay"), seen_in_turn("delay", "noise")
    noisy = seen_in_turn("noise")
    assert before[3] == before[0] == noisy[0] != true[0]
    assert len({float(motion.rho.x - true[0].rho.x) for motion in behind}) == len(behind)
    assert float(behind[0].rho.x) == float(noisy[0].rho.x)


def test_the_controller_starts_on_what_it_sees() -> None:
    """Its own state at t = 0 comes from the measured motion. Kills: a start on the true motion."""
    closed, drawn = loop_of("bias")
    started = closed_loop.Controller(lambda view, gains: view.motion.rho, closed.controller.respond)
    y, _ = closed_loop.start(closed._replace(controller=started), drawn)
    np.testing.assert_allclose(array(y.control) - array(drawn.motion.rho), array(drawn.navigation[0]["position_m"]), atol=1e-12)


def test_a_trace_shows_what_is_measured() -> None:
    """`seen_*` beside the true motion, by the same names, where there are navigation errors, and only there."""
    closed, drawn = loop_of("bias")
    rows = jax.tree.map(lambda x: jnp.asarray(x)[None], drawn)
    carry = jax.vmap(partial(flight.begin, closed, ()))(rows)
    seen = jax.vmap(lambda own, at: flight.observe(partial(closed_loop.evaluate, closed), own, at, 0))(rows, carry)
    (with_errors, *_), meanings = tables.trace_tables([seen], {}, measured=True)
    (without, *_), plain = tables.trace_tables([seen], {}, measured=False)
    more = [name for name in with_errors if name not in without]
    assert more == [f"seen_{name}" for name in without if name.split("_")[0] in QUANTITIES]
    assert list(without) == [name for name in with_errors if name not in more]
    assert all(meanings[name].unit == plain[name.removeprefix("seen_")].unit for name in more)
    off = [float(with_errors[f"seen_rho_{axis}_m"][0] - with_errors[f"rho_{axis}_m"][0]) for axis in "xyz"]
    np.testing.assert_allclose(off, array(drawn.navigation[0]["position_m"]), atol=1e-12)


def test_scene_is_no_fixed_point() -> None:
    """The motion that is measured here moves in every quantity, so an error that stands still would be seen."""
    for quantity in drift(0):
        assert array(quantity).all()
    assert scene()[0].rho.x.shape == (flights.LANES,)
