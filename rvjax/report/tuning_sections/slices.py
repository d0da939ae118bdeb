"""Section: the first objective over each value, and all values at once."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from rvjax.report import plotting
from rvjax.report.blocks import Drawing, Section
from rvjax.report.number_format import count
from rvjax.report.tuning_sections.course import label, shown
from rvjax.run_folder.tuning_record import Axis, Row, Searched

Free = list[tuple[int, Axis]]
"""The free parameters, each with the place of its coordinate."""

MOST = 12
COLUMNS = 3
LINES = 300


def section(found: Searched) -> Section | None:
    """One panel for each free parameter, and parallel coordinates; None where nothing finite was flown."""
    free = [(index, one) for index, one in enumerate(one for one in found.parameters if one.free)]
    rows = [row for row in found.rows if row.u and row.objectives and math.isfinite(row.objectives[0])]
    if not rows:
        return None
    body = [_slices(found, rows, free[:MOST])]
    if len(free) > 1:
        body.append(_parallel(found, rows, free[:MOST]))
    more = f" The first {MOST} of {len(free)} are drawn." if len(free) > MOST else ""
    return Section("slices", "Where the good values lie", f"Every candidate by its values.{more}", tuple(body))


def _slices(found: Searched, rows: list[Row], free: Free) -> Drawing:
    lines = math.ceil(len(free) / COLUMNS)
    figure, panels = plotting.axes(lines, min(COLUMNS, len(free)), 2.3 * lines + 0.3, sharey=True)
    y = np.array([shown(found, 0, row.objectives[0]) for row in rows])
    best_low = not found.objectives[0].largest
    ends = np.quantile(y, [0.0, 0.9] if best_low else [0.1, 1.0])
    room = ends[1] - ends[0] or 1.0
    for axis, (_, one) in zip(panels, free, strict=False):
        whole = np.array([not row.left for row in rows])
        x = _positions(one.name, one.scale, rows, found)
        axis.scatter(x[~whole], y[~whole], s=9, color=plotting.SKY, alpha=0.6, lw=0, label="left in a race")
        axis.scatter(x[whole], y[whole], s=20, color=plotting.BLUE, lw=0, label="flew all samples")
        if found.best:
            best = found.row[found.best]
            axis.scatter(
                _positions(one.name, one.scale, [best], found),
                [shown(found, 0, best.objectives[0])],
                s=60,
                color=plotting.GREEN,
                lw=0,
                label="winner",
            )
        if one.own is not None and one.scale != "levels":
            axis.axvline(float(one.own), color=plotting.RED, lw=1.0, ls=(0, (4, 3)), label="campaign as it is")
        if one.scale == "log":
            plotting.logarithmic(axis.xaxis, float(np.max(x) / np.min(x)) if np.min(x) > 0 else 10.0)
        if one.scale == "levels":
            _level_ticks(axis, _levels(one.name, found))
        axis.set_xlabel(one.name)
        axis.set_ylim(ends[0] - 0.08 * room, ends[1] + 0.08 * room)
    for axis in panels[len(free) :]:
        axis.set_axis_off()
    panels[0].set_ylabel(label(found, 0))
    panels[0].legend(loc="best", fontsize=7)
    where = "above" if best_low else "below"
    caption = f"The first objective over each value; the worst tenth of the candidates lies {where} the panels."
    return Drawing("tuning-slices", caption, figure)


def _parallel(found: Searched, rows: list[Row], free: Free) -> Drawing:
    figure, (axis,) = plotting.axes(1, 1, 3.0)
    order = sorted(rows, key=lambda row: (row.violation, row.score), reverse=True)[-LINES:]
    u = np.array([[row.u[index] for index, _ in free] for row in order])
    places = np.arange(len(free))
    shades = np.linspace(0.08, 0.75, len(order))
    colours = [(*_rgb(plotting.BLUE), shade) for shade in shades]
    axis.add_collection(LineCollection([np.column_stack([places, line]) for line in u], colors=colours, linewidths=0.9))
    if found.best:
        axis.plot(places, [found.row[found.best].u[index] for index, _ in free], color=plotting.GREEN, lw=2.4, label="winner")
    own = found.start
    if own:
        axis.plot(
            places, [own[index] for index, _ in free], color=plotting.RED, lw=1.4, ls=(0, (4, 3)), label="campaign as it is"
        )
    axis.set_xticks(places, [one.name.rpartition(".")[2] for _, one in free], rotation=20, ha="right")
    axis.set_yticks([0, 0.5, 1], ["low end", "middle", "high end"])
    axis.set_xlim(-0.1, len(free) - 0.9)
    axis.set_ylim(-0.03, 1.03)
    if found.best:
        axis.legend(loc="upper right")
    caption = f"A line for each of {count(len(order))} candidates over their ranges, the darker the better."
    return Drawing("tuning-parallel", caption, figure)


def _rgb(colour: str) -> tuple[float, ...]:
    return tuple(int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5))


def _levels(name: str, found: Searched) -> list[str]:
    """The values that any candidate has had, in their order."""
    return sorted({str(row.values[name]) for row in found.rows if name in row.values}, key=lambda text: (len(text), text))


def _positions(name: str, scale: str, rows: list[Row], found: Searched) -> np.ndarray:
    if scale != "levels":
        return np.array([float(row.values[name]) for row in rows])
    known = _levels(name, found)
    return np.array([float(known.index(str(row.values[name]))) for row in rows])


def _level_ticks(axis: Axes, known: list[str]) -> None:
    step = max(1, len(known) // 8)
    axis.set_xticks(range(0, len(known), step), known[::step])
