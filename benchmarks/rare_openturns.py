"""Subset sampling of OpenTURNS beside splitting, on margins with known answers: `python -m benchmarks.rare_openturns [--repeats
N]`.

OpenTURNS is no dependency; where it is not installed, the command says so and ends. Each row: the mean of p̂/p over the repeats,
their coefficient of variation, and the flights of a repeat. The budget of splitting is twenty replicates; that of OpenTURNS one
run with levels of the same probability (0.1) and as many states for each level as all replicates together.
"""

from __future__ import annotations

import argparse
import importlib.util
from typing import Any

import numpy as np

from benchmarks.rare_coverage import CHAINS, LEARNERS, REPLICATES
from benchmarks.rare_margins import CASES, Case
from rvjax.stats.rare import splitting
from rvjax.stats.rare.points import Points, Values

SHOWN = ("linear 1e-6", "two-sided 1e-6", "4 half-spaces", "concave", "100 exponentials")


def by_openturns(case: Case, seed: int, states: int) -> tuple[float, int]:
    """p̂ and the flights of a run of OpenTURNS' subset sampling."""
    openturns: Any = __import__("openturns")
    openturns.RandomGenerator.SetSeed(seed)
    flights = 0

    def margins(points: Any) -> Any:
        nonlocal flights
        z = np.asarray(points, dtype=np.float64)
        flights += len(z)
        return case.margin(z, np.zeros(len(z), dtype=np.int64))[:, None].tolist()

    function = openturns.PythonFunction(case.dimension, 1, func_sample=margins)
    vector = openturns.CompositeRandomVector(function, openturns.RandomVector(openturns.Normal(case.dimension)))
    algorithm = openturns.SubsetSampling(openturns.ThresholdEvent(vector, openturns.LessOrEqual(), 0.0))
    algorithm.setConditionalProbability(1.0 / splitting.STATES)
    algorithm.setBlockSize(1000)
    algorithm.setMaximumOuterSampling(max(1, states // 1000))
    algorithm.run()
    return float(algorithm.getResult().getProbabilityEstimate()), flights


def by_splitting(case: Case, seed: int) -> tuple[float, int]:
    """p̂ and the flights of twenty replicates, the first pass included."""
    flights = 0

    def margin(points: Points) -> Values:
        nonlocal flights
        flights += len(points)
        return case.margin(points.z, points.keys)

    ladder = splitting.learn(margin, case.dimension, seed, chains=LEARNERS)
    came = splitting.replicates(margin, ladder, seed, range(REPLICATES), chains=CHAINS)
    return float(np.mean([replicate.probability for replicate in came])), flights


def main() -> None:
    """Prints a table in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=20)
    repeats = parser.parse_args().repeats
    if importlib.util.find_spec("openturns") is None:
        print("OpenTURNS is not installed: nothing to compare with")
        return
    print("| margin | method | mean p̂/p | variation | flights |\n|---|---|---|---|---|")
    states = REPLICATES * CHAINS * splitting.STATES
    for name in SHOWN:
        case = CASES[name]()
        for method, run in (("splitting", by_splitting), ("OpenTURNS", lambda case, seed: by_openturns(case, seed, states))):
            came = np.array([run(case, seed) for seed in range(repeats)])
            ratio = came[:, 0] / case.probability
            print(f"| {name} | {method} | {ratio.mean():.3f} | {ratio.std(ddof=1):.3f} | {came[:, 1].mean():,.0f} |", flush=True)


if __name__ == "__main__":
    main()
