"""Audit: proof that every dispersion reaches the flight, and that it acts; and that every fixed input acts.

    read back   the numbers inside the compiled program at t = 0 equal the table: bit for bit where a draw is a number of the
                flight, by an independent formula where numbers are derived from draws
    effect      moving a single stream changes some number of the state or of the metrics
    fixed       so does switching off a single fixed input (`audit_fixed`); without a flight where its numbers show that it does
                nothing (`rvjax.simulation.effect`)

A pair of lanes flies the same sample twice, with a stream moved in the second lane. So a single chunk of the campaign's program
tries all streams. Where a pair stays equal to the last bit, other samples are tried, those with an early fault first.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import Any

import jax
import numpy as np
from numpy.typing import NDArray

from rvjax.campaign import units
from rvjax.campaign.choice import entry_names
from rvjax.campaign.draw_names import covers
from rvjax.campaign.plain_values import Place, is_list, is_mapping
from rvjax.campaign.quantity import COMPONENTS
from rvjax.campaign.thruster_layout import thruster_names
from rvjax.errors import AuditError, CampaignError
from rvjax.execution.audit_finite import refuse_lost
from rvjax.execution.audit_fixed import Probe, permitted, probes, switched_off
from rvjax.execution.audit_readback import ReadBack, readings
from rvjax.run_folder import Audited
from rvjax.simulation import effect, jax_config, scene_checks
from rvjax.simulation.batch import LANES, Flyer
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.draws import Draws
from rvjax.simulation.flight import Carry
from rvjax.simulation.problem import Problem

Values = NDArray[np.float64]

Pair = tuple[str, int]
"""What is changed in the second lane of a pair, and the sample of both lanes."""

Fly = Callable[[list[Pair]], dict[str, str]]
"""Flies pairs. Returns what acted, each with the number that it changed."""

POOL = 8 * LANES
"""Number of samples from which those for a stream are chosen."""

ROUNDS = 4
"""Largest number of rounds; later rounds try the streams without an effect on other samples."""

LOOK_S = 5.0
"""Time of flight between two checks of the effects [s]."""


@dataclass(frozen=True)
class Audit:
    """streams: number tried. columns: number read back. unlike: sentences on numbers that differ between flight and table.
    idle: stream without an effect → number of samples tried. moved: stream with an effect → the number of the state, else of a
    metric, that it changed most when the effect was first seen. fixed: number of fixed inputs that were switched off. inert:
    fixed input without an effect → why. warnings: sentences on inputs that the steps cannot follow."""

    streams: int
    columns: int
    unlike: tuple[str, ...]
    idle: Mapping[str, int]
    moved: Mapping[str, str]
    fixed: int = 0
    inert: Mapping[str, str] = field(default_factory=dict[str, str])
    warnings: tuple[str, ...] = ()

    @property
    def record(self) -> Audited:
        """The record that a run folder keeps."""
        return Audited(
            dispersions=self.streams,
            read_back=self.columns,
            acting=len(self.moved),
            idle=dict(self.idle),
            moved=dict(self.moved),
            fixed=self.fixed,
            inert=dict(self.inert),
            warnings=list(self.warnings),
        )

    def __str__(self) -> str:
        fixed = "" if not self.fixed else f"; {self.fixed} fixed input{'' if self.fixed == 1 else 's'} switched off"
        idle = [*self.idle, *self.inert]
        allowed = f"; without an effect, as allowed: {', '.join(idle)}" if idle else ""
        equal = f"audit: {self.columns} columns are equal in the flight and in the table"
        return f"{equal}; {len(self.moved)} dispersions each act alone{fixed}{allowed}"


def audit(problem: Problem, flyer: Flyer) -> Audit:
    """Flies the audit of the dispersions of a problem, with the program that flies its samples."""
    pool, _ = Draws.of(problem, np.arange(POOL, dtype=np.int64))
    unlike: dict[str, str] = {}
    columns: set[str] = set()

    def fly(pairs: list[Pair]) -> dict[str, str]:
        acted, read = _fly(problem, flyer, pairs)
        columns.update(column for reading in read for column in reading.columns)
        unlike.update({" ".join(reading.columns): sentence for reading in read if (sentence := _unlike(reading))})
        return acted

    moved, idle = _search({name: _candidates(problem, pool, name) for name in pool.streams}, fly)
    missing = set(pool.values) - columns
    unlike |= {name: f"{name}: no number of the flight shows this draw" for name in sorted(missing)}
    moved = {name: moved[name] for name in pool.streams if name in moved}
    return Audit(len(pool.streams), len(columns), tuple(unlike.values()), idle, moved)


def _search(
    waiting: dict[str, Iterator[int]], fly: Callable[[list[Pair]], dict[str, str]]
) -> tuple[dict[str, str], dict[str, int]]:
    """(what acted → the number that it changed, what did not → number of samples tried). waiting: by name, the samples on which
    it is tried."""
    tried: Counter[str] = Counter()
    moved: dict[str, str] = {}
    for _ in range(ROUNDS):
        names = list(waiting)
        for first in range(0, len(names), LANES // 2):
            group = names[first : first + LANES // 2]
            pairs = [(name, sample) for name in group for sample in islice(waiting[name], LANES // 2 // len(group))]
            if not pairs:
                continue
            acted = fly(pairs)
            tried.update(name for name, _ in pairs)
            moved |= acted
            for name in acted:
                del waiting[name]
    return moved, {name: tried[name] for name in waiting}


def audit_fixed(problem: Problem, flyer: Flyer) -> tuple[list[Probe], dict[str, int]]:
    """(the fixed inputs that were switched off, those of them without an effect → number of samples tried)."""
    pool, _ = Draws.of(problem, np.arange(POOL, dtype=np.int64))
    all_probes = {probe.name: probe for probe in probes(problem, pool.streams)}

    def fly(pairs: list[Pair]) -> dict[str, str]:
        samples, second = _lanes(pairs)
        _, drawn = Draws.of(problem, samples)
        drawn = switched_off(problem, drawn, [(all_probes[name], lanes) for name, lanes in second.items()])
        return _acted(problem, flyer, [name for name, _ in pairs], drawn)

    _, idle = _search({name: _failing(problem, pool, probe) for name, probe in all_probes.items()}, fly)
    return list(all_probes.values()), idle


def _failing(problem: Problem, pool: Draws, probe: Probe) -> Iterator[int]:
    """Samples of the pool on which a fixed input is tried. For a channel of a fault with a schedule: those in which it fails."""
    onsets = [pool.values.get(f"{problem.faults[probe.part].prefix}.onset_s.{channel}") for channel in probe.channels]
    known = [onset for onset in onsets if onset is not None]
    if not known:
        yield from range(POOL)
        return
    first = np.min(known, axis=0)
    yield from (int(sample) for sample in np.argsort(first, kind="stable")[: np.count_nonzero(np.isfinite(first))])


def prove(problem: Problem, flyer: Flyer, baseline: bool = False) -> Audit:
    """The audit of a problem whose dispersions all reach the flight and act.

    baseline: another controller flies the draws of an audited campaign. If it loses a flight before the faults begin, they have
    no effect; so only the draws of the controller have to act.

    Errors: AuditError where a number of the flight differs from the table; CampaignError naming every dispersion and every fixed
    input that does nothing and is not in audit.allow.
    """
    if not baseline and (wrong := [*effect.refused(problem), *scene_checks.findings(problem)]):
        raise CampaignError(wrong)
    result = audit(problem, flyer)
    if result.unlike:
        sentences = "\n".join(result.unlike)
        raise AuditError(f"internal error (a bug in rvjax): the flight differs from the table; please report it\n{sentences}")
    judged = [name for name in result.idle if not baseline or covers("controller", name)]
    source = problem.spec.source
    findings = [
        source.finding(_place(source.value, name), *_no_effect(name, "moving it alone", "a dispersion", result.idle[name]))
        for name in judged
        if not effect.allowed(problem, name)
    ]
    fixed, idle = ([], {}) if baseline else audit_fixed(problem, flyer)
    findings += [
        source.finding(probe.place, *_no_effect(probe.name, "switching it off", "an input", idle[probe.name]))
        for probe in fixed
        if probe.name in idle and not effect.allowed(problem, probe.name)
    ]
    if findings:
        raise CampaignError(findings)
    warnings = () if baseline else tuple(f"{finding.path}: {finding.found}" for finding in effect.warnings(problem))
    inert = {} if baseline else permitted(problem, fixed, idle)
    return replace(result, fixed=len(fixed), inert=inert, warnings=warnings)


def prove_baselines(problem: Problem) -> None:
    """The draws of each baseline controller act; those of the campaign are proved with its controller. Errors as in `prove`."""
    for baseline in problem.baselines.values():
        if any(covers("controller", name) for name in baseline.dispersions.variables):
            prove(baseline, Flyer.of(baseline), baseline=True)


def _no_effect(name: str, change: str, what: str, tried: int) -> tuple[str, str]:
    """The two halves of the finding on an input without an effect."""
    message = f"{name} does nothing: {change} changed no number in {tried} flights"
    return message, f"accepted: {what} that acts, or its name under audit.allow"


def _place(node: Any, name: str) -> Place:
    """The place of a draw in the campaign file, as far as the parts of its name lead."""
    place: Place = ()
    for step in name.split("."):
        key = _key(node, step)
        if key is None:
            break
        place, node = (*place, key), node[key]
    return place


def _key(node: Any, step: str) -> str | int | None:
    """The key (in any unit) or the index for a part of a name; None where there is none."""
    if is_mapping(node):
        stem = units.split(step)[0]
        return next((key for key in node if key == step or units.split(key)[0] == stem), None)
    if not is_list(node):
        return None
    if step in (names := entry_names(node)):
        return names.index(step)
    named = [*COMPONENTS.values(), thruster_names(len(node))]
    fitting = (components for components in named if step in components and len(components) == len(node))
    return next((components.index(step) for components in fitting), None)


def _candidates(problem: Problem, pool: Draws, name: str) -> Iterator[int]:
    """Samples of the pool on which a stream is tried. For a fault's channel: those with a fault there, the earliest onset first.
    For a schedule: sample 0, then those in which it decides on a channel, the earliest onset first."""
    fault = next((part for part in problem.faults if covers(part.prefix, name)), None)
    if fault is None:
        yield from range(POOL)
        return
    begins = f"{fault.prefix}.onset_s"
    if covers(f"{fault.prefix}.schedule", name):
        yield 0
        other = Draws.of(problem, pool.samples, {name: np.ones(POOL, dtype=bool)})[0]
        onsets = [np.minimum(x, other.values[n]) for n, x in _draws_under(begins, pool) if n in other.values]
        differ = [x != other.values[n] for n, x in _draws_under(begins, pool) if n in other.values]
        first = np.min(np.where(differ, onsets, np.inf), axis=0, initial=np.inf)
    else:
        first = pool.values.get(f"{begins}.{name.rpartition('.')[2]}", np.full(POOL, np.inf))
    known = np.isfinite(first)
    yield from (int(sample) for sample in np.argsort(first, kind="stable")[: np.count_nonzero(known)])
    if not known.any():
        yield from range(POOL)


def _draws_under(prefix: str, draws: Draws) -> list[tuple[str, Values]]:
    """The draws whose names begin with a prefix."""
    return [(name, values) for name, values in draws.values.items() if covers(prefix, name)]


def _fly(problem: Problem, flyer: Flyer, pairs: list[Pair]) -> tuple[dict[str, str], list[ReadBack]]:
    """The streams that acted in a pair, each with the number it changed; and the numbers read back from all lanes."""
    samples, moved = _lanes(pairs)
    draws, drawn = Draws.of(problem, samples, moved)
    read: list[ReadBack] = []

    def read_back(numbers: Drawn) -> None:
        if not read:
            read.extend(readings(problem, draws, numbers))

    return _acted(problem, flyer, [name for name, _ in pairs], drawn, read_back), read


def _lanes(pairs: list[Pair]) -> tuple[NDArray[np.int64], dict[str, NDArray[np.bool_]]]:
    """The sample of every lane; and, by name, the second lanes of its pairs."""
    samples = np.resize(np.repeat([sample for _, sample in pairs], 2), LANES).astype(np.int64)
    second = {name: np.zeros(LANES, dtype=bool) for name, _ in pairs}
    for place, (name, _) in enumerate(pairs):
        second[name][2 * place + 1] = True
    return samples, second


def _acted(
    problem: Problem, flyer: Flyer, names: list[str], drawn: Drawn, read_back: Callable[[Drawn], None] = lambda numbers: None
) -> dict[str, str]:
    """What acted, each with the number that it changed. names: of the pairs of lanes. read_back: gets the compiled numbers."""
    acted: dict[str, str] = {}

    def look(numbers: Drawn, carry: Carry) -> bool:
        refuse_lost(problem, numbers, carry)
        read_back(numbers)
        for name, signal in zip(names, _signals(problem, carry), strict=False):  # fewer names than pairs in the last chunk
            if signal:
                acted.setdefault(name, signal)
        return not acted.keys() >= set(names)

    steps, every = problem.spec.horizon.steps, max(1, round(LOOK_S / problem.spec.horizon.step_s))
    instants = {steps, *range(every, steps, every), *(step for step in (1, 10) if step < steps)}
    flyer.watch(drawn, sorted(instants), look)
    return acted


def _signals(problem: Problem, carry: Carry) -> list[str]:
    """For each pair the number that differs most between its lanes, relative to its largest value in any lane; empty where all
    are equal to the last bit. Numbers of the state, a discrete-time controller's too, go before those of the metrics."""
    signals = [""] * (LANES // 2)
    accumulators = {next(iter(metric.columns)): state for metric, state in zip(problem.metrics, carry.accumulators, strict=True)}
    for part in (carry.y, {"controller": carry.held.control}, accumulators, {"lost_s": carry.lost_s}):
        if not (numbers := jax.tree_util.tree_flatten_with_path(part)[0]):
            continue
        paths, leaves = zip(*numbers, strict=True)
        shares = np.stack([_shares(leaf) for leaf in leaves])
        for pair, (place, share) in enumerate(zip(np.argmax(shares, axis=0), np.max(shares, axis=0), strict=True)):
            if not signals[pair] and share >= 0.0:
                signals[pair] = jax.tree_util.keystr(paths[place], simple=True, separator=".")
    return signals


def _shares(leaf: Values) -> Values:
    """(pairs,) difference between the lanes of a pair over the largest value in any lane; −1 where they are equal. Of an array in
    every lane that of the entry with the largest."""
    if leaf.ndim > 1:
        return np.max([_shares(entry) for entry in leaf.reshape(len(leaf), -1).T], axis=0)
    first, second = leaf[0 : LANES // 2 * 2 : 2], leaf[1 : LANES // 2 * 2 : 2]
    same = (first == second) | (np.isnan(first) & np.isnan(second))
    with np.errstate(invalid="ignore", over="ignore"):
        share = np.abs(first - second) / np.max(np.abs(leaf[np.isfinite(leaf)]), initial=np.finfo(leaf.dtype).tiny)
    return np.where(same, -1.0, np.where(np.isnan(share), np.inf, share))


def _unlike(reading: ReadBack) -> str:
    """A sentence on a number that differs between flight and table; empty where they agree."""
    digits = np.finfo(jax_config.precision()).eps
    table = reading.table.astype(jax_config.precision()) if reading.exact else reading.table
    inside = np.asarray(reading.inside, dtype=np.float64)
    room = 0.0 if reading.exact else 64.0 * digits * max(1.0, reading.size, float(np.max(np.abs(table))))
    with np.errstate(invalid="ignore"):
        wrong = ~((np.abs(inside - table) <= room) | (inside == table))
    if not wrong.any():
        return ""
    first = int(np.argmax(wrong))
    return f"{', '.join(reading.columns)}: the table says {table[first]:.17g}, the flight has {inside[first]:.17g}"
