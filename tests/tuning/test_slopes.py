"""Gradients through the closed loop, against differences of flights."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from rvjax import closed_loop
from rvjax.batch import LANES, Flyer, Tangents
from rvjax.draw import Draws
from rvjax.metrics.interface import Metric
from rvjax.tuning import slopes
from rvjax.tuning import tune as tuning
from rvjax.tuning.flights import Flights
from rvjax.tuning.slopes import SMOOTH, Slopes
from rvjax.tuning.space import Space
from tests.tuning.short import write

STEP = 1e-4


def flights_of(space: Space) -> Flights:
    """One that knows the candidate of a point, without a folder."""
    made = Flights(space, cast("Any", SimpleNamespace()), (), np.inf)
    return made


def smooth_at(space: Space, point: np.ndarray, metric: Metric, count: int) -> float:
    """The mean over the first samples of the smooth function, by flights of their own; the numbers with all their digits."""
    ((name, _),) = metric.columns.items()
    exact = {
        key: one.low * (one.high / one.low) ** u if hasattr(one, "high") and "log" in str(type(one)).lower() else one.low + u * (one.high - one.low)
        for (key, one), u in zip(space.free.items(), point, strict=True)
    }
    exact["controller.gains.k_sigma"] = 0.2 * exact["x"]
    problem = space.load({key: value for key, value in exact.items() if "." in key})
    _, drawn = Draws.of(problem, np.arange(LANES))
    flown = Flyer(problem.loop, (metric, *problem.metrics)).fly(drawn, problem.spec.horizon.steps, problem.spec.horizon.steps)
    return float(np.mean(flown.values[name][:count]))


@pytest.mark.parametrize("metric", ["settling_time_s", "delta_v_m_s"])
def test_slopes_are_the_differences_of_flights(tmp_path: Path, metric: str) -> None:
    """Along every coordinate, a tie's too, to a part in a thousand of the steepest. Kills: a tangent of the wrong coordinate, a
    range that is taken for linear, samples beyond the first round, a tie that is not followed, a step that is not differentiated."""
    path = write(tmp_path, ("metric: settling_time_s, quantile: 0.8", f"metric: {metric}, quantile: 0.8"), ("cma-es, population: 6", "gradient"))
    space, spec, _, _ = tuning.prepare(path)
    flights = flights_of(space)
    made = Slopes(space, spec, flights)
    point = np.array([0.55, 0.6, 0.4])
    number = flights.number(space.values(point), point)
    (found,) = made.of([number], point[None])
    count = spec.rounds[0]
    assert made.flown == 3 * count
    expected = np.empty(3)
    for axis in range(3):
        ends = [point + sign * STEP * 10 * np.eye(3)[axis] for sign in (1.0, -1.0)]
        high, low = (smooth_at(space, end, SMOOTH[metric], count) for end in ends)
        expected[axis] = (high - low) / (2 * STEP * 10)
    np.testing.assert_allclose(found, expected, atol=2e-3 * np.abs(expected).max())
    assert np.abs(expected).min() > 1e-3 * np.abs(expected).max()
