"""The confirmation: the winner and the original campaign, on draws that the search has not seen.

Each objective is estimated anew for both, their difference in pairs with a two-sided interval:

    quantile       paired percentile bootstrap (`rvjax.stats.quantile_shift`)
    probability    Newcombe's interval for paired shares
    mean           interval of the mean of the differences
    cvar, sum      paired percentile bootstrap

    optimism = what the search saw of the winner − what the fresh draws show, in the sense in which it looked too good
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.analysis.verdicts import judge_all
from rvjax.analysis.verdicts.compliance import complies
from rvjax.analysis.verdicts.sentences import title
from rvjax.campaign import Requirement, Spec
from rvjax.components.samplers import sampling_design_of
from rvjax.run_folder import RunFolder
from rvjax.run_folder.tuning_record import Confirmation, Confirmed, Interval, Kept
from rvjax.search.tuning.objective import Judge, Measure
from rvjax.stats import Estimate, mcnemar, mean_interval, newcombe, pairs_of, quantile_shift
from rvjax.stats.sampling_design import Independent

Values = NDArray[np.float64]

SEED = 20181
"""Of the bootstraps: the same folders give the same intervals."""

RESAMPLES = 2000


def confirm(tuned: Path, own: Path, spec: Spec, judge: Judge, searched: Sequence[float], confidence: float) -> Confirmation:
    """Judges two run folders of the same draws. spec: the original campaign, as it was confirmed. searched: the winner's
    objectives as the search saw them, then, of a weighted sum, the sum."""
    new, old = (RunFolder.open(path).samples() for path in (tuned, own))
    rows: list[Confirmed] = []
    for measure, seen in zip(judge.measures, searched, strict=False):
        x, y = measure.losses(new.frame), measure.losses(old.frame)
        share = measure.objective.probability
        values = [measure.shown(measure.value(values)) for values in (x, y)]
        estimate = _difference(measure, x, y, confidence)
        rows.append(_row(str(measure), measure.unit, share, seen, values, estimate, measure.largest or share))
    if judge.goal == "weighted" and len(judge.measures) > 1:
        sides = [[measure.losses(samples.frame) for measure in judge.measures] for samples in (new, old)]
        total = judge.total
        values = [total(side) for side in sides]
        estimate = _resampled(
            lambda rows_: total([x[rows_] for x in sides[0]]) - total([y[rows_] for y in sides[1]]), len(new.frame), confidence
        )
        rows.append(_row("weighted sum", "1", False, searched[-1], values, estimate, largest=False))
    kept = [*_kept(spec.require, new.frame, old.frame, spec)]
    return Confirmation(samples=len(new.frame), seed=spec.seed, confidence=confidence, objectives=rows, requirements=kept)


def _row(
    text: str, unit: str, share: bool, seen: float, values: Sequence[float], difference: Estimate, largest: bool
) -> Confirmed:
    tuned, original = values
    sign = -1.0 if largest else 1.0
    low, high = sorted((sign * difference.low, sign * difference.high))
    verdict = "better" if high < 0.0 else "worse" if low > 0.0 else "not told apart"
    optimism = sign * _minus(tuned, seen)
    return Confirmed(
        text=text,
        unit=unit,
        share=share,
        searched=seen,
        tuned=tuned,
        own=original,
        difference=Interval(value=difference.value, low=difference.low, high=difference.high),
        optimism=optimism,
        method=difference.method,
        verdict=verdict,
    )


def _difference(measure: Measure, x: Values, y: Values, confidence: float) -> Estimate:
    """Winner minus original, in the sense of the metric."""
    objective, generator = measure.objective, np.random.default_rng(SEED)
    if objective.probability:
        return newcombe(pairs_of(x < 0.5, y < 0.5), confidence)
    sign = -1.0 if measure.largest else 1.0
    if objective.quantile is not None:
        worst = -math.inf if measure.largest else math.inf
        return quantile_shift(sign * y, sign * x, objective.quantile, confidence, rng=generator, worst=worst)
    if objective.mean and np.isfinite(x).all() and np.isfinite(y).all():
        return mean_interval(sign * (x - y), confidence)
    return _resampled(lambda rows: sign * _minus(measure.value(x[rows]), measure.value(y[rows])), len(x), confidence)


def _minus(a: float, b: float) -> float:
    """a − b, NaN where both are infinite alike."""
    return a - b if math.isfinite(a) or math.isfinite(b) or a != b else math.nan


def _resampled(difference: Callable[[NDArray[np.int64]], float], n: int, confidence: float) -> Estimate:
    """A difference with its paired percentile bootstrap; where it is undefined, the interval is infinite."""
    generator = np.random.default_rng(SEED)
    resampled = np.array([difference(generator.integers(n, size=n)) for _ in range(RESAMPLES)])
    low, high = np.where(np.isnan(resampled), -np.inf, resampled), np.where(np.isnan(resampled), np.inf, resampled)
    tail = (1.0 - confidence) / 2.0
    method = f"paired percentile bootstrap, approximate, {RESAMPLES} resamples"
    ends = float(np.quantile(low, tail, method="lower")), float(np.quantile(high, 1.0 - tail, method="higher"))
    return Estimate(difference(np.arange(n)), *ends, n, confidence, method)


def _kept(requirements: Sequence[Requirement], new: pd.DataFrame, old: pd.DataFrame, spec: Spec) -> list[Kept]:
    """The verdicts on both, and for a share the samples in which a single side complies."""
    basis = sampling_design_of(spec)
    assert isinstance(basis, Independent), "a tuning is of independent samples"
    verdicts = [judge_all(requirements, frame, basis) for frame in (new, old)]
    kept: list[Kept] = []
    for requirement, tuned, original in zip(requirements, *verdicts, strict=True):
        only_tuned = only_own = p_worse = None
        if not requirement.mean:
            a, b = complies(requirement, new), complies(requirement, old)
            only_tuned, only_own = int(np.sum(a & ~b)), int(np.sum(b & ~a))
            p_worse = float(mcnemar(only_tuned, only_own, better="b"))
        kept.append(
            Kept(
                text=title(requirement),
                tuned=tuned.verdict,
                own=original.verdict,
                only_tuned=only_tuned,
                only_own=only_own,
                p_worse=p_worse,
            )
        )
    return kept
