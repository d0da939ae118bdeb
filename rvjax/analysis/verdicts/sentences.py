"""Sentences of verdicts. Bounds are rounded outwards, with enough digits to differ from the required value."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Decimal
from typing import TYPE_CHECKING

from rvjax.analysis.percentages import chosen, rounded
from rvjax.analysis.verdicts.verdict import Evidence, Under

if TYPE_CHECKING:
    from rvjax.campaign import Requirement
    from rvjax.campaign.bound import Bound
    from rvjax.stats import Estimate

MANY = 10**9
"""More samples than this are not suggested."""


def success_of(requirement: Requirement, unit: str = "") -> str:
    """The condition a sample must meet, in words: settling_time_s below 150 s. unit: of the metric."""
    never = "not " if requirement.at_most is not None else ""
    return f"{never}{condition(requirement, unit)}{_of_class(requirement)}{_under(requirement)}"


def title(requirement: Requirement) -> str:
    """A short title of the requirement: its name, or its condition."""
    if requirement.name:
        return requirement.name
    what = condition(requirement, "")
    if requirement.quantile is not None:
        what = f"{requirement.quantile:.12g} quantile of {what}"
    elif requirement.mean:
        what = f"mean of {what}"
    elif requirement.at_most is not None:
        what = f"{what}: at most {requirement.at_most:.12g}"
    else:
        what = f"{what}: at least {requirement.limit:.12g}"
    return what + _of_class(requirement) + _under(requirement)


def of_share(
    requirement: Requirement, successes: int, share: Estimate, quantity: Estimate | None, unit: str, under: Under | None = None
) -> str:
    """How many samples comply, the bounds of their share, and the required share."""
    percent = _percentages(requirement.limit, share)
    observed = f" ({percent[3]})" if share.n else ""
    confidence = f"with {chosen(share.confidence)} % confidence"
    stopping = " at any stopping time" if requirement.is_sequential else ""
    never = "not " if requirement.at_most is not None else ""
    text = (
        f"{_start(requirement, under)}{never}{condition(requirement, unit)} in {successes} of {share.n} samples"
        f"{_of_class(requirement)}{observed}. "
        f"The share is at least {percent[1]} and at most {percent[2]}, each {confidence}{stopping}; "
        f"{percent[0]} is required."
    )
    if quantity is not None:
        low, high = number(quantity.low, unit, ROUND_FLOOR), number(quantity.high, unit, ROUND_CEILING)
        middle = number(quantity.value, unit)
        text += f" The {requirement.quantile:.12g}-quantile is {middle}, at least {low} and at most {high}, each {confidence}."
    return text


def of_mean(
    requirement: Requirement, bound: Bound, mean: Estimate, unit: str, *, outside: int, lost: int, under: Under | None = None
) -> str:
    """The mean, its bounds and the required bound."""
    low, high = number(mean.low, unit, ROUND_FLOOR), number(mean.high, unit, ROUND_CEILING)
    confidence = f"with {chosen(mean.confidence)} % confidence"
    if requirement.range is None:
        confidence += " (approximate, since its range is not stated: on skewed values a bound errs several times as often)"
    text = (
        f"{_start(requirement, under)}mean of {_metric(requirement)} over {mean.n} samples{_of_class(requirement)}: "
        f"{number(mean.value, unit)}, at least {low} and at most {high}, each {confidence}; "
        f"it must be {bound.side} {number(bound.value, unit)}."
    )
    if lost:
        text += f" Samples without a value ({lost}) count as the worst value."
    if outside and requirement.range is not None:
        ends = " to ".join(number(end, unit) for end in requirement.range)
        text += (
            f" {outside} values lie outside the stated range of {ends}, so the bounds do not hold; "
            "state a range that contains all values."
        )
    return text


def outlook(requirement: Requirement, n: int, more: int | None) -> str:
    """What it takes to decide an undecided requirement. n: samples so far; more: further ones, None for too many."""
    if requirement.method == "sprt":
        return "More samples would decide; resume with a larger --samples."
    if more is None:
        return f"The share is so close to the required share that a decision needs more than {MANY:,} further samples."
    about = f"About {more:,} more samples would decide if the share stayed the same"
    if requirement.method == "sequential":
        return f"{about}; resume with a larger --samples."
    return f"{about}; fly {n + more:,} samples with another seed, because a fixed number may be judged only once."


def stopped(requirement: Requirement, evidence: Evidence) -> str:
    """After how many samples a sequential method decided, and with what evidence."""
    assert evidence.decided is not None
    at = evidence.decided
    passing = evidence.passing[at] >= evidence.needed_pass
    logarithms, needed = (evidence.passing, evidence.needed_pass) if passing else (evidence.failing, evidence.needed_fail)
    decided = (
        f"Decided after {evidence.samples[at]:,} samples: the evidence is {_power(logarithms[at])}, {_power(needed)} is needed."
    )
    if requirement.method == "sprt":
        ends = (requirement.design, requirement.limit)
        likelier, other = ends if passing else ends[::-1]
        return f"{decided} The samples fit a share of {chosen(likelier)} % better than a share of {chosen(other)} %."
    return decided


def _power(logarithm: float) -> str:
    """e^x to three digits, as a power of ten where it is very large or small."""
    return f"{math.exp(logarithm):.3g}" if abs(logarithm) < 100 else f"10^{logarithm / math.log(10):.0f}"


def _start(requirement: Requirement, under: Under | None = None) -> str:
    law = "" if under is None else f"under {under.law} ({under.kept:,} kept of {under.flown:,} samples): "
    return f"{requirement.name}: {law}" if requirement.name else law


def _metric(requirement: Requirement) -> str:
    return requirement.metric + (f" ({requirement.channel})" if requirement.channel else "")


def condition(requirement: Requirement, unit: str) -> str:
    """settling_time_s below 200 s."""
    bound = requirement.bound
    return _metric(requirement) + (f" {bound.side} {number(bound.value, unit)}" if bound else "")


def _of_class(requirement: Requirement) -> str:
    conditions = " and ".join(f"{draw} {condition}" for draw, condition in requirement.where.items())
    return f" with {conditions}" if conditions else ""


def _under(requirement: Requirement) -> str:
    return f" under {requirement.under}" if requirement.under else ""


def _percentages(limit: float, share: Estimate) -> list[str]:
    """In percent: the limit, the lower bound of the share (rounded down), its upper bound (rounded up), and its value.

    They have 2 to 8 decimals, enough to tell them from the limit, and more where they would read as 0 or 100 otherwise.
    """
    gaps = [abs(100 * (end - limit)) for end in (share.low, share.high, share.value) if abs(end - limit) > 1e-9]
    decimals = min(max([2, *(math.ceil(-math.log10(gap)) + 1 for gap in gaps)]), 8)
    ends = ((limit, ROUND_HALF_EVEN), (share.low, ROUND_FLOOR), (share.high, ROUND_CEILING), (share.value, ROUND_HALF_EVEN))
    return [f"{rounded(Decimal(f'{100 * end:.14g}'), decimals, way):f} %" for end, way in ends if not math.isnan(end)]


def number(value: float, unit: str, way: str = ROUND_HALF_EVEN) -> str:
    """A number to four digits with its unit. An error in its 13th digit, as of a sum of many steps, does not move an end."""
    if value and math.isfinite(value):
        exact = Decimal(f"{value:.12g}")
        value = float(exact.quantize(Decimal(1).scaleb(exact.adjusted() - 3), rounding=way))
    return f"{value:.4g} {unit}" if unit not in ("", "1") else f"{value:.4g}"
