"""Section: rare failures: the estimate with both intervals, its levels against ordinary flights, and where flights fail."""

from __future__ import annotations

import shlex

import numpy as np

from rvjax.analysis.verdicts import Verdict
from rvjax.analysis.verdicts.rare import WORDS
from rvjax.analysis.verdicts.verdict import RareFailure
from rvjax.report import plotting
from rvjax.report.blocks import Cell, Code, Drawing, Mark, Named, Section, Table
from rvjax.report.number_format import count, number
from rvjax.report.run_view import Run
from rvjax.report.sections.verdicts import requirement_words
from rvjax.run_folder import rare_record
from rvjax.run_folder.rare_record import Interval, RareRecord, Region
from rvjax.stats import wilks_smallest_n
from rvjax.stats.rare.replicates import variation

_DRAWS = 4
"""Coordinates of a region in the table."""


def section(run: Run) -> Section | None:
    """The searches of a run; None where no requirement asks for one."""
    rare = [(n, verdict, verdict.rare) for n, verdict in enumerate(run.verdicts, 1) if verdict.rare is not None]
    if not rare:
        return None
    words = [WORDS[failure.basis] for _, _, failure in rare]
    lead = f"{len(rare)} requirement{'s' if len(rare) > 1 else ''} on rare failures: {', '.join(words)}."
    caption = (
        "Probability that a sample does not comply. Estimate: conditional on every failure region of weight having been reached; "
        "its nominal interval (each end one-sided at the requirement's confidence) errs somewhat more often than it says. "
        "Proved: the lower bound from the search or from ordinary flights, the upper bound from ordinary flights alone. No n "
        "flights, however they are chosen, prove a probability much below 1/n."
    )
    head = ("requirement", "verdict", "estimate", "nominal interval", "proved interval", "flights", "by counting")
    body: list[str | Drawing | Table] = [Table(caption, head, tuple(_row(run, *item) for item in rare))]
    for n, _, failure in rare:
        if (record := run.searches.get(n)) is not None:
            body += _search(run, n, record, failure)
    return Section("rare", "Rare failures", lead, tuple(body))


def _row(run: Run, n: int, verdict: Verdict, failure: RareFailure) -> tuple[Cell, ...]:
    record = run.searches.get(n)
    name = Named(f"{n}. {requirement_words(run, verdict.requirement)}", f"{failure.method}; {WORDS[failure.basis]}")
    if failure.value is None or failure.low is None or failure.high is None or record is None:
        return (name, Mark(verdict.verdict), "–", "–", _span(failure.proved_low, failure.proved_high), "–", "–")
    counting = wilks_smallest_n(1.0 - failure.allowed, verdict.requirement.confidence)
    return (
        name,
        Mark(verdict.verdict),
        number(failure.value),
        _span(failure.low, failure.high),
        _span(failure.proved_low, failure.proved_high),
        f"{count(failure.flights)}, of these {count(record.learning)} to learn the levels",
        f"{count(counting)} flights without a failure would prove it ({counting / max(1, failure.flights):.3g} times as many); "
        f"{_as_sharp(record, failure.value)}",
    )


def _as_sharp(record: RareRecord, p: float) -> str:
    """How many ordinary flights have the same standard error: p (1 − p)/se²."""
    spread = variation(record.estimates)
    if not (p > 0.0 and spread > 0.0):
        return "no failure was reached"
    return f"as sharp an estimate by counting: {count(round(len(record.estimates) * (1.0 - p) / (p * spread**2)))} flights"


def _span(low: float, high: float) -> str:
    return f"{number(low)} to {number(high)}"


