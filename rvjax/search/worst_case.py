"""The worst draws: a search over what a campaign draws for the smallest margin of a requirement.

Points, draws and margins: `rvjax.execution.draw_space`. Here a flight that was lost has the margin −∞, a body that cannot exist
+∞, and noise in flight is that of sample 0 throughout: a flight is a function of z. After the searches the worst case descends
along the gradient of its margin, where the metric has a gradient; a batch tries LANES lengths of a step. The result is written
as a campaign whose sampler gives these very numbers, and flown again from there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import jax
import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import special

from rvjax.analysis.verdicts.sentences import success_of
from rvjax.campaign import Requirement, Source
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.draw_names import covers
from rvjax.columns import FAILED, METRIC, draw_column, metric_column
from rvjax.errors import CampaignError, UsageError
from rvjax.execution.draw_space import Coordinate, DrawSpace, Values
from rvjax.execution.executors.threads import map_in_threads
from rvjax.search import failure_search
from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES, Tangents
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem, load

REACH = 1e-4
"""Difference of z over which the numbers that fly are differenced."""

LENGTHS = np.geomspace(1e-3, 4.0, LANES)
"""Of the steps down a gradient that are tried at once."""

BATCH = 4 * LANES
"""Flights at once, the same on every machine: what is searched depends on it."""

DESCENTS = 8
"""Largest number of steps along the gradient, from the worst case of the searches."""

BEYOND = 1e-6
"""Probability that a sample is outside the ball that is searched by default."""


@dataclass(frozen=True)
class Case:
    """A flight. z: its point; margin; draws and values of the metrics by name, in SI; outcome; distance: |z|."""

    z: Values
    margin: float
    draws: Mapping[str, float]
    values: Mapping[str, float]
    outcome: str

    def frame(self, other: Mapping[str, float]) -> pd.DataFrame:
        """The row of the samples table, with other values of some metrics."""
        values = {metric_column(name): value for name, value in {**self.values, **other}.items()}
        return pd.DataFrame([{"outcome": self.outcome, **values, **{draw_column(name): x for name, x in self.draws.items()}}])

    @property
    def distance(self) -> float:
        """|z|"""
        return float(np.linalg.norm(self.z))


@dataclass(frozen=True)
class Worst:
    """Result of a search. worst: the flight with the smallest margin. likeliest: the most probable flight that does not comply;
    None where all comply. flights, failing: numbers flown and not complying. history: the smallest margin of each batch."""

    requirement: str
    coordinates: tuple[Coordinate, ...]
    flights: int
    failing: int
    worst: Case
    likeliest: Case | None
    history: tuple[float, ...]


class WorstCaseSearch(DrawSpace):
    """A campaign and the coordinates of its draws that are searched; the other draws stay at their medians."""

    def __init__(self, problem: Problem, requirement: Requirement, vary: Sequence[str] = ()) -> None:
        super().__init__(problem, requirement, vary)
        self._tangents: dict[str, Tangents] = {}

    def fly(self, z: Values) -> list[Case]:
        """A case for each row of z."""
        chunks: list[list[Case]] = []
        parts = [z[first : first + LANES] for first in range(0, len(z), LANES)]
        map_in_threads(self._chunk, parts, chunks.append, self.flyer.stop)
        return [case for chunk in chunks for case in chunk]

    def _chunk(self, z: Values) -> list[Case]:
        draws, frame = self.fly_chunk(z)
        margins = np.where(self._exist(draws), self.margins(frame), math.inf)
        came = {name: frame[metric_column(name)].to_numpy() for name in self.problem.metric_columns}
        return [
            Case(
                z[row],
                float(margins[row]),
                {name: float(values[row]) for name, values in draws.values.items()},
                {name: float(values[row]) for name, values in came.items()},
                str(frame["outcome"].iloc[row]),
            )
            for row in range(len(z))
        ]

    def gradient(self, case: Case) -> Values:
        """(d,) gradient of the margin at a case, through every step of the flight; a lane for each coordinate. 0 where the metric
        has no gradient, such as a settling time."""
        name = self._deciding_metric(case)
        if name is None:
            return np.zeros(len(case.z))
        metric = next(metric for metric in self.problem.metrics if name in metric.columns)
        program = self._tangents.setdefault(name, Tangents(self.problem.loop, metric, name))
        count, steps = len(case.z), self.problem.spec.horizon.steps
        (_, high), (_, low) = (self.draws(case.z + sign * REACH * np.eye(count)) for sign in (1.0, -1.0))
        numbers = self.draws(np.repeat(case.z[None], count, axis=0))[1]
        tangent = jax.tree.map(lambda a, b: (a - b) / (2.0 * REACH), high, low)
        slopes = program.fly(numbers, tangent, steps) * self._rise(case, name)
        return np.where(np.isfinite(slopes), slopes, 0.0)

    def _deciding_metric(self, case: Case) -> str | None:
        """The metric that decides the margin of a case."""
        if case.outcome in FAILED or not math.isfinite(case.margin):
            return None
        if self.requirement.metric != "captured":
            return self.reading.column.removeprefix(METRIC)
        names = ("window_position_error_m", "window_attitude_error_deg")
        falls = [self.margins(case.frame({name: 1.01 * case.values[name]}))[0] for name in names]
        return names[int(np.argmin(falls))]

    def _rise(self, case: Case, name: str) -> float:
        """d margin / d metric at a case."""
        x = case.values[name]
        step = 1e-6 * (abs(x) or 1.0)
        high, low = (float(self.margins(case.frame({name: x + sign * step}))[0]) for sign in (1.0, -1.0))
        return (high - low) / (2.0 * step)

    @staticmethod
    def _exist(draws: Draws) -> NDArray[np.bool_]:
        rejected = [values for name, values in draws.values.items() if name.endswith(".rejected")]
        return np.all([values == 0 for values in rejected], axis=0) if rejected else np.ones(len(draws.samples), dtype=bool)


def prepare(
    path: str | Path | Source, overrides: Sequence[str] = (), number: int = 1, vary: Sequence[str] = ()
) -> WorstCaseSearch:
    """The search of a campaign. number: of the requirement, from 1. vary: prefixes of draws; by default all draws.

    CampaignError with every finding, also where there is no such requirement or nothing is drawn; UsageError for an unknown draw.
    """
    problem = load(path, overrides)
    required, source = problem.spec.require, problem.spec.source
    if not 1 <= number <= len(required):
        accepted = f"1 to {len(required)}" if required else "a campaign with a section require"
        finding = source.finding(("require",), f"there is no requirement {number}", f"accepted: {accepted}", key=True)
        raise CampaignError([finding])
    if required[number - 1].mean:
        shares = [str(index) for index, requirement in enumerate(required, 1) if not requirement.mean]
        accepted = f"accepted: --requirement {' or '.join(shares)}" if shares else "accepted: a requirement on a share"
        message = f"requirement {number} is on a mean, which no single flight meets"
        raise CampaignError([source.finding(("require", number - 1), message, accepted)])
    names = list(problem.dispersions.variables)
    for prefix in vary:
        if not any(covers(prefix, name) for name in names):
            raise UsageError(f"--vary {prefix}: no draw of this campaign; {did_you_mean(prefix, names)}")
    if not names:
        raise CampaignError([source.finding((), "nothing is drawn", "accepted: a campaign with a distribution")])
    jax_config.configure(problem.spec.precision)
    return WorstCaseSearch(problem, required[number - 1], vary)


def find_worst_case(
    path: str | Path | Source,
    requirement: int = 1,
    overrides: Sequence[str] = (),
    *,
    flights: int = 20_000,
    vary: Sequence[str] = (),
    seed: int = 0,
    radius: float | None = None,
    on_progress: Callable[[int, float], None] = lambda flights, margin: None,
) -> Worst:
    """Searches the draws of a campaign for the smallest margin of a requirement.

    requirement: its number, from 1. flights: the largest number flown. vary: prefixes of the draws that are searched, by default
    all. radius: |z| ≤ radius in standard normal coordinates; by default a sample in a million is outside.
    on_progress: called with the flights so far and the smallest margin.

    Errors: those of `prepare`.
    """
    return worst(prepare(path, overrides, requirement, vary), flights, seed, radius=radius, on_progress=on_progress)


class _Record:
    """Flies points and records the results: the worst case, the most probable failure, the numbers flown and failing."""

    def __init__(self, search: WorstCaseSearch, on_progress: Callable[[int, float], None]) -> None:
        self._search, self._on_progress = search, on_progress
        self.flights = self.failing = 0
        self._best: Case | None = None
        self.likeliest: Case | None = None

    def margins(self, z: Values) -> Values:
        """(n,) margins at the points z (n, d)."""
        cases = self._search.fly(z)
        failed = [case for case in cases if not case.margin >= 0.0]
        self.flights += len(cases)
        self.failing += len(failed)
        self._best = min(cases if self._best is None else [self._best, *cases], key=_badness)
        likeliest = failed if self.likeliest is None else [self.likeliest, *failed]
        self.likeliest = min(likeliest, key=lambda case: case.distance, default=None)
        self._on_progress(self.flights, self._best.margin)
        return np.array([case.margin for case in cases])

    @property
    def best(self) -> Case:
        """The case with the smallest margin."""
        assert self._best is not None, "nothing was flown"
        return self._best

    def descend(self, domain: failure_search.Domain) -> bool:
        """A step from the worst case along its gradient; whether the worst case got worse."""
        gradient = self._search.gradient(self.best)
        self.flights += len(gradient)
        if not (length := float(np.linalg.norm(gradient))) > 0.0:
            return False
        before = _badness(self.best)
        self.margins(domain.inside(self.best.z - LENGTHS[:, None] * gradient / length))
        return _badness(self.best) < before


def worst(
    search: WorstCaseSearch,
    flights: int,
    seed: int = 0,
    *,
    radius: float | None = None,
    box: float | None = None,
    first_only: bool = False,
    likeliest_too: bool = False,
    on_progress: Callable[[int, float], None] = lambda flights, margin: None,
) -> Worst:
    """Searches the smallest margin with up to `flights` flights.

    radius: |z| ≤ radius; by default a sample in a million is outside. box: |z_i| ≤ box instead of a ball. first_only: stops at
    the first flight that does not comply. likeliest_too: after a failure, searches the most probable failure. on_progress: called
    with the flights so far and the smallest margin. UsageError for a radius with a box.
    """
    if radius is not None and box is not None:
        raise UsageError("both a radius and a box; accepted: one of them")
    dimension = len(search.coordinates)
    if radius is None and box is None:
        radius = math.sqrt(float(special.chdtri(dimension, BEYOND)))
    record = _Record(search, on_progress)
    side = box or failure_search.FARTHEST
    descent = dimension + LANES
    reserved = 0 if first_only else min(flights // 4 // descent, DESCENTS) * descent
    searched = failure_search.search(
        record.margins,
        dimension,
        seed,
        flights=flights - reserved,
        batch=min(BATCH, flights - reserved),
        radius=radius,
        most_sigma=side,
        until_failure=first_only,
        refine=likeliest_too,
    )
    history = [float(margin) for margin in searched.history]
    domain = failure_search.Domain(side, radius)
    worse = not first_only
    while worse and record.flights + descent <= flights:
        flown = record.flights
        worse = record.descend(domain)
        if record.flights > flown + dimension:
            history.append(record.best.margin)
    return Worst(
        requirement=success_of(search.requirement),
        coordinates=search.coordinates,
        flights=record.flights,
        failing=record.failing,
        worst=record.best,
        likeliest=record.likeliest,
        history=tuple(history),
    )


def _badness(case: Case) -> float:
    return -math.inf if math.isnan(case.margin) else case.margin
