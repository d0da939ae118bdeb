"""The laws that a campaign names before it flies: which of its samples are samples of each, and whether that can decide.

    section `laws` ─at its places→ the campaign a second time ─compare→ OtherLaw ─thinning→ n/W of n samples, in the mean

A law that a requirement names must lie within the laws of the campaign, with a bounded ratio: only then are the samples that
thinning keeps independent samples of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from rvjax.campaign import Source
from rvjax.campaign.named_laws import LAWS
from rvjax.campaign.overrides import override, replaced_by
from rvjax.errors import CampaignError, Finding
from rvjax.simulation.law_checks import Anchor, followers, other_law
from rvjax.simulation.requirement_checks import reach
from rvjax.stats.other_laws import OtherLaw
from rvjax.stats.reweighting import FEWEST_KEPT

if TYPE_CHECKING:
    from rvjax.simulation.problem import Problem

RESHAPE = "accepted under a law: laws within those of the campaign, with a bounded ratio; `rvjax reweigh` shows others"


def with_laws(problem: Problem, load: Callable[[Source], Problem]) -> Problem:
    """The problem with its named laws, and its requirements with theirs. load: the problem of a source.

    CampaignError with every finding: what is no law of a draw, and requirements that the samples of their law cannot decide.
    """
    findings: list[Finding] = []
    laws: dict[str, OtherLaw] = {}
    for name in problem.spec.laws:
        try:
            laws[name] = _law(problem, name, load)
        except CampaignError as error:
            findings += error.findings
    if findings or (findings := [*_undecidable(problem, laws)]):
        raise CampaignError(dict.fromkeys(findings))
    if not laws:
        return problem
    require = tuple(requirement.judged_under(laws) for requirement in problem.spec.require)
    return replace(problem, spec=problem.spec.model_copy(update={"require": require}), laws=laws)


def expected(samples: int, law: OtherLaw) -> int:
    """How many of the samples thinning keeps, in the mean."""
    return round(samples * law.share_kept)


def pinned(problem: Problem, changed: Callable[[tuple[str, ...]], Problem]) -> tuple[Problem, list[str]]:
    """The problem with other laws, and the numbers that stay as they are flown although they follow from these laws by default.
    changed: the problem with other laws and these numbers."""
    new = changed(())
    pins = followers(problem, new)
    return (changed(tuple(pins)) if pins else new), pins


def _law(problem: Problem, name: str, load: Callable[[Source], Problem]) -> OtherLaw:
    place, source = (LAWS, name), problem.spec.source
    changed = replaced_by(source, place)
    label = f"under {name}"
    try:
        new, _ = pinned(problem, lambda pins: load(override(changed, pins)))
    except CampaignError as error:
        raise CampaignError([replace(finding, found=f"{label}: {finding.found}") for finding in error.findings]) from None
    places = {key: (source.where((*place, key), key=True), label) for key in problem.spec.laws[name]}
    return other_law(problem, new, Anchor(places, ""))


def _undecidable(problem: Problem, laws: dict[str, OtherLaw]) -> Iterator[Finding]:
    """Findings about laws that no verdict can be under, and requirements that no outcome decides."""
    spec = problem.spec
    for name in dict.fromkeys(requirement.under for requirement in spec.require):
        if name is None or name not in laws:
            continue
        law, place = laws[name], (LAWS, name)
        kept = expected(spec.samples, law)
        if law.beyond > 0.0:
            message = f"{100 * law.beyond:.3g} % of {name} lies beyond the laws of the campaign"
            yield spec.source.finding(place, message, RESHAPE, key=True)
        elif not math.isfinite(law.log_sup):
            message = f"the ratio of {name} to the laws of the campaign has no upper bound"
            yield spec.source.finding(place, message, RESHAPE, key=True)
        elif kept < FEWEST_KEPT:
            message = f"about {kept} of {spec.samples:,} samples would be samples of {name}, fewer than {FEWEST_KEPT}"
            yield spec.source.finding(place, message, "accepted: more samples, or laws nearer to those of the campaign", key=True)
        else:
            for index, requirement in enumerate(spec.require):
                if requirement.under == name and not any(reach(requirement, kept)):
                    message = f"about {kept} of {spec.samples:,} samples are kept under {name}: they reach neither PASS nor FAIL"
                    yield spec.source.finding(("require", index), message, "accepted: more samples, or a lower confidence")