def _search(run: Run, n: int, record: RareRecord, failure: RareFailure) -> list[str | Drawing | Table]:
    """Levels, weights, regions and commands of a search."""
    body: list[str | Drawing | Table] = [_figure(n, record), _levels(n, record)]
    if (weights := record.weights) is not None:
        tilted = ", ".join(weights.coordinates) or "none"
        body.append(
            f"Importance sampling for requirement {n}: {count(weights.flights)} flights, {count(weights.failing)} failed, "
            f"effective sample size {weights.effective:.3g}, largest weight {100 * weights.largest:.2g} % of their sum, "
            f"Pareto k {weights.shape:.2f}; {weights.parts} parts in the coordinates {tilted}."
        )
    if failure.refusals:
        body.append(f"The estimate for requirement {n} is refused: {'; '.join(failure.refusals)}.")
    if record.regions:
        rows = tuple(_region(k, region) for k, region in enumerate(record.regions, 1))
        caption = (
            f"Regions of failure of requirement {n}: failing points near each other. Moved: mean ± standard deviation of a "
            "coordinate of the draws in σ; 0 ± 1 for all samples. Most probable: the failing flight nearest to the middle of the "
            "draws, in the coordinates that differ among failing flights."
        )
        head = (
            "region",
            "share of failing points",
            "moved, in σ",
            "most probable: |z|",
            "its margin",
            "its outcome",
            "its draws",
        )
        body.append(Table(caption, head, rows))
        folder = f"{run.folder}/{rare_record.folder_of(n)}"
        again = f"{folder}/failing"
        commands = [Code(f"rvjax run {shlex.quote(f'{folder}/{rare_record.FAILING}')} --out {shlex.quote(again)}")]
        commands += [Code(f"rvjax replay {shlex.quote(again)} --sample {region.sample}") for region in record.regions]
        names = ["all", *(str(k) for k in range(1, len(record.regions) + 1))]
        caption = "Commands that fly the most probable failing flights again; the first makes the folder of the others."
        body.append(Table(caption, ("region", "command"), tuple(zip(names, commands, strict=True))))
    return body


def _levels(n: int, record: RareRecord) -> Table:
    caption = (
        f"Levels of requirement {n}, from {len(record.replicates)} replicates of {record.chains} chains. Share: of the states at "
        "the level before. Both intervals hold for all levels together at 99 %; where they have no number in common, the "
        "estimate is refused."
    )
    head = ("level of the margin", "share", "moves accepted", "probability by splitting", "by counting", "ordinary flights", "")
    rows = tuple(
        (
            "failure" if level.level == 0.0 else f"{level.level:.4g}",
            f"{level.share:.3f}",
            "–" if level.accepted is None else f"{100 * level.accepted:.0f} %",
            _with_interval(level.split),
            _with_interval(level.counted),
            f"{count(level.count)} of {count(record.ordinary)}",
            "agree" if level.agrees else "disagree",
        )
        for level in record.levels
    )
    return Table(caption, head, rows)


def _with_interval(interval: Interval) -> str:
    return f"{number(interval.value)} ({_span(interval.low, interval.high)})"


def _region(k: int, region: Region) -> tuple[Cell, ...]:
    moved = "; ".join(f"{one.name} {one.mean:+.2f} ± {one.deviation:.2f}" for one in region.moved[:_DRAWS])
    stems = {one.name.rpartition(".")[0] if one.name.rpartition(".")[2].isdigit() else one.name for one in region.moved[:_DRAWS]}
    drawn = [(name, value) for name, value in region.draws.items() if any(name == s or name.startswith(f"{s}.") for s in stems)]
    draws = "; ".join(f"{name} = {value:.4g}" for name, value in drawn[: 3 * _DRAWS])
    share = f"{100 * region.share:.0f} % ({count(region.points)})"
    return (str(k), share, moved, f"{region.distance:.2f}", f"{region.margin:.3g}", Mark(region.outcome), draws)


def _figure(n: int, record: RareRecord) -> Drawing:
    """P(g ≤ level) by splitting and by counting."""
    figure, axes = plotting.panels(1, 1, 2.8)
    axis = axes[0]
    levels = np.array([level.level for level in record.levels])
    curves = (("split", plotting.BLUE, "splitting", 0.0), ("counted", plotting.RED, "ordinary flights", 0.06))
    for kind, colour, label, shift in curves:
        values = [getattr(level, kind) for level in record.levels if getattr(level, kind).value > 0.0]
        middle = np.array([value.value for value in values])
        ends = np.array([[value.value - value.low for value in values], [value.high - value.value for value in values]])
        place = np.flatnonzero([getattr(level, kind).value > 0.0 for level in record.levels]) + shift
        if values:
            axis.errorbar(place, middle, yerr=np.maximum(ends, 0.0), fmt="o", ms=4, color=colour, capsize=3, label=label)
    axis.set_yscale("log")
    axis.set_xticks(np.arange(len(levels)), ["failure" if level == 0.0 else f"{level:.3g}" for level in levels])
    axis.set_xlabel("level of the margin")
    axis.set_ylabel("probability below it")
    plotting.shared_legend(figure, plotting.labelled(axis), 2)
    text = f"Requirement {n}: probability that the margin is at or below each level, with intervals that hold together at 99 %."
    return Drawing(f"rare-{n}", text, figure)
