"""The mean wrench of a trace: with it, held over each step, two spacecraft in the inertial frame repeat the flight
(`oracles.absolute`, which shares no code with the flight).

Held commands are repeated to the rounding of positions of 7e6 m: 1e-9 m in a number, some 1e-8 m after a while. A wrench that
changes within a step leaves h²/12 Δu/m of position: its mean has the impulse, not the lever arm in time.
"""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pandas as pd
import pytest

from rvjax.columns import CHANNELS
from rvjax.physics.constants import MU_EARTH
from rvjax.physics.vectors import Channels
from rvjax.simulation import closed_loop
from rvjax.simulation.batch import Flyer
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.draws import Draws
from rvjax.simulation.engines.llvm.engine import LlvmChunk
from rvjax.simulation.problem import Problem, load
from rvjax.simulation.tables import trace_tables
from tests import flights
from tests.oracles import absolute

HELD = """\
rvjax: 1
name: held
samples: 2
horizon: {duration_s: 20, step_s: 0.05, control_period_s: 0.05}
target: {orbit: {semi_major_axis_km: 7000, eccentricity: 0.02}, rate_deg_s: [0.3, -0.4, 0.2], port_m: [4, -2, 1.5]}
pursuer: {mass_kg: 90, inertia_kgm2: {principal: [20, 23, 17]}, centre_of_mass_m: [0.04, -0.03, 0.05]}
start: {rho_m: {box: 10}, sigma: {box: 0.2}, nu_m_s: {box: 0.1}, omega_rad_s: {box: 0.01}}
actuators: {upper: [4, 4, 4, 0.8, 0.8, 0.8], lower: [3, 3, 3, 0.6, 0.6, 0.6]}
disturbances: [{use: constant, force_N: [0.02, -0.03, 0.01], torque_Nm: [0.002, 0.001, -0.003]}]
controller: {use: pd-plus}
capture: {window_s: 5}
"""
SLOSHING = (
    HELD + "effects: [{use: slosh-pendulum, slosh_mass_kg: 6, pivot_m: [0.2, 0, 0.1], rod_m: [0, 0.1, -0.3], damping: 0.4}]\n"
)
SMOOTH = SLOSHING.replace(", control_period_s: 0.05", "")


@pytest.fixture
def campaign(tmp_path: Path) -> Any:
    """A campaign from its text."""

    def made(text: str, *overrides: str) -> Problem:
        (tmp_path / "campaign.yaml").write_text(text)
        return load(tmp_path / "campaign.yaml", overrides)

    return made


def traced(problem: Problem, every: int = 1) -> tuple[Drawn, list[pd.DataFrame]]:
    """The numbers of two samples and their traces."""
    flyer = Flyer.of(problem)
    _, drawn = Draws.of(problem, np.resize(np.arange(2), flyer.lanes(2)))
    record = flyer.fly(drawn, problem.spec.horizon.steps, every, trace=(0, 1))
    return drawn, trace_tables(record.steps, {}, measured=False, effects={}, means=record.means)[0]


def constants(drawn: Drawn, lane: int) -> absolute.Constants:
    """The plant of a sample as plain arrays."""
    plant = jax.tree.map(lambda x: float(np.asarray(x)[lane]), drawn.plant)
    inertia, target_inertia = (np.array(flights.matrix(j)) for j in (plant.inertia, plant.target_inertia))
    return absolute.Constants(plant.mass, inertia, target_inertia, np.array(plant.port.parts()), MU_EARTH)


def means(trace: pd.DataFrame) -> Any:
    return absolute.columns(trace, "mean_*", CHANNELS)


@pytest.mark.parametrize(
    ("text", "most"),
    [
        pytest.param(HELD, absolute.Deviation(position=1e-7, velocity=1e-10, attitude=1e-12, rate=1e-13), id="held"),
        pytest.param(SLOSHING, absolute.Deviation(position=1e-5, velocity=2e-7, attitude=1e-6, rate=2e-8), id="sloshing"),
        pytest.param(SMOOTH, absolute.Deviation(position=5e-5, velocity=1e-6, attitude=1e-5, rate=1e-7), id="smooth"),
    ],
)
def test_the_mean_wrench_repeats_a_flight(text: str, most: absolute.Deviation, campaign: Any) -> None:
    """In the inertial frame, of a body whose centre of mass is off. Kills: a moment about the reference point of the torques; a
    disturbance or an effect left out; the wrench of the instant for that of the step; a row too early or late."""
    drawn, traces = traced(campaign(text))
    for lane, trace in enumerate(traces):
        found = absolute.deviation(trace, absolute.propagate_held(trace, constants(drawn, lane)))
        assert all(x <= limit for x, limit in zip(found, most, strict=True)), found


