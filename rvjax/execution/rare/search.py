"""A search of rare failures: two passes of splitting, importance sampling if asked for, a check by ordinary flights, a record.

    pass 1 ─levels→ pass 2, replicates of M chains in groups of 20 ─p̂_r→ [importance sampling ─p̂_b→] check ─→ rare.json

M: the largest of CHAINS at which twenty replicates stay within the budget. With a budget of minutes alone M is WITHOUT_BUDGET,
and groups follow each other until the time is over; the bounds hold for any such rule. The search is a function of the
campaign's seed, the number of the requirement and the budget, so that a search that was killed and resumed gives the same
record, replicate by replicate.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from rvjax.analysis.verdicts.sentences import success_of
from rvjax.campaign.requirement import TRACED
from rvjax.errors import CampaignError
from rvjax.execution.draw_space import DrawSpace
from rvjax.execution.identity import source_digest
from rvjax.execution.progress import OnProgress, Progress
from rvjax.execution.rare import regions
from rvjax.execution.rare.flights import RareFlights
from rvjax.places import Place
from rvjax.run_folder import RunDescription, RunFolder, rare_record
from rvjax.run_folder.rare_record import Interval, Level, RareRecord, Weights
from rvjax.run_folder.storages import is_run_folder
from rvjax.simulation.batch import LANES
from rvjax.simulation.problem import Problem
from rvjax.stats import Estimate
from rvjax.stats.rare import importance, splitting
from rvjax.stats.rare.level_check import LevelCheck, check_levels
from rvjax.stats.rare.points import KEYS, Points, Values, joined
from rvjax.stats.rare.replicates import lopsided, student_interval
from rvjax.stats.rare.splitting import STATES, Ladder, Replicate, Stalled

REPLICATES = 20
"""The fewest replicates, and those of a group."""

CHAINS = (13, 26, 52, 104, 208, 416)
"""Divisors of a chunk, so that replicates fill chunks together."""

FLIGHTS, WITHOUT_BUDGET = 150_000, 104
"""Budget of a requirement without one; chains of a replicate where only minutes are limited."""

FLOOR = 1e-3
"""Pass 1 gives up where the probability of a level is this part of the accepted one."""

CHECKING = 0.4
"""With importance sampling: share of the flights after pass 1 for the replicates of splitting, which check it."""

MOST_GROUPS = 1000


def search_all(problem: Problem, flown_by: Mapping[str, Any], main: RunFolder, on_progress: OnProgress) -> None:
    """Searches the rare failures of every requirement that asks for it, into folders inside the run folder, whose samples are
    flown. flown_by: the identity of the run. Finished searches are left as they are. CampaignError where a margin has no
    order."""
    for number, requirement in enumerate(problem.spec.require, 1):
        if requirement.is_rare and rare_record.read(main.path, number) is None:
            RareSearch(problem, number, main, on_progress).run(flown_by)


class RareSearch:
    """The search for the requirement with this number, from 1."""

    def __init__(
        self, problem: Problem, number: int, main: RunFolder, on_progress: OnProgress, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.problem, self.number, self.main = problem, number, main
        self.requirement = problem.spec.require[number - 1]
        self.space = DrawSpace(problem, self.requirement)
        self.seed = int(hashlib.sha256(f"{problem.spec.seed}:rare:{number}".encode()).hexdigest()[:15], 16)
        budget = self.requirement.budget
        self._minutes = None if budget is None else budget.minutes
        self._most = (FLIGHTS if self._minutes is None else None) if budget is None or budget.flights is None else budget.flights
        self._on_progress, self._clock, self._began = on_progress, clock, clock()
        self._note = "first pass"

    def run(self, flown_by: Mapping[str, Any]) -> RareRecord:
        """Flies what the folder of the search lacks and writes the record."""
        place = self.main.path / rare_record.folder_of(self.number)
        with self._open(place, flown_by) as folder:
            with RareFlights(self.space, folder, self._report, lambda: self._report(flights.flights)) as flights:
                ladder = self._ladder(flights)
                learning = flights.flights
                chains, count = self._size(ladder, learning)
                came = self._replicates(flights, ladder, chains, count)
                failing = joined([ladder.failing, *(replicate.failing for replicate in came)])
                weights = self._weigh(flights, failing) if self.requirement.method == "importance" else None
            checks = self._checks(ladder, came)
            found = regions.find(self.space, failing, self.seed)
            regions.export(self.space, found, folder, self.main.provenance.get("overrides", ()))
            record = self._record(flights, ladder, learning, chains, came, weights, checks, found)
            folder.write_bytes(rare_record.NAME, record.encode())
            folder.seal()
        self._report(flights.flights, ended=True)
        return record

    def _open(self, place: Place, flown_by: Mapping[str, Any]) -> RunFolder:
        """The folder of the search, created or resumed."""
        judging = {"name", "accept", "confidence", *TRACED}
        settings = json.dumps(self.requirement.model_dump(mode="json", exclude=judging), sort_keys=True)
        identity = {
            **flown_by,
            "rare": hashlib.sha256(f"{self.number}:{settings}".encode()).hexdigest(),
            "search": source_digest(("execution/draw_space.py", "execution/rare", "stats/rare")),
        }
        before = RunFolder.open(place) if is_run_folder(place) else None
        spec = self.problem.spec
        description = RunDescription(
            identity=identity,
            provenance={name: value for name, value in self.main.provenance.items() if name in ("overrides", "command")},
            campaign_text=spec.source.text,
            samples=LANES if before is None else before.requested,
            name=spec.name,
            inputs=spec.source.inputs,
        )
        return RunFolder.create(place, description) if before is None else RunFolder.resume(place, description, LANES)

    def _report(self, flights: int, *, ended: bool = False) -> None:
        total = max(self._most or 0, flights + LANES * (not ended))
        share = 1.0 if ended else min(flights / total, 0.99)
        if self._minutes is not None and not ended:
            share = max(share if self._most else 0.0, min((self._clock() - self._began) / (60.0 * self._minutes), 0.99))
        self._on_progress(
            Progress(
                phase="rare failures",
                done=flights,
                total=flights if ended else total,
                share=share,
                seconds=self._clock() - self._began,
                ended=ended,
                note=self._note,
            )
        )

    def _ladder(self, flights: RareFlights) -> Ladder:
        """Pass 1. A margin without order is a mistake in the campaign."""

        def on_level(level: int, share: float) -> None:
            self._note = f"first pass, level {level} has probability {share:.2g}"

        chains = LANES if self._most is None or self._most >= 10 * LANES * STATES else 104
        floor = max(FLOOR * self.requirement.allowed, 1e-15)
        try:
            return splitting.learn(
                flights.margin, len(self.space.coordinates), self.seed, chains=chains, noisy=True, floor=floor, on_level=on_level
            )
        except Stalled as stalled:
            finding = self.problem.spec.source.finding(
                ("require", self.number - 1, "metric"),
                f"the margin of {success_of(self.requirement)} leads nowhere: {stalled}",
                "accepted: a metric that comes gradually nearer to its bound, such as a margin of `margins`",
            )
            raise CampaignError([finding]) from stalled

    def _size(self, ladder: Ladder, learning: int) -> tuple[int, int | None]:
        """Chains of a replicate, and the number of replicates; None: until the time is over."""
        if self._most is None:
            return WITHOUT_BUDGET, None
        left = (self._most - learning) * (CHECKING if self.requirement.method == "importance" else 1.0)
        fits = [chains for chains in CHAINS if REPLICATES * splitting.flights_of(ladder, chains) <= left]
        chains = fits[-1] if fits else CHAINS[0]
        return chains, max(REPLICATES, int(left / splitting.flights_of(ladder, chains)))

    def _replicates(self, flights: RareFlights, ladder: Ladder, chains: int, count: int | None) -> list[Replicate]:
        """Pass 2, in groups. The time limit ends it only between groups, and not before the first is flown."""
        came: list[Replicate] = []
        while count is None or len(came) < count:
            self._note = f"{len(came)} estimates" + (f", mean {_mean(came):.3g}" if came else "")
            behind = len(came) + REPLICATES if count is None else min(len(came) + REPLICATES, count)
            came += splitting.replicates(flights.margin, ladder, self.seed, range(len(came), behind), chains=chains)
            if self._late() or len(came) >= MOST_GROUPS * REPLICATES:
                break
        interval = student_interval([replicate.probability for replicate in came], 0.9)
        self._note = f"{len(came)} estimates, mean {interval.value:.3g} ({interval.low:.2g} to {interval.high:.2g})"
        return came

    def _late(self) -> bool:
        return self._minutes is not None and self._clock() - self._began >= 60.0 * self._minutes

    def _weigh(self, flights: RareFlights, failing: Points) -> tuple[importance.Proposal, importance.Weighed]:
        """Importance sampling with the law that the failing points taught, in blocks of whole chunks."""
        independent, dimension = max(len(failing) // STATES, REPLICATES), len(self.space.coordinates)
        proposal = importance.learn(failing.z, independent, self.seed) if len(failing) > 1 else importance.usual(dimension)
        left = REPLICATES * LANES if self._most is None else max(self._most - flights.flights, 0)
        chunks = max(REPLICATES, left // LANES)
        points = proposal.draw(np.random.default_rng([self.seed, 3]), chunks * LANES)
        self._note += "; importance sampling"
        return proposal, importance.weigh(proposal, points, flights.margin(points), chunks)

    def _checks(self, ladder: Ladder, came: Sequence[Replicate]) -> list[LevelCheck]:
        """What the ordinary flights of the run say about the levels, failure being the last."""
        margins = [self.space.failure_margins(frame) for _, frame, _ in self.main.tables()]
        ordinary: Values = np.concatenate(margins)
        levels = [*ladder.levels, 0.0]
        below = [[replicate.below(level) for replicate in came] for level in range(len(levels))]
        return check_levels(levels, below, [int(np.sum(ordinary <= level)) for level in levels], len(ordinary))

    def _record(
        self,
        flights: RareFlights,
        ladder: Ladder,
        learning: int,
        chains: int,
        came: Sequence[Replicate],
        weighed: tuple[importance.Proposal, importance.Weighed] | None,
        checks: Sequence[LevelCheck],
        found: Sequence[regions.Found],
    ) -> RareRecord:
        estimates = [replicate.probability for replicate in came]
        refusals = [
            f"{check.count} of {check.counted.n} ordinary flights are at or below level {check.level:.4g}, which splitting gives "
            f"the probability {check.split.value:.3g}"
            for check in checks
            if not check.agrees
        ]
        if not ladder.reached:
            refusals.append(f"the first pass reached no failure down to the probability {ladder.probability:.2g}")
        refusals += [why for why in (lopsided(estimates),) if why and ladder.reached and weighed is None]
        weights = None
        if weighed is not None:
            proposal, came_to = weighed
            refusals += came_to.refusals()
            if (disagreeing := importance.disagreement(came_to, tuple(estimates))) is not None:
                ours, theirs = disagreeing
                refusals.append(f"importance sampling gives {ours.value:.3g}, splitting {theirs.value:.3g}")
            weights = Weights(
                flights=came_to.flights,
                failing=came_to.failing,
                effective=came_to.effective,
                largest=came_to.largest,
                shape=came_to.shape,
                coordinates=[self.space.coordinates[k].name for k in proposal.selected],
                parts=len(proposal.mixture.shares),
                blocks=list(came_to.blocks),
            )
        return RareRecord(
            requirement=self.number,
            condition=success_of(self.requirement),
            method=self.requirement.method,  # pyright: ignore[reportArgumentType]  # one of the two, or nothing is searched
            seed=self.seed,
            dimension=len(self.space.coordinates),
            chains=chains,
            states=STATES,
            reached=ladder.reached,
            learning=learning,
            flights=flights.flights,
            replicates=estimates,
            levels=_levels(checks, came),
            ordinary=checks[0].counted.n,
            failing=checks[-1].count,
            weights=weights,
            refusals=refusals,
            regions=[region.record for region in found],
        )


def _levels(checks: Sequence[LevelCheck], came: Sequence[Replicate]) -> list[Level]:
    """Levels with the means over the replicates that reached them."""
    rows: list[Level] = []
    for place, check in enumerate(checks):
        shares = [replicate.shares[place] for replicate in came if len(replicate.shares) > place]
        moves = [replicate.accepted[place - 1] for replicate in came if place and len(replicate.accepted) >= place]
        rows.append(
            Level(
                level=check.level,
                share=float(np.mean(shares)) if shares else 0.0,
                accepted=float(np.mean(moves)) if moves else None,
                count=check.count,
                counted=_interval(check.counted),
                split=_interval(check.split),
                agrees=check.agrees,
            )
        )
    return rows


def _interval(estimate: Estimate) -> Interval:
    return Interval(value=estimate.value, low=estimate.low, high=estimate.high)


def _mean(came: Sequence[Replicate]) -> float:
    return float(np.mean([replicate.probability for replicate in came]))


assert KEYS < 2**53, "keys are exact in a table of points"
