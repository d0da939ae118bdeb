"""The number of samples a requirement needs, and its chances to pass: exact, before any flight.

samples            smallest n with which k failures pass, k = 0, 1, …      P(X ≤ k) ≤ 1 − confidence, X ~ Bin(n, 1 − p₀)
chances            P(PASS), P(FAIL), P(UNDECIDED) at a true share p; 1 − P(PASS) is the producer's risk if p meets the limit
expected samples   of a sequential method, tested after every chunk
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

from rvjax.analysis.verdicts.sentences import title
from rvjax.campaign.plain_values import exact
from rvjax.errors import UsageError
from rvjax.stats import e_boundary, schedule, sprt_boundary, verdict_chances, walk, wilks_smallest_n

if TYPE_CHECKING:
    from rvjax.campaign import Requirement
    from rvjax.stats import Boundary

FAILURES = (0, 1, 2, 3, 4, 5, 10)
"""Numbers of allowed failures in the first table."""

PARTS = (0.5, 0.25, 0.1)
"""Default true failure rates, as parts of the allowed failure rate."""

MOST_FAILURES = 2_000
"""The largest number of allowed failures in the search for a plan with the required power."""

BUDGET = 100_000
"""Samples after which a sequential method counts as undecided, outside of a campaign."""


class Fate(NamedTuple):
    """The probabilities of the three verdicts."""

    passes: float
    fails: float
    undecided: float


@dataclass(frozen=True)
class Fixed:
    """A fixed number of samples n: PASS with up to `failures` failures. chances: at each true share."""

    failures: int
    n: int
    chances: tuple[Fate, ...]


@dataclass(frozen=True, kw_only=True)
class Running:
    """A method at a true share, tested after every `every` samples, up to `budget`. samples: expected number."""

    method: str
    true: float
    every: int
    budget: int
    passes: float
    fails: float
    undecided: float
    samples: float


@dataclass(frozen=True)
class Plan:
    """A plan of samples for a required share.

    limit: the required share, of bad samples if `bad`, otherwise of good ones; trues: the assumed true shares of the same
    samples. enough: the smallest fixed plan with the required power at the first true share, None if it needs more than
    `MOST_FAILURES` allowed failures.
    """

    limit: float
    bad: bool
    confidence: float
    power: float
    trues: tuple[float, ...]
    fixed: tuple[Fixed, ...]
    enough: Fixed | None
    running: tuple[Running, ...]


def plan(
    limit: float,
    confidence: float = 0.95,
    trues: Sequence[float] = (),
    power: float = 0.9,
    *,
    expected: float | None = None,
    bad: bool = False,
    every: int = 416,
    budget: int = BUDGET,
) -> Plan:
    """The plan of samples for a requirement on a share: of good samples, at least `limit`; if `bad`, of bad samples, at most it.

    trues: assumed true shares on the better side of the limit, three by default. expected: the better share of an SPRT, which is
    shown only with this number. All are shares of the same samples. UsageError names every number out of range.
    """
    _check(limit, confidence, trues, power, expected, bad=bad)
    stated, given = limit, tuple(trues)
    if bad:
        limit, trues, expected = 1.0 - limit, [1.0 - share for share in trues], None if expected is None else 1.0 - expected
    shown = _shown(limit, trues)
    fixed = tuple(_fixed(limit, confidence, k, shown) for k in FAILURES)
    running = [
        _running("sequential", e_boundary(schedule(budget, every), limit, 1 - confidence), p, every, budget) for p in shown
    ]
    if expected is not None:
        boundary = sprt_boundary(schedule(budget, every), limit, expected, 1 - confidence, 1 - power)
        running += [_running("sprt", boundary, p, every, budget) for p in shown]
    enough = _enough(limit, confidence, shown, power)
    named = given or (tuple(part * stated for part in PARTS) if bad else shown)
    running = [replace(test, true=named[place % len(named)]) for place, test in enumerate(running)]
    return Plan(stated, bad, confidence, power, trues=named, fixed=fixed, enough=enough, running=tuple(running))


def of_requirement(requirement: Requirement, samples: int, trues: Sequence[float], every: int) -> tuple[Running, ...]:
    """The chances of a campaign's requirement with its method and number of samples, at assumed true shares."""
    limit, confidence = requirement.limit, requirement.confidence
    shown = _shown(limit, trues)
    if requirement.mean:
        problem = "the chances of a mean depend on its distribution"
        raise UsageError(f"{title(requirement)}: {problem}; accepted: requirements on shares")
    if requirement.is_rare:
        problem = f"the chances of method {requirement.method} depend on how the margin slopes"
        raise UsageError(f"{title(requirement)}: {problem}; accepted: requirements judged by counting")
    if requirement.method == "fixed":
        return tuple(_judged_once(samples, limit, confidence, p) for p in shown)
    looks = schedule(samples, every)
    if requirement.method == "sequential":
        boundary = e_boundary(looks, limit, 1 - confidence)
    else:
        boundary = sprt_boundary(looks, limit, requirement.design, 1 - confidence, 1 - requirement.strength)
    return tuple(_running(requirement.method, boundary, p, every, samples) for p in shown)


