"""A race: candidates fly a few common samples, those that are not worse fly more, until few are left that have flown all.

    n_0 < n_1 < … < n_R       samples after each round, the first n_r of the search's: all candidates fly the same draws

After each round but the last a candidate leaves

    by a test    that it is worse than the best of the round, in pairs (`Judge.p_worse`), with Holm's correction over the
                 candidates, each round at risk/R (half of that for the hard samples): the best of all is thrown out by a
                 test with probability ≤ risk, as far as the tests keep theirs
    by halving   if it is not among the best `keep` of those that began the round, the best so far not counted

Hard samples are flown in the first round as well: a candidate that fails more of them than the best does, by the same test,
leaves. They never enter a score, so no score is that of chosen samples.

Successive halving: Karnin, Koren & Somekh, ICML 2013; Jamieson & Talwalkar, AISTATS 2016. Racing: Maron & Moore, NIPS 1994;
Birattari et al., GECCO 2002.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.campaign.tuning import Goal
from rvjax.run_folder.tuning_record import Left
from rvjax.search.tuning.objective import REFUSED, Judge
from rvjax.stats import holm
from rvjax.stats.pareto import Score, front_of


class Field(Protocol):
    """Who flies the candidates of a race."""

    def fly(self, candidates: Sequence[int], samples: NDArray[np.int64]) -> None:
        """Flies what of it has not been flown."""
        ...

    def affordable(self, candidates: Sequence[int], samples: NDArray[np.int64]) -> list[int]:
        """The first of the candidates that the budget allows to fly these samples."""
        ...

    def table(self, candidate: int, samples: NDArray[np.int64]) -> pd.DataFrame:
        """Its flights of these samples, in their order."""
        ...

    def refused(self, candidate: int) -> bool:
        """Whether the campaign does not accept its values."""
        ...


@dataclass
class Standing:
    """How a candidate came out. round: the last that it flew; samples: how many its score is of; left: how it left, if it did."""

    candidate: int
    round: int = -1
    samples: int = 0
    score: Score = field(default_factory=lambda: Score(REFUSED, ()))
    left: Left = ""


@dataclass(frozen=True)
class RaceSettings:
    """sizes: samples after each round; keep, risk: as in a campaign; hard: the hard samples."""

    sizes: tuple[int, ...]
    keep: float
    risk: float
    hard: tuple[int, ...] = ()


def race(
    candidates: Sequence[int],
    runners: Field,
    judge: Judge,
    rules: RaceSettings,
    incumbent: int | None = None,
    late: Callable[[], bool] = lambda: False,
) -> tuple[list[Standing], bool]:
    """Flies candidates against each other and against the incumbent, the best so far, which never leaves; returns the standing of
    each of the candidates, in their order, and whether the budget was used up before the end. late: asked before each round."""
    everyone = [*candidates, *([] if incumbent is None else [incumbent])]
    standings = {candidate: Standing(candidate) for candidate in everyone}
    for candidate, standing in standings.items():
        if runners.refused(candidate):
            standing.left = "refused"
            standing.score = Score(REFUSED, (math.inf,) * judge.objectives)
    last, over = len(rules.sizes) - 1, False
    order = [*([] if incumbent is None else [incumbent]), *(candidate for candidate in candidates if candidate != incumbent)]
    for number, size in enumerate(rules.sizes):
        running = [candidate for candidate in order if not standings[candidate].left]
        if not running or over:
            break
        samples = np.arange(size, dtype=np.int64)
        flown = np.union1d(samples, np.array(rules.hard if number == 0 else (), dtype=np.int64))
        fit = [] if late() else runners.affordable(running, flown)
        for candidate in running[len(fit) :]:
            standings[candidate].left = "budget"
        over = len(fit) < len(running)
        running = [] if fit == [incumbent] and over else fit
        if not running:
            break
        runners.fly(running, flown)
        tables = {candidate: runners.table(candidate, samples) for candidate in running}
        for candidate in running:
            standing = standings[candidate]
            standing.round, standing.samples, standing.score = number, size, judge.score(tables[candidate])
        if number == last:
            break
        order = ordered({candidate: standings[candidate].score for candidate in running}, judge.goal)
        risk = rules.risk / last / (2.0 if number == 0 and rules.hard else 1.0)
        worse = _worse(order, tables, judge, risk, judge.goal)
        if number == 0 and rules.hard:
            hard = np.array(rules.hard, dtype=np.int64)
            worse |= _failing(order, {candidate: runners.table(candidate, hard) for candidate in running}, judge, risk)
        challengers = [candidate for candidate in order if candidate != incumbent]
        most = max(1, math.ceil(rules.keep * len(challengers)))
        stay = [challenger for challenger in challengers if challenger not in worse]
        for candidate in running:
            if candidate != incumbent:
                standings[candidate].left = "test" if candidate in worse else "" if candidate in stay[:most] else "halving"
    for candidate in candidates:
        if not standings[candidate].left and standings[candidate].round < last:
            standings[candidate].left = "budget"
    return [standings[candidate] for candidate in candidates], over


def ordered(scores: dict[int, Score], goal: Goal) -> list[int]:
    """Candidates from the best to the worst; equal ones by their numbers."""
    fronts = front_of(list(scores.values())) if goal == "pareto" else [0] * len(scores)
    crowd = crowding(list(scores.values()), fronts) if goal == "pareto" else [0.0] * len(scores)
    keys = {
        candidate: (score.violation, front, -room, score.objectives if goal != "pareto" else (), candidate)
        for (candidate, score), front, room in zip(scores.items(), fronts, crowd, strict=True)
    }
    return sorted(scores, key=lambda candidate: keys[candidate])


def crowding(scores: Sequence[Score], fronts: Sequence[int]) -> list[float]:
    """How much room each has on its front, +∞ at the ends."""
    room = [0.0] * len(scores)
    for front in set(fronts):
        members = [i for i, rank in enumerate(fronts) if rank == front]
        for k in range(len(scores[members[0]].objectives)):
            line = sorted(members, key=lambda i: scores[i].objectives[k])
            low, high = scores[line[0]].objectives[k], scores[line[-1]].objectives[k]
            room[line[0]] = room[line[-1]] = math.inf
            for before, i, after in zip(line, line[1:], line[2:], strict=False):
                wide = scores[after].objectives[k] - scores[before].objectives[k]
                room[i] += wide / (high - low) if math.isfinite(wide) and high > low else 0.0
    return room


def ranks(standings: Sequence[Standing], goal: Goal) -> NDArray[np.float64]:
    """Rank of each candidate of a race, 0 the best: first by the round reached, then by score; equal scores share a rank."""
    stages = sorted({standing.round for standing in standings}, reverse=True)
    ranks = np.empty(len(standings))
    place = 0
    for stage in stages:
        members = [i for i, standing in enumerate(standings) if standing.round == stage]
        order = ordered({i: standings[i].score for i in members}, goal)
        before: Score | None = None
        for offset, i in enumerate(order):
            same = before is not None and before == standings[i].score
            ranks[i] = ranks[order[offset - 1]] if same else place + offset
            before = standings[i].score
        place += len(members)
    return ranks


def _worse(order: Sequence[int], tables: dict[int, pd.DataFrame], judge: Judge, risk: float, goal: Goal) -> set[int]:
    """The candidates that are worse than the best by Holm's test; with several objectives: worse than any of the best front."""
    leaders = [order[0]]
    if goal == "pareto":
        fronts = front_of([judge.score(tables[candidate]) for candidate in order])
        leaders = [candidate for candidate, front in zip(order, fronts, strict=True) if front == 0]
    others = [candidate for candidate in order if candidate not in leaders]
    if not others:
        return set()
    p_values = [
        min(1.0, len(leaders) * min(judge.p_worse(tables[other], tables[leader]) for leader in leaders)) for other in others
    ]
    return {other for other, p in zip(others, holm(p_values), strict=True) if p <= risk}


def _failing(order: Sequence[int], tables: dict[int, pd.DataFrame], judge: Judge, risk: float) -> set[int]:
    """The candidates that fail more of the hard samples than the best."""
    others = [candidate for candidate in order if candidate != order[0]]
    if not others:
        return set()
    p_values = [judge.p_fails(tables[other], tables[order[0]]) for other in others]
    return {other for other, p in zip(others, holm(p_values), strict=True) if p <= risk}
