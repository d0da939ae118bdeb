"""Races of candidates whose worth is known: who wins, at what cost, and with which risk."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy import stats as scipy_stats

from rvjax.campaign.tuning import Objective
from rvjax.columns import Column
from rvjax.search.tuning.objective import Judge, Measure
from rvjax.search.tuning.race import RaceSettings, Standing, crowding, ordered, race, ranks
from rvjax.stats.pareto import Score, front_of

COLUMNS = {"metric.settling_time_s": Column("settling_time_s", "s", "", "lower")}
SIZES = (32, 64, 128, 256, 512)


def judge(**said: object) -> Judge:
    objective = Objective.model_validate({"metric": "settling_time_s", **(said or {"mean": True})})
    made = Judge((), (Measure.of(objective, COLUMNS),), "weighted")
    made.columns(list(COLUMNS))
    return made


class Runners:
    """Candidates whose sample k comes to `loss(candidate, k)`; counts what flies, at most `budget`."""

    def __init__(self, loss: Callable[[int], NDArray[np.float64]], budget: float = np.inf) -> None:
        self._loss, self.budget = loss, budget
        self._known: dict[int, NDArray[np.float64]] = {}
        self.flown: set[tuple[int, int]] = set()

    def affordable(self, candidates: Sequence[int], samples: NDArray[np.int64]) -> list[int]:
        costs = np.cumsum([len({(one, int(k)) for k in samples} - self.flown) for one in candidates])
        return [one for one, cost in zip(candidates, costs, strict=True) if len(self.flown) + cost <= self.budget]

    def fly(self, candidates: Sequence[int], samples: NDArray[np.int64]) -> None:
        self.flown |= {(one, int(k)) for one in candidates for k in samples}
        assert len(self.flown) <= self.budget

    def table(self, candidate: int, samples: NDArray[np.int64]) -> pd.DataFrame:
        assert all((candidate, int(k)) in self.flown for k in samples)
        losses = self._known.setdefault(candidate, self._loss(candidate))
        return pd.DataFrame({"sample": samples, "outcome": "captured", "metric.settling_time_s": losses[samples]})

    def refused(self, candidate: int) -> bool:
        return candidate == 99


def field(seed: int, count: int, spread: float = 1.0) -> Runners:
    """Candidates whose means lie `spread` apart on the average, over common draws of deviation 1 and own ones of ½."""
    rng = np.random.default_rng(seed)
    common, means = rng.normal(size=2000), np.cumsum(rng.exponential(size=count)) * spread
    rng.shuffle(means)
    own = rng.normal(size=(count, 2000)) * 0.5
    return Runners(lambda one: means[one] + common + own[one])


def test_the_race_has_the_winner_of_the_full_evaluation() -> None:
    """20 races of 64 candidates each: at most 30 % of the flights; the winner is that of the full evaluation, or not worse than
    it by a paired test at 1 in 1,000 (one of 20 may differ by chance in 2 % of all seeds: none does here). Kills: halving that
    keeps the worst, samples that differ between candidates, flights that are flown twice."""
    made = judge()
    shares: list[float] = []
    for seed in range(20):
        runners = field(seed, 64, 0.1)
        came, over = race(range(64), runners, made, RaceSettings(SIZES, 0.5, 0.05))
        assert not over
        shares.append(len(runners.flown) / (64 * SIZES[-1]))
        winner = min((one for one in came if not one.left), key=lambda one: one.score).candidate
        everything = np.arange(SIZES[-1])
        runners.fly(range(64), everything)
        tables = {one: runners.table(one, everything) for one in range(64)}
        best = min(range(64), key=lambda one: made.score(tables[one]))
        assert winner == best or made.p_worse(tables[winner], tables[best]) > 1e-3
    assert max(shares) <= 0.30


def test_tests_alone_throw_the_best_out_seldom() -> None:
    """8 candidates that are alike but for a hair, raced by tests only (keep: 1), 150 times: the best is thrown out in at most
    the stated 20 %, beyond which chance goes in 1 of 10,000. Kills: no correction over candidates, a risk for each round."""
    made, thrown, repeats, risk = judge(), 0, 150, 0.2
    for seed in range(repeats):
        rng = np.random.default_rng(seed)
        common, own = rng.normal(size=128), rng.normal(size=(8, 128))
        runners = Runners(lambda one, c=common, o=own: (one > 0) * 1e-3 + c + o[one])
        came, _ = race(range(8), runners, made, RaceSettings(SIZES[:3], 1.0, risk))
        thrown += came[0].left == "test"
        assert all(one.left in ("", "test") for one in came)
    assert thrown <= scipy_stats.binom.isf(1e-4, repeats, risk)


def test_the_incumbent_never_leaves_and_the_others_are_told_apart() -> None:
    """Kills: a best so far that is thrown out; a refused candidate that flies; ranks that mix rounds."""
    runners = field(5, 32, 0.3)
    came, _ = race([*range(1, 32), 99], runners, judge(), RaceSettings(SIZES, 0.25, 0.05), incumbent=0)
    assert {k for one, k in runners.flown if one == 0} == set(range(SIZES[-1]))
    assert not any(one == 99 for one, _ in runners.flown)
    assert came[-1] == Standing(99, -1, 0, Score(np.inf, (np.inf,)), "refused")
    assert [one.candidate for one in came] == [*range(1, 32), 99]
    order = ranks(came, "weighted")
    assert sorted(order.tolist()) == list(range(32))
    assert order[-1] == 31
    by_round = [came[int(i)].round for i in np.argsort(order)]
    assert by_round == sorted(by_round, reverse=True)


def test_hard_samples_throw_out_who_fails_them_and_enter_no_score() -> None:
    """Candidate 1 does as well as 0 on all samples but the hard ones, where it is lost. Kills: hard samples in a score, hard
    samples that are not flown, a candidate that stays although it fails them."""
    hard = tuple(range(600, 640))

    def loss(one: int) -> NDArray[np.float64]:
        rng = np.random.default_rng(one)
        return np.random.default_rng(9).normal(size=700) + 0.01 * rng.normal(size=700)

    class Lost(Runners):
        def table(self, candidate: int, samples: NDArray[np.int64]) -> pd.DataFrame:
            frame = super().table(candidate, samples)
            return frame.assign(outcome=np.where((candidate == 1) & (samples >= 600), "not_finite", "captured"))

    runners = Lost(loss)
    came, _ = race([1, 2], runners, judge(), RaceSettings(SIZES, 1.0, 0.05, hard), incumbent=0)
    assert (came[0].left, came[0].round) == ("test", 0)
    assert came[1].left == ""
    assert came[0].score == judge().score(runners.table(1, np.arange(SIZES[0])))
    assert {(one, k) for one in range(3) for k in hard} <= runners.flown


def test_a_budget_ends_a_race_with_what_is_known() -> None:
    """Kills: flights beyond the budget; a field that does not fly at all since it does not fit as a whole; a candidate that
    counts as one that flew everything."""
    for rounds, budget in ((1, 16 * SIZES[0] + 10), (1, 5 * SIZES[0]), (0, SIZES[0] - 1), (2, 16 * SIZES[0] + 4 * SIZES[0])):
        runners = field(6, 16, 0.02)
        runners.budget = budget
        came, over = race(range(16), runners, judge(), RaceSettings(SIZES, 0.5, 0.05))
        assert over
        assert budget - SIZES[rounds] < len(runners.flown) <= budget
        assert {one.left for one in came} <= {"test", "halving", "budget"}
        assert max(one.samples for one in came) == ((0, *SIZES)[rounds] if rounds < 2 else SIZES[1])
    came, over = race(range(1, 16), field(6, 16, 1.0), judge(), RaceSettings(SIZES, 0.5, 0.05), 0, late=lambda: True)
    assert over
    assert {one.left for one in came} == {"budget"}


def test_fronts_and_room_on_them() -> None:
    """Against brute force. Kills: the sign of an objective, equal points that dominate each other, ends without room."""
    rng = np.random.default_rng(7)
    scores = [Score(0.0, tuple(row)) for row in rng.integers(0, 6, size=(40, 2)).astype(float)] + [Score(1.0, (0.0, 0.0))]
    fronts = front_of(scores)
    for i, one in enumerate(scores):
        better = [
            j
            for j, other in enumerate(scores)
            if other.violation < one.violation
            or (
                other.violation == one.violation
                and all(a <= b for a, b in zip(other.objectives, one.objectives, strict=True))
                and other.objectives != one.objectives
            )
        ]
        assert (fronts[i] == 0) == (not better)
        assert all(fronts[j] < fronts[i] for j in better)
    line = [Score(0.0, (float(k), float(9 - k))) for k in (0, 1, 5, 9)]
    room = crowding(line, front_of(line))
    assert room[0] == room[3] == np.inf
    assert room[2] == pytest.approx(16 / 9)
    assert room[1] == pytest.approx(10 / 9)
    assert ordered(dict(enumerate(line)), "pareto")[:2] == [0, 3]
