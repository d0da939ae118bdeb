"""The integration and the batch: order 4, faults and disturbances as drawn, lost samples, threads, interruptions, float32."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from rvjax.columns import CHANNELS
from rvjax.components.disturbances import gravity_gradient
from rvjax.physics.state import State
from rvjax.simulation import jax_config, rk4
from rvjax.simulation.batch import Flown, Flyer
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.engines.llvm.engine import LlvmEngine
from tests import flights
from tests.flights import Recorder
from tests.oracles.absolute import columns, deviation

OBSERVER = "disturbance-observer"
"""A controller with an internal state that compiles quickly."""
STEPS, STEP_S = 350, 0.05


def gentle(step_s: float, duration_s: float = 300.0) -> Drawn:
    return flights.draw(flights.gains("saturated-adaptive") | flights.GENTLE, duration_s, step_s)


def slow_pd(step_s: float) -> Drawn:
    return flights.draw(flights.gains("pd-plus") | flights.SLOW_PD, 300.0, step_s)


@pytest.mark.parametrize(("controller", "draw"), [("pd_plus", slow_pd), ("filtered", gentle)])
def test_order_four(controller: str, draw: Callable[[float], Drawn], request: pytest.FixtureRequest) -> None:
    """|y_h − y_{h/2}| / |y_{h/2} − y_{h/4}| = 2⁴ for ρ and σ over the whole flight; kills wrong weights or stages of RK4."""
    record: Recorder = request.getfixturevalue(controller)
    coarse, middle, fine = (record(draw(0.1 / every), every).traces[0] for every in (1, 2, 4))
    first, second = deviation(coarse, middle), deviation(middle, fine)
    for name in ("position", "attitude"):
        assert 14.0 <= getattr(first, name) / getattr(second, name) <= 18.0, (name, first, second)


def test_rk4_is_exact_for_cubics_and_no_further() -> None:
    """ẏ = 4t³ is integrated exactly, ẏ = 5t⁴ with the error of Simpson's rule h⁵/24; kills wrong weights."""
    for power, error in ((3, 0.0), (4, 1.0 / 24.0)):

        def rate(t: Any, y: Any, power: int = power) -> Any:
            return (power + 1) * t**power + 0.0 * y

        h = jnp.asarray(0.5)
        found = rk4.step(rate, jnp.asarray(0.0), jnp.asarray(0.0), h, rate(0.0, jnp.asarray(0.0)))
        assert float(found - h ** (power + 1)) == pytest.approx(error * 0.5**5, abs=1e-15)


@pytest.fixture(scope="module")
def faulted(pd_plus: Recorder) -> tuple[Drawn, pd.DataFrame]:
    """A flight with every fault at 100 s."""
    drawn = flights.draw(flights.gains("pd-plus"), 150.0, 0.05, onset_s=100.0)
    return drawn, pd_plus(drawn, 1).traces[0]


def numbers_of(tree: Any) -> NDArray[np.float64]:
    """The numbers of one lane, as an array."""
    return np.array([part[0] for part in tree.parts()])


def test_faults_begin_at_their_onset(faulted: tuple[Drawn, pd.DataFrame]) -> None:
    """applied = h before the onset, e h + s u⁺ from it on; kills a fault before its onset and the sign of the bias."""
    drawn, trace = faulted
    commanded, applied = columns(trace, "cmd_*", CHANNELS), columns(trace, "applied_*", CHANNELS)
    before = trace["t_s"].to_numpy() < 100.0
    np.testing.assert_array_equal(applied[before], commanded[before])
    loss, push = drawn.faults
    expected = commanded * numbers_of(loss["remaining"]) + numbers_of(push["share"]) * numbers_of(drawn.plant.upper)
    np.testing.assert_allclose(applied[~before], expected[~before], rtol=1e-12, atol=1e-15)


def test_disturbances_are_as_drawn(faulted: tuple[Drawn, pd.DataFrame]) -> None:
    """d = constant + a sin(wt + φ), channel by channel; kills a lost phase and a swapped channel."""
    drawn, trace = faulted
    steady, wave = drawn.disturbances
    t = trace["t_s"].to_numpy()[:, None]
    constant = np.concatenate([numbers_of(steady["force_N"]), numbers_of(steady["torque_Nm"])])
    amplitude = np.concatenate([numbers_of(wave["force_N"]), numbers_of(wave["torque_Nm"])])
    expected = constant + amplitude * np.sin(numbers_of(wave["rate_rad_s"]) * t + numbers_of(wave["phase_rad"]))
    np.testing.assert_allclose(columns(trace, "dist_*", CHANNELS), expected, rtol=0.0, atol=1e-14)


def test_gravity_gradient_is_a_torque_alone() -> None:
    """(0, 3μ/|r|⁵ r×Jr) of the true inertia; the torque itself is tested with the plant."""
    one = flights.lane(gentle(STEP_S), 0)
    known = type("Known", (), {"position": one.target.r})()
    push = gravity_gradient.push(0.0, State(one.motion, one.target, ()), known, one.plant, (), one.gains)
    assert not np.array(push.force.parts()).any()
    assert np.linalg.norm(np.array(push.torque.parts())) > 0.0


@pytest.fixture(scope="module")
def flyer() -> Flyer:
    """A law with a state, with faults."""
    return Flyer(LlvmEngine(flights.loop(OBSERVER), flights.METRICS))


