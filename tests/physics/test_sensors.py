"""Sensors: noise that grows with the range, measurements that come seldom or are lost.

The re-enactments are written in NumPy and SciPy and import nothing of what they check.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from rvjax.components.navigation.interface import Known
from rvjax.physics.state import Motion, TargetMotion, Tick
from rvjax.physics.vectors import Channels, Vector
from rvjax.simulation import closed_loop, flight, tables
from tests import flights
from tests.members import array, built
from tests.physics.test_navigation import QUANTITIES, drift, turned

Array = NDArray[np.float64]

FALSE_ALARM = 1e-6
"""Of each statistical test, over all its comparisons, with a sound program; the seeds are fixed."""

H, WITHIN = 0.05, 0.65
"""Step [s], and where in a step the measurement is looked at, as a share of it."""

W = (0.02, -0.03, 0.01)
"""ω_t [rad/s] of the target in these tests."""
TRUTH = Known(
    TargetMotion(Vector(7e6, 1e5, -2e5), Vector(10.0, 7e3, 50.0), Vector(*W)), Vector(1e-4, 2e-4, -1e-4), Vector(4, 1, 2)
)


def measured(use: str, steps: int, samples: int, path: Callable[[Any], Motion] = drift, **said: Any) -> Any:
    """(what is measured where each step begins, what is measured within it, the ages there), of `path`: (samples, steps, …)."""
    error, numbers = built("navigation", use, samples, **said)

    def one(own: Any) -> Any:
        own = error.given(own, TRUTH)

        def step(memory: Any, k: Any) -> Any:
            memory = error.keep(Tick(k, k * H, jnp.asarray(H)), path(k), memory, own)
            ages = error.age(k * H, memory) if error.age else ()
            within = error.see((k + WITHIN) * H, path(k + WITHIN), memory, own)
            return memory, (error.see(k * H, path(k), memory, own), within, ages)

        return jax.lax.scan(step, jax.tree.map(jnp.asarray, error.start(path(0.0), own)), jnp.arange(steps))[1]

    first, within, ages = jax.jit(jax.vmap(one))(numbers)
    return *({name: array(getattr(x, name)) for name in QUANTITIES} for x in (first, within)), np.asarray(ages)


def parts(at: Any, path: Callable[[Any], Motion] = drift) -> dict[str, Array]:
    """The true quantities at some steps, (…, 3)."""
    return {name: array(getattr(path(np.asarray(at, dtype=float)), name)) for name in QUANTITIES}


RANGES = (0.0, 2.0, 34.0)


def away(k: Any) -> Motion:
    """A motion at another range in each of three steps, in a direction off the axes."""
    far = 15.0 * k * k - 13.0 * k
    return Motion(Vector(far * 2 / 7, far * -3 / 7, far * 6 / 7), *(Vector(x + 0.0 * far, x, -x) for x in (0.1, 0.2, 0.01)))


SIZES = {"position_m": 0.01, "velocity_m_s": 0.002, "attitude_deg": 0.05, "rate_deg_s": 0.01}
GROWTHS = {"position_m": 0.005, "velocity_m_s": 2e-4, "attitude_deg": 0.02, "rate_deg_s": 0.004}


@pytest.mark.parametrize("floor", [True, False])
def test_noise_grows_with_the_range(floor: bool) -> None:
    """Σe²/(s² + (g|ρ|)²) is χ² at each range and of each of the twelve numbers; false alarm 1e-6.

    Kills: s + g|ρ|, g without s, g ρᵢ for g|ρ|, the range of the step before, degrees for radians.
    """
    samples = 3_000
    said = {f"{key}_per_m": value for key, value in GROWTHS.items()} | (SIZES if floor else {})
    seen, _, _ = measured("noise", 3, samples, away, **said)
    true = parts(np.arange(3), away)
    np.testing.assert_allclose(np.linalg.norm(true["rho"], axis=-1), RANGES, rtol=1e-12)
    low, high = stats.chi2.ppf([0.5 * FALSE_ALARM / 36, 1.0 - 0.5 * FALSE_ALARM / 36], samples)
    for name, key in zip(QUANTITIES, SIZES, strict=True):
        off = turned(seen[name], np.broadcast_to(true[name], seen[name].shape)) if name == "sigma" else seen[name] - true[name]
        unit = np.pi / 180.0 if "deg" in key else 1.0
        for step, far in enumerate(RANGES):
            size = unit * np.hypot(SIZES[key] * floor, GROWTHS[key] * far)
            if size == 0.0:
                np.testing.assert_array_equal(seen[name][:, step], np.broadcast_to(true[name][step], (samples, 3)))
                continue
            energy = ((off[:, step] / size) ** 2).sum(0)
            assert ((low <= energy) & (energy <= high)).all(), (name, far, energy / samples)


def test_noise_of_a_growth_that_is_zero_is_the_noise_without_it() -> None:
    """Up to rounding, and what does not grow bit for bit. Kills: a growth that shifts the random numbers."""
    plain, _, _ = measured("noise", 3, 5, away, **SIZES)
    grown, _, _ = measured("noise", 3, 5, away, **SIZES, position_m_per_m=0.0)
    for name in QUANTITIES:
        np.testing.assert_allclose(grown[name], plain[name], rtol=1e-14, atol=1e-15)
        assert name == "rho" or (grown[name] == plain[name]).all()


@pytest.mark.parametrize(("period", "phase", "first"), [(0.25, 0.0, 0), (0.25, 0.1, 2), (0.05, 0.0, 0), (0.75, 0.56, 11)])
def test_an_update_comes_at_its_instants_and_is_held(period: float, phase: float, first: int) -> None:
    """Bit for bit the motion at the last instant, also within a step; before the first one that at t = 0; the age says how old.

    Kills: a period of a step more or less, an instant of the next step, a phase on the other side, what is held moving.
    """
    steps = np.arange(40)
    every = round(period / H)
    last = np.where(steps < first, 0, first + (steps - first) // every * every)
    seen, within, ages = measured("update-rate", len(steps), 2, period_s=period, phase_s=phase)
    for name, true in parts(last).items():
        np.testing.assert_array_equal(seen[name], np.broadcast_to(true, seen[name].shape))
        np.testing.assert_array_equal(within[name], np.broadcast_to(true, seen[name].shape))
    np.testing.assert_allclose(ages, np.broadcast_to((steps - last) * H, ages.shape), atol=1e-12)


def test_an_update_concerns_what_is_named() -> None:
    """Gyros go on beside a slow camera, bit for bit. Kills: a list that is not read, the others' places in it."""
    seen, within, _ = measured("update-rate", 12, 1, period_s=0.2, of=["attitude", "position"])
    last = np.arange(12) // 4 * 4
    for name in QUANTITIES:
        held = name in ("rho", "sigma")
        np.testing.assert_array_equal(seen[name][0], parts(last if held else np.arange(12))[name])
        np.testing.assert_array_equal(within[name][0], parts(last if held else np.arange(12) + WITHIN)[name])


