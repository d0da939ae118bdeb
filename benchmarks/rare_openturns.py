"""Subset sampling of OpenTURNS beside splitting, on margins with known answers: `python -m benchmarks.rare_openturns [--repeats
N]`.

OpenTURNS is no dependency; where it is not installed, the command says so and ends. Each row: the flights of a repeat, the mean
of p̂/p over the repeats, their coefficient of variation, the median of the lower and of the upper end of the interval at 95 %, how
often this holds p, and how many runs ended with an error of the library and are left out. The budget of splitting is the first
pass and twenty replicates; that of OpenTURNS one run with levels of the same probability (0.1) and as many states for each level
as all replicates together. What came out: docs/rare.md.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import importlib.util
from typing import Any, NamedTuple

import numpy as np

from benchmarks import markdown
from benchmarks.rare_coverage import CHAINS, CONFIDENCE, REPLICATES, Counted, repeat
from benchmarks.rare_margins import CASES, Case
from rvjax.stats.rare import splitting

BLOCK = 1000
"""Points of each call of the margin by OpenTURNS."""

SHOWN = ("linear 1e-6", "two-sided 1e-6", "4 half-spaces")


class Run(NamedTuple):
    """An estimate, the ends of its interval, and the flights that it took."""

    estimate: float
    low: float
    high: float
    flights: int


def by_openturns(case: Case, seed: int) -> Run | None:
    """A run of OpenTURNS' subset sampling; None where it ends with an error."""
    openturns: Any = __import__("openturns")
    openturns.RandomGenerator.SetSeed(seed)
    margin = Counted(case)

    def margins(points: Any) -> Any:
        z = np.asarray(points, dtype=np.float64)
        return margin(z, np.zeros(len(z), dtype=np.int64))[:, None].tolist()

    function = openturns.PythonFunction(case.dimension, 1, func_sample=margins)
    vector = openturns.CompositeRandomVector(function, openturns.RandomVector(openturns.Normal(case.dimension)))
    algorithm = openturns.SubsetSampling(openturns.ThresholdEvent(vector, openturns.LessOrEqual(), 0.0))
    algorithm.setConditionalProbability(1.0 / splitting.STATES)
    algorithm.setBlockSize(BLOCK)
    algorithm.setMaximumOuterSampling(REPLICATES * CHAINS * splitting.STATES // BLOCK)
    try:
        algorithm.run()
    except TypeError:  # its variance estimate is below 0 in some runs
        return None
    result = algorithm.getResult()
    estimate, length = result.getProbabilityEstimate(), result.getConfidenceLength(CONFIDENCE)
    return Run(estimate, estimate - length / 2.0, estimate + length / 2.0, margin.flights)


def by_splitting(case: Case, seed: int) -> Run | None:
    """The first pass and twenty replicates."""
    margin = Counted(case)
    came = repeat(case._replace(margin=margin), "splitting", seed)
    return Run(came.estimate, came.low, came.high, margin.flights)


def _row(name: str, method: str, p: float, came: list[Run | None]) -> str:
    runs = [run for run in came if run is not None]
    ratios = np.array([run.estimate for run in runs]) / p
    error = ratios.std(ddof=1) / np.sqrt(len(runs))
    low, high = (np.median([end(run) for run in runs]) / p for end in (lambda run: run.low, lambda run: run.high))
    holds = np.mean([run.low <= p <= run.high for run in runs])
    flights = np.mean([run.flights for run in runs])
    return (
        f"| {name} | {method} | {flights:,.0f} | {ratios.mean():.3f} ± {error:.3f} | {ratios.std(ddof=1):.3f} | "
        f"{low:.2f} p to {high:.2f} p | {100.0 * holds:.1f} % | {len(came) - len(runs)} |"
    )


def main() -> None:
    """Prints a table in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=200)
    repeats = parser.parse_args().repeats
    if importlib.util.find_spec("openturns") is None:
        print("OpenTURNS is not installed: nothing to compare with")
        return
    print(f"{repeats} repeats; OpenTURNS {importlib.metadata.version('openturns')}")
    columns = ("margin", "method", "flights", "mean p̂/p", "variation", "interval, median", "holds", "errors")
    print(markdown.head(columns))
    for name in SHOWN:
        case = CASES[name]()
        for method, run in (("splitting", by_splitting), ("OpenTURNS", by_openturns)):
            print(_row(name, method, case.probability, [run(case, seed) for seed in range(repeats)]), flush=True)


if __name__ == "__main__":
    main()
