"""The draws of a campaign as points of standard normal space, and the margin of a requirement there.

    z ∈ R^d ─Φ→ u ∈ (0, 1)^d ─laws→ draws ─fly→ metric ─margin→ g(z), below 0 where the flight does not comply

    requirement            margin of a flight
    captured               −log₁₀ of the larger of the errors over the closing window, each in radii of its tube
    metric below v         (v − x)/|v|; where x is infinite, −1 − log₁₀(1 + position error over the closing window, in tubes)
    metric above v         (x − v)/|v|
    at_most                with the other sign: what shall hardly ever happen
    outside of `where`,    +∞;  a flight that was lost: NaN, or −1 − (T − t)/T with the time t of the loss (`failure_margins`)
    or no draw of `under`

z is standard normal, so |z| says how improbable a point is, whatever the laws. A key says which sample's noise a flight has.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import special

from rvjax.analysis.verdicts.compliance import RequirementEvaluator
from rvjax.campaign import Requirement
from rvjax.campaign.draw_names import covers
from rvjax.columns import FAILED, draw_column, metric_column
from rvjax.components.samplers.interface import Samples
from rvjax.components.samplers.uniforms_table import Block, columns_of
from rvjax.execution.chunks import STRETCH
from rvjax.simulation import tables
from rvjax.simulation.batch import Flyer, devices
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem
from rvjax.simulation.requirement_checks import counted

Values = NDArray[np.float64]

FLAT = 1e3
"""Margin of a flight whose metric is infinite and has no other measure."""


@dataclass(frozen=True)
class Coordinate:
    """A uniform number of a variable. name: its column in a table of points."""

    variable: str
    name: str


@dataclass(frozen=True)
class Fixed:
    """A sampler that gives the same points for any samples."""

    seed: int
    numbers: Mapping[str, Values]

    def at(self, samples: Samples) -> Block:
        """The points."""
        return Block(self.seed, samples, self.numbers)


class FlownPoints(NamedTuple):
    """Points that were flown. draws: of the points. frame: outcome, metrics and draws, a row for each point."""

    draws: Draws
    frame: pd.DataFrame


class DrawSpace:
    """A campaign, a requirement, and the coordinates of its draws. The other draws stay at their medians."""

    def __init__(self, problem: Problem, requirement: Requirement, vary: Sequence[str] = ()) -> None:
        self.problem, self.requirement = problem, requirement
        self.reading = RequirementEvaluator(requirement)
        self._columns = {metric_column(name): column for name, column in problem.metric_columns.items()}
        self.reading.columns(
            [*self._columns, *(draw_column(name) for name in (*problem.dispersions.columns, *counted(problem.spec)))]
        )
        laws: Mapping[str, Any] = {name: variable.law for name, variable in problem.dispersions.variables.items()}
        self._counts = {name: law.uniforms for name, law in laws.items()}
        chosen = [name for name in laws if not vary or any(covers(prefix, name) for prefix in vary)]
        self.coordinates = tuple(Coordinate(name, column) for name in chosen for column in columns_of(name, self._counts[name]))
        self.flyer = Flyer.of(problem)

    def fly_chunk(self, z: Values, keys: NDArray[np.int64] | None = None, device: int = 0) -> FlownPoints:
        """Flies up to LANES points z (n, d). keys: (n,) of their noise, by default that of sample 0. Where the engine flies more
        lanes than there are points, further rows repeat the first."""
        lanes = np.arange(self.flyer.lanes(len(z)))
        lanes[len(z) :] = 0
        draws, drawn = self.draws(z[lanes], None if keys is None else keys[lanes])
        horizon, places = self.problem.spec.horizon, devices()
        flown = self.flyer.fly(drawn, horizon.steps, STRETCH, device=places[device % len(places)])
        came = tables.outcomes(flown, horizon.duration_s, self.problem.metrics)
        frame = pd.DataFrame(came | {draw_column(name): values for name, values in draws.values.items()})
        return FlownPoints(draws, frame)

    def draws(self, z: Values, keys: NDArray[np.int64] | None = None) -> tuple[Draws, Any]:
        """The draws of points z (n, d), and the numbers of their flights. keys: as in `fly_chunk`."""
        dispersions = replace(self.problem.dispersions, sampler=Fixed(self.problem.spec.seed, self.numbers(z)))
        samples = np.zeros(len(z), dtype=np.int64) if keys is None else keys
        return Draws.of(replace(self.problem, dispersions=dispersions), samples)

    def numbers(self, z: Values) -> dict[str, Values]:
        """(n, count) uniform numbers of every variable at points (n, d)."""
        inside = np.clip(special.ndtr(z), np.finfo(float).tiny, np.nextafter(1.0, 0.0))
        numbers = {name: np.full((len(z), count), 0.5) for name, count in self._counts.items()}
        index = {(name, column): k for name, count in self._counts.items() for k, column in enumerate(columns_of(name, count))}
        for values, coordinate in zip(inside.T, self.coordinates, strict=True):
            numbers[coordinate.variable][:, index[coordinate.variable, coordinate.name]] = values
        return numbers

    def margins(self, frame: pd.DataFrame) -> Values:
        """(n,) margins of flights; NaN for a flight that collided or is not finite."""
        requirement, capture = self.requirement, self.problem.spec.capture
        position = frame[metric_column("window_position_error_m")].to_numpy(dtype=float) / capture.position_m
        if requirement.metric == "captured":
            turn = (
                np.tan(np.radians(frame[metric_column("window_attitude_error_deg")].to_numpy(dtype=float)) / 4.0)
                / capture.attitude_mrp
            )
            margin = -np.log10(np.maximum(np.maximum(position, turn), 1e-12))
        else:
            x = self.reading.values(frame, self._columns)
            limit, sign = self.reading.bound.value, self.reading.bound.sign
            never = -1.0 - np.log10(1.0 + np.where(np.isfinite(position), position, FLAT))
            margin = np.where(np.isinf(x), sign * np.sign(x) * never, sign * (limit - x) / (abs(limit) or 1.0))
            margin = -margin if requirement.at_most is not None else margin
        return np.where(self.reading.possible(frame), np.where(frame["outcome"].isin(FAILED), np.nan, margin), math.inf)

    def failure_margins(self, frame: pd.DataFrame) -> Values:
        """(n,) margins whose sign is the verdict on the flight: above 0 exactly where it complies.

        A lost flight has −1 − (T − t)/T: the earlier it was lost, the deeper. So even failures that are losses have an order.
        """
        duration = self.problem.spec.horizon.duration_s
        lost = frame["outcome"].isin(FAILED).to_numpy()
        time = frame[tables.OUTCOME_TIME.name].to_numpy(dtype=float)
        margin = np.where(lost, -1.0 - (duration - np.minimum(time, duration)) / duration, self.margins(frame))
        complies = self.reading.comply(self.reading.values(frame, self._columns))
        tiny = np.finfo(float).tiny
        return np.where(complies, np.fmax(margin, tiny), np.where(np.isnan(margin), -1.0, np.minimum(margin, 0.0)))