def calm(k: Any) -> Motion:
    """Slow enough for the rotation of a step to be exact to 1e-10: another motion at every step."""
    rho, nu, sigma, omega = drift(k)
    return Motion(rho, nu * 0.2, sigma * 0.3, omega * 0.05)


def propagated(held: tuple[str, ...], new: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """The propagation step by step with SciPy's rotations: at the beginning of each step, and within it."""
    now = parts(0, calm)
    seen: dict[str, list[Array]] = {name: [] for name in QUANTITIES}
    within: dict[str, list[Array]] = {name: [] for name in QUANTITIES}

    def ahead(x: dict[str, Array], dt: float) -> dict[str, Array]:
        attitude = Rotation.from_mrp(x["sigma"])  # its matrix is that of T to inertial with our σ: R(σ) is its inverse
        rate = x["omega"] + attitude.inv().apply(np.array(W))
        turn = Rotation.from_rotvec(-rate * dt)
        return {
            "rho": turn.apply(x["rho"] + x["nu"] * dt),
            "nu": turn.apply(x["nu"]),
            "sigma": (attitude * Rotation.from_rotvec(x["omega"] * dt)).as_mrp(),
            "omega": x["omega"],
        }

    for k, fresh in enumerate(new):
        if k:
            now = ahead(now, H)
        true = parts(k, calm)
        now = {name: now[name] if name in held and not fresh else true[name] for name in QUANTITIES}
        later, truth = ahead(now, WITHIN * H), parts(k + WITHIN, calm)
        for name in QUANTITIES:
            seen[name].append(now[name])
            within[name].append(later[name] if name in held else truth[name])
    return tuple({name: np.array(rows) for name, rows in table.items()} for table in (seen, within))  # pyright: ignore


CAMERA = ["position", "velocity", "attitude"]


@pytest.mark.parametrize("of", [[*CAMERA, "rate"], CAMERA, ["position"], ["attitude"]])
def test_what_is_propagated_is_the_propagation_by_scipy(of: list[str]) -> None:
    """Step by step, with what is still measured. Kills: Ω without Rω_t, ν that does not turn, ω of the last update where gyros go
    on, a propagation that starts anew in each step, a first step that is too long."""
    steps = 21
    seen, within, _ = measured("update-rate", steps, 1, calm, period_s=0.5, phase_s=0.2, of=of, between="propagate")
    names = tuple(dict(zip([*CAMERA, "rate"], QUANTITIES, strict=True))[word] for word in of)
    new = (np.arange(steps) >= 4) & ((np.arange(steps) - 4) % 10 == 0)
    first, second = propagated(names, new)
    for name in QUANTITIES:
        np.testing.assert_allclose(seen[name][0], first[name], rtol=0.0, atol=1e-8, err_msg=name)
        np.testing.assert_allclose(within[name][0], second[name], rtol=0.0, atol=1e-8, err_msg=name)


def still(k: Any) -> Motion:
    """A motion of one instant, for what follows from it alone."""
    return Motion(*(Vector(x + 0.0 * k, y + 0.0 * k, z + 0.0 * k) for x, y, z in STILL))


STILL = ((12.0, -7.0, 5.0), (0.3, 0.4, -0.2), (0.2, -0.1, 0.3), (0.02, 0.015, -0.03))


def test_a_propagated_measurement_obeys_the_kinematics() -> None:
    """ρ̇ = ν − Ω×ρ, ν̇ = −Ω×ν, σ̇ = G(σ)ω, ω̇ = 0 over 3 s, by SciPy's integrator; Ω is held in a step, which costs 0.3 mm.

    Kills: the sign of Ω×ρ, ν for ν − Ω×ρ, σ̇ with ω of T.
    """
    seen, _, ages = measured("outage", 61, 1, still, start_s=H, duration_s=99.0, between="propagate")

    def rates(t: float, y: Array) -> Array:
        del t
        rho, nu, sigma, omega = y.reshape(4, 3)
        s2 = sigma @ sigma
        cross = np.array([[0, -sigma[2], sigma[1]], [sigma[2], 0, -sigma[0]], [-sigma[1], sigma[0], 0]])
        turn = np.eye(3) - 4 * (1 - s2) / (1 + s2) ** 2 * cross + 8 / (1 + s2) ** 2 * cross @ cross
        rate = omega + turn @ np.array(W)
        mrp = 0.25 * ((1 - s2) * np.eye(3) + 2 * cross + 2 * np.outer(sigma, sigma)) @ omega
        return np.concatenate([nu - np.cross(rate, rho), -np.cross(rate, nu), mrp, 0.0 * omega])

    end = solve_ivp(rates, (0.0, 60 * H), np.array(STILL).ravel(), rtol=1e-11, atol=1e-12).y[:, -1].reshape(4, 3)
    for name, expected, tolerance in zip(QUANTITIES, end, (5e-4, 2e-5, 1e-8, 1e-12), strict=True):
        np.testing.assert_allclose(seen[name][0, -1], expected, rtol=0.0, atol=tolerance, err_msg=name)
    assert np.abs(end[0] - np.array(STILL[0])).max() > 1.0
    np.testing.assert_allclose(ages[0, -1], 60 * H, rtol=1e-12)


@pytest.mark.parametrize(
    ("start", "duration", "lost"),
    [(0.5, 0.25, range(10, 15)), (0.49, 0.26, range(10, 15)), (0.0, 0.1, range(2)), (0.93, 9, range(19, 30))],
)
def test_an_outage_begins_and_ends_at_the_nearest_steps(start: float, duration: float, lost: range) -> None:
    """Bit for bit. Kills: a step more or less at either end, an end that is a duration."""
    seen, _, _ = measured("outage", 30, 1, start_s=start, duration_s=duration)
    last = np.array([max(lost.start - 1, 0) if k in lost else k for k in range(30)])
    for name, true in parts(last).items():
        np.testing.assert_array_equal(seen[name][0], true)


def chances(steps: int, single: float, begins: float, length: int) -> Array:
    """The probability that the measurement of each step is lost: the Markov chain of the steps that an outage still lasts."""
    state = np.zeros(length + 1)
    state[0] = 1.0
    lost = np.zeros(steps)
    for k in range(steps):
        ended = np.append(state[1:], 0.0)  # an outage of j steps has j − 1 left
        ended[0] += state[0]
        state = ended.copy()
        state[0] = ended[0] * (1.0 - begins)
        state[length] += ended[0] * begins
        lost[k] = 1.0 - state[0] * (1.0 - single)
    return lost


LOSSES = (
    {"probability": 0.3},
    {"mean_interval_s": 1.5, "duration_s": 0.4},
    {"probability": 0.1, "mean_interval_s": 4, "duration_s": 1},
)


@pytest.mark.parametrize("said", LOSSES)
def test_measurements_are_lost_as_often_as_they_should(said: dict[str, Any]) -> None:
    """How many samples are without a measurement at a step is binomial with the probability of the Markov chain: at ten
    steps, and at two steps in turn where they are independent; false alarm 1e-6.

    Kills: outages that are twice as often, losses that are the same in every sample, the chance of
    one process for the other.
    """
    samples, steps = 3_000, 200
    _, _, ages = measured("dropouts", steps, samples, **said)
    lost = ages > 0.5 * H
    length = round(said.get("duration_s", H) / H)
    begins = 1.0 - np.exp(-H / said["mean_interval_s"]) if "mean_interval_s" in said else 0.0
    expected = chances(steps, said.get("probability", 0.0), begins, length)
    looked = [1, 2, 5, 9, 20, 35, 60, 100, 150, 199]
    for k in looked:
        low, high = stats.binom.ppf([0.5 * FALSE_ALARM / 11, 1.0 - 0.5 * FALSE_ALARM / 11], samples, expected[k])
        assert low <= lost[:, k].sum() <= high, (k, lost[:, k].mean(), expected[k])
    if begins == 0.0:
        both = (lost[:, 1::2][:, :99] & lost[:, 2::2]).sum()
        low, high = stats.binom.ppf([0.5 * FALSE_ALARM / 11, 1.0 - 0.5 * FALSE_ALARM / 11], samples * 99, 0.09)
        assert low <= both <= high


def test_an_outage_lasts_as_long_as_it_was_drawn() -> None:
    """Each sample has its duration; one that follows at once makes it longer by a whole one. Kills: a duration of another sample,
    of a step more or less, an outage that is renewed while it lasts."""
    said = {"mean_interval_s": 2.0, "duration_s": {"uniform": [0.1, 0.6]}}
    _, numbers = built("navigation", "dropouts", 300, **said)
    _, _, ages = measured("dropouts", 200, 300, **said)
    length = np.round(np.asarray(numbers["duration_s"]) / H)
    assert len(set(length)) > 5
    seen = 0
    for own, row in zip(length, ages > 0.5 * H, strict=True):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(int)))
        runs = [(stop - begin, stop) for begin, stop in zip(edges[::2], edges[1::2], strict=True) if begin > 1]
        assert all(run % own == 0 for run, stop in runs if stop < len(row)), (own, runs)
        seen += len(runs)
    assert seen > 500


