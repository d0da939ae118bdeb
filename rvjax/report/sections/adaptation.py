"""Section: whether the adaptive controller stayed healthy."""

from __future__ import annotations

from rvjax.report import plotting
from rvjax.report.blocks import Drawing, Section
from rvjax.report.metric_tables import quantiles, shares
from rvjax.report.number_format import axis_label, capital, label, percent, spoken
from rvjax.report.run_view import CONFIDENCE, Run
from rvjax.stats.quantile_sketch import Sketch

RUNAWAY = 10.0
"""|χ| from which on a Nussbaum gain has run away; the flights of a healthy law stay near 1. An edge of the sketch's buckets."""

_METRICS = r"peak_chi|peak_estimate_drift|saturation_depth\.any"


def section(run: Run) -> Section:
    """Peak Nussbaum argument, drift of the estimates, depth of saturation; the share of samples that ran away."""
    title = "Health of the adaptive controller"
    names = [name for name in run.metrics(_METRICS) if _acts(run.metric(name))]
    if not {"peak_chi", "peak_estimate_drift"} & set(names):
        return Section("adaptation", title, f"The controller {run.spec.controller.use} reports no adaptive signals.")
    body: list[str | Drawing] = [_figure(run, names)]
    table = quantiles(run, "Peak values over the whole flight.", names)
    if "peak_chi" not in names:
        return Section("adaptation", title, "The controller adapts, without a Nussbaum gain.", (*body, table))
    away = run.metric("peak_chi").at_least(RUNAWAY)
    runaway = f"Nussbaum argument ran away: peak |χ| ≥ {RUNAWAY:g}"
    events = shares(run, "Flights with a runaway.", {"peak_chi.runaway": (runaway, away)})
    share = spoken(run.share("peak_chi.runaway", away))
    lead = f"The Nussbaum argument runs away (|χ| ≥ {RUNAWAY:g}) in {share} of the samples."
    return Section("adaptation", title, lead, (*body, table, events))


def _acts(values: Sketch) -> bool:
    """Whether any of the values is not 0."""
    return bool(values.value(0) or values.value(values.n - 1))


def _figure(run: Run, names: list[str]) -> Drawing:
    figure, panels = plotting.axes(1, len(names), 3.0)
    for axis, name in zip(panels, names, strict=True):
        plotting.distribution(axis, run.metric(name), plotting.BLUE, label(name), run.band)
        reach = [run.metric(name), Sketch(RUNAWAY)] if name == "peak_chi" else [run.metric(name)]
        plotting.value_axis(axis.xaxis, reach, spread=10)
        plotting.probability_axis(axis)
        axis.set_title(capital(label(name)))
        axis.set_xlabel(axis_label(label(name), run.column(name).unit))
        if name == "peak_chi":
            plotting.limit(axis, RUNAWAY, "runaway")
    band = run.basis.words(f" with their {percent(CONFIDENCE)} band")
    text = f"Distribution functions over {run.flown:,d} samples{band}."
    return Drawing("adaptation", text, figure)
