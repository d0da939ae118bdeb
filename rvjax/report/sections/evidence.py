"""Section: how the evidence of sequential verdicts grew with the samples, and where it was enough."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from rvjax.analysis.verdicts import Evidence, Verdict
from rvjax.report import plotting
from rvjax.report.blocks import Drawing, Section, Table
from rvjax.report.number_format import count, power_of_ten
from rvjax.report.run_view import Run
from rvjax.report.sections.verdicts import requirement_words

_SHOWN = 6
"""Paths that are drawn; the others are in the table."""

_DECADES = 8.0
"""A path is drawn so many powers of ten beyond what is needed, at most, and as many below 1."""


def section(run: Run) -> Section | None:
    """A path and a row for each requirement that is judged after every chunk; None where there is none."""
    found = [(number, one, one.evidence) for number, one in enumerate(run.verdicts, 1) if one.evidence is not None]
    if not found:
        return None
    undecided = sum(evidence.decided is None for _, _, evidence in found)
    lead = f"{len(found) - undecided} of {len(found)} sequential requirements are decided."
    caption = (
        "Evidence is an e-process, or the likelihood ratio of the two shares that SPRT compares; looked at after every chunk. "
        "If the requirement does not hold, evidence for PASS ever reaches what is needed with at most the stated risk, however "
        "often one looks. Samples behind the decision change nothing."
    )
    head = ("requirement", "method", "decided at", "failures by then", "evidence for PASS", "for FAIL", "needed for PASS, FAIL")
    rows = tuple(_row(run, number, verdict, evidence) for number, verdict, evidence in found)
    return Section("evidence", "How the evidence grew", lead, (_figure(found[:_SHOWN]), Table(caption, head, rows)))


def _row(run: Run, number: int, verdict: Verdict, evidence: Evidence) -> tuple[str, ...]:
    at = evidence.decided if evidence.decided is not None else len(evidence.samples) - 1
    decided = f"{count(int(evidence.samples[at]))} samples" if evidence.decided is not None else "not yet"
    failures = count(int(evidence.failures[at])) if at >= 0 else "–"
    reached = [_times(float(path[at])) if at >= 0 else "–" for path in (evidence.passing, evidence.failing)]
    needed = f"{_times(evidence.needed_pass)}, {_times(evidence.needed_fail)}"
    name = f"{number}. {requirement_words(run, verdict.requirement)}"
    return (name, verdict.requirement.method, decided, failures, *reached, needed)


def _times(logarithm: float) -> str:
    """e^x to three digits, whatever its size."""
    if abs(logarithm) < math.log(1e4):
        return f"{math.exp(logarithm):.3g}"
    exponent = math.floor(logarithm / math.log(10))
    return f"{math.exp(logarithm - exponent * math.log(10)):.2g}·{power_of_ten(exponent)}"


def _figure(found: list[tuple[int, Verdict, Evidence]]) -> Drawing:
    columns = min(2, len(found))
    rows = -(-len(found) // columns)
    figure, axes = plotting.axes(rows, columns, 2.3 * rows + 0.5)
    for axis, (number, verdict, evidence) in zip(axes, found, strict=False):
        _panel(axis, f"{number}. {verdict.requirement.name or verdict.requirement.metric}: {verdict.verdict}", evidence)
    for axis in axes[len(found) :]:
        plotting.empty(axis, "")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    text = "Evidence over samples, in powers of ten, for PASS and for FAIL, and what each needs (dashed)."
    return Drawing("evidence", text, figure)


def _panel(axis: Axes, title: str, evidence: Evidence) -> None:
    axis.set_title(title)
    for path, needed, colour, label in (
        (evidence.passing, evidence.needed_pass, plotting.BLUE, "for PASS"),
        (evidence.failing, evidence.needed_fail, plotting.RED, "for FAIL"),
    ):
        x, y = _drawn(evidence.samples, path / math.log(10), needed / math.log(10))
        axis.plot(x, y, "o-" if len(x) < 30 else "-", ms=3, color=colour, label=label)
        axis.axhline(needed / math.log(10), color=colour, lw=1.0, ls=(0, (4, 3)))
    if evidence.decided is not None:
        axis.axvline(float(evidence.samples[evidence.decided]), color=plotting.INK, lw=1.0, label="decided")
    axis.set_xlabel("samples")
    axis.set_ylabel("log₁₀ evidence")


def _drawn(samples: NDArray[np.int64], path: NDArray[np.float64], needed: float) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """At most a few hundred points from 0 samples on, clipped where nobody needs to see more."""
    kept = np.unique(np.linspace(0, len(samples) - 1, min(len(samples), 300)).round().astype(int)) if len(samples) else []
    x, y = samples[kept], np.clip(path[kept], -_DECADES, needed + _DECADES)
    return np.concatenate([[0], x]), np.concatenate([[0.0], y])
