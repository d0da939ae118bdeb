"""Section: the winner compared with the original campaign on fresh draws."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rvjax.report.blocks import Cell, Code, Headline, Mark, Number, Section, Table
from rvjax.report.number_format import count, percent, quantity, share
from rvjax.run_folder.tuning_record import Confirmation, Confirmed, Kept, Missed, Searched
from rvjax.stats import Estimate
from rvjax.stats.sampling_design import Observed

_UNDECIDED = "not told apart"  # in `search.json`
UNMET = "NOT MET"
WORDS = {"better": "BETTER", "worse": "WORSE", _UNDECIDED: "NO CLEAR DIFFERENCE"}


def headline(search: Searched) -> Headline:
    """The top of the page: the first objective on fresh draws, as a word and as a sentence."""
    confirmation = search.confirmation
    assert confirmation is not None, "a search ends with its confirmation"
    exits = [row.left for row in search.rows if row.candidate]
    facts: tuple[tuple[str, Cell], ...] = (
        ("method", search.method),
        ("candidates", Number("search.candidates", len(exits))),
        ("candidate flights", Number("search.flights", search.cost.flights)),
        ("fresh samples", Number("search.fresh", confirmation.samples)),
        ("compiled programs", Number("search.programs", search.cost.programs)),
    )
    outcomes = tuple((name, exits.count(key)) for key, name in _EXITS.items() if exits.count(key) or not key)
    word, sentence = overall(search)
    return Headline(
        search.name,
        search.description,
        Mark(word),
        sentence,
        facts,
        outcomes,
        kind="Tuning report",
        total_label="candidates",
    )


_EXITS = {
    "": "flew_all_samples",
    "test": "eliminated_by_a_test",
    "halving": "eliminated_by_halving",
    "refused": "with_invalid_values",
    "budget": "stopped_by_the_budget",
}
"""How a candidate left its race (`Row.left`), in words."""


def value_text(value: float, objective: Confirmed) -> str:
    """A value of an objective with its unit; a dash for a difference of two infinite values."""
    if math.isnan(value):
        return "–"
    return share(value, 4) if objective.share else quantity(value, objective.unit)


def _passed(confirmation: Confirmation) -> list[str]:
    """Requirements that the winner passes and the original campaign fails."""
    return [kept.text for kept in confirmation.requirements if kept.tuned == "PASS" and kept.own == "FAIL"]


def _lost(confirmation: Confirmation) -> list[str]:
    """Requirements that the original campaign passes and the winner does not."""
    return [kept.text for kept in confirmation.requirements if kept.own == "PASS" and kept.tuned != "PASS"]


def _sentence(search: Searched, first: Confirmed, passed: Sequence[str], lost: Sequence[str]) -> str:
    if not search.best:
        return f"No candidate was better than the original campaign: {first.text} {value_text(first.own, first)}."
    values = f"{first.text} {value_text(first.tuned, first)}; original campaign {value_text(first.own, first)}."
    if not passed and not lost:
        return f"Candidate {search.best} on fresh draws: {values}"
    changes = [f"passes {', '.join(passed)} (the original campaign fails)"] if passed else []
    changes += [f"does not pass {', '.join(lost)} (the original campaign passes)"] if lost else []
    return f"Candidate {search.best} on fresh draws {' and '.join(changes)}. Objective: {values}"


def overall(search: Searched) -> tuple[str, str]:
    """(word, sentence). Requirements that only the winner or only the original campaign passes come before objectives, as in the
    search."""
    confirmation = search.confirmation
    assert confirmation is not None, "a search ends with its confirmation"
    if search.missed:
        return UNMET, f"No candidate meets the requirements, so the original campaign is kept. {shortfall(search)}"
    first = confirmation.objectives[-1] if search.goal == "weighted" else confirmation.objectives[0]
    passed, lost = (_passed(confirmation), _lost(confirmation)) if search.best else ([], [])
    word = "worse" if lost else "better" if passed else first.verdict
    return WORDS[word], _sentence(search, first, passed, lost)


def shortfall(search: Searched) -> str:
    """The candidate that comes closest to the requirements, and what it misses by how much."""
    assert search.closest is not None, "no candidate meets the requirements"
    name = f"Candidate {search.closest}" if search.closest else "The original campaign itself"
    samples = count(search.row[search.closest].samples)
    return f"{name} comes closest: {'; '.join(map(_missed, search.missed))} ({samples} samples of the search)."


def _missed(missed: Missed) -> str:
    if missed.share:
        return f"{missed.text}, met in {100 * missed.observed:.4g} %, {100 * (missed.limit - missed.observed):.3g} points short"
    excess = quantity(abs(missed.observed - missed.limit), missed.unit)
    return f"{missed.text}, mean {quantity(missed.observed, missed.unit)}, beyond the bound by {excess}"


def section(search: Searched) -> Section | None:
    """Objectives with differences and intervals, then requirements; None if the search has no confirmation."""
    confirmation = search.confirmation
    if confirmation is None:
        return None
    tables = [_objectives(search, confirmation)]
    if confirmation.requirements:
        tables.append(_requirements(confirmation))
    note = "The winner is a campaign file. Its run and the run of the original campaign have separate reports."
    return Section("confirmation", "Confirmation on fresh draws", _lead(search), (*tables, note, _FILES))


def _objectives(search: Searched, confirmation: Confirmation) -> Table:
    methods = "; ".join(dict.fromkeys(objective.method for objective in confirmation.objectives))
    confidence, searched_on = percent(confirmation.confidence), search.row[search.best].samples
    samples = confirmation.samples
    rows = tuple(
        (
            objective.text,
            _observed(f"confirmed.{n}.searched", objective.searched, objective, searched_on),
            _observed(f"confirmed.{n}.tuned", objective.tuned, objective, samples),
            _observed(f"confirmed.{n}.own", objective.own, objective, samples),
            _difference(f"confirmed.{n}.difference", objective, samples, confirmation.confidence),
            _observed(f"confirmed.{n}.optimism", objective.optimism, objective, samples),
            Mark(WORDS[objective.verdict]),
        )
        for n, objective in enumerate(confirmation.objectives)
    )
    head = ("objective", "winner in the search", "winner", "original campaign", "difference", "optimism", "verdict")
    caption = (
        f"Winner and original campaign on the same {count(samples)} draws of seed {confirmation.seed}, which are new to the "
        f"search. Difference: winner minus original campaign, paired, each at {confidence} confidence ({methods}). Optimism: the "
        "amount by which the winner's value in the search was better than on these draws. A dash: both values are infinite."
    )
    return Table(caption, head, rows)


def _requirements(confirmation: Confirmation) -> Table:
    rows = tuple(
        (requirement.text, Mark(requirement.tuned), Mark(requirement.own), *_changed(requirement, n))
        for n, requirement in enumerate(confirmation.requirements)
    )
    caption = (
        "Requirements on the same draws, with the number of samples in which only the winner or only the original campaign "
        "complies. p: McNemar's exact test, one-sided, of the hypothesis that the winner complies as often."
    )
    head = ("requirement", "winner", "original campaign", "only winner complies", "only original complies", "p")
    return Table(caption, head, rows)


_FILES = Table(
    "Files in this folder.",
    ("content", "file or command"),
    (
        ("best campaign", Code("best.yaml")),
        ("report of the winner", Code("tuned/report.html")),
        ("report of the original campaign", Code("own/report.html")),
        ("all candidates", Code("candidates.csv")),
        ("comparison of both runs", Code("rvjax compare own tuned")),
    ),
)


def _lead(search: Searched) -> str:
    assert search.confirmation is not None
    if search.missed:
        return f"The campaign keeps its values: no candidate meets the requirements. {shortfall(search)}"
    if not search.best:
        return "The campaign keeps its values: no candidate was better."
    by = {
        verdict: [objective.text for objective in search.confirmation.objectives if objective.verdict == verdict]
        for verdict in WORDS
    }
    parts = [f"{verdict} in {', '.join(texts)}" for verdict, texts in by.items() if texts and verdict != _UNDECIDED]
    same = by[_UNDECIDED]
    parts += [f"not clearly different in {', '.join(same)}"] if same else []
    passed = _passed(search.confirmation)
    more = f" It passes requirements that the original campaign fails: {', '.join(passed)}." if passed else ""
    return f"The winner is {'; '.join(parts)}.{more}"


def _changed(requirement: Kept, n: int) -> tuple[Cell, ...]:
    if requirement.only_tuned is None or requirement.only_own is None or requirement.p_worse is None:
        return ("–",) * 3  # the requirement is on a mean
    names = (f"confirmed.requirement.{n}.only_winner", f"confirmed.requirement.{n}.only_own")
    p = f"{requirement.p_worse:.2g}" if requirement.p_worse >= 1e-4 else "< 0.0001"
    return Number(names[0], requirement.only_tuned), Number(names[1], requirement.only_own), p


def _observed(name: str, value: float, objective: Confirmed, n: int) -> Cell:
    if math.isnan(value):
        return "–"  # a difference of two infinite values
    return Number(name, Observed(value, n), objective.unit, percent=objective.share)


def _difference(name: str, objective: Confirmed, n: int, confidence: float) -> Cell:
    if math.isnan(objective.difference.value):
        return "–"  # both are infinite
    low, high = sorted((objective.difference.low, objective.difference.high))
    estimate = Estimate(objective.difference.value, low, high, n, confidence, objective.method)
    return Number(name, estimate, objective.unit, percent=objective.share)