def _shown(limit: float, trues: Sequence[float]) -> tuple[float, ...]:
    """The true shares that the plan assumes."""
    return tuple(trues) or tuple(1.0 - part * (1.0 - limit) for part in PARTS)


def _fixed(limit: float, confidence: float, failures: int, trues: Sequence[float]) -> Fixed:
    n = wilks_smallest_n(limit, confidence, failures)
    return Fixed(failures, n, tuple(_fate(n, limit, confidence, p) for p in trues))


def _fate(n: int, limit: float, confidence: float, true: float) -> Fate:
    chances = verdict_chances(n, limit, confidence, true)
    return Fate(float(chances.passes), float(chances.fails), float(chances.undecided))


def _judged_once(n: int, limit: float, confidence: float, true: float) -> Running:
    fate = _fate(n, limit, confidence, true)
    return Running(method="fixed", true=true, every=n, budget=n, **fate._asdict(), samples=float(n))


def _enough(limit: float, confidence: float, trues: Sequence[float], power: float) -> Fixed | None:
    """The plan with the fewest failures k that has the power at the first true share; power rises with k, but for small waves."""
    low, high = 0, 1
    while high <= MOST_FAILURES and _passes(limit, confidence, high, trues[0]) < power:
        low, high = high, 2 * high
    if high > MOST_FAILURES:
        return None
    ks = [k for k in range(low, high + 1) if _passes(limit, confidence, k, trues[0]) >= power]
    return _fixed(limit, confidence, ks[0], trues)


def _passes(limit: float, confidence: float, failures: int, true: float) -> float:
    return _fate(wilks_smallest_n(limit, confidence, failures), limit, confidence, true).passes


def _running(method: str, boundary: Boundary, true: float, every: int, budget: int) -> Running:
    chances = walk(true, boundary)
    return Running(
        method=method,
        true=true,
        every=every,
        budget=budget,
        passes=chances.passes,
        fails=chances.fails,
        undecided=chances.undecided,
        samples=chances.samples,
    )


def _check(limit: float, confidence: float, trues: Sequence[float], power: float, expected: float | None, *, bad: bool) -> None:
    wrong: list[str] = []
    if not (0.0 < limit < 1.0 and 0.0 < 1.0 - limit < 1.0):
        wrong.append(f"--at-{'most' if bad else 'least'} {exact(limit)}; accepted: a share between 0 and 1")
    if not 0.5 <= confidence < 1.0:
        wrong.append(f"--confidence {exact(confidence)}; accepted: at least 0.5, below 1")
    if not 0.5 <= power < 1.0:
        wrong.append(f"--power {exact(power)}; accepted: at least 0.5, below 1")
    for name, share in (*(("--true", true) for true in trues), *(() if expected is None else (("--expected", expected),))):
        if bad and not 0.0 < share < limit:
            wrong.append(f"{name} {exact(share)}; accepted: a share below the {exact(limit)} that is allowed, above 0")
        elif not bad and not limit < share < 1.0:
            wrong.append(f"{name} {exact(share)}; accepted: a share above the {exact(limit)} that is required, below 1")
    if wrong:
        raise UsageError("\n".join(wrong))
