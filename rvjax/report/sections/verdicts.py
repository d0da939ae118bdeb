"""Section: what was required, and whether the flown samples show it."""

from __future__ import annotations

import math
import re
from collections import Counter

from rvjax.analysis.verdicts import Verdict
from rvjax.campaign import Requirement
from rvjax.report.blocks import Cell, Headline, Mark, Named, Number, Section, Table
from rvjax.report.number_format import SPACE, capital, channel, count, label, percent, prefixed, setting
from rvjax.report.run_view import Run, is_share

_HEAD = ("requirement", "verdict", "share that complies", "required share", "quantile or mean", "basis")
_ORDER = ("FAIL", "UNDECIDED", "PASS")


def section(run: Run) -> Section:
    """One row per requirement: its verdict, the share of samples that comply with one-sided bounds, and a sentence."""
    title = "Requirements and verdicts"
    if not run.verdicts:
        why = run.basis.sentence or "the campaign states no requirement, so there is no verdict"
        return Section("verdicts", title, f"{capital(why)}{_of_plan(run)}.")
    words = Counter(verdict.verdict for verdict in run.verdicts)
    found = ", ".join(f"{words[word]} {word}" for word in _ORDER if words[word])
    caption = (
        "PASS: the lower bound of the share that complies reaches the required share. FAIL: the upper bound is below. "
        "UNDECIDED: neither, more samples are needed. Each bound alone holds at the requirement's confidence."
    )
    rows = tuple(_row(run, verdict, index) for index, verdict in enumerate(run.verdicts))
    plural = "s" if len(run.verdicts) > 1 else ""
    return Section("verdicts", title, f"{len(run.verdicts)} requirement{plural}: {found}.", (Table(caption, _HEAD, rows),))


def _of_plan(run: Run) -> str:
    """Why there is no verdict, where the samples do not allow any."""
    why = f". The samples are of the plan {run.spec.sampler.use}: they say nothing about the shares of all draws"
    return why if run.basis.sentence else ""


def headline(run: Run) -> Headline:
    """The top of the page: worst verdict of all, captured share, what was flown, and the account of all samples."""
    account = run.account
    words = {verdict.verdict for verdict in run.verdicts}
    word = next((word for word in _ORDER if word in words), "EXPLORATION" if run.basis.sentence else "NO REQUIREMENT")
    captured = run.share("captured", account.captured)
    sentence = {
        "PASS": "Every requirement is shown to hold.",
        "FAIL": "At least one requirement is shown not to hold.",
        "UNDECIDED": "No requirement is shown to fail, but the samples do not suffice to show that all hold.",
        "NO REQUIREMENT": "The campaign states no requirement.",
        "EXPLORATION": f"{capital(run.basis.sentence)}{_of_plan(run)}.",
    }[word]
    if account.missing:
        sentence += f" Incomplete: {count(account.missing)} of {count(account.requested)} samples are missing."
    horizon = run.spec.horizon
    facts: tuple[tuple[str, Cell], ...] = (
        ("Captured", captured),
        ("Controller", run.spec.controller.use),
        ("Horizon", f"{setting(horizon.duration_s)}{SPACE}s in steps of {setting(horizon.step_s)}{SPACE}s"),
        ("Captured if", _capture(run)),
        ("Flown", _flown(run)),
    )
    outcomes = (
        ("captured", account.captured),
        ("not_settled", account.not_settled),
        ("not_finite", account.not_finite),
        ("missing", account.missing),
    )
    return Headline(run.spec.name, run.spec.description, Mark(word), sentence, facts, outcomes)


def _capture(run: Run) -> str:
    tube = run.spec.capture
    radius = f"{setting(tube.position_m)}{SPACE}m and {setting(tube.attitude_mrp)} MRP"
    return f"within {radius} over the last {setting(tube.window_s)}{SPACE}s"


def _flown(run: Run) -> str:
    """When and with what, as far as the folder says."""
    known = {**run.provenance, **run.identity}
    words = {"started": "{}", "rvjax": "with rvjax {}", "precision": "in {}", "device": "on {}", "seed": "seed {}"}
    return ", ".join(text.format(known[name]) for name, text in words.items() if name in known)


def _row(run: Run, verdict: Verdict, index: int) -> tuple[Cell, ...]:
    requirement = verdict.requirement
    key = f"requirement.{index + 1}"
    found: Cell = "–"
    if verdict.quantity is not None:
        found = Number(f"{key}.quantile", verdict.quantity, *_unit(run, requirement))
    elif requirement.mean:
        found = Number(f"{key}.mean", verdict.estimate, *_unit(run, requirement))
    return (
        Named(requirement_words(run, requirement), verdict.text.removeprefix(f"{verdict.verdict}: ")),
        Mark(verdict.verdict),
        "–" if requirement.mean else Number(f"{key}.complies", verdict.estimate, percent=True),
        "–" if requirement.mean else percent(verdict.limit),
        found,
        f"{percent(requirement.confidence)} confidence, n = {count(verdict.n)}; {verdict.estimate.method}",
    )


def _unit(run: Run, requirement: Requirement) -> tuple[str, bool]:
    """(unit, whether shown in percent) of the metric that is required."""
    column = next((name for name in run.metrics(rf"{re.escape(requirement.metric)}(\..*)?")), "")
    return (run.column(column).unit if column else "1"), is_share(requirement.metric)


def requirement_words(run: Run, requirement: Requirement) -> str:
    """settling time: 95 % of samples below 200 s."""
    what = label(requirement.metric) + (f", {channel(requirement.channel)}" if requirement.channel else "")
    what += "".join(f", where {draw} {condition}" for draw, condition in requirement.where.items())
    side, bound = ("below", requirement.below) if requirement.below is not None else ("above", requirement.above)
    if bound is None:
        return f"{what}: at least {percent(requirement.limit)} of samples"
    unit, in_percent = _unit(run, requirement)
    value = percent(bound) if in_percent else f"{setting(bound)} {prefixed(math.inf, unit)[1]}".strip()
    if requirement.quantile is not None:
        return f"{what}: {percent(requirement.quantile)} quantile {side} {value}"
    if requirement.mean:
        return f"{what}: mean {side} {value}"
    if requirement.at_most is not None:
        return f"{what} {side} {value}: at most {percent(requirement.at_most)} of samples"
    return f"{what} {side} {value}: at least {percent(requirement.limit)} of samples"
