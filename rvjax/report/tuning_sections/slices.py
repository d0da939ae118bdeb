"""Section: the first objective over each parameter, and all parameters at once."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from rvjax.report import plotting
from rvjax.report.blocks import Drawing, Section
from rvjax.report.number_format import count
from rvjax.report.tuning_sections.course import label, plotted
from rvjax.run_folder.tuning_record import Axis, Row, Searched

Free = list[tuple[int, Axis]]
"""The free parameters, each with the index of its coordinate."""

MOST = 12
"""Number of parameters that the figures show."""

COLUMNS = 3
LINES = 300
"""Number of candidates in the parallel coordinates."""


def section(search: Searched) -> Section | None:
    """A panel for each free parameter, and parallel coordinates; None if no candidate has a finite objective."""
    free = list(enumerate(parameter for parameter in search.parameters if parameter.free))
    rows = [row for row in search.rows if row.u and row.objectives and math.isfinite(row.objectives[0])]
    if not rows:
        return None
    body = [_slices(search, rows, free[:MOST])]
    if len(free) > 1:
        body.append(_parallel(search, rows, free[:MOST]))
    more = f" The figures show the first {MOST} of {len(free)} parameters." if len(free) > MOST else ""
    return Section(
        "slices", "Parameter values of the candidates", f"The objective over the values of every candidate.{more}", tuple(body)
    )


def _slices(search: Searched, rows: list[Row], free: Free) -> Drawing:
    lines = math.ceil(len(free) / COLUMNS)
    figure, panels = plotting.axes(lines, min(COLUMNS, len(free)), 2.3 * lines + 0.3, sharey=True)
    y = np.array([plotted(search, 0, row.objectives[0]) for row in rows])
    best_low = not search.objectives[0].largest
    ends = np.quantile(y, [0.0, 0.9] if best_low else [0.1, 1.0])
    room = ends[1] - ends[0] or 1.0
    finished = np.array([not row.left for row in rows])
    for axis, (_, parameter) in zip(panels, free, strict=False):
        x = _positions(parameter.name, parameter.scale, rows, search)
        axis.scatter(x[~finished], y[~finished], s=9, color=plotting.SKY, alpha=0.6, lw=0, label="did not fly all samples")
        axis.scatter(x[finished], y[finished], s=20, color=plotting.BLUE, lw=0, label="flew all samples")
        if search.best:
            best = search.row[search.best]
            axis.scatter(
                _positions(parameter.name, parameter.scale, [best], search),
                [plotted(search, 0, best.objectives[0])],
                s=60,
                color=plotting.GREEN,
                lw=0,
                label="winner",
            )
        if parameter.own is not None and parameter.scale != "levels":
            axis.axvline(float(parameter.own), color=plotting.RED, lw=1.0, ls=(0, (4, 3)), label="original campaign")
        if parameter.scale == "log":
            plotting.logarithmic(axis.xaxis, float(np.max(x) / np.min(x)) if np.min(x) > 0 else 10.0)
        if parameter.scale == "levels":
            _level_ticks(axis, _levels(parameter.name, search))
        axis.set_xlabel(parameter.name)
        axis.set_ylim(ends[0] - 0.08 * room, ends[1] + 0.08 * room)
    for axis in panels[len(free) :]:
        axis.set_axis_off()
    panels[0].set_ylabel(label(search, 0))
    plotting.legend(panels[0], fontsize=7)
    where = "above" if best_low else "below"
    caption = f"The first objective over each parameter. Some of the worst tenth of the candidates lie {where} the panels."
    return Drawing("tuning-slices", caption, figure)


def _parallel(search: Searched, rows: list[Row], free: Free) -> Drawing:
    figure, (axis,) = plotting.axes(1, 1, 3.0)
    order = sorted(rows, key=lambda row: (row.violation, row.score), reverse=True)[-LINES:]
    u = np.array([[row.u[index] for index, _ in free] for row in order])
    places = np.arange(len(free))
    shades = np.linspace(0.08, 0.75, len(order))
    colours = [(*_rgb(plotting.BLUE), shade) for shade in shades]
    axis.add_collection(LineCollection([np.column_stack([places, line]) for line in u], colors=colours, linewidths=0.9))
    if search.best:
        axis.plot(places, [search.row[search.best].u[index] for index, _ in free], color=plotting.GREEN, lw=2.4, label="winner")
    if search.start:
        axis.plot(
            places,
            [search.start[index] for index, _ in free],
            color=plotting.RED,
            lw=1.4,
            ls=(0, (4, 3)),
            label="original campaign",
        )
    axis.set_xticks(places, [parameter.name.rpartition(".")[2] for _, parameter in free], rotation=20, ha="right")
    axis.set_yticks([0, 0.5, 1], ["low end", "middle", "high end"])
    axis.set_xlim(-0.1, len(free) - 0.9)
    axis.set_ylim(-0.03, 1.03)
    if search.best:
        axis.legend(loc="upper right")
    caption = (
        f"Parallel coordinates of {count(len(order))} candidates over the parameter ranges. Darker lines are better candidates."
    )
    return Drawing("tuning-parallel", caption, figure)


def _rgb(colour: str) -> tuple[float, ...]:
    return tuple(int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5))


def _levels(name: str, search: Searched) -> list[str]:
    """The distinct values of a parameter among all candidates, in order."""
    return sorted({str(row.values[name]) for row in search.rows if name in row.values}, key=lambda text: (len(text), text))


def _positions(name: str, scale: str, rows: list[Row], search: Searched) -> np.ndarray:
    if scale != "levels":
        return np.array([float(row.values[name]) for row in rows])
    levels = _levels(name, search)
    return np.array([float(levels.index(str(row.values[name]))) for row in rows])


def _level_ticks(axis: Axes, levels: list[str]) -> None:
    step = max(1, len(levels) // 8)
    axis.set_xticks(range(0, len(levels), step), levels[::step])