@pytest.fixture(scope="module")
def sound(flyer: Flyer) -> Flown:
    """Four sound samples, interrupted every 50 steps, lane 1 traced."""
    return flyer.fly(faulty_draw(), STEPS, every=50, with_envelope=True, trace=[1])


def faulty_draw() -> Drawn:
    """Default gains, faults in the middle of the flight."""
    return flights.draw(flights.gains(OBSERVER), STEPS * STEP_S, STEP_S, onset_s=8.0, window_s=5.0)


def assert_same(a: Flown, b: Flown, lanes: Any = slice(None), others: Any = slice(None)) -> None:
    """Bit by bit."""
    for name, values in a.values.items():
        np.testing.assert_array_equal(values[lanes], b.values[name][others], err_msg=name)
    np.testing.assert_array_equal(a.lost_s[lanes], b.lost_s[others])


def test_where_a_flight_is_interrupted_changes_nothing(flyer: Flyer, sound: Flown) -> None:
    """Every 7 steps and every 50: bit-equal; kills a fold that counts an instant twice where it is resumed."""
    assert_same(flyer.fly(faulty_draw(), STEPS, every=7), sound)


def test_lost_samples_are_reported_and_disturb_nobody(flyer: Flyer, sound: Flown) -> None:
    """A NaN mass is lost at the first step, absurd gains later, a NaN start at once; the other lanes are bit-equal to a flight
    without them. Kills a loss that is not reported and any mixing of lanes."""
    drawn = faulty_draw()
    mass, speed, rho = drawn.plant.mass.copy(), drawn.gains["observer_force_rad_s"].copy(), drawn.motion.rho.x.copy()
    mass[0], speed[1], rho[2] = np.nan, 1e3, np.nan
    drawn = drawn._replace(
        plant=drawn.plant._replace(mass=mass),
        gains=flights.changed(drawn.gains, observer_force_rad_s=speed),
        motion=drawn.motion._replace(rho=drawn.motion.rho.like((rho, *drawn.motion.rho.parts()[1:]))),
    )
    flown = flyer.fly(drawn, STEPS, every=50)
    assert flown.lost_s[0] == STEP_S
    assert 0.0 < flown.lost_s[1] < STEPS * STEP_S
    assert flown.lost_s[2] == 0.0
    assert flown.values["captured"][:3].tolist() == [0.0, 0.0, 0.0]
    assert_same(flown, sound, slice(3, 4), slice(3, 4))


def test_chunks_beside_each_other_change_nothing(flyer: Flyer, sound: Flown) -> None:
    """The same chunk flown by four threads at once is bit-equal to itself flown alone; kills a buffer that two flights share."""
    with ThreadPoolExecutor(4) as threads:
        beside = list(threads.map(lambda every: flyer.fly(faulty_draw(), STEPS, every), (7, 50, 350, 25)))
    for flown in beside:
        assert_same(flown, sound)


def test_lanes_know_nothing_of_each_other(flyer: Flyer, sound: Flown) -> None:
    """The same samples in another order give the same rows, bit by bit; kills any mixing of lanes."""
    order = np.array([2, 0, 3, 1])
    assert_same(flyer.fly(flights.lane(faulty_draw(), order), STEPS, every=50), sound, slice(None), order)


def test_glances_agree_with_the_traced_steps(sound: Flown) -> None:
    """A glance is |ρ|, |ν|, |σ|, |ω| and h(v) of every sample, a traced step everything of the chosen ones: here of lane 1."""
    assert [float(step.t[0]) for step in sound.steps] == pytest.approx([k * STEP_S for k in range(0, STEPS + 1, 50)])
    for glance, step in zip(sound.envelope, sound.steps, strict=True):
        for name in ("rho", "nu", "sigma", "omega"):
            size = np.linalg.norm([part[0] for part in getattr(step.motion, name).parts()])
            assert getattr(glance, name)[1] == pytest.approx(size, rel=1e-12)
        wrench = [part[1] for part in glance.commanded.parts()]
        np.testing.assert_allclose(wrench, [part[0] for part in step.commanded.parts()], rtol=1e-12)


@pytest.mark.parametrize(
    ("recorder", "controller", "draw"), [("pd_plus", "pd-plus", slow_pd), ("levant", "saturated-adaptive", gentle)]
)
def test_what_float32_costs(
    recorder: str, controller: str, draw: Callable[[float], Drawn], request: pytest.FixtureRequest, full: bool
) -> None:
    """60 s of an approach from 16 m in float32 against float64: measured 1e-5 m and 7e-7 rad; nothing is promoted on the way."""
    if controller != "pd-plus" and not full:
        pytest.skip("the law that compiles soonest by default; the adaptive one with --long")
    rows = 1200
    drawn = draw(0.05)
    truth = request.getfixturevalue(recorder)(drawn, 1)
    jax_config.configure("float32")
    try:
        small = jax.tree.map(lambda x: np.asarray(x, np.float32), drawn)
        record = flights.recorder(flights.loop(controller), rows)(small, 1)
    finally:
        jax_config.configure("float64")
    assert all(values.dtype == np.float32 for values in record.values.values())
    apart = deviation(record.traces[0], truth.traces[0].iloc[: rows + 1])
    assert 0.0 < apart.position <= 5e-5, apart
    assert 0.0 < apart.attitude <= 5e-6, apart
