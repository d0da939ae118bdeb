"""Section: what fresh draws say of the winner, beside the campaign as it is."""

from __future__ import annotations

from collections.abc import Sequence

from rvjax.report.blocks import Cell, Code, Headline, Mark, Number, Section, Table
from rvjax.report.number_format import count, percent, quantity
from rvjax.run_folder.tuning_record import Confirmed, Kept, Searched
from rvjax.stats import Estimate
from rvjax.stats.sampling_design import Observed

WORDS = {"better": "BETTER", "worse": "WORSE", "not told apart": "NOT TOLD APART"}


def headline(found: Searched) -> Headline:
    """The top of the page: the first objective on fresh draws, in one word and one sentence."""
    done = found.confirmation
    assert done is not None, "a search ends with its confirmation"
    first = done.objectives[-1] if found.goal == "weighted" else done.objectives[0]
    left = [row.left for row in found.rows if row.candidate]
    facts: tuple[tuple[str, Cell], ...] = (
        ("method", found.method),
        ("candidates", Number("search.candidates", len(left))),
        ("flights of candidates", Number("search.flights", found.cost.flights)),
        ("fresh samples", Number("search.fresh", done.samples)),
        ("programs compiled", Number("search.programs", found.cost.programs)),
    )
    outcomes = tuple((name, left.count(key)) for key, name in _LEFT.items() if left.count(key) or not key)
    word, sentence = _overall(found, first)
    return Headline(
        found.name,
        found.description,
        Mark(word),
        sentence,
        facts,
        outcomes,
        "Tuning report",
        "candidates",
    )


_LEFT = {
    "": "flew_all_samples",
    "test": "left_by_a_test",
    "halving": "left_by_halving",
    "refused": "refused_by_the_campaign",
    "budget": "left_when_the_budget_ended",
}


def shown(value: float, one: Confirmed) -> str:
    """A value of an objective."""
    return f"{100 * value:.4g} %" if one.share else quantity(value, one.unit)


def _sentence(found: Searched, first: Confirmed, passed: Sequence[str], lost: Sequence[str]) -> str:
    if not found.best:
        return f"No candidate was better than the campaign as it is: {first.text} {shown(first.own, first)}."
    but = f"{first.text} {shown(first.tuned, first)}, {shown(first.own, first)} of the campaign as it is."
    if not passed and not lost:
        return f"Candidate {found.best}, on draws that the search has not seen: {but}"
    does = [f"{word} {', '.join(texts)}" for word, texts in (("passes", passed), ("does not pass", lost)) if texts]
    other = "unlike the campaign as it is" if not (passed and lost) else "other than the campaign as it is"
    return f"Candidate {found.best}, on draws that the search has not seen, {' and '.join(does)}, {other}; {but}"


def _overall(found: Searched, first: Confirmed) -> tuple[str, str]:
    """Requirements come before objectives, as in the search: one that only the winner passes, or only the campaign as it is."""
    assert found.confirmation is not None
    required = found.confirmation.requirements if found.best else []
    passed = [one.text for one in required if one.tuned == "PASS" and one.own == "FAIL"]
    lost = [one.text for one in required if one.own == "PASS" and one.tuned != "PASS"]
    word = "worse" if lost else "better" if passed else first.verdict
    return WORDS[word], _sentence(found, first, passed, lost)


def section(found: Searched) -> Section | None:
    """Objectives with the difference and its interval, and requirements."""
    done = found.confirmation
    if done is None:
        return None
    methods = "; ".join(dict.fromkeys(one.method for one in done.objectives))
    confidence, searched_on = percent(done.confidence), found.row[found.best].samples
    rows = tuple(
        (
            one.text,
            _observed(f"confirmed.{n}.searched", one.searched, one, searched_on),
            _observed(f"confirmed.{n}.tuned", one.tuned, one, done.samples),
            _observed(f"confirmed.{n}.own", one.own, one, done.samples),
            Number(f"confirmed.{n}.difference", _estimate(one, done.samples, done.confidence), one.unit, percent=one.share),
            _observed(f"confirmed.{n}.optimism", one.optimism, one, done.samples),
            Mark(WORDS[one.verdict]),
        )
        for n, one in enumerate(done.objectives)
    )
    head = ("objective", "winner, in the search", "winner", "campaign as it is", "difference", "optimism", "verdict")
    caption = (
        f"Both on the same {count(done.samples)} draws of seed {done.seed}, which the search has not seen. Difference: winner "
        f"minus campaign as it is, in pairs, {confidence} confidence, each by itself ({methods}). "
        "Optimism: by how much the winner looked better in the search than it is."
    )
    tables: list[Table | str] = [Table(caption, head, rows)]
    if done.requirements:
        required = tuple((one.text, Mark(one.tuned), Mark(one.own), *_changed(one, n)) for n, one in enumerate(done.requirements))
        words = "Requirements on the same draws. p: McNemar's exact test against “the winner complies as often”, one-sided."
        tables.append(
            Table(
                words, ("requirement", "winner", "campaign as it is", "with the winner alone", "without it alone", "p"), required
            )
        )
    tables.append("The winner is a campaign of its own; its run and that of the campaign as it is have reports of their own:")
    files = (
        ("best campaign", Code("best.yaml")),
        ("run of the winner", Code("tuned/report.html")),
        ("run of the campaign as it is", Code("own/report.html")),
        ("all candidates", Code("candidates.csv")),
        ("compare them", Code("rvjax compare own tuned")),
    )
    tables.append(Table("In this folder.", ("what", "where"), files))
    return Section("confirmation", "On fresh draws", _lead(found), tuple(tables))


def _lead(found: Searched) -> str:
    assert found.confirmation is not None
    if not found.best:
        return "The campaign keeps its values: the search found none that were better."
    by = {word: [one.text for one in found.confirmation.objectives if one.verdict == word] for word in WORDS}
    parts = [f"{word} in {', '.join(texts)}" for word, texts in by.items() if texts and word != "not told apart"]
    rest = by["not told apart"]
    parts += [f"not told apart in {', '.join(rest)}"] if rest else []
    fails = [one.text for one in found.confirmation.requirements if one.own == "FAIL" and one.tuned == "PASS"]
    more = f" It passes what the campaign as it is fails: {', '.join(fails)}." if fails else ""
    return f"The winner is {'; '.join(parts)}.{more}"


def _changed(kept: Kept, n: int) -> tuple[Cell, ...]:
    if kept.only_tuned is None or kept.only_own is None or kept.p_worse is None:
        return ("–",) * 3  # of a mean
    names = (f"confirmed.requirement.{n}.only_winner", f"confirmed.requirement.{n}.only_own")
    p = f"{kept.p_worse:.2g}" if kept.p_worse >= 1e-4 else "< 0.0001"
    return Number(names[0], kept.only_tuned), Number(names[1], kept.only_own), p


def _observed(name: str, value: float, one: Confirmed, n: int) -> Number:
    return Number(name, Observed(value, n), one.unit, percent=one.share)


def _estimate(one: Confirmed, n: int, confidence: float) -> Estimate:
    low, high = sorted((one.difference.low, one.difference.high))
    value = one.difference.value
    return Estimate(value, low, high, n, confidence, one.method)
