"""Section: settling times and remaining errors."""

from __future__ import annotations

import math

from matplotlib.axes import Axes

from rvjax.campaign import Requirement
from rvjax.report import plotting
from rvjax.report.blocks import Drawing, Section
from rvjax.report.metric_tables import quantiles, shares
from rvjax.report.number_format import axis_label, capital, count, label, percent, setting, spoken
from rvjax.report.run_view import CONFIDENCE, Run

_TIMES = "settling_time_s|attitude_settling_time_s|fault_recovery_s"
_ERRORS = "(final|window)_.*error.*"
_PERIODS = {"final": "at the end", "window": "largest over the closing window"}
_TIMES_CAPTION = "Settling times from the start of the flight; fault recovery from the last fault onset."
_COLOURS = (plotting.BLUE, plotting.RED, plotting.GREEN)


def section(run: Run) -> Section | None:
    """Distribution functions with confidence bands, and quantiles, of settling times and remaining errors."""
    title = "Settling times and remaining errors"
    times, errors = run.metrics(_TIMES), run.metrics(_ERRORS)
    if not times or not errors:
        return None
    never = {f"{name}.never": (f"{label(name)}: never within the horizon", _never(run, name)) for name in times}
    body = (
        _time_figure(run, times),
        quantiles(run, _TIMES_CAPTION, times),
        shares(run, "Samples that never settle (in the figure: the gap between the curve and 1).", never),
        _error_figure(run, errors),
        quantiles(run, "Errors at the end of the flight, and the largest errors over the closing window.", errors),
    )
    return Section("settling", title, _lead(run, times[0]), body)


def _lead(run: Run, name: str) -> str:
    late = run.quantile(name, 0.95)
    if math.isinf(late.estimate.value):
        share = run.share(f"{name}.never", _never(run, name))
        return f"{spoken(share)} of the samples never settle within the horizon ({label(name)}: ∞)."
    return f"95 % of the samples have a {label(name)} of at most {spoken(late)}."


def _never(run: Run, name: str) -> int:
    return run.metric(name).at_least(math.inf)


def _time_figure(run: Run, names: list[str]) -> Drawing:
    figure, (axis,) = plotting.axes(1, 1, 3.6)
    for name, colour in zip(names, _COLOURS, strict=False):
        plotting.distribution(axis, run.metric(name), colour, label(name), run.band)
        required(axis, run, name, colour)
    plotting.probability_axis(axis)
    axis.set_xlim(0, run.spec.horizon.duration_s)
    axis.set_xlabel("time, s")
    axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return Drawing("settling-times", f"Distribution functions of the settling and recovery times. {_band(run)}", figure)


def _error_figure(run: Run, names: list[str]) -> Drawing:
    """One panel per kind of error, with the final error and the largest one over the closing window."""
    kinds = {kind: [name for name in names if _kind(name) == kind] for kind in dict.fromkeys(map(_kind, names))}
    figure, panels = plotting.panels(math.ceil(len(kinds) / 2), 2, 2.7 * math.ceil(len(kinds) / 2) + 0.2)
    tubes = {"m": run.spec.capture.position_m, "deg": math.degrees(4 * math.atan(run.spec.capture.attitude_mrp))}
    for axis, (kind, members) in zip(panels, kinds.items(), strict=False):
        unit = run.column(members[0]).unit
        for name, colour in zip(members, _COLOURS, strict=False):
            plotting.distribution(axis, run.metric(name), colour, _PERIODS[name.split("_")[0]], run.band)
            required(axis, run, name, colour)
        plotting.value_axis(axis.xaxis, [run.metric(name) for name in members], spread=3)
        if unit in tubes:
            plotting.limit(axis, tubes[unit], "capture tube")
        plotting.probability_axis(axis)
        axis.set_title(capital(kind))
        axis.set_xlabel(axis_label(kind, unit))
    for axis in panels[len(kinds) :]:
        axis.set_axis_off()
    plotting.shared_legend(figure, plotting.labelled(panels[0]), 2)
    return Drawing("errors", f"Distribution functions of the remaining errors. {_band(run)}", figure)


def _kind(name: str) -> str:
    """window_position_error_m → position error."""
    return label(name.split("_", 1)[1])


def required(axis: Axes, run: Run, name: str, colour: str) -> None:
    """Dashed lines at the limits that the campaign requires of the metric."""
    for verdict in run.verdicts:
        requirement = verdict.requirement
        bound = requirement.bound
        if requirement.metric == name and bound is not None:
            text = f"required: {_much(requirement)} {bound.side} {setting(bound.value)}"
            plotting.limit(axis, bound.value, text, colour)


def _much(requirement: Requirement) -> str:
    """How much of the distribution a requirement is on: at least 95 %, at most 1 %, 0.9 quantile, mean."""
    if requirement.mean:
        return "mean"
    if requirement.quantile is not None:
        return f"{percent(requirement.quantile)} quantile"
    return (
        f"at most {percent(requirement.at_most)}" if requirement.at_most is not None else f"at least {percent(requirement.limit)}"
    )


def _band(run: Run) -> str:
    shaded = (
        f"Shaded: {percent(CONFIDENCE)} confidence band of the whole distribution function (Dvoretzky–Kiefer–Wolfowitz, "
        f"n = {count(run.flown)}). "
    )
    return f"{run.design.words(shaded)}A curve that ends in ▸ stays below 1: the remaining samples have an infinite value."
