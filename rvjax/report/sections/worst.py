"""Section: the worst samples, their draws, and the commands that replay them."""

from __future__ import annotations

import math
import shlex

import numpy as np
from numpy.typing import NDArray

from rvjax.columns import draw_column, metric_column
from rvjax.report.blocks import Cell, Code, Mark, Section, Table
from rvjax.report.number_format import label, quantity, share
from rvjax.report.run_view import Run, is_share

SHOWN = 10
_EXTREME_DRAWS = 3
_METRICS = ("settling_time_s", "window_position_error_m", "window_attitude_error_deg", "saturation_duty.any")


def section(run: Run) -> Section:
    """The ten worst samples: outcome, main metrics, most extreme draws, and replay commands."""
    rows = range(min(SHOWN, run.flown))
    names = [name for name in _METRICS if run.metrics(name.replace(".", r"\."))]
    drawn = _drawn(run)
    collided = " then collided ones, by time of collision;" if run.account.collided else ""
    caption = (
        f"Order: not finite samples first, by time of divergence;{collided} then not settled ones, by largest position error "
        "over the closing window; then captured ones, by settling time. Most extreme draws: those with the rank furthest from "
        "the median; p99 means larger than in 99 % of the samples. With many draws, some are extreme by chance in every sample."
        + run.head_note
    )
    head = ("sample", "outcome", *(label(name) for name in names), "most extreme draws")
    table = Table(caption, head, tuple(_row(run, row, names, drawn) for row in rows))
    replay = "Commands that replay a sample with its full trace."
    commands = Table(replay, ("sample", "command"), tuple(_replay(run, row) for row in rows))
    lead = f"The {len(rows)} worst samples and the commands that replay them."
    return Section("worst", "Worst samples", lead, (table, commands))


def _row(run: Run, row: int, names: list[str], drawn: dict[str, NDArray[np.float64]]) -> tuple[Cell, ...]:
    sample, outcome = run.totals.worst.loc[row, ["sample", "outcome"]]
    values = (_value(run, name, row) for name in names)
    return (f"{sample}", Mark(str(outcome)), *values, _extreme_draws(run, row, drawn))


def _replay(run: Run, row: int) -> tuple[Cell, ...]:
    sample = run.totals.worst["sample"].iloc[row]
    return (f"{sample}", Code(f"rvjax replay {shlex.quote(run.folder)} --sample {sample}"))


def _value(run: Run, name: str, row: int) -> str:
    """The recorded value; an observation has no interval."""
    value = float(run.totals.worst[metric_column(name)].iloc[row])
    if math.isnan(value):
        return "–"
    return share(value) if is_share(name) else quantity(value, run.column(name).unit)


def _extreme_draws(run: Run, row: int, drawn: dict[str, NDArray[np.float64]]) -> str:
    """The draws whose rank is furthest from the median: path = value unit (p99)."""
    values = {path: float(run.totals.worst[draw_column(path)].iloc[row]) for path in drawn}
    ranks = {path: _rank(x, values[path]) for path, x in drawn.items()}
    far = sorted(ranks, key=lambda path: -abs(ranks[path] - 0.5))[:_EXTREME_DRAWS]
    words = {path: quantity(values[path], run.totals.columns[draw_column(path)].unit) for path in far}
    return "; ".join(f"{path} = {words[path]} (p{100 * ranks[path]:.1f})" for path in far)


def _drawn(run: Run) -> dict[str, NDArray[np.float64]]:
    """The ascending values of every draw that varies among the first samples."""
    drawn = {path: np.sort(run.draw_of_head(path)) for path in run.draws()} if len(run.head) else {}
    return {path: x for path, x in drawn.items() if x[0] < x[-1]}


def _rank(x: NDArray[np.float64], value: float) -> float:
    """The mid-rank of a value in ascending numbers: the share of smaller numbers plus half the share of equal ones."""
    below, behind = np.searchsorted(x, value, side="left"), np.searchsorted(x, value, side="right")
    return float(below + behind) / (2 * x.size)
