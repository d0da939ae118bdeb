"""A search: batches of candidates that a method proposes, each batch a race against the best so far."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.campaign.tuning import Tuning
from rvjax.components.search_methods.interface import Results, Spent, Task
from rvjax.components.search_methods.interface import Search as Propose
from rvjax.search.tuning.candidate_flights import Flights
from rvjax.search.tuning.gradients import Slopes
from rvjax.search.tuning.objective import Judge
from rvjax.search.tuning.race import RaceSettings, Standing, ordered, race, ranks
from rvjax.stats.pareto import front_of

OWN = 0
"""Number of the original campaign."""

IDLE = 20
"""After so many batches in a row without a new candidate there is nothing left to find."""


@dataclass
class Round:
    """How many candidates began a round of the races, and how many it threw out, by tests and by halving."""

    size: int
    begun: int = 0
    by_test: int = 0
    by_halving: int = 0


@dataclass
class Search:
    """Evaluates what a method proposes. stop_at: lanes after which it is over, of a search that was over by time before."""

    tuning: Tuning
    flights: Flights
    judge: Judge
    on_message: Callable[[str], None]
    slopes: Slopes | None = None
    stop_at: int | None = None
    standings: dict[int, Standing] = field(default_factory=dict[int, Standing])
    batch_of: dict[int, int] = field(default_factory=dict[int, int])
    best: int = OWN
    batches: int = 0
    hard: tuple[int, ...] = ()
    idle: int = 0

    def __post_init__(self) -> None:
        self.rounds = [Round(size) for size in self.tuning.rounds]
        self._began = time.monotonic()

    def run(self, propose: Propose, task: Task) -> None:
        """Flies everything that the method proposes until the budget is used up; before that the original campaign."""
        with suppress(Spent):
            propose(task, self)
        if not self.standings:
            self._begin()

    def _begin(self) -> None:
        samples = np.arange(self.tuning.rounds[-1], dtype=np.int64)
        self.flights.fly([OWN], samples)
        standing = Standing(OWN, len(self.tuning.rounds) - 1, len(samples), self.judge.score(self.flights.table(OWN, samples)))
        self.standings[OWN], self.batch_of[OWN] = standing, 0
        self._remember_hard()

    def __call__(self, points: NDArray[np.float64]) -> Results:
        """What comes of proposed points: a race of those that have not flown yet; others keep the standing that they have."""
        if not self.standings:
            self._begin()
        if self._late():
            raise Spent
        numbers: list[int] = []
        most = self.tuning.budget.candidates
        cut = False
        for point in points:
            known = len(self.flights.candidates)
            if most is not None and known > most and not self.flights.knows(point):
                cut = True  # beyond the budget: other proposals of this batch still fly
                continue
            numbers.append(self.flights.number(self.flights.space.values(point), point))
        new = [fromkey for fromkey in dict.fromkeys(numbers) if fromkey not in self.standings]
        self.idle = 0 if new else self.idle + 1
        if (not new and cut) or self.idle > IDLE:
            raise Spent
        over = self._race(new) if new else False
        if cut or over:
            raise Spent
        return self._tell(numbers, points)

    def table(self, candidate: int) -> pd.DataFrame:
        """The table of all samples on which a candidate is scored."""
        return self.flights.table(candidate, np.arange(self.standings[candidate].samples, dtype=np.int64))

    def winner(self) -> int | None:
        """The best candidate that meets every requirement on all samples of the search; None where no candidate does.

        The order of candidates asks for more than the required shares, so the first in order may miss a requirement that another
        candidate meets.
        """
        whole = {candidate: self.standings[candidate].score for candidate in (self.best, *self._whole())}
        meets = (candidate for candidate in dict.fromkeys((self.best, *ordered(whole, self.judge.goal))))
        return next((one for one in meets if not self.judge.missed(self.table(one))), None)

    def front(self) -> list[int]:
        """The candidates that nothing dominates, of those that flew all samples."""
        whole = self._whole()
        fronts = front_of([self.standings[candidate].score for candidate in whole])
        return [candidate for candidate, front in zip(whole, fronts, strict=True) if front == 0]

    def _whole(self) -> list[int]:
        return [candidate for candidate, standing in self.standings.items() if not standing.left and standing.score.objectives]

    def _late(self) -> bool:
        """Whether the minutes are over; of a search that was over by time before, whether it has all that it had then."""
        minutes = self.tuning.budget.minutes
        if self.stop_at is not None:
            return self.flights.lanes >= self.stop_at
        return minutes is not None and time.monotonic() - self._began >= 60.0 * minutes

    def _race(self, new: list[int]) -> bool:
        """Flies new candidates; returns whether the budget was used up meanwhile."""
        race_of = self.tuning.race
        rules = RaceSettings(self.tuning.rounds, race_of.keep, race_of.risk, self.hard)
        self.batches += 1
        came, over = race(new, self.flights, self.judge, rules, self.best, self._late)
        for standing in came:
            self.standings[standing.candidate], self.batch_of[standing.candidate] = standing, self.batches
            for number in range(standing.round + 1):
                self.rounds[number].begun += 1
            if standing.left == "test":
                self.rounds[standing.round].by_test += 1
            elif standing.left == "halving":
                self.rounds[standing.round].by_halving += 1
        whole = {candidate: self.standings[candidate].score for candidate in self._whole()}
        if self.judge.goal == "pareto":
            self.best = self._middle(self.front())
        else:
            self.best = ordered({fromkey: whole[fromkey] for fromkey in dict.fromkeys((self.best, *whole))}, self.judge.goal)[0]
        self._remember_hard()
        self._say()
        return over

    def _middle(self, front: list[int]) -> int:
        """The member of the best front nearest to the best of each objective, in units of the front's extent."""
        scores = np.array([self.standings[candidate].score.objectives for candidate in front])
        finite = np.isfinite(scores)
        low = np.where(finite, scores, np.inf).min(axis=0)
        wide = np.where(finite, scores, -np.inf).max(axis=0) - low
        with np.errstate(invalid="ignore"):
            scaled = np.where(finite, (scores - low) / np.where(wide > 0.0, wide, 1.0), 1e9)
        return front[int(np.argmin(np.linalg.norm(scaled, axis=1)))]

    def _remember_hard(self) -> None:
        """The samples that the best candidate does worst, of those that the first round does not fly anyway."""
        count = self.tuning.race.hard
        if not count:
            return
        samples = self.flights.samples(self.best)
        losses = self.judge.measures[0].losses(self.flights.table(self.best, samples))
        later = samples >= self.tuning.rounds[0]
        order = np.argsort(-losses[later], kind="stable")
        self.hard = tuple(samples[later][order[:count]].tolist())

    def _tell(self, numbers: list[int], points: NDArray[np.float64]) -> Results:
        standings = [self.standings[number] for number in numbers]
        blank = (np.inf,) * self.judge.objectives
        slopes = None if self.slopes is None else self.slopes.of(numbers, points)
        return Results(
            np.array([standing.score.violation for standing in standings]),
            np.array([standing.score.objectives or blank for standing in standings]),
            ranks(standings, self.judge.goal),
            slopes,
        )

    def _say(self) -> None:
        most = self.tuning.budget.candidates
        of = "" if most is None else f" of {most}"
        values = self.judge.values(self.table(self.best))
        who = "the original campaign" if self.best == OWN else f"candidate {self.best}"
        objectives = ", ".join(f"{measure} {value:.4g}" for measure, value in zip(self.judge.measures, values, strict=True))
        violated = self.standings[self.best].score.violation
        broken = f", requirements missed by {violated:.3g}" if violated else ""
        done = len(self.flights.candidates) - 1
        self.on_message(f"{done}{of} candidates, {self.flights.flights} flights; best: {who}, {objectives}{broken}")
