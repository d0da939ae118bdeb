"""Verdicts on rare failures: what ordinary flights and a search prove, and what remains an estimate.

    p    probability that a sample does not comply            p₁   largest accepted one            α = 1 − confidence

    PASS    proved       Clopper-Pearson of the ordinary flights: p ≤ p₁ at risk α                the only unconditional PASS
    FAIL    proved       p > p₁ by Clopper-Pearson of the ordinary flights, or by the e-value of the search's unbiased
                         estimates, each at risk α/2
    else    conditional  the estimate of the search holds if every failure region of weight was reached: UNDECIDED, or with
                         `accept: estimate` PASS where its nominal upper bound is ≤ p₁, FAIL where its lower bound is > p₁
            refused      UNDECIDED: ordinary flights disagree with the levels, or the weights cannot be trusted

No n flights prove that p is much below 1/n (docs/verdicts.md, "What n flights can prove"), so nothing else could be a PASS.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from decimal import ROUND_CEILING, ROUND_FLOOR

from rvjax.analysis.percentages import chosen
from rvjax.analysis.verdicts import sentences
from rvjax.analysis.verdicts.verdict import Basis, RareFailure, Verdict, Word
from rvjax.places import Place
from rvjax.run_folder import rare_record
from rvjax.run_folder.rare_record import RareRecord
from rvjax.stats import clopper_pearson_lower, clopper_pearson_upper
from rvjax.stats.rare.replicates import proved_lower_bound, student_interval

WORDS: dict[Basis, str] = {
    "counted": "proved by ordinary flights",
    "proved": "proved",
    "accepted": "by the estimate, conditional",
    "conditional": "estimate, conditional",
    "refused": "estimate refused",
    "missing": "not searched",
}
"""What a verdict rests on, in words."""


def conclude_all(verdicts: Iterable[Verdict], folder: Place | str) -> tuple[Verdict, ...]:
    """The verdicts of a run folder, those on rare failures with the records of their searches in it."""
    return tuple(
        conclude(verdict, rare_record.read(folder, number)) if verdict.requirement.is_rare else verdict
        for number, verdict in enumerate(verdicts, 1)
    )


def conclude(counted: Verdict, record: RareRecord | None) -> Verdict:
    """The verdict from the counts of ordinary flights and the record of a search, None where there is none."""
    requirement, n = counted.requirement, counted.n
    allowed, confidence, failing = requirement.allowed, requirement.confidence, counted.n - counted.successes
    half = 1.0 - (1.0 - confidence) / 2.0
    estimates = [] if record is None else record.estimates
    interval = student_interval(estimates, max(2.0 * confidence - 1.0, 1e-9)) if estimates else None
    rare = RareFailure(
        method=requirement.method,
        allowed=allowed,
        value=None if interval is None else interval.value,
        low=None if interval is None else interval.low,
        high=None if interval is None else interval.high,
        proved_low=max(clopper_pearson_lower(failing, n, half) if n else 0.0, proved_lower_bound(estimates, half)),
        proved_high=clopper_pearson_upper(failing, n, confidence) if n else 1.0,
        replicates=len(estimates),
        flights=0 if record is None else record.flights,
        ordinary=n,
        failing=failing,
        refusals=() if record is None else tuple(record.refusals),
        basis="missing",
    )
    word, basis = _decided(rare, accepted=requirement.accept == "estimate")
    rare = replace(rare, basis=basis)
    return replace(counted, verdict=word, rare=rare, text=f"{word}: {_text(counted, rare)}")


def _decided(rare: RareFailure, *, accepted: bool) -> tuple[Word, Basis]:
    if rare.proved_high <= rare.allowed:
        return "PASS", "counted"
    if rare.proved_low > rare.allowed:
        return "FAIL", "proved"
    if rare.low is None or rare.high is None:
        return "UNDECIDED", "missing"
    if rare.refusals:
        return "UNDECIDED", "refused"
    if accepted and rare.high <= rare.allowed:
        return "PASS", "accepted"
    if accepted and rare.low > rare.allowed:
        return "FAIL", "accepted"
    return "UNDECIDED", "conditional"


def _text(verdict: Verdict, rare: RareFailure) -> str:
    """What is known of the failure probability, what of it is proved, and what would decide."""
    requirement = verdict.requirement
    what = sentences.success_of(requirement)
    start = f"{requirement.name}: " if requirement.name else ""
    percent = f"with {chosen(requirement.confidence)} % confidence"
    known = (
        f"{start}{what}: violated in {rare.failing} of {rare.ordinary} ordinary flights, so with a probability of at most "
        f"{_up(rare.proved_high)} {percent} (proved); at most {rare.allowed:.6g} is accepted."
    )
    if rare.value is not None and rare.low is not None and rare.high is not None:
        known += (
            f" Estimate by {rare.method}: {rare.value:.3g}, at least {_down(rare.low)} and at most {_up(rare.high)}, each "
            f"{percent} (conditional: if every failure region of weight was reached; nominal: a bound errs somewhat more often "
            f"than it says); {rare.replicates} independent estimates from {rare.flights:,} flights."
        )
    known += f" Proved: at least {_down(rare.proved_low)} {percent}."
    return f"{known} {_conclusion(rare)}"


def _conclusion(rare: RareFailure) -> str:
    flights = rare.ordinary + rare.flights
    texts: dict[Basis, str] = {
        "counted": "The ordinary flights prove it.",
        "proved": "The lower bound proves the failure.",
        "accepted": "Nothing is proved; the estimate decides, because the requirement says accept: estimate.",
        "conditional": f"No {flights:,} flights, however chosen, prove much less than {_up(1 / max(1, flights))}, so an estimate "
        "is no proof; accept: estimate lets it decide.",
        "refused": f"The estimate is refused: {'; '.join(rare.refusals)}.",
        "missing": "The search has not been flown; `rvjax run` with the same --out flies it.",
    }
    return texts[rare.basis]


def _up(value: float) -> str:
    return sentences.number(value, "", ROUND_CEILING)


def _down(value: float) -> str:
    return sentences.number(value, "", ROUND_FLOOR)
