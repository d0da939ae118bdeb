"""Checks of requirements that the samples of a campaign can never decide, before it flies."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator

from rvjax.campaign import Requirement, Spec
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.formula import TimeShare
from rvjax.columns import MARGIN
from rvjax.errors import Finding
from rvjax.stats import clopper_pearson_lower, clopper_pearson_upper, log_e_fail, log_e_pass, log_ratio


def findings(spec: Spec, draws: Collection[str]) -> list[Finding]:
    """Findings about classes by unknown draws, undecidable requirements and wrong interpretations. draws: the names of all."""
    return [*_classes(spec, {*draws, *counted(spec)}), *_undecidable(spec), *_interpretations(spec), *_unsearchable(spec, draws)]


def reach(requirement: Requirement, samples: int) -> tuple[bool, bool]:
    """Whether the samples can reach PASS (if all comply) and FAIL (if none complies)."""
    limit, confidence, n = requirement.limit, requirement.confidence, samples
    if requirement.mean or requirement.is_rare:
        return True, True
    if requirement.method == "fixed":
        return clopper_pearson_lower(n, n, confidence) >= limit, clopper_pearson_upper(0, n, confidence) < limit
    needed = -math.log(1.0 - confidence)
    if requirement.method == "sequential":
        return float(log_e_pass(n, 0, limit)) >= needed, float(log_e_fail(n, n, limit)) >= needed
    best, worst = (float(log_ratio(n, failures, limit, requirement.design)) for failures in (0, n))
    return best >= needed, -worst >= -math.log(1.0 - requirement.strength)


def _classes(spec: Spec, names: Collection[str]) -> Iterator[Finding]:
    for index, requirement in enumerate(spec.require):
        for draw in requirement.where:
            if draw not in names:
                place = ("require", index, "where", draw)
                yield spec.source.finding(
                    place, f"{draw} is no draw of this campaign", did_you_mean(draw, sorted(names)), key=True
                )


def counted(spec: Spec) -> Iterator[str]:
    """Columns that count draws: how many channels of a fault fail."""
    for fault in spec.faults:
        if "schedule" in fault.parameters:
            yield f"{fault.prefix}.schedule.failing"


def _undecidable(spec: Spec) -> Iterator[Finding]:
    for index, requirement in enumerate(spec.require):  # those under a law: `rvjax.simulation.named_laws`
        if requirement.under is None and not any(reach(requirement, spec.samples)):
            message = f"{spec.samples} samples can reach neither PASS nor FAIL"
            yield spec.source.finding(("require", index), message, "accepted: more samples, or a lower confidence")


def _unsearchable(spec: Spec, draws: Collection[str]) -> Iterator[Finding]:
    """Rare failures of a campaign without draws: every flight is the same."""
    for index, requirement in enumerate(spec.require):
        if requirement.is_rare and not draws:
            message = f"nothing is drawn, so method {requirement.method} has nothing to search"
            yield spec.source.finding(("require", index, "method"), message, "accepted: a campaign with a distribution")


def _interpretations(spec: Spec) -> Iterator[Finding]:
    """Interpretations (ECSS-E-ST-60-10C) that do not fit the form of a requirement.

    ensemble: a share of samples. temporal: a share of samples has a share of time. mixed: the mean share of time.
    """
    shares = {f"{MARGIN}{name}" for name, formula in spec.margins.items() if isinstance(formula, TimeShare)}
    for index, requirement in enumerate(spec.require):
        of_time, shown = requirement.metric in shares, requirement.above is not None
        forms = {
            "ensemble": (not of_time and not requirement.mean, "a share or a quantile of a metric that is no share of time"),
            "temporal": (
                of_time and shown and requirement.at_least is not None,
                "above and at_least of a margin that is a time_share",
            ),
            "mixed": (
                of_time and shown and requirement.mean and requirement.range == (0.0, 1.0),
                "mean: true, above and range: [0, 1] of a margin that is a time_share",
            ),
        }
        if requirement.interpretation is not None and not forms[requirement.interpretation][0]:
            message = f"this requirement has no {requirement.interpretation} interpretation"
            place = ("require", index, "interpretation")
            yield spec.source.finding(place, message, f"accepted: {forms[requirement.interpretation][1]}")
