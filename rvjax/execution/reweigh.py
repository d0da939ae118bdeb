"""A finished run under other laws of its draws, without a flight (`rvjax.stats.reweighting`, `rvjax.simulation.law_checks`)."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.analysis.verdicts.compliance import RequirementEvaluator
from rvjax.analysis.verdicts.folders import campaign_of
from rvjax.analysis.verdicts.sentences import title
from rvjax.campaign import Requirement, Source
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.overrides import place_of
from rvjax.columns import draw_column
from rvjax.errors import CampaignError, IncompleteError, UsageError
from rvjax.places import Place
from rvjax.run_folder import RunFolder
from rvjax.simulation.law_checks import Anchor, other_law
from rvjax.simulation.named_laws import pinned
from rvjax.simulation.problem import Problem, load
from rvjax.stats import Estimate, clopper_pearson
from rvjax.stats.other_laws import OtherLaw
from rvjax.stats.reweighting import (
    FEWEST_KEPT,
    WeightQuality,
    control_variate,
    quality,
    self_normalised,
    with_the_rest,
)

CAPTURED = Requirement(metric="captured", at_least=0.5, name="captured")
"""Judged first, whatever the campaign requires: only its share is shown."""


@dataclass(frozen=True)
class Share:
    """The share of flights that comply with a requirement: as flown, among the kept samples (exact), and by weights (nominal);
    None where that is refused. required: the share, None where nothing is required."""

    name: str
    required: float | None
    flown: Estimate
    thinned: Estimate | None
    weighted: Estimate | None


@dataclass(frozen=True)
class Reweighed:
    """law: the other laws; n, kept: samples of the run and of the other law; quality: of the weights; refusals: why there is no
    exact, or no weighted, estimate; fresh: the command of a fresh run; pinned: numbers that follow from a changed law by default,
    but stay as they were flown; named: the name of the laws, where the campaign named them before it flew."""

    law: OtherLaw
    n: int
    kept: int
    quality: WeightQuality
    shares: tuple[Share, ...]
    refusals: tuple[str, ...]
    fresh: str
    pinned: tuple[str, ...] = ()
    named: str | None = None


def reweigh(
    place: str | Place, overrides: Sequence[str] = (), confidence: float = 0.95, *, named: str | None = None
) -> Reweighed:
    """The shares of a finished run under other laws. overrides: `place=value`, the laws; or named: a law of the campaign.

    IncompleteError if samples are missing; CampaignError with every finding about what is no law of a draw, and where neither the
    kept samples nor the weights are enough; UsageError for an unknown name.
    """
    folder = complete(place)
    before = [str(item) for item in folder.provenance.get("overrides", ())]
    source = folder.campaign_source()
    old = load(source, before)
    if named is not None:
        overrides = _values_of(old, named)
    new, pins, dropped = _changed(old, source, [*before, *overrides])
    command = ["rvjax", "run", str(folder.path / "campaign.yaml")]
    fresh = shlex.join([*command, *(word for item in (*before, *overrides, *pins, *dropped) for word in ("--set", item))])
    check_whole(folder, old, f"; or a fresh run: {fresh}")
    anchor = Anchor(_places(old, overrides), f"or a fresh run: {fresh}")
    law = other_law(old, new, anchor)
    evaluators = [RequirementEvaluator(requirement) for requirement in (CAPTURED, *_shown(old.spec.require, named))]
    frame = table(folder, evaluators, law.draws)
    found = replace(_reweighed(law, frame, evaluators, confidence, fresh), pinned=tuple(pins), named=named)
    if all(share.thinned is None and share.weighted is None for share in found.shares):
        raise CampaignError([anchor.finding((), "; ".join(found.refusals), "accepted: laws nearer to those of the run")])
    return found


def complete(place: str | Place) -> RunFolder:
    """A run folder with all its samples. IncompleteError if some are missing; UsageError for the folder of a search."""
    folder = RunFolder.open(place)
    if missing := folder.requested - folder.chunks.total:
        raise IncompleteError(f"{place}: {missing} samples are missing; `rvjax run` with the same --out flies them")
    campaign_of(folder)
    return folder


def table(folder: RunFolder, evaluators: Sequence[RequirementEvaluator], draws: Iterable[str]) -> pd.DataFrame:
    """All samples, with the columns that the requirements need and with these draws."""
    names = list(folder.columns())
    columns = dict.fromkeys(name for evaluator in evaluators for name in evaluator.columns(names))
    columns |= dict.fromkeys(map(draw_column, draws))
    return pd.concat([part for _, part, _ in folder.some(["sample", "outcome", *columns])], ignore_index=True)


def check_whole(folder: RunFolder, problem: Problem, instead: str = "") -> None:
    """CampaignError where a run stopped when it was decided: how many samples it has depends on what they showed."""
    if folder.requested < problem.spec.samples:
        flown = f"{folder.requested:,} of {problem.spec.samples:,} samples"
        message = f"the run stopped after {flown}, when they had decided its requirements"
        accepted = f"accepted: a run of all samples, by `rvjax run` with the same --out{instead}"
        raise CampaignError([problem.spec.source.finding(("samples",), message, accepted)])


def _values_of(problem: Problem, name: str) -> list[str]:
    """`place=value` of a named law. UsageError for an unknown name."""
    laws = problem.spec.laws
    if name not in laws:
        accepted = did_you_mean(name, laws) if laws else "accepted: --set, since the campaign names no laws"
        raise UsageError(f"--law {name}: no law that the campaign named before it flew; {accepted}")
    return [f"{place}={json.dumps(value)}" for place, value in laws[name].items()]


def _changed(old: Problem, source: Path | Source, overrides: Sequence[str]) -> tuple[Problem, list[str], list[str]]:
    """The campaign with other laws; the numbers that stay as they were flown; and what has to be left out, where laws that the
    campaign names do not fit the other laws."""
    dropped = list[str]()
    if old.spec.laws:
        try:
            load(source, overrides)
        except CampaignError:
            dropped = ["require=[]", "laws={}"]
    new, pins = pinned(old, lambda pins: load(source, [*overrides, *pins, *dropped]))
    return new, pins, dropped


def _places(old: Problem, overrides: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Where in the campaign stands what each `place=value` replaces, and the argument."""
    source = old.spec.source
    paths = {item.partition("=")[0]: item for item in overrides}
    return {path: (source.where(place_of(source.value, path), key=True), f"--set {item}") for path, item in paths.items()}


