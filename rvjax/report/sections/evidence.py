"""Section: the evidence of sequential verdicts over the number of samples, and where it reached a decision."""

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
"""Number of requirements that the figure shows; the table shows all."""

_DECADES = 8.0
"""The figure clips evidence at this many powers of ten above the decision level, and below 1."""


def section(run: Run) -> Section | None:
    """A curve and a row for each sequential requirement; None if there is none."""
    sequential = [
        (number, verdict, verdict.evidence) for number, verdict in enumerate(run.verdicts, 1) if verdict.evidence is not None
    ]
    if not sequential:
        return None
    undecided = sum(evidence.decided is None for _, _, evidence in sequential)
    lead = f"{len(sequential) - undecided} of {len(sequential)} sequential requirements are decided."
    caption = (
        "Evidence is an e-process; for SPRT, the likelihood ratio of its two shares. It is checked after every chunk. If the "
        "requirement does not hold, the probability that the evidence for PASS ever reaches its decision level is at most the "
        "stated risk, however often it is checked. Samples after the decision do not change it."
    )
    head = (
        "requirement",
        "method",
        "decided after",
        "failures by then",
        "evidence for PASS",
        "for FAIL",
        "levels for PASS, FAIL",
    )
    rows = tuple(_row(run, number, verdict, evidence) for number, verdict, evidence in sequential)
    return Section("evidence", "Evidence over samples", lead, (_figure(sequential[:_SHOWN]), Table(caption, head, rows)))


def _row(run: Run, number: int, verdict: Verdict, evidence: Evidence) -> tuple[str, ...]:
    at = evidence.decided if evidence.decided is not None else len(evidence.samples) - 1
    decided = f"{count(int(evidence.samples[at]))} samples" if evidence.decided is not None else "not yet"
    failures = count(int(evidence.failures[at])) if at >= 0 else "–"
    reached = [_times(float(path[at])) if at >= 0 else "–" for path in (evidence.passing, evidence.failing)]
    needed = f"{_times(evidence.needed_pass)}, {_times(evidence.needed_fail)}"
    name = f"{number}. {requirement_words(run, verdict.requirement)}"
    return (name, verdict.requirement.method, decided, failures, *reached, needed)


def _times(logarithm: float) -> str:
    """e^x in three digits, also where e^x is not a float."""
    if abs(logarithm) < math.log(1e4):
        return f"{math.exp(logarithm):.3g}"
    exponent = math.floor(logarithm / math.log(10))
    mantissa = f"{math.exp(logarithm - exponent * math.log(10)):.2g}"
    return f"1·{power_of_ten(exponent + 1)}" if mantissa == "10" else f"{mantissa}·{power_of_ten(exponent)}"


def _figure(sequential: list[tuple[int, Verdict, Evidence]]) -> Drawing:
    columns = min(2, len(sequential))
    rows = -(-len(sequential) // columns)
    figure, axes = plotting.panels(rows, columns, 2.4 * rows + 0.5)
    for axis, (number, verdict, evidence) in zip(axes, sequential, strict=False):
        _panel(axis, f"{number}. {verdict.requirement.name or verdict.requirement.metric}: {verdict.verdict}", evidence)
    for axis in axes[len(sequential) :]:
        plotting.empty(axis, "")
    plotting.shared_legend(figure, plotting.labelled(axes[0]), 3)
    text = "Evidence for PASS and for FAIL over the number of samples (log₁₀). Dashed: the decision levels."
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
    """Up to 300 points of a curve, starting at 0 samples, clipped `_DECADES` beyond the decision level."""
    kept = np.unique(np.linspace(0, len(samples) - 1, min(len(samples), 300)).round().astype(int)) if len(samples) else []
    x, y = samples[kept], np.clip(path[kept], -_DECADES, needed + _DECADES)
    return np.concatenate([[0], x]), np.concatenate([[0.0], y])