def loop_of(*errors: tuple[str, dict[str, Any]]) -> tuple[closed_loop.Loop, closed_loop.Drawn]:
    """One lane of PD+ without faults and disturbances behind navigation errors, in this order."""
    pairs = [built("navigation", use, flights.LANES, **said) for use, said in errors]
    closed = flights.loop("pd-plus")._replace(faults=(), disturbances=(), navigation=tuple(own for own, _ in pairs))
    drawn = flights.draw(flights.gains("pd-plus"), 300.0, H)
    drawn = drawn._replace(faults=(), disturbances=(), navigation=tuple(numbers for _, numbers in pairs))
    return closed, flights.lane(drawn, 2)


def recorded(closed: closed_loop.Loop, drawn: closed_loop.Drawn, steps: int) -> Any:
    """The Steps of a flight, stacked."""
    evaluate = partial(closed_loop.evaluate, closed)

    def one(carry: Any, k: Any) -> Any:
        return flight.step(evaluate, (), drawn, carry, k), flight.observe(evaluate, drawn, carry, k)

    drawn = jax.tree.map(jnp.asarray, drawn)
    return jax.jit(lambda: jax.lax.scan(one, flight.begin(closed, (), drawn), jnp.arange(steps))[1])()


def test_lost_updates_of_a_flight_are_those_enacted_again() -> None:
    """From the trace's columns alone: what was lost says the age; an update takes what dropouts let through, and holds it.

    Kills: an update that is made up for within its period, an order that is turned, an age of the wrong component, ages that
    are not in the trace.
    """
    closed, drawn = loop_of(("dropouts", {"probability": 0.4}), ("update-rate", {"period_s": 0.2, "of": CAMERA}))
    seen = recorded(closed, drawn, 120)
    rows = jax.tree.map(lambda x: np.asarray(x)[:, None], seen)
    each_step = [jax.tree.map(lambda x, k=k: x[k], rows) for k in range(120)]
    means = [Channels.pair(np.zeros(1), np.zeros(1))] * 119
    (table,), columns = tables.trace_tables(each_step, {}, measured=True, means=means, interrupted=("dropouts", "slow"))
    assert columns["navigation.slow.age_s"].unit == "s"
    lost = table["navigation.dropouts.age_s"].to_numpy() > 0.5 * H
    through = [0]
    for k in range(1, 120):
        through.append(through[-1] if lost[k] else k)
    held = [through[k - k % 4] for k in range(120)]
    assert 20 < sum(lost) < 75
    assert any(lost[k] for k in range(4, 120, 4))
    np.testing.assert_allclose(table["navigation.slow.age_s"], np.arange(120) % 4 * H, atol=1e-9)
    for stem, source in (("rho_{}_m", held), ("nu_{}_m_s", held), ("sigma_{}", held), ("omega_{}_rad_s", through)):
        for axis in "xyz":
            true = table[stem.format(axis)].to_numpy()
            np.testing.assert_array_equal(table[f"seen_{stem.format(axis)}"], true[source])
