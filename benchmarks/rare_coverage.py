"""How often the intervals of rare failures hold: `python -m benchmarks.rare_coverage [--repeats N] [--case NAME] [--method M]
[--chains M]`.

Each repeat learns afresh, then estimates with 20 independent replicates. Written for each margin of `benchmarks.rare_margins`:
the mean of p̂/p with its standard error, the coefficient of variation of a repeat, how often Student's interval at 95 % holds p,
how often the proved bound at 95 % is right and its median, for importance sampling how many repeats were refused, and the
flights of a repeat. What came out: docs/rare.md.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from benchmarks import markdown
from benchmarks.rare_margins import CASES, Case, Keys, Values
from rvjax.stats.rare import importance, splitting
from rvjax.stats.rare.points import Points, joined
from rvjax.stats.rare.replicates import proved_lower_bound, student_interval

REPLICATES, CHAINS, LEARNERS, DRAWN = 20, 26, 104, 8000
CONFIDENCE = 0.95


class Repeat(NamedTuple):
    """An estimate, Student's interval, the proved bound, and why it was refused."""

    estimate: float
    low: float
    high: float
    proved: float
    refused: tuple[str, ...]


class Counted:
    """A margin that counts its flights."""

    def __init__(self, case: Case) -> None:
        self.case, self.flights = case, 0

    def __call__(self, z: Values, keys: Keys) -> Values:
        self.flights += len(z)
        return self.case.margin(z, keys)


def repeat(case: Case, method: str, seed: int, learners: int = LEARNERS, chains: int = CHAINS) -> Repeat:
    """One repeat: pass 1 with `learners` chains, then 20 replicates of `chains` chains; importance sampling then flies 8,000
    more.
    """

    def margin(points: Points) -> Values:
        return case.margin(points.z, points.keys)

    ladder = splitting.learn(margin, case.dimension, seed, chains=learners, noisy=case.noisy)
    came = splitting.replicates(margin, ladder, seed, range(REPLICATES), chains=chains)
    values, refused = tuple(replicate.probability for replicate in came), ()
    if method == "importance":
        failing = joined([ladder.failing, *(replicate.failing for replicate in came)])
        proposal = importance.learn(failing.z, max(len(failing) // splitting.STATES, 20), seed)
        points = proposal.draw(np.random.default_rng([seed, 3]), DRAWN)
        weighed = importance.weigh(proposal, points, margin(points), REPLICATES)
        refused = (*weighed.refusals(), *(["splitting disagrees"] if importance.disagreement(weighed, values) else []))
        values = weighed.blocks
    interval = student_interval(values, CONFIDENCE)
    return Repeat(interval.value, interval.low, interval.high, proved_lower_bound(values, CONFIDENCE), refused)


def repeats_of(
    case: Case, count: int, method: str, first: int = 0, learners: int = LEARNERS, chains: int = CHAINS
) -> list[Repeat]:
    """Repeats with the seeds from `first` on."""
    return [repeat(case, method, seed, learners, chains) for seed in range(first, first + count)]


def _row(name: str, case: Case, came: Sequence[Repeat], flights: float, seconds: float) -> str:
    p, n = case.probability, len(came)
    kept = [r for r in came if not r.refused]
    if not kept:
        return f"| {name} | {p:.4g} | {n} | – | – | – | – | – | {n} | {flights:,.0f} | {seconds:.0f} |"
    ratios = np.array([r.estimate for r in kept]) / p
    error = ratios.std(ddof=1) / np.sqrt(len(kept)) if len(kept) > 1 else float("nan")
    holds = np.mean([r.low <= p <= r.high for r in kept])
    proved = np.mean([r.proved <= p for r in kept])
    median = np.median([r.proved for r in kept]) / p
    return (
        f"| {name} | {p:.4g} | {n} | {ratios.mean():.3f} ± {error:.3f} | {ratios.std(ddof=1):.3f} | {100 * holds:.1f} % | "
        f"{100 * proved:.1f} % | {median:.2f} p | {n - len(kept)} | {flights:,.0f} | {seconds:.0f} |"
    )


def main() -> None:
    """Prints a table in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=200)
    parser.add_argument("--case", choices=CASES, action="append")
    parser.add_argument("--method", choices=("splitting", "importance"), default="splitting")
    parser.add_argument("--chains", type=int, default=CHAINS)
    given = parser.parse_args()
    print(f"{given.method}: {REPLICATES} replicates of {given.chains} chains of {splitting.STATES} states")
    columns = ("margin", "p", "repeats", "mean p̂/p", "variation", "interval holds", "proved bound holds", "its median")
    columns += ("refused", "flights", "s")
    print(markdown.head(columns))
    for name in given.case or CASES:
        case, begun = CASES[name](), time.perf_counter()
        counted = Counted(case)
        came = repeats_of(case._replace(margin=counted), given.repeats, given.method, chains=given.chains)
        print(_row(name, case, came, counted.flights / given.repeats, time.perf_counter() - begun), flush=True)


if __name__ == "__main__":
    main()
