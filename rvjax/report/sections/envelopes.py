"""Section: errors, rates and the commanded wrench over time."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rvjax.columns import CHANNELS
from rvjax.report import plotting
from rvjax.report.blocks import Drawing, Number, Section, Table
from rvjax.report.number_format import axis_label, capital, channel, count, percent, setting
from rvjax.report.run_view import CONFIDENCE, Run

_NORMS = {
    "rho_m": ("position error", "|ρ|", "m"),
    "sigma": ("attitude error", "|σ| (MRP)", "1"),
    "nu_m_s": ("velocity error", "|ν|", "m/s"),
    "omega_rad_s": ("relative rate", "|ω|", "rad/s"),
}


def section(run: Run) -> Section | None:
    """Median, 5–95 % range and full range over time, with the worst flights overlaid; the commanded wrench and its limits."""
    title = "Flights over time"
    if run.envelopes.empty:
        return None
    kept = len(set(run.envelopes["sample"]))
    lead = f"Time histories of {count(kept)} of the {count(run.flown)} flown samples."
    table = run.envelopes.pivot(index="sample", columns="t_s")
    body = (_norm_figure(run, table), _norm_table(run, table, kept), _wrench_figure(run, table))
    return Section("envelopes", title, lead, body)


def _norm_figure(run: Run, table: pd.DataFrame) -> Drawing:
    figure, panels = plotting.panels(2, 2, 5.6, sharex=True)
    for axis, (name, (words, symbol, unit)) in zip(panels, _NORMS.items(), strict=True):
        values = _history(table, name)
        plotting.bands(axis, _times(table), values, lost=math.inf)
        for trace in run.traces.values():
            axis.plot(trace["t_s"], _norm(trace, name), color=plotting.RED, lw=0.7, alpha=0.8, label="worst flights")
        positive = values[np.isfinite(values) & (values > 0)]
        if positive.size:
            low, high = np.quantile(positive, (0.001, 0.999))
            high = min(10 * high, positive.max())  # a diverging flight may leave the axes
            plotting.logarithmic(axis.yaxis, high / low)
            axis.set_ylim(low / 1.5, high * 1.5)
        axis.set_title(capital(words))
        axis.set_ylabel(axis_label(symbol, unit))
        _marks(axis, run, table)
    _finish(figure, panels, 2)
    return Drawing("envelopes", _caption("Errors and rates", run, table), figure)


def _wrench_figure(run: Run, table: pd.DataFrame) -> Drawing:
    figure, panels = plotting.panels(2, 3, 4.9, sharex=True)
    for axis, name in zip(panels, CHANNELS, strict=True):
        plotting.bands(axis, _times(table), _history(table, f"cmd_{name}"), lost=math.nan)
        for trace in run.traces.values():
            axis.plot(trace["t_s"], trace[f"cmd_{name}"], color=plotting.RED, lw=0.5, alpha=0.6, label="worst flights")
        low, high = run.limits(name)
        axis.set_ylim(1.2 * low, 1.2 * high)
        for value in (low, high):
            axis.axhline(value, color=plotting.INK, lw=1.0, ls=(0, (4, 3)), label="nominal limit")
        axis.set_title(capital(channel(name)))
        axis.set_ylabel("N" if name.startswith("f") else "N·m")
        _marks(axis, run, table)
    _finish(figure, panels, 3)
    low, high = run.spec.actuators.spread.supports[0]
    text = _caption("Commanded wrench h(v) with its nominal limits", run, table)
    if high > low:
        text += f" Each sample draws its limits between {setting(low)} and {setting(high)} times the nominal ones."
    return Drawing("wrench", text, figure)


def _norm_table(run: Run, table: pd.DataFrame, kept: int) -> Table:
    """Median and 95 % quantile of every norm at five times."""
    times = _times(table)
    indices = [int(i) for i in np.linspace(0, times.size - 1, 5).round()]
    rows = tuple(
        (f"{words} {symbol}, {label}", *(_at(run, table, name, unit, q, i) for i in indices))
        for name, (words, symbol, unit) in _NORMS.items()
        for q, label in ((0.5, "median"), (0.95, "95 % quantile"))
    )
    intervals = run.design.words(f" with {percent(CONFIDENCE)} confidence intervals from order statistics")
    text = f"Quantiles at five times{intervals} (n = {count(kept)})."
    return Table(text, ("norm", *(f"t = {setting(times[i])} s" for i in indices)), rows)


def _at(run: Run, table: pd.DataFrame, name: str, unit: str, q: float, index: int) -> Number:
    estimate = run.design.quantile(_history(table, name)[:, index], q, CONFIDENCE)
    return Number(f"envelope.{name}.t{_times(table)[index]:g}.q{q * 100:g}", estimate, unit)


def _times(table: pd.DataFrame) -> NDArray[np.float64]:
    """(times,) s."""
    return np.asarray(table.columns.get_level_values("t_s").unique(), dtype=float)


def _history(table: pd.DataFrame, name: str) -> NDArray[np.float64]:
    """(samples, times) of one quantity."""
    return table[name].to_numpy(dtype=float)


def _norm(trace: pd.DataFrame, name: str) -> NDArray[np.float64]:
    """The Euclidean norm of a trace's vector: rho_m from rho_x_m, rho_y_m, rho_z_m."""
    stem, _, unit = name.partition("_")
    return np.linalg.norm([trace["_".join(filter(None, (stem, axis, unit)))] for axis in "xyz"], axis=0)


def _marks(axis: Axes, run: Run, table: pd.DataFrame) -> None:
    """Marks along the upper edge: the range of fault onsets, and the times at which flights diverged."""
    if (window := run.onsets()) is not None:
        axis.axvspan(window[0], max(window[1], window[0] + 1e-3), 0.97, 1.0, color=plotting.ORANGE, lw=0, label="fault onsets")
    lost = run.head.loc[(run.head["outcome"] == "not_finite") & np.isin(run.head["sample"], table.index), "outcome_time_s"]
    if not lost.empty:
        across = axis.get_xaxis_transform()
        axis.plot(lost, np.full(len(lost), 0.94), "x", color=plotting.RED, mew=1.5, transform=across, label="flight diverged")


def _finish(figure: Figure, panels: list[Axes], columns: int) -> None:
    """Time labels under the lowest axes, and a common legend above all axes."""
    for axis in panels[-columns:]:
        axis.set_xlabel("time, s")
    entries = plotting.labelled(panels[0])
    plotting.shared_legend(figure, entries, len(entries))


def _caption(what: str, run: Run, table: pd.DataFrame) -> str:
    rows = max(map(len, run.traces.values()), default=0)
    worst = f" Red: the {len(run.traces)} worst flights with a kept trace, {count(rows)} instants each." if run.traces else ""
    onsets = " Orange: the range of fault onsets." if run.onsets() else ""
    lost = " A flight that diverged counts as an infinite error from then on; its wrench is left out."
    shown = f"{count(len(table))} samples at {count(_times(table).size)} instants"
    between = " Peaks between these instants are not shown; the metrics count every step."
    return f"{what} over time for {shown}: median, 5–95 % range, and full range.{between}{worst}{onsets}{lost}"