def test_what_remains_falls_with_the_square_of_the_step(campaign: Any) -> None:
    """A continuous wrench, at two steps: ratio 4. Kills: a mean of order one, which the limits above might let pass."""
    found: list[absolute.Deviation] = []
    for step in (0.1, 0.05):
        drawn, (trace, _) = traced(campaign(SMOOTH, f"horizon.step_s={step}"))
        found.append(absolute.deviation(trace, absolute.propagate_held(trace, constants(drawn, 0))))
    ratios = np.array(found[0]) / np.array(found[1])
    assert ((ratios > 3.9) & (ratios < 4.1)).all(), ratios


def test_the_weights_are_those_of_the_step(campaign: Any) -> None:
    """Against the four stages written out in NumPy. Kills: weights 1, 1, 1, 1, a stage at another state or time, a step that is
    not the one that begins here."""
    problem = campaign(SMOOTH, "disturbances=[{use: sinusoid, force_N: 0.5, torque_Nm: 0.1, rate_rad_s: 20, phase_deg: 20}]")
    flyer = Flyer.of(problem)
    _, lanes = Draws.of(problem, np.arange(flyer.lanes(1)))
    h, first = 0.05, 3
    chunk = flyer.engine.begin(lanes)
    chunk.advance(0, first)
    drawn, carry = jax.tree.map(lambda x: x[0], chunk.numbers_and_carry())
    evaluate = jax.jit(partial(closed_loop.evaluate, problem.loop))
    leaves, structure = jax.tree.flatten(carry.y)
    y, t = np.array(leaves, np.float64), first * h

    def stage(t: float, y: Any) -> tuple[Any, Any]:
        rate, now, _ = evaluate(drawn, t, jax.tree.unflatten(structure, list(y)), carry.held, None)
        assert isinstance(now.total, Channels)
        return np.array(jax.tree.leaves(rate)), np.array(now.total.parts())

    k1, u1 = stage(t, y)
    k2, u2 = stage(t + h / 2, y + h / 2 * k1)
    k3, u3 = stage(t + h / 2, y + h / 2 * k2)
    _, u4 = stage(t + h, y + h * k3)
    found = np.array(chunk.mean_wrench(first, first + 1).parts())[:, 0]
    np.testing.assert_allclose(found, (u1 + 2 * u2 + 2 * u3 + u4) / 6, rtol=1e-12, atol=1e-14)
    assert np.abs(found - (u1 + u2 + u3 + u4) / 4).max() > 1e-5, "other weights are another number here"


@pytest.mark.parametrize("engine", ["llvm", "xla"])
def test_a_thinned_row_has_the_mean_up_to_the_next(engine: str, campaign: Any) -> None:
    """The last pair of rows is closer. Kills: the mean of the row's step alone; a divisor that is always `every`; a number in the
    last row, where no step begins; a flight that the means move on."""
    problem = campaign(SMOOTH, f"engine={engine}", "horizon.duration_s=6")
    (_, (whole, _)), (_, (thin, _)) = traced(problem), traced(problem, 7)
    steps = problem.spec.horizon.steps
    edges = [*range(0, steps, 7), steps]
    expected = [means(whole)[a:b].mean(axis=0) for a, b in pairwise(edges)]
    np.testing.assert_allclose(means(thin)[:-1], expected, rtol=1e-10, atol=1e-13)
    assert np.isnan(means(thin)[-1]).all()
    assert np.isfinite(means(whole)[:-1]).all()
    plain = [name for name in thin if not str(name).startswith("mean_")]
    pd.testing.assert_frame_equal(thin[plain], whole[plain].iloc[edges].reset_index(drop=True), check_exact=True)


def test_without_a_trace_nothing_is_computed(campaign: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a second flight of every chunk."""
    monkeypatch.setattr(LlvmChunk, "mean_wrench", lambda *_: pytest.fail("no trace was asked for"))
    problem = campaign(HELD)
    flyer = Flyer.of(problem)
    _, drawn = Draws.of(problem, np.arange(2))
    assert flyer.fly(drawn, 40, 10, with_envelope=True).means == []
