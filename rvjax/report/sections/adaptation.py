"""Section: whether the adaptive controller stayed healthy."""

from __future__ import annotations

from rvjax.report import plotting
from rvjax.report.blocks import Drawing, Section
from rvjax.report.metric_tables import quantiles, shares
from rvjax.report.number_format import axis_label, capital, label, percent, spoken
from rvjax.report.run_view import CONFIDENCE, Run
from rvjax.stats.quantile_sketch import Sketch

RUNAWAY = 10.0
"""A Nussbaum gain with |χ| ≥ this value has run away; a healthy controller stays near 1. This is a bucket edge of the sketch."""

_METRICS = r"peak_chi|peak_estimate_drift|saturation_depth\.any"


def section(run: Run) -> Section | None:
    """Peak Nussbaum argument, parameter drift and saturation depth; the share of samples with a runaway."""
    title = "Health of the adaptive controller"
    names = [name for name in run.metrics(_METRICS) if _acts(run.metric(name))]
    if not {"peak_chi", "peak_estimate_drift"} & set(names):
        return None
    body: list[str | Drawing] = [_figure(run, names)]
    table = quantiles(run, "Peak values over the whole flight.", names)
    if "peak_chi" not in names:
        return Section("adaptation", title, "The controller is adaptive but has no Nussbaum gain.", (*body, table))
    away = run.metric("peak_chi").at_least(RUNAWAY)
    runaway = f"runaway of the Nussbaum argument: peak |χ| ≥ {RUNAWAY:g}"
    events = shares(run, "Runaways of the Nussbaum argument.", {"peak_chi.runaway": (runaway, away)})
    share = spoken(run.share("peak_chi.runaway", away))
    lead = f"The Nussbaum argument runs away (|χ| ≥ {RUNAWAY:g}) in {share} of the samples."
    return Section("adaptation", title, lead, (*body, table, events))


def _acts(values: Sketch) -> bool:
    """Whether any value differs from 0."""
    return bool(values.value(0) or values.value(values.n - 1))


def _figure(run: Run, names: list[str]) -> Drawing:
    figure, panels = plotting.panels(1, len(names), 3.0, legend_above=False)
    for axis, name in zip(panels, names, strict=True):
        plotting.distribution(axis, run.metric(name), plotting.BLUE, label(name), run.band)
        reach = [run.metric(name), Sketch(RUNAWAY)] if name == "peak_chi" else [run.metric(name)]
        plotting.value_axis(axis.xaxis, reach, spread=10)
        plotting.probability_axis(axis)
        axis.set_title(capital(label(name)))
        axis.set_xlabel(axis_label(label(name), run.column(name).unit))
        if name == "peak_chi":
            plotting.limit(axis, RUNAWAY, "runaway")
    band = run.design.words(f" with {percent(CONFIDENCE)} confidence bands")
    text = f"Distribution functions of the peak values, {run.flown:,d} samples{band}."
    return Drawing("adaptation", text, figure)