def _shown(require: Sequence[Requirement], named: str | None) -> list[Requirement]:
    """The requirements on shares under the laws of the campaign, and those under the law that is shown."""
    shares = [requirement for requirement in require if not requirement.mean and requirement.under in (None, named)]
    return [requirement.model_copy(update={"under": None}) if requirement.under else requirement for requirement in shares]


def _reweighed(
    law: OtherLaw, frame: pd.DataFrame, evaluators: Sequence[RequirementEvaluator], confidence: float, fresh: str
) -> Reweighed:
    samples = frame["sample"].to_numpy(dtype=np.int64)
    drawn = {name: frame[draw_column(name)].to_numpy(dtype=float) for name in law.draws}
    log_w = law.log_weights(drawn)
    weights = np.exp(log_w)
    refusals: list[str] = []
    mask = law.keeps(samples, drawn) if math.isfinite(law.log_sup) else np.zeros(len(frame), dtype=bool)
    kept = int(np.count_nonzero(mask))
    if not math.isfinite(law.log_sup):
        refusals.append("the ratio of the new law to the old one has no upper bound, so no samples can be kept")
    elif kept < FEWEST_KEPT:
        refusals.append(f"{kept} of {len(frame):,} samples are kept, fewer than {FEWEST_KEPT}")
    found = quality(weights)
    if complaints := found.complaints():
        refusals.append(f"the weights have {', and '.join(complaints)}")
    exact, nominal = math.isfinite(law.log_sup) and kept >= FEWEST_KEPT, not complaints
    shares = [
        _share(evaluator, frame, mask if exact else None, weights if nominal else None, law, confidence)
        for evaluator in evaluators
    ]
    return Reweighed(law, len(frame), kept, found, tuple(shares), tuple(refusals), fresh)


def _share(
    evaluator: RequirementEvaluator,
    frame: pd.DataFrame,
    mask: NDArray[np.bool_] | None,
    weights: NDArray[np.float64] | None,
    law: OtherLaw,
    confidence: float,
) -> Share:
    chosen = evaluator.chosen(frame)
    good = evaluator.comply(evaluator.values(frame, {}))[chosen]
    requirement = evaluator.requirement
    thinned = weighted = None
    if mask is not None:
        inside = good[mask[chosen]]
        thinned = with_the_rest(clopper_pearson(int(np.count_nonzero(inside)), len(inside), confidence), law.beyond)
    if weights is not None and len(good) > 1:
        estimator = control_variate if chosen.all() else self_normalised
        weighted = with_the_rest(_clipped(estimator(weights[chosen], good, confidence)), law.beyond)
    flown = clopper_pearson(int(np.count_nonzero(good)), len(good), confidence)
    required = None if requirement is CAPTURED else requirement.limit
    return Share(title(requirement), required, flown, thinned, weighted)


def _clipped(estimate: Estimate) -> Estimate:
    """A share within 0 and 1."""
    low, value, high = (min(1.0, max(0.0, x)) for x in (estimate.low, estimate.value, estimate.high))
    return Estimate(value, low, high, estimate.n, estimate.confidence, estimate.method)
