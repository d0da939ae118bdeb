"""Section: the draws that correlate with the results."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rvjax.report import plotting
from rvjax.report.blocks import Drawing, Number, Section, Table
from rvjax.report.number_format import label, percent
from rvjax.report.run_view import CONFIDENCE, Run
from rvjax.stats import Estimate
from rvjax.stats.sampling_design import Observed

_RESULTS = ("settling_time_s", "window_position_error_m")
_SHOWN = 12
_FEWEST = 30


def section(run: Run) -> Section:
    """Rank correlations of the draws with the settling time and the window position error, where clearly not zero."""
    title = "Drivers of the results"
    drawn = _varied(run) if len(run.head) >= _FEWEST else {}
    results = [name for name in _RESULTS if run.metrics(name)]
    if not drawn or not results:
        reason = f"Not shown: rank correlations need at least {_FEWEST} samples and a draw that varies."
        return Section("drivers", title, reason)
    confidence = 1 - (1 - CONFIDENCE) / (len(drawn) * len(results))
    values = {name: run.metric_of_head(name) for name in results}
    correlations = {
        name: {path: run.design.correlation(x, y, confidence) for path, x in drawn.items()} for name, y in values.items()
    }
    strength = {path: max(abs(correlations[name][path].value) for name in results) for path in drawn}
    clear = [
        path
        for path in drawn
        if any(not low <= 0 <= high for low, high in (plotting.ends(correlations[name][path]) for name in results))
    ]
    leading = sorted(clear, key=lambda path: (-strength[path], path))[:_SHOWN]
    if not leading:
        return Section("drivers", title, f"None of the {len(drawn)} draws clearly correlates with a result.")
    intervals = (
        f" Intervals: {percent(CONFIDENCE)} simultaneous confidence for all {len(drawn) * len(results)} pairs (Bonferroni, with "
        "the approximation of Bonett and Wright)."
    )
    shown = f"The {_SHOWN} strongest. " if len(clear) > _SHOWN else ""
    caption = (
        f"{shown}Spearman rank correlation: +1 if the result always rises with the draw, −1 if it always falls."
        f"{run.design.words(intervals)} Correlation does not prove a cause, and it misses effects that are not monotonic."
        f"{run.head_note}"
    )
    head = ("draw", *(label(name) for name in results))
    rows = tuple(
        (path, *(Number(f"correlation.{name}.{path}", correlations[name][path]) for name in results)) for path in leading
    )
    verb = "correlates" if len(clear) == 1 else "correlate"
    lead = (
        f"{len(clear)} of {len(drawn)} draws{run.design.words(' clearly')} {verb} with the "
        f"{' or the '.join(map(label, results))}; {leading[0]} has the strongest correlation."
    )
    return Section("drivers", title, lead, (_figure(run, correlations, leading), Table(caption, head, rows)))


def _varied(run: Run) -> dict[str, NDArray[np.float64]]:
    """Every draw that varies, and the length of every drawn vector as |path|."""
    drawn = {path: run.draw_of_head(path) for path in run.draws()}
    vectors = {path.removesuffix(".x") for path in drawn if path.endswith(".x")}
    stems = [stem for stem in sorted(vectors) if f"{stem}.y" in drawn and f"{stem}.z" in drawn]
    drawn |= {f"|{stem}|": np.linalg.norm([drawn[f"{stem}.{axis}"] for axis in "xyz"], axis=0) for stem in stems}
    return {path: x for path, x in drawn.items() if x.min() < x.max()}


def _figure(run: Run, correlations: dict[str, dict[str, Estimate | Observed]], leading: list[str]) -> Drawing:
    """A dot with its interval per draw and result."""
    figure, (axis,) = plotting.axes(1, 1, 0.34 * len(leading) + 1.1, legend_above=True)
    axis.axvline(0, color=plotting.INK, lw=0.8)
    for offset, colour, name in zip((-0.14, 0.14), (plotting.BLUE, plotting.RED), correlations, strict=False):
        estimates = [correlations[name][path] for path in leading]
        y = np.arange(len(leading)) + offset
        x = np.array(
            [
                (e.value, e.value - low, high - e.value)
                for e, (low, high) in zip(estimates, map(plotting.ends, estimates), strict=True)
            ]
        )
        axis.errorbar(x[:, 0], y, xerr=x[:, 1:].T, fmt="o", ms=4, color=colour, capsize=2, lw=1.2, label=label(name))
    axis.set_yticks(range(len(leading)), leading)
    axis.set_ylim(len(leading) - 0.5, -0.5)
    axis.set_xlim(-1, 1)
    axis.set_xlabel("rank correlation")
    plotting.shared_legend(figure, plotting.labelled(axis), 2)
    text = f"Rank correlations, strongest first{run.design.words(', with simultaneous intervals')}.{run.head_note}"
    return Drawing("drivers", text, figure)
