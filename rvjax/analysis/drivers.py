"""Which draws matter, from a run that is there: every draw with every result, by `rvjax.stats.rank_dependence`.

    result          values                                       lost flights
    a failure       1 where a requirement is not met             fail
    a metric        in SI                                        the worst rank in ξ; left out of S, with the share left out

ξ finds every form of dependence, S is the share of the variance that the draw explains by itself. The p-values of ξ are Holm's
for all draws and results together. They need independent samples; without, ξ and S are observed values.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second
from numpy.typing import NDArray

from rvjax.analysis.run_totals import metric
from rvjax.analysis.verdicts.compliance import RequirementEvaluator
from rvjax.analysis.verdicts.sentences import title
from rvjax.campaign import Requirement
from rvjax.columns import DRAW, METRIC, Column
from rvjax.stats import Estimate, holm
from rvjax.stats.rank_dependence import Dependence, order_of, rank_index
from rvjax.stats.reweighting import Class, shares_of_classes
from rvjax.stats.sampling_design import Independent, Observed, SamplingDesign

Values = NDArray[np.float64]

FEWEST = 30
"""Samples."""

CLASSES = 5

LARGEST_PART, LEAST_PARTS = 0.05, 10.0
"""A value with a larger part of the variance than 5 %, and than ten even parts, decides S by itself: S is not shown."""

REJECTED = ".rejected"
NOT_CAPTURED = "not captured"


@dataclass(frozen=True)
class Result:
    """name; values: (n,) with the worst value in place of a lost flight; failure: whether it is an indicator of failures."""

    name: str
    values: Values
    unit: str = "1"
    failure: bool = False


@dataclass(frozen=True)
class Driver:
    """A draw with a result. xi; way: of its p-value; p, p_holm: by itself, and of all pairs together; None without independent
    samples. share: the first-order index, None where fewer than 30 values are finite; left_out: share of the values that are not.
    """

    draw: str
    result: str
    xi: float
    way: str
    p: float | None
    p_holm: float | None
    share: Estimate | Observed | None
    left_out: float


@dataclass(frozen=True)
class Drivers:
    """pairs: of every draw and result, the least probable by chance first. n: samples; draws: the names of those that vary."""

    pairs: tuple[Driver, ...]
    n: int
    draws: tuple[str, ...]
    confidence: float

    def of(self, result: str) -> list[Driver]:
        """The pairs of a result."""
        return [pair for pair in self.pairs if pair.result == result]

    def clear(self, result: str) -> list[Driver]:
        """The pairs of a result that are not by chance, at the confidence for all pairs together."""
        return [pair for pair in self.of(result) if pair.p_holm is not None and pair.p_holm <= 1.0 - self.confidence]


def varied(frame: pd.DataFrame) -> dict[str, Values]:
    """Every draw that varies, by its name, and the length of every drawn vector as |name|."""
    names = [str(name) for name in frame.columns if str(name).startswith(DRAW) and not str(name).endswith(REJECTED)]
    numeric = [name for name in names if pd.api.types.is_numeric_dtype(frame[name])]
    drawn = {name.removeprefix(DRAW): frame[name].to_numpy(dtype=float) for name in numeric}
    stems = sorted(name.removesuffix(".x") for name in drawn if name.endswith(".x"))
    vectors = [stem for stem in stems if f"{stem}.y" in drawn and f"{stem}.z" in drawn]
    drawn |= {f"|{stem}|": np.linalg.norm([drawn[f"{stem}.{axis}"] for axis in "xyz"], axis=0) for stem in vectors}
    return {name: x for name, x in drawn.items() if x.size and x.min() < x.max()}


def failures(frame: pd.DataFrame, requirements: Iterable[Requirement]) -> list[Result]:
    """Which flights are not captured, and which do not meet each requirement on a share, those whose draws
    its class and its law do not have left as good."""
    found = [Result(NOT_CAPTURED, (frame["outcome"] != "captured").to_numpy(dtype=float), failure=True)]
    for number, requirement in enumerate(requirements, 1):
        same = requirement.metric == "captured" and not requirement.where and not requirement.under
        if not requirement.mean and not same:
            evaluator = RequirementEvaluator(requirement)
            failing = ~evaluator.comply(evaluator.values(frame, {})) & evaluator.possible(frame)
            found.append(Result(f"requirement {number}: {title(requirement)}", failing.astype(float), failure=True))
    return found


def metrics(frame: pd.DataFrame, columns: Mapping[str, Column], names: Sequence[str] = ()) -> list[Result]:
    """The metrics of a table, or those of these names; without `captured`, which is a failure."""
    known = [str(name).removeprefix(METRIC) for name in frame.columns if str(name).startswith(METRIC)]
    chosen = [name for name in known if name != "captured" and (not names or name in names)]
    return [Result(name, metric(frame, name, columns), columns[METRIC + name].unit) for name in chosen]


def drivers(
    drawn: Mapping[str, Values],
    results: Sequence[Result],
    design: SamplingDesign,
    confidence: float = 0.95,
) -> Drivers:
    """Every draw (`varied`) with every result that varies."""
    rng = np.random.Generator(np.random.Philox(key=0))
    orders = {name: order_of(x, rng) for name, x in drawn.items()}
    independent = isinstance(design, Independent)
    pairs: list[Driver] = []
    for result in results:
        if len(result.values) < FEWEST or result.values.min() == result.values.max():
            continue
        dependence, finite = Dependence(result.values, rng), np.isfinite(result.values)
        for name, order in orders.items():
            xi = dependence.xi(order)
            p = dependence.p(xi) if independent else None
            share = _share(result.values, order, finite, confidence, independent)
            left_out = 1.0 - float(np.mean(finite))
            pairs.append(Driver(name, result.name, xi, dependence.way if independent else "", p, None, share, left_out))
    return Drivers(_with_holm(pairs), len(next(iter(drawn.values()), ())), tuple(drawn), confidence)


def _with_holm(pairs: list[Driver]) -> tuple[Driver, ...]:
    adjusted: list[float | None] = [None] * len(pairs)
    if pairs and all(pair.p is not None for pair in pairs):
        adjusted = [float(p) for p in holm([pair.p or 0.0 for pair in pairs])]
    done = [Driver(**{**vars(pair), "p_holm": p}) for pair, p in zip(pairs, adjusted, strict=True)]
    return tuple(sorted(done, key=lambda pair: (1.0 if pair.p is None else pair.p, -pair.xi, pair.draw)))


def _share(
    y: Values, order: NDArray[np.int64], finite: NDArray[np.bool_], confidence: float, independent: bool
) -> Estimate | Observed | None:
    n = int(np.count_nonzero(finite))
    if n < FEWEST:
        return None
    inside = order[finite[order]]
    values = y[inside]
    squares = (values - float(values.mean())) ** 2
    if float(squares.max()) > max(LARGEST_PART, LEAST_PARTS / n) * float(squares.sum()):
        return None
    index = rank_index(values, np.arange(n))
    if not independent:
        return Observed(index.value, n)
    half = float(scipy.special.ndtri((1.0 + confidence) / 2.0)) * index.error
    method = "first-order index by ranks, normal, approximate"
    return Estimate(index.value, index.value - half, index.value + half, n, confidence, method)


def failing_classes(x: Values, failed: Values, design: SamplingDesign, confidence: float, classes: int = CLASSES) -> list[Class]:
    """P(failure | class of the draw) in classes of equal size, with bars that hold for all classes together (Clopper-Pearson).

    Without independent samples the bars are from 0 to 1.
    """
    found = shares_of_classes(x, failed > 0.5, classes, confidence)
    if isinstance(design, Independent):
        return found
    none = [Estimate(c.share.value, 0.0, 1.0, c.share.n, c.share.confidence, "observed") for c in found]
    return [c._replace(share=share) for c, share in zip(found, none, strict=True)]
