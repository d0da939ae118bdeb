"""Section: the requirements and their verdicts."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence

from rvjax.analysis.verdicts import Verdict
from rvjax.campaign import Requirement
from rvjax.campaign.requirement import TRACED
from rvjax.report.blocks import Cell, Headline, Mark, Named, Number, Section, Table
from rvjax.report.number_format import SPACE, capital, channel, count, label, percent, prefixed, setting
from rvjax.report.run_view import Run, is_share

_HEAD = ("requirement", "verdict", "compliant share", "required share", "quantile or mean", "method")
_SEARCHED = (
    "Methods splitting and importance: PASS is proved by ordinary flights only, FAIL by these or by the proved lower bound of "
    "the search; an estimate is conditional on every failure region of weight having been reached, and decides only where the "
    "requirement accepts it."
)
_ORDER = ("FAIL", "UNDECIDED", "PASS")


def section(run: Run) -> Section:
    """One row per requirement: verdict, compliant share with one-sided bounds, and a sentence."""
    title = "Requirements and verdicts"
    if not run.verdicts:
        reason = run.design.sentence or "the campaign states no requirement, so there is no verdict"
        return Section("verdicts", title, f"{capital(reason)}{_plan_note(run)}.")
    words = Counter(verdict.verdict for verdict in run.verdicts)
    counts = ", ".join(f"{words[word]} {word}" for word in _ORDER if words[word])
    caption = _caption([verdict.requirement for verdict in run.verdicts])
    rows = tuple(_row(run, verdict, index) for index, verdict in enumerate(run.verdicts))
    plural = "s" if len(run.verdicts) > 1 else ""
    tables = (Table(caption, _HEAD, rows), *_traceability(run))
    return Section("verdicts", title, f"{len(run.verdicts)} requirement{plural}: {counts}.", tables)


def _traceability(run: Run) -> Iterator[Table]:
    """Where the requirements come from, if any says so: a column for each key that one of them states."""
    stated = [key for key in TRACED if any(key in verdict.requirement.origin for verdict in run.verdicts)]
    if stated:
        caption = "Traceability: where each requirement comes from, as the campaign states it."
        head = ("requirement", "verdict", *stated)
        rows = (
            (
                requirement_words(run, verdict.requirement),
                Mark(verdict.verdict),
                *(verdict.requirement.origin.get(key, "–") for key in stated),
            )
            for verdict in run.verdicts
        )
        yield Table(caption, head, tuple(rows))


def _caption(requirements: Sequence[Requirement]) -> str:
    """What the verdicts mean, for the methods that the campaign uses."""
    methods = {requirement.method for requirement in requirements if not requirement.mean}
    texts = {
        "fixed": "PASS: the lower confidence bound of the compliant share reaches the required share. FAIL: the upper bound lies "
        "below it.",
        "sequential": "Method sequential: PASS and FAIL as soon as the evidence for them reaches its decision level.",
        "sprt": "Method sprt: PASS as soon as the evidence for the expected share against the required share reaches its level; "
        "FAIL as soon as that against the expected share does.",
        "splitting": _SEARCHED,
        "importance": _SEARCHED,
    }
    parts = list(dict.fromkeys(text for method, text in texts.items() if method in methods))
    if any(requirement.mean for requirement in requirements):
        parts.append("Mean: PASS if its confidence interval lies on the required side of the bound, FAIL if on the other side.")
    if any(requirement.under for requirement in requirements):
        parts.append(
            "Under a law: judged by the samples that are independent samples of it, which the draws and a random number of a "
            "stream of its own decide; the campaign named the law before it flew."
        )
    one_sided = "UNDECIDED: neither; more samples are needed. Each bound is one-sided at the requirement's confidence."
    return " ".join([*parts, one_sided])


def _plan_note(run: Run) -> str:
    """Why an exploration has no verdict; empty for independent draws."""
    note = (
        f". The sampler {run.spec.sampler.use} does not make independent draws, so its samples do not estimate shares of the "
        "campaign's distribution"
    )
    return note if run.design.sentence else ""


def headline(run: Run) -> Headline:
    """The top of the page: the worst verdict, the captured share, the settings of the run, and the account of all samples."""
    account = run.account
    words = {verdict.verdict for verdict in run.verdicts}
    word = next((word for word in _ORDER if word in words), "EXPLORATION" if run.design.sentence else "NO REQUIREMENT")
    captured = run.share("captured", account.captured)
    sentence = {
        "PASS": "The samples show that every requirement holds.",
        "FAIL": "The samples show that at least one requirement does not hold.",
        "UNDECIDED": "No requirement fails, but there are too few samples to show that all of them hold.",
        "NO REQUIREMENT": "The campaign states no requirement.",
        "EXPLORATION": f"{capital(run.design.sentence)}{_plan_note(run)}.",
    }[word]
    if account.missing:
        sentence += f" Incomplete: {count(account.missing)} of {count(account.requested)} samples are missing."
    horizon = run.spec.horizon
    facts: tuple[tuple[str, Cell], ...] = (
        ("Captured", captured),
        ("Controller", run.spec.controller.use),
        ("Horizon", f"{setting(horizon.duration_s)}{SPACE}s in steps of {setting(horizon.step_s)}{SPACE}s"),
        ("Capture criterion", _capture(run)),
        ("Run", _run_facts(run)),
        *(("Warning", str(warning)) for warning in run.provenance.get("warnings", ())),
    )
    outcomes = (
        ("captured", account.captured),
        ("not_settled", account.not_settled),
        ("collided", account.collided),
        ("not_finite", account.not_finite),
        ("missing", account.missing),
    )
    return Headline(run.spec.name, run.spec.description, Mark(word), sentence, facts, outcomes)


def _capture(run: Run) -> str:
    tube = run.spec.capture
    radius = f"{setting(tube.position_m)}{SPACE}m and {setting(tube.attitude_mrp)} MRP"
    return f"within {radius} over the last {setting(tube.window_s)}{SPACE}s"


def _run_facts(run: Run) -> str:
    """Start time, version, precision, device and seed, where the folder records them."""
    known = {**run.provenance, **run.identity}
    words = {"started": "{}", "rvjax": "with rvjax {}", "precision": "in {}", "device": "on {}", "seed": "seed {}"}
    return ", ".join(text.format(known[name]) for name, text in words.items() if name in known)


def _row(run: Run, verdict: Verdict, index: int) -> tuple[Cell, ...]:
    requirement = verdict.requirement
    key = f"requirement.{index + 1}"
    quantity: Cell = "–"
    if verdict.quantity is not None:
        quantity = Number(f"{key}.quantile", verdict.quantity, *_unit(run, requirement))
    elif requirement.mean:
        quantity = Number(f"{key}.mean", verdict.estimate, *_unit(run, requirement))
    return (
        Named(requirement_words(run, requirement), verdict.text.removeprefix(f"{verdict.verdict}: ")),
        Mark(verdict.verdict),
        "–" if requirement.mean else Number(f"{key}.complies", verdict.estimate, percent=True),
        "–" if requirement.mean else percent(verdict.limit),
        quantity,
        f"{percent(requirement.confidence)} confidence, n = {count(verdict.n)}; {verdict.estimate.method}",
    )


def _unit(run: Run, requirement: Requirement) -> tuple[str, bool]:
    """(unit, whether shown in percent) of the required metric."""
    column = next((name for name in run.metrics(rf"{re.escape(requirement.metric)}(\..*)?")), "")
    return (run.column(column).unit if column else "1"), is_share(requirement.metric)


def requirement_words(run: Run, requirement: Requirement) -> str:
    """settling time: 95 % of samples below 200 s."""
    what = label(requirement.metric) + (f", {channel(requirement.channel)}" if requirement.channel else "")
    what += "".join(f", where {draw} {condition}" for draw, condition in requirement.where.items())
    what += f", under {requirement.under}" if requirement.under else ""
    bound = requirement.bound
    if bound is None:
        return f"{what}: at least {percent(requirement.limit)} of samples"
    unit, in_percent = _unit(run, requirement)
    value = percent(bound.value) if in_percent else f"{setting(bound.value)} {prefixed(math.inf, unit)[1]}".strip()
    if requirement.quantile is not None:
        return f"{what}: {percent(requirement.quantile)} quantile {bound.side} {value}"
    if requirement.mean:
        return f"{what}: mean {bound.side} {value}"
    if requirement.at_most is not None:
        return f"{what} {bound.side} {value}: at most {percent(requirement.at_most)} of samples"
    return f"{what} {bound.side} {value}: at least {percent(requirement.limit)} of samples"
