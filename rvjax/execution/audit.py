"""Audit: proof that every dispersion reaches the flight, and that it acts.

    reading   what the compiled program has in hand at t = 0 is what the table says: bit for bit where a draw is a number of the
              flight, and by an independent formula where numbers are derived from it
    effect    a stream moved alone, everything else as it was, changes some number of the state or of the metrics

A pair of lanes flies one sample twice, once with one stream moved; so all streams are tried in one chunk of the campaign's own
program. Where a pair stays equal to the last bit, other samples are tried, those first in which a fault begins early.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
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
from rvjax.execution.audit_readback import ReadBack, readings
from rvjax.run_folder import Audited
from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES, Flyer
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.draws import Draws
from rvjax.simulation.flight import Carry
from rvjax.simulation.problem import Problem

Values = NDArray[np.float64]

POOL = 8 * LANES
"""Samples out of which those are taken that a stream is tried on."""

ROUNDS = 4
"""Chunks that are flown at most; the later ones try those streams again that had no effect."""

LOOK_S = 5.0
"""Time of flight between two looks at whether every stream has had its effect [s]."""


@dataclass(frozen=True)
class Audit:
    """streams: how many were tried; columns: how many were read back. unlike: what the flight has in another way than the table,
    in words. idle: the streams without an effect, with the number of samples that each was tried on. moved: the others, each with
    the number of the state, or else of a metric, that it changed most where it was first seen to."""

    streams: int
    columns: int
    unlike: tuple[str, ...]
    idle: Mapping[str, int]
    moved: Mapping[str, str]

    @property
    def record(self) -> Audited:
        """What a run folder keeps of it."""
        return Audited(
            dispersions=self.streams,
            read_back=self.columns,
            acting=len(self.moved),
            idle=dict(self.idle),
            moved=dict(self.moved),
        )

    def __str__(self) -> str:
        allowed = f"; without an effect, as allowed: {', '.join(self.idle)}" if self.idle else ""
        told = f"audit: {self.columns} columns are in the flight what the table says"
        return f"{told}; {len(self.moved)} dispersions each act alone{allowed}"


def audit(problem: Problem, flyer: Flyer) -> Audit:
    """Flies the audit of a problem, with the program that flies its samples."""
    pool, _ = Draws.of(problem, np.arange(POOL, dtype=np.int64))
    waiting = {name: _candidates(problem, pool, name) for name in pool.streams}
    tried: Counter[str] = Counter()
    unlike: dict[str, str] = {}
    columns: set[str] = set()
    moved: dict[str, str] = {}
    for _ in range(ROUNDS):
        names = list(waiting)
        for first in range(0, len(names), LANES // 2):
            group = names[first : first + LANES // 2]
            pairs = [(name, sample) for name in group for sample in islice(waiting[name], LANES // 2 // len(group))]
            if not pairs:
                continue
            acted, read = _fly(problem, flyer, pairs)
            tried.update(name for name, _ in pairs)
            columns |= {column for reading in read for column in reading.columns}
            unlike |= {" ".join(reading.columns): found for reading in read if (found := _unlike(reading))}
            moved |= acted
            for name in acted:
                del waiting[name]
    idle = {name: tried[name] for name in waiting}
    missing = set(pool.values) - columns
    unlike |= {name: f"{name}: nothing tells what the flight has of it" for name in sorted(missing)}
    moved = {name: moved[name] for name in pool.streams if name in moved}
    return Audit(len(pool.streams), len(columns), tuple(unlike.values()), idle, moved)


def prove(problem: Problem, flyer: Flyer, baseline: bool = False) -> Audit:
    """The audit of a problem whose dispersions all reach the flight and act.

    baseline: another controller on the draws of a campaign whose audit is done. Under a law that loses a flight before its faults
    come they do nothing, so only the controller's own draws have to act.

    Errors: AuditError where the flight has other numbers than the table; CampaignError naming every dispersion that does nothing
    and is not allowed to.
    """
    found = audit(problem, flyer)
    if found.unlike:
        raise AuditError("what flies is not what the table says; please report this\n" + "\n".join(found.unlike))
    source, allowed = problem.spec.source, problem.spec.audit.allow
    judged = [name for name in found.idle if not baseline or covers("controller", name)]
    if wrong := [name for name in judged if not any(covers(one, name) for one in allowed)]:
        raise CampaignError(source.finding(_place(source.value, name), *_words(name, found.idle[name])) for name in wrong)
    return found


def _words(name: str, tried: int) -> tuple[str, str]:
    found = f"{name} does nothing: moving it alone changed no number in {tried} flights"
    return found, "accepted: a dispersion that acts, or its name under audit.allow"


def _place(said: Any, name: str) -> Place:
    """Where a campaign says something of a draw: as far as the steps of its name lead."""
    place: Place = ()
    for step in name.split("."):
        key = _key(said, step)
        if key is None:
            break
        place, said = (*place, key), said[key]
    return place


def _key(said: Any, step: str) -> str | int | None:
    """The key, in whatever unit, or the index that a step of a name means; None where it leads nowhere."""
    if is_mapping(said):
        stem = units.split(step)[0]
        return next((key for key in said if key == step or units.split(key)[0] == stem), None)
    if not is_list(said):
        return None
    if step in (names := entry_names(said)):
        return names.index(step)
    named = [*COMPONENTS.values(), thruster_names(len(said))]
    fitting = (components for components in named if step in components and len(components) == len(said))
    return next((components.index(step) for components in fitting), None)


def _candidates(problem: Problem, pool: Draws, name: str) -> Iterator[int]:
    """Samples of the pool that a stream is tried on. Of a fault's channel: those in which it begins first, if at all. Of a
    schedule: any one, then those in which it decides on a channel, the earliest onset first."""
    fault = next((part for part in problem.faults if covers(part.prefix, name)), None)
    if fault is None:
        yield from range(POOL)
        return
    begins = f"{fault.prefix}.onset_s"
    if covers(f"{fault.prefix}.schedule", name):
        yield 0
        other = Draws.of(problem, pool.samples, {name: np.ones(POOL, dtype=bool)})[0]
        onsets = [np.minimum(x, other.values[n]) for n, x in _own(pool, begins) if n in other.values]
        differ = [x != other.values[n] for n, x in _own(pool, begins) if n in other.values]
        first = np.min(np.where(differ, onsets, np.inf), axis=0, initial=np.inf)
    else:
        first = pool.values.get(f"{begins}.{name.rpartition('.')[2]}", np.full(POOL, np.inf))
    known = np.isfinite(first)
    yield from (int(sample) for sample in np.argsort(first, kind="stable")[: np.count_nonzero(known)])
    if not known.any():
        yield from range(POOL)


def _own(draws: Draws, beginning: str) -> list[tuple[str, Values]]:
    """The draws of a table under a name."""
    return [(name, values) for name, values in draws.values.items() if covers(beginning, name)]


def _fly(problem: Problem, flyer: Flyer, pairs: list[tuple[str, int]]) -> tuple[dict[str, str], list[ReadBack]]:
    """The streams that acted in one of their pairs, each with what it changed, and what was read back of all lanes."""
    samples = np.resize(np.repeat([sample for _, sample in pairs], 2), LANES).astype(np.int64)
    names = [name for name, _ in pairs]
    moved = {name: np.zeros(LANES, dtype=bool) for name in names}
    for place, name in enumerate(names):
        moved[name][2 * place + 1] = True
    draws, drawn = Draws.of(problem, samples, moved)
    acted: dict[str, str] = {}
    read: list[ReadBack] = []

    def look(numbers: Drawn, carry: Carry) -> bool:
        if not read:
            read.extend(readings(problem, draws, numbers))
        for name, signal in zip(names, _signals(problem, carry), strict=False):  # fewer names than pairs in the last chunk
            if signal:
                acted.setdefault(name, signal)
        return not acted.keys() >= set(names)

    steps, every = problem.spec.horizon.steps, max(1, round(LOOK_S / problem.spec.horizon.step_s))
    instants = {steps, *range(every, steps, every), *(one for one in (1, 10) if one < steps)}
    flyer.watch(drawn, sorted(instants), look)
    return acted, read


def _signals(problem: Problem, carry: Carry) -> list[str]:
    """Of each pair the number that differs most between its two lanes, measured by its largest value in any lane; empty where all
    are the same to the last bit. Numbers of the state go before those of the metrics."""
    found = [""] * (LANES // 2)
    folds = {next(iter(metric.columns)): own for metric, own in zip(problem.metrics, carry.accumulators, strict=True)}
    for part in (carry.y, folds, {"lost_s": carry.lost_s}):
        paths, leaves = zip(*jax.tree_util.tree_flatten_with_path(part)[0], strict=True)
        shares = np.stack([_shares(leaf) for leaf in leaves])
        for pair, (place, share) in enumerate(zip(np.argmax(shares, axis=0), np.max(shares, axis=0), strict=True)):
            if not found[pair] and share >= 0.0:
                found[pair] = jax.tree_util.keystr(paths[place], simple=True, separator=".")
    return found


def _shares(leaf: Values) -> Values:
    """(pairs,) by what share of its largest value a number differs in the two lanes of a pair; below 0 where it does not."""
    own, other = leaf[0 : LANES // 2 * 2 : 2], leaf[1 : LANES // 2 * 2 : 2]
    same = (own == other) | (np.isnan(own) & np.isnan(other))
    with np.errstate(invalid="ignore", over="ignore"):
        share = np.abs(own - other) / np.max(np.abs(leaf[np.isfinite(leaf)]), initial=np.finfo(leaf.dtype).tiny)
    return np.where(same, -1.0, np.where(np.isnan(share), np.inf, share))


def _unlike(reading: ReadBack) -> str:
    """What is wrong with a reading, in words; empty where nothing is."""
    digits = np.finfo(jax_config.precision()).eps
    table = reading.table.astype(jax_config.precision()) if reading.exact else reading.table
    inside = np.asarray(reading.inside, dtype=np.float64)
    room = 0.0 if reading.exact else 64.0 * digits * max(1.0, float(np.max(np.abs(table))))
    with np.errstate(invalid="ignore"):
        wrong = ~((np.abs(inside - table) <= room) | (inside == table))
    if not wrong.any():
        return ""
    first = int(np.argmax(wrong))
    return f"{', '.join(reading.columns)}: the table says {table[first]:.17g}, the flight has {inside[first]:.17g}"
