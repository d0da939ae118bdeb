"""Gradients through the closed loop, against differences of flights."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from rvjax.components.metrics.interface import Metric
from rvjax.search.tuning import tune as tuning
from rvjax.search.tuning.candidate_flights import Flights
from rvjax.search.tuning.gradients import SMOOTH, Slopes
from rvjax.search.tuning.space import Space
from rvjax.simulation.batch import LANES, Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.engines.llvm.engine import LlvmEngine
from tests.tuning.short import write

STEP = 1e-4


def flights_of(space: Space) -> Flights:
    """One that knows the candidate of a point, without a folder."""
    return Flights(space, cast("Any", SimpleNamespace()), (), np.inf)


def smooth_at(space: Space, point: np.ndarray, metric: Metric, count: int, flyers: list[Flyer]) -> float:
    """The mean over the first samples of the smooth function, by flights of their own; the numbers with all their digits."""
    ((name, _),) = metric.columns.items()
    k_rho, k_nu, x = 0.02 * 25.0 ** point[0], 0.1 * 30.0 ** point[1], 0.5 + 1.5 * point[2]
    exact = {"controller.gains.k_rho": k_rho, "controller.gains.k_nu": k_nu, "controller.gains.k_sigma": 0.2 * x}
    problem = space.load(exact)
    _, drawn = Draws.of(problem, np.arange(LANES))
    flyers += [] if flyers else [Flyer(LlvmEngine(problem.loop, (metric, *problem.metrics)))]
    flown = flyers[0].fly(drawn, problem.spec.horizon.steps, problem.spec.horizon.steps)
    return float(np.mean(flown.values[name][:count]))


@pytest.mark.parametrize("metric", ["settling_time_s", "delta_v_m_s"])
def test_slopes_are_the_differences_of_flights(tmp_path: Path, metric: str, full: bool) -> None:
    """Along every coordinate, a tie's too, to three in a thousand (the values of a candidate have four digits). Kills: a tangent
    of the wrong coordinate, a range that is taken for linear, samples beyond the first round, a tie that is not followed, values
    with four digits that are differenced, a step that is not differentiated."""
    if metric != "settling_time_s" and not full:
        pytest.skip("one metric by default: --long")
    path = write(
        tmp_path,
        ("metric: settling_time_s, quantile: 0.8", f"metric: {metric}, quantile: 0.8"),
        ("cma-es, population: 6", "gradient"),
        ("faults: [{use: effectiveness, onset_s: {uniform: [2, 8]}, remaining: {uniform: [0.5, 1]}}]\n", ""),
    )
    space, spec, _, _ = tuning.prepare(path)
    flights = flights_of(space)
    made = Slopes(space, spec, flights)
    point = np.array([np.log(0.12 / 0.02) / np.log(25), np.log(0.8 / 0.1) / np.log(30), 0.4])  # 0.12, 0.8, 1.1
    number = flights.number(space.values(point), point)
    (found,) = made.of([number], point[None])
    count = spec.rounds[0]
    assert flights.flights == 3 * count
    expected, flyers = np.empty(3), list[Flyer]()
    for axis in range(3):
        ends = [point + sign * STEP * np.eye(3)[axis] for sign in (1.0, -1.0)]
        high, low = (smooth_at(space, end, SMOOTH[metric], count, flyers) for end in ends)
        expected[axis] = (high - low) / (2 * STEP)
    np.testing.assert_allclose(found, expected, rtol=3e-3)
