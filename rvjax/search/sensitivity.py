"""Which groups of draws matter, by further flights (`rvjax.stats.pick_freeze`).

    row i:  A_i = sample i,   B_i = sample n + i,   C_gi = sample i with every number of group g from sample n + i

Groups are the sections of a campaign, each fault, and all noise in flight; draws that are correlated, or redrawn together, join
theirs.
The streams of a sample belong to groups by their names, so C_gi differs from A_i in nothing but group g, to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.analysis import drivers
from rvjax.analysis.drivers import Result
from rvjax.campaign import Source
from rvjax.campaign.draw_names import covers
from rvjax.columns import METRIC
from rvjax.components.samplers import sampling_design_of
from rvjax.components.samplers.interface import Samples
from rvjax.errors import CampaignError, UsageError
from rvjax.execution.chunks import ENVELOPE_INSTANTS
from rvjax.execution.executors.threads import map_in_threads
from rvjax.simulation import jax_config, tables
from rvjax.simulation.batch import LANES, Flown, Flyer, devices
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem, load
from rvjax.stats.pick_freeze import GroupIndices, OverTime, RunningSums, indices, most_that_matter, over_time, ranks
from rvjax.stats.random_streams import uniforms
from rvjax.stats.sampling_design import Independent

NOISE = "noise in flight"
FIRST, SECOND = "A=", "B="
"""Names of the sets A and B among those of the groups, which cannot have a `=`."""
FEWEST_ROWS = 30
SIGNALS = {"position error": "rho", "attitude error": "sigma"}
"""Of the envelope of a flight, by their words."""

Values = NDArray[np.float64]
Swaps = Callable[[str], bool]


@dataclass(frozen=True)
class ResultIndices:
    """name; kind: `failures`, `rank score` (lost flights worst), `finite values`; groups: the indices of each group."""

    name: str
    kind: str
    groups: Mapping[str, GroupIndices]


@dataclass(frozen=True)
class Sensitivity:
    """groups: the streams of each, by its name; rows, flights; results; constant: results that no flight changes; unchanged: of
    each group the largest share of flights in which it can matter, None where it changed a bit of one; curves: of each signal
    and group, over `times_s`."""

    groups: Mapping[str, tuple[str, ...]]
    rows: int
    flights: int
    results: tuple[ResultIndices, ...]
    constant: tuple[str, ...]
    unchanged: Mapping[str, float | None]
    times_s: Values
    curves: Mapping[str, Mapping[str, OverTime]]


@dataclass(frozen=True)
class _Mixed:
    """A sampler whose streams come from other samples where `swaps` says so. other: by what number later these are."""

    seed: int
    swaps: Swaps
    other: int

    def at(self, samples: Samples) -> _MixedPoints:
        return _MixedPoints(self, samples)

    def noise(self, samples: Samples, stream: str) -> Samples:
        """(samples,) those whose numbers of this stream these samples have."""
        return samples + (self.other if self.swaps(stream) else 0)


@dataclass(frozen=True)
class _MixedPoints:
    sampler: _Mixed
    samples: Samples = field(repr=False)

    def uniforms(self, name: str, count: int) -> Values:
        return uniforms(self.sampler.seed, name, self.sampler.noise(self.samples, name))[:, :count]

    def prescribed(self, name: str) -> None:
        """No draw is prescribed."""


def mixed_draws(problem: Problem, samples: Samples, swaps: Swaps, other: int) -> tuple[Draws, Any]:
    """The draws of these samples, those streams that `swaps` names from the samples `other` later."""
    mixed = _Mixed(problem.spec.seed, swaps, other)
    return Draws.of(replace(problem, dispersions=replace(problem.dispersions, sampler=mixed)), samples)


def groups_of(problem: Problem, given: Mapping[str, Sequence[str]] | None = None) -> dict[str, tuple[str, ...]]:
    """The streams of each group. given: the user's groups, each the beginnings of names of draws.

    UsageError for a name that no stream has, one in two groups, a group named like a section that has other draws too, or groups
    that share correlated draws.
    """
    streams = list(Draws.of(problem, np.arange(1, dtype=np.int64))[0].streams)
    place = {name: _section(name) for name in streams}
    for group, beginnings in (given or {}).items():
        for beginning in beginnings:
            covered = [name for name in streams if covers(beginning, name)]
            if not covered:
                accepted = f"accepted: beginnings of {', '.join(streams[:3])} …"
                raise UsageError(f"--group {group}: no draw begins with {beginning}; {accepted}")
            if taken := [name for name in covered if place[name] in (given or {}) and place[name] != group]:
                raise UsageError(f"--group {group}: {taken[0]} is in the group {place[taken[0]]} too; accepted: one group each")
            place |= dict.fromkeys(covered, group)
    chosen = [beginning for beginnings in (given or {}).values() for beginning in beginnings]
    for group in given or {}:
        if others := [name for name in streams if _section(name) == group and not any(covers(each, name) for each in chosen)]:
            accepted = f"accepted: another name, or {group} with all of its draws"
            raise UsageError(f"--group {group}: the group of a section, with {others[0]} in it as well; {accepted}")
    together = [group.names for group in problem.dispersions.groups]
    together += [tuple(retry.counts) for retry in problem.dispersions.retries]
    for names in together:
        joined = sorted({place[name] for name in names if name in place})
        if len(joined) > 1:
            name = " + ".join(joined)
            place = {stream: name if group in joined else group for stream, group in place.items()}
    found: dict[str, list[str]] = {}
    for name, group in place.items():
        found.setdefault(group, []).append(name)
    return {name: tuple(streams) for name, streams in found.items()}


def _section(name: str) -> str:
    """The group of a stream by default."""
    steps = name.split(".")
    if steps[-1] == "noise":
        return NOISE
    return ".".join(steps[:2]) if steps[0] == "faults" else steps[0]


@dataclass
class _Rows:
    """What the flights of some rows gave: frame and outcomes of each set, and sums over time."""

    frames: dict[str, pd.DataFrame]
    shared: dict[tuple[str, str], RunningSums]
    kept: dict[tuple[str, str], RunningSums]


class SensitivityFlights:
    """A campaign, its groups, and the flights of its rows."""

    def __init__(self, problem: Problem, groups: Mapping[str, Sequence[str]]) -> None:
        self.problem, self.groups = problem, groups
        self._flyer = Flyer.of(problem)
        steps = problem.spec.horizon.steps
        self._every = max(1, -(-steps // ENVELOPE_INSTANTS))
        self.instants = np.append(np.arange(0, steps, self._every), steps) * problem.spec.horizon.step_s

    def fly(self, rows: int, on_progress: Callable[[int], None] = lambda flights: None) -> _Rows:
        """All flights of `rows` rows, A, B and C of each group."""
        total, done = _Rows({}, {}, {}), [0]
        parts: list[_Rows] = []

        def took(part: _Rows) -> None:
            done[0] += (len(self.groups) + 2) * len(next(iter(part.frames.values())))
            parts.append(part)
            on_progress(done[0])

        starts = list(range(0, rows, LANES))
        map_in_threads(lambda first: self._rows(first, min(LANES, rows - first), rows), starts, took, self._flyer.stop)
        ordered = sorted(parts, key=lambda part: int(part.frames[FIRST]["sample"].iloc[0]))
        for part in ordered:
            for sums, theirs in ((total.shared, part.shared), (total.kept, part.kept)):
                for key, other in theirs.items():
                    mine = sums.setdefault(key, RunningSums(other.bins))
                    mine.n += other.n
                    mine.sums += other.sums
        for name in ordered[0].frames:
            total.frames[name] = pd.concat([part.frames[name] for part in ordered], ignore_index=True)
        return total

    def _rows(self, first: int, count: int, rows: int) -> _Rows:
        frames: dict[str, pd.DataFrame] = {}
        envelopes: dict[str, dict[str, Values]] = {}
        for name in (FIRST, SECOND, *self.groups):
            chosen = set(self.groups.get(name, ()))
            swaps: Swaps = (lambda stream: True) if name == SECOND else chosen.__contains__
            frames[name], flown = self._fly(first, count, rows, swaps)
            envelopes[name] = {
                words: np.stack([getattr(point, key)[:count] for point in flown.envelope], axis=1)
                for words, key in SIGNALS.items()
            }
        shared: dict[tuple[str, str], RunningSums] = {}
        kept: dict[tuple[str, str], RunningSums] = {}
        for words in SIGNALS:
            for group in self.groups:
                for sums, base in ((shared, SECOND), (kept, FIRST)):
                    sums[words, group] = RunningSums(envelopes[base][words].shape[1])
                    sums[words, group].add(envelopes[base][words], envelopes[group][words])
        return _Rows(frames, shared, kept)

    def _fly(self, first: int, count: int, rows: int, swaps: Swaps) -> tuple[pd.DataFrame, Flown]:
        samples = first + np.arange(self._flyer.lanes(count), dtype=np.int64) % count
        draws, drawn = mixed_draws(self.problem, samples, swaps, rows)
        horizon = self.problem.spec.horizon
        flown = self._flyer.fly(drawn, horizon.steps, self._every, with_envelope=True, device=devices()[0])
        frame, _ = tables.samples_table(self.problem, draws, flown, slice(0, count))
        return frame, flown


def prepare(
    path: str | Path | Source, overrides: Sequence[str] = (), given: Mapping[str, Sequence[str]] | None = None
) -> SensitivityFlights:
    """The flights of a campaign. given: the user's groups. CampaignError with every finding, also where nothing is drawn or the
    sampler is none of independent samples; UsageError as of `groups_of`."""
    problem = load(path, overrides)
    if not isinstance(sampling_design_of(problem.spec), Independent):
        message = f"{problem.spec.sampler.use} decides draws together, so that no group can be exchanged alone"
        raise CampaignError([problem.spec.source.finding(("sampler",), message, "accepted: sampler: {use: monte-carlo}")])
    jax_config.configure(problem.spec.precision)
    groups = groups_of(problem, given)
    if not groups:
        raise CampaignError([problem.spec.source.finding((), "nothing is drawn", "accepted: a campaign with a distribution")])
    return SensitivityFlights(problem, groups)


def sensitivity(
    flights: SensitivityFlights,
    rows: int,
    metrics: Sequence[str] = (),
    confidence: float = 0.95,
    on_progress: Callable[[int], None] = lambda flights: None,
) -> Sensitivity:
    """Flies rows · (G + 2) flights and gives the indices of each group. metrics: by default those of the requirements, the
    settling time and the position error over the closing window. UsageError for fewer than 30 rows or an unknown metric."""
    problem = flights.problem
    if rows < FEWEST_ROWS:
        raise UsageError(f"{rows} rows; accepted: {FEWEST_ROWS} or more")
    known = [name for name in problem.metric_columns if name != "captured"]
    if unknown := [name for name in metrics if name not in known]:
        raise UsageError(f"--result {unknown[0]}: no metric of this campaign; accepted: {', '.join(known)}")
    required = [requirement.metric for requirement in problem.spec.require]
    chosen = metrics or [name for name in known if name in {*required, "settling_time_s", "window_position_error_m"}]
    came = flights.fly(rows, on_progress)
    rng = np.random.Generator(np.random.Philox(key=0))
    parts = list(_results(problem, came.frames, chosen))
    constant = tuple(name for name, _, sets in parts if len({x for part in sets.values() for x in part.values.tolist()}) == 1)
    found = [result for part in parts if part[0] not in constant for result in _indices(*part, confidence, rng)]
    unchanged = {
        group: most_that_matter(_same(came.frames[FIRST], came.frames[group]), rows, confidence) for group in flights.groups
    }
    curves = {
        words: {group: over_time(came.shared[words, group], came.kept[words, group]) for group in flights.groups}
        for words in SIGNALS
    }
    groups = {name: tuple(streams) for name, streams in flights.groups.items()}
    return Sensitivity(groups, rows, rows * (len(groups) + 2), tuple(found), constant, unchanged, flights.instants, curves)


def _same(a: pd.DataFrame, c: pd.DataFrame) -> int:
    """The number of rows whose outcome and every metric have the same bits."""
    names = ["outcome", *(name for name in a.columns if str(name).startswith(METRIC))]
    equal = [(a[name] == c[name]) | (a[name].isna() & c[name].isna()) for name in names]
    return int(np.count_nonzero(np.all(equal, axis=0)))


def _results(
    problem: Problem, frames: Mapping[str, pd.DataFrame], metrics: Sequence[str]
) -> Iterable[tuple[str, bool, dict[str, Result]]]:
    """Of each result: its name, whether it is an indicator, and the values of each set."""
    failing = {name: drivers.failures(frame, problem.spec.require) for name, frame in frames.items()}
    for place, result in enumerate(failing[FIRST]):
        yield result.name, True, {name: parts[place] for name, parts in failing.items()}
    columns = {f"{METRIC}{name}": column for name, column in problem.metric_columns.items()}
    for metric in metrics:
        values = {name: drivers.metrics(frame, columns, [metric])[0] for name, frame in frames.items()}
        yield metric, False, values


def _indices(
    name: str, indicator: bool, sets: Mapping[str, Result], confidence: float, rng: np.random.Generator
) -> list[ResultIndices]:
    a, b = sets[FIRST].values, sets[SECOND].values
    swapped = {group: result.values for group, result in sets.items() if group not in (FIRST, SECOND)}
    if indicator:
        return [ResultIndices(name, "failures", indices(a, b, swapped, confidence, rng=rng))]
    scores = ranks(a, b, swapped)
    return [
        ResultIndices(name, "rank score", indices(*scores, confidence, rng=rng)),
        ResultIndices(name, "finite values", indices(a, b, swapped, confidence, rng=rng)),
    ]
