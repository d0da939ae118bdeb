"""Rank correlations of the draws with results: their values, and their figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from rvjax.report import plotting
from rvjax.report.blocks import Drawing
from rvjax.report.number_format import label, percent
from rvjax.report.run_view import CONFIDENCE, Run
from rvjax.stats import Estimate
from rvjax.stats.sampling_design import Observed

Correlations = Mapping[str, Mapping[str, Estimate | Observed]]
"""By result and draw."""


def correlations(run: Run, drawn: Mapping[str, NDArray[np.float64]], results: Sequence[str]) -> Correlations:
    """Spearman's rank correlation of every draw with every result, with simultaneous intervals (Bonferroni)."""
    confidence = 1 - (1 - CONFIDENCE) / max(1, len(drawn) * len(results))
    values = {name: run.metric_of_head(name) for name in results}
    return {name: {path: run.design.correlation(x, y, confidence) for path, x in drawn.items()} for name, y in values.items()}


def is_clear(estimate: Estimate | Observed) -> bool:
    """Whether its interval excludes 0."""
    low, high = plotting.ends(estimate)
    return not low <= 0 <= high


def strongest(known: Correlations, draws: Sequence[str]) -> list[str]:
    """The draws, those with the strongest correlation with any result first."""
    strength = {path: max(abs(of[path].value) for of in known.values()) for path in draws}
    return sorted(draws, key=lambda path: (-strength[path], path))


def explained(run: Run, pairs: int) -> str:
    """What a rank correlation is, for captions."""
    intervals = (
        f" Intervals: {percent(CONFIDENCE)} simultaneous confidence for all {pairs} pairs (Bonferroni, with the approximation of "
        "Bonett and Wright)."
    )
    return (
        "Rank correlation (Spearman): +1 if the result always rises with the draw, −1 if it always falls; it misses effects that "
        f"are not monotonic.{run.design.words(intervals)} Neither number proves a cause."
    )


def figure(run: Run, known: Correlations, leading: Sequence[str]) -> Drawing:
    """A dot with its interval per draw and result."""
    drawing, (axis,) = plotting.axes(1, 1, 0.34 * len(leading) + 1.1, legend_above=True)
    axis.axvline(0, color=plotting.INK, lw=0.8)
    for offset, colour, name in zip((-0.14, 0.14), (plotting.BLUE, plotting.RED), known, strict=False):
        estimates = [known[name][path] for path in leading]
        y = np.arange(len(leading)) + offset
        x = np.array(
            [
                (e.value, e.value - low, high - e.value)
                for e, (low, high) in zip(estimates, map(plotting.ends, estimates), strict=True)
            ]
        )
        axis.errorbar(x[:, 0], y, xerr=x[:, 1:].T, fmt="o", ms=4, color=colour, capsize=2, lw=1.2, label=label(name))
    axis.set_yticks(range(len(leading)), list(leading))
    axis.set_ylim(len(leading) - 0.5, -0.5)
    axis.set_xlim(-1, 1)
    axis.set_xlabel("rank correlation")
    plotting.shared_legend(drawing, plotting.labelled(axis), 2)
    text = f"Rank correlations, strongest first{run.design.words(', with simultaneous intervals')}.{run.head_note}"
    return Drawing("drivers", text, drawing)
