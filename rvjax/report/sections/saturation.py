"""Section: actuator saturation."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rvjax import stats
from rvjax.columns import CHANNELS
from rvjax.report import plotting
from rvjax.report.blocks import Cell, Drawing, Number, Section, Table
from rvjax.report.metric_tables import quantiles
from rvjax.report.number_format import axis_label, capital, channel, count, percent, spoken
from rvjax.report.run_view import CONFIDENCE, Run, is_share
from rvjax.stats import Estimate
from rvjax.stats.sampling_design import Observed

_BINS = 5
_DOTS = 200  # samples drawn as dots
_DUTY = "Saturation duty: share of the flight in which the clipped command |h(v)| is at least 99 % of its limit."
_LONGEST = "Longest uninterrupted time in saturation."
_DEPTH = "Saturation depth: largest command |v| before clipping, as a multiple of the limit on its side."
_NO_SEVERITY = "No fault of this campaign takes effectiveness from a channel, so there is no fault severity."
_SHOWN = {"saturation_duty": ("saturation duty", "%", 100.0), "saturation_depth": ("saturation depth", "1", 1.0)}


def section(run: Run) -> Section | None:
    """Duty, longest stretch and depth of saturation per channel, and over the fault severity."""
    title = "Saturation"
    if not run.metrics(r"saturation_duty\.any"):
        return None
    saturated = run.metric("saturation_duty.any").positive
    share = spoken(run.share("saturation_duty.any.ever", saturated))
    lead = f"{share} of the samples saturate a channel at some time (clipped command |h(v)| ≥ 99 % of its limit)."
    stem = "saturation_duty" if saturated else "saturation_depth"
    tables = [quantiles(run, _DEPTH, run.metrics(r"saturation_depth\..*"))]
    if saturated:
        duty, longest = run.metrics(r"saturation_duty\..*"), run.metrics(r"longest_saturated_s\..*")
        tables = [quantiles(run, _DUTY, duty), quantiles(run, _LONGEST, longest), *tables]
    severe = {name: severity for name in CHANNELS if (severity := run.severity(name)) is not None and severity.size}
    faults = _against_severity(run, severe, stem) if severe else (_NO_SEVERITY,)
    return Section("saturation", title, lead, (_spread_figure(run, stem), *tables, *faults))


def _spread_figure(run: Run, stem: str) -> Drawing:
    """Median, 5–95 % range, 99 % quantile and largest finite value per channel; infinite values lie beyond the axis."""
    words, unit, scale = _SHOWN[stem]
    names = run.metrics(rf"{stem}\..*")
    figure, (axis,) = plotting.axes(1, 1, 0.36 * len(names) + 0.9)
    values = [run.metric(name) for name in names]
    largest = scale * np.array([max(0.0, part.value(part.finite - 1)) if part.finite else 0.0 for part in values])
    beyond = 1.05 * max(largest.max(), 1e-3)
    ranks = [stats.quantile_rank(run.flown, q) for q in (0.05, 0.5, 0.95, 0.99)]
    low, middle, high, far = scale * np.array([[part.value(rank) for part in values] for rank in ranks])
    rows = np.arange(len(names))
    left, right = np.minimum(low, beyond), np.minimum(high, beyond)
    axis.barh(rows, right - left, left=left, height=0.5, color=plotting.SKY, label="5–95 % range")
    axis.vlines(middle, rows - 0.25, rows + 0.25, color=plotting.BLUE, lw=2.5, label="median")
    axis.plot(far, rows, "D", color=plotting.PURPLE, ms=5, label="99 % quantile")
    axis.plot(largest, rows, "|", color=plotting.INK, ms=10, mew=1.5, label="largest finite")
    axis.set_yticks(rows, [channel(name.partition(".")[2]) for name in names])
    axis.invert_yaxis()
    axis.grid(visible=False, axis="y")
    axis.set_xlim(0, beyond)
    axis.set_xlabel(axis_label(words, unit))
    axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return Drawing(
        "saturation", f"{capital(words)} per channel, {count(run.flown)} samples. Infinite values lie beyond the axis.", figure
    )


def _against_severity(run: Run, severe: dict[str, NDArray[np.float64]], stem: str) -> tuple[Drawing, Table]:
    """Duty or depth over the fault severity per channel, in bins of equal width."""
    words, unit, scale = _SHOWN[stem]
    least, most_severe = np.min(list(severe.values())), np.max(list(severe.values()))
    edges = np.linspace(least, max(most_severe, least + 1e-3), _BINS + 1)
    figure, panels = plotting.panels(2, 3, 4.9, sharex=True, sharey="row")
    every = max(1, len(run.head) // _DOTS)
    rows: list[tuple[Cell, ...]] = []
    for axis, (name, severity) in zip(panels, severe.items(), strict=False):
        values = run.metric_of_head(f"{stem}.{name}")
        place = np.clip(np.digitize(severity, edges) - 1, 0, len(edges) - 2)
        axis.plot(severity[::every], scale * values[::every], ".", color=plotting.SKY, ms=2.5, alpha=0.6, label="samples")
        groups = [values[place == part] for part in range(len(edges) - 1)]
        median, most = ([run.design.quantile(group, q, CONFIDENCE) for group in groups] for q in (0.5, 0.95))
        centres = (edges[:-1] + edges[1:]) / 2
        plotting.intervals(axis, centres, median, plotting.BLUE, "median", scale)
        plotting.intervals(axis, centres, most, plotting.RED, "95 % quantile", scale)
        axis.set_title(capital(channel(name)))
        axis.set_xlabel("fault severity")
        axis.set_ylabel(axis_label(words, unit))
        axis.set_ylim(bottom=0)
        axis.label_outer()
        rows.append((capital(channel(name)), *(_cell(f"{stem}.{name}", part, estimate) for part, estimate in enumerate(most))))
    for axis in panels[len(severe) :]:
        axis.set_axis_off()
    plotting.shared_legend(figure, plotting.labelled(panels[0]), 3)
    bars = f" with {percent(CONFIDENCE)} confidence intervals"
    dots = len(range(0, len(run.head), every))
    drawn = (
        f"{capital(words)} over fault severity, the share of its effectiveness that a channel has lost by the end of the flight. "
        "Remaining shares of several faults multiply: effectiveness, incipient (its final loss), float and stuck (none remains). "
        "Faults that end before the flight do not count; intermittent ones count as while they act. "
        f"Quantiles per bin of severity{run.design.words(bars)}. Dots: {count(dots)} "
        f"of the samples. Infinite quantiles are not drawn.{run.head_note}"
    )
    head = ("channel", *(f"severity {low:.2f} – {high:.2f}" for low, high in pairwise(edges)))
    interval = f" with {percent(CONFIDENCE)} confidence intervals"
    caption = f"95 % quantile of the {words} per bin of fault severity{run.design.words(interval)}.{run.head_note}"
    return Drawing("saturation-severity", drawn, figure), Table(caption, head, tuple(rows))


def _cell(name: str, part: int, estimate: Estimate | Observed) -> Cell:
    return Number(f"{name}.bin{part + 1}.q95", estimate, percent=is_share(name)) if estimate.n else "no sample"
