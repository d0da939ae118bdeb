"""The worst draws: a search over what a campaign draws for the smallest margin of a requirement.

    z ∈ R^d ─Φ→ u ∈ (0, 1)^d ─laws→ draws ─fly→ metric ─margin→ g(z), below 0 where the flight does not comply

    requirement            margin of one flight
    captured               −log₁₀ of the larger of the errors over the closing window, each in radii of its tube
    metric below v         (v − x)/|v|; where x is infinite, −1 − log₁₀(1 + position error over the closing window, in tubes)
    metric above v         (x − v)/|v|
    at_most                with the other sign: what shall hardly ever happen
    outside of `where`     +∞;  a flight that was lost: −∞;  a body that cannot exist: +∞

z is standard normal, so |z| says how improbable a point is, whatever the laws. Noise in flight is that of sample 0 throughout: a
flight is a function of z. After the searches the worst case goes down the gradient of its margin, where the metric has one, LANES
lengths of a step at once. What is found is written as a campaign whose sampler gives these very numbers, and flown again from
there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import special

from rvjax.analysis.verdicts.compliance import RequirementEvaluator
from rvjax.analysis.verdicts.sentences import success_of
from rvjax.campaign import Requirement
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.draw_names import covers
from rvjax.campaign.export import campaign_text
from rvjax.columns import METRIC, draw_column, metric_column
from rvjax.components.samplers.interface import Samples
from rvjax.components.samplers.uniforms_table import Block, columns_of
from rvjax.errors import UsageError
from rvjax.execution.chunks import STRETCH
from rvjax.execution.executors.threads import map_in_threads
from rvjax.run_folder import atomic_files
from rvjax.search import failure_search
from rvjax.simulation import jax_config, tables
from rvjax.simulation.batch import LANES, Flyer, Tangents, devices
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem, load
from rvjax.simulation.requirement_checks import counted

Values = NDArray[np.float64]

REACH = 1e-4
"""Difference of z over which the numbers that fly are differenced."""

LENGTHS = np.geomspace(1e-3, 4.0, LANES)
"""Of the steps down a gradient that are tried at once."""

BATCH = 4 * LANES
"""Flights at once, the same on every machine: what is searched depends on it."""

DESCENTS = 8
"""Steps down the gradient at most, from the worst case that the searches have found."""

BEYOND = 1e-6
"""Probability that a sample is outside of the ball that is searched by default."""

CAMPAIGN, POINTS = "worst.yaml", "worst.csv"

FLAT = 1e3
"""Margin of a flight whose metric is infinite in a metric that has no other measure."""


@dataclass(frozen=True)
class Coordinate:
    """Where a number of a variable stands. name: of its column in a table of points."""

    variable: str
    name: str


@dataclass(frozen=True)
class Case:
    """A flight. z: its point; margin; draws and values of the metrics by name, in SI; outcome; distance: |z|."""

    z: Values
    margin: float
    draws: Mapping[str, float]
    values: Mapping[str, float]
    outcome: str

    def frame(self, other: Mapping[str, float]) -> pd.DataFrame:
        """Its row of a table, with other values of some metrics."""
        values = {metric_column(name): value for name, value in {**self.values, **other}.items()}
        return pd.DataFrame([{"outcome": self.outcome, **values, **{draw_column(name): x for name, x in self.draws.items()}}])

    @property
    def distance(self) -> float:
        """|z|"""
        return float(np.linalg.norm(self.z))


@dataclass(frozen=True)
class Worst:
    """What a search of the draws found. worst: the smallest margin; likeliest: of the flights that do not comply the one nearest
    to the middle of the draws; None where all comply. failing: how many of the flights do not comply. history: the smallest
    margin of each batch."""

    requirement: str
    coordinates: tuple[Coordinate, ...]
    flights: int
    failing: int
    worst: Case
    likeliest: Case | None
    history: tuple[float, ...]


@dataclass(frozen=True)
class Fixed:
    """A sampler of points that are given, whatever the numbers of the samples."""

    seed: int
    numbers: Mapping[str, Values]

    def at(self, samples: Samples) -> Block:
        """The points."""
        return Block(self.seed, samples, self.numbers)


class WorstCaseSearch:
    """A campaign, and the coordinates of its draws that are searched; the others stay at their medians."""

    def __init__(self, problem: Problem, requirement: Requirement, vary: Sequence[str] = ()) -> None:
        self.problem, self.requirement = problem, requirement
        self._reading = RequirementEvaluator(requirement)
        self._columns = {metric_column(name): column for name, column in problem.metric_columns.items()}
        self._reading.columns(
            [*self._columns, *(draw_column(name) for name in (*problem.dispersions.columns, *counted(problem.spec)))]
        )
        laws: Mapping[str, Any] = {name: variable.law for name, variable in problem.dispersions.variables.items()}
        self._counts = {name: law.uniforms for name, law in laws.items()}
        chosen = [name for name in laws if not vary or any(covers(one, name) for one in vary)]
        self.coordinates = tuple(Coordinate(name, own) for name in chosen for own in columns_of(name, self._counts[name]))
        self._flyer = Flyer(problem.loop, problem.metrics)
        self._tangents: dict[str, Tangents] = {}

    def fly(self, z: Values) -> list[Case]:
        """One case for each row of z."""
        found: list[list[Case]] = []
        parts = [z[first : first + LANES] for first in range(0, len(z), LANES)]
        map_in_threads(self._chunk, parts, found.append, self._flyer.stop)
        return [case for part in found for case in part]

    def _chunk(self, z: Values) -> list[Case]:
        draws, drawn = self._draws(np.vstack([z, np.repeat(z[:1], LANES - len(z), axis=0)]))
        horizon = self.problem.spec.horizon
        came = tables.outcomes(self._flyer.fly(drawn, horizon.steps, STRETCH, device=devices()[0]), horizon.duration_s)
        frame = pd.DataFrame(came | {draw_column(name): values for name, values in draws.values.items()})
        margins = np.where(self._exist(draws), self.margins(frame), math.inf)
        return [
            Case(
                z[row],
                float(margins[row]),
                {name: float(values[row]) for name, values in draws.values.items()},
                {name: float(came[metric_column(name)][row]) for name in self.problem.metric_columns},
                str(came["outcome"][row]),
            )
            for row in range(len(z))
        ]

    def _draws(self, z: Values) -> tuple[Draws, Any]:
        """The draws of points, all with the noise of sample 0."""
        dispersions = replace(self.problem.dispersions, sampler=Fixed(self.problem.spec.seed, self.numbers(z)))
        return Draws.of(replace(self.problem, dispersions=dispersions), np.zeros(len(z), dtype=np.int64))

    def slope(self, case: Case) -> Values:
        """(d,) the gradient of the margin at a case: of its metric through every step of the flight, a lane for each coordinate;
        0 where the metric has none, as a settling time."""
        name = self._slope_of(case)
        if name is None:
            return np.zeros(len(case.z))
        metric = next(one for one in self.problem.metrics if name in one.columns)
        program = self._tangents.setdefault(name, Tangents(self.problem.loop, metric, name))
        count, steps = len(case.z), self.problem.spec.horizon.steps
        (_, high), (_, low) = (self._draws(case.z + sign * REACH * np.eye(count)) for sign in (1.0, -1.0))
        own = self._draws(np.repeat(case.z[None], count, axis=0))[1]
        tangent = jax.tree.map(lambda a, b: (a - b) / (2.0 * REACH), high, low)
        slopes = program.fly(own, tangent, steps) * self._rise(case, name)
        return np.where(np.isfinite(slopes), slopes, 0.0)

    def _slope_of(self, case: Case) -> str | None:
        """The metric that decides the margin of a case."""
        if case.outcome == "not_finite" or not math.isfinite(case.margin):
            return None
        if self.requirement.metric != "captured":
            return self._reading.column.removeprefix(METRIC)
        names = ("window_position_error_m", "window_attitude_error_deg")
        falls = [self.margins(case.frame({name: 1.01 * case.values[name]}))[0] for name in names]
        return names[int(np.argmin(falls))]

    def _rise(self, case: Case, name: str) -> float:
        """d margin / d metric at a case."""
        x = case.values[name]
        step = 1e-6 * (abs(x) or 1.0)
        high, low = (float(self.margins(case.frame({name: x + sign * step}))[0]) for sign in (1.0, -1.0))
        return (high - low) / (2.0 * step)

    def numbers(self, z: Values) -> dict[str, Values]:
        """(n, count) uniform numbers of every variable at points (n, d)."""
        inside = np.clip(special.ndtr(z), np.finfo(float).tiny, np.nextafter(1.0, 0.0))
        found = {name: np.full((len(z), count), 0.5) for name, count in self._counts.items()}
        place = {(name, own): k for name, count in self._counts.items() for k, own in enumerate(columns_of(name, count))}
        for column, one in zip(inside.T, self.coordinates, strict=True):
            found[one.variable][:, place[one.variable, one.name]] = column
        return found

    @staticmethod
    def _exist(draws: Draws) -> NDArray[np.bool_]:
        rejected = [values for name, values in draws.values.items() if name.endswith(".rejected")]
        return np.all([values == 0 for values in rejected], axis=0) if rejected else np.ones(len(draws.samples), dtype=bool)

    def margins(self, frame: pd.DataFrame) -> Values:
        """(n,) margins of flights; NaN of a flight that was lost."""
        one, capture = self.requirement, self.problem.spec.capture
        position = frame[metric_column("window_position_error_m")].to_numpy(dtype=float) / capture.position_m
        if one.metric == "captured":
            turn = (
                np.tan(np.radians(frame[metric_column("window_attitude_error_deg")].to_numpy(dtype=float)) / 4.0)
                / capture.attitude_mrp
            )
            margin = -np.log10(np.maximum(np.maximum(position, turn), 1e-12))
        else:
            x = self._reading.values(frame, self._columns)
            limit, sign = self._reading.bound.value, self._reading.bound.sign
            never = -1.0 - np.log10(1.0 + np.where(np.isfinite(position), position, FLAT))
            margin = np.where(np.isinf(x), sign * np.sign(x) * never, sign * (limit - x) / (abs(limit) or 1.0))
            margin = -margin if one.at_most is not None else margin
        return np.where(self._reading.chosen(frame), np.where(frame["outcome"] == "not_finite", np.nan, margin), math.inf)


def prepare(path: str | Path, overrides: Sequence[str] = (), number: int = 1, vary: Sequence[str] = ()) -> WorstCaseSearch:
    """What is searched. number: of the requirement, from 1. vary: beginnings of names of draws; all by default.

    CampaignError with every finding; UsageError where there is no such requirement, no such draw, or nothing is drawn.
    """
    problem = load(path, overrides)
    required = problem.spec.require
    if not 1 <= number <= len(required):
        accepted = f"1 to {len(required)}" if required else "none, the campaign requires nothing"
        raise UsageError(f"{path}: there is no requirement {number}; accepted: {accepted}")
    if required[number - 1].mean:
        raise UsageError(f"{path}: requirement {number} is on a mean, which no flight meets by itself; accepted: another one")
    names = list(problem.dispersions.variables)
    for one in vary:
        if not any(covers(one, name) for name in names):
            raise UsageError(f"--vary {one}: no draw of this campaign; {did_you_mean(one, names)}")
    if not names:
        raise UsageError(f"{path}: nothing is drawn; accepted: a campaign with at least one distribution")
    return WorstCaseSearch(problem, required[number - 1], vary)


def find_worst_case(
    path: str | Path,
    requirement: int = 1,
    overrides: Sequence[str] = (),
    *,
    flights: int = 20_000,
    vary: Sequence[str] = (),
    seed: int = 0,
    radius: float | None = None,
) -> Worst:
    """Searches the draws of a campaign for the smallest margin of a requirement.

    requirement: its number, from 1. flights: the largest number flown. vary: prefixes of the draws that are searched, by default
    all. radius: |z| ≤ radius in standard normal coordinates; by default a sample in a million is outside.

    Errors: those of `prepare`.
    """
    return worst(prepare(path, overrides, requirement, vary), flights, seed, radius=radius)


def worst(
    hunt: WorstCaseSearch,
    flights: int,
    seed: int = 0,
    *,
    radius: float | None = None,
    box: float | None = None,
    first_only: bool = False,
    likeliest_too: bool = False,
    told: Callable[[int, float], None] = lambda flights, margin: None,
) -> Worst:
    """Flies at most so many flights. radius: |z| is at most that; by default what one sample in a million is beyond. box: each
    coordinate is at most that, in the place of a ball. first_only: ends with the first flight that does not comply.
    likeliest_too: after one, the searches go on for the nearest one, not for the worst. told: called with the flights so far and
    the smallest margin. UsageError for both a radius and a box."""
    if radius is not None and box is not None:
        raise UsageError("both a radius and a box; accepted: one of them")
    if radius is None and box is None:
        radius = math.sqrt(float(special.chdtri(len(hunt.coordinates), BEYOND)))
    jax_config.configure(hunt.problem.spec.precision)
    best: list[Case] = []
    likeliest: list[Case] = []
    failing = done = 0

    def margin(z: Values) -> Values:
        nonlocal failing, done
        cases = hunt.fly(z)
        found = np.array([case.margin for case in cases])
        failed = [case for case in cases if not case.margin >= 0.0]
        failing, done = failing + len(failed), done + len(cases)
        best[:] = [min([*best, *cases], key=_badness)]
        likeliest[:] = sorted([*likeliest, *failed], key=lambda case: case.distance)[:1]
        told(done, best[0].margin)
        return found

    dimension, side = len(hunt.coordinates), box or failure_search.FARTHEST
    descent = dimension + LANES
    spared = 0 if first_only else min(flights // 4 // descent, DESCENTS) * descent
    batch = min(BATCH, flights - spared)
    spent, how = flights - spared, {"until_failure": first_only, "refine": likeliest_too}
    found = failure_search.search(margin, dimension, seed, spent, batch, radius, side, **how)
    history = [float(x) for x in found.history]
    while done + descent <= flights and not first_only:
        slope = hunt.slope(best[0])
        done += dimension
        if not (length := float(np.linalg.norm(slope))) > 0.0:
            break
        before = _badness(best[0])
        margin(failure_search.Domain(side, radius).inside(best[0].z - LENGTHS[:, None] * slope / length))
        history.append(best[0].margin)
        if not _badness(best[0]) < before:
            break
    return Worst(
        success_of(hunt.requirement),
        hunt.coordinates,
        done,
        failing,
        best[0],
        likeliest[0] if likeliest else None,
        tuple(history),
    )


def export(hunt: WorstCaseSearch, found: Worst, folder: Path, overrides: Sequence[str] = ()) -> Path:
    """Writes the cases found as a campaign of few samples, the worst first, with the numbers that decide their draws; returns its
    path. With noise in flight only the worst one, which is sample 0, has the noise that it was found with."""
    spec = hunt.problem.spec
    noisy = any(part.noisy for part in (*hunt.problem.disturbances, *hunt.problem.navigation))
    noisy |= any(part.schedule is not None for part in hunt.problem.faults)  # whose lots are those of a sample
    cases = [found.worst]
    if found.likeliest is not None and found.likeliest.margin != found.worst.margin and not noisy:
        cases.append(found.likeliest)
    numbers = hunt.numbers(np.array([case.z for case in cases]))
    table = {column: block[:, k] for name, block in numbers.items() for k, column in enumerate(columns_of(name, block.shape[1]))}
    lines = [",".join(table), *(",".join(repr(float(values[row])) for values in table.values()) for row in range(len(cases)))]
    with atomic_files.explained(folder):
        folder.mkdir(parents=True, exist_ok=True)
    points = POINTS
    while points in spec.source.inputs:
        points = f"found-{points}"
    atomic_files.replace(folder / points, ("\n".join(lines) + "\n").encode())
    for name, content in spec.source.inputs.items():
        atomic_files.replace(folder / name, content)
    drawn = sorted({name.partition(".")[0] for name in numbers})  # one flight proves of no draw that it acts
    sets = [
        *overrides,
        f"audit={{allow: [{', '.join(drawn)}]}}",
        f"samples={len(cases)}",
        f"sampler={{use: points, csv: {points}}}",
        "keep={all: true}",
    ]
    said = f"the worst flight of {found.flights} that `rvjax worst` flew is sample 0, its margin {found.worst.margin:.6g}"
    comment = f"{found.requirement}: {said}."
    text = campaign_text(spec, sets, ("require", "tune", "baselines"), "-worst", comment)
    path = folder / CAMPAIGN
    atomic_files.replace(path, text.encode())
    return path


def _badness(case: Case) -> float:
    return -math.inf if math.isnan(case.margin) else case.margin
