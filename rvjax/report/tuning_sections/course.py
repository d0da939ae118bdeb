"""Section: how the search went on."""

from __future__ import annotations

import math

from rvjax.report import plotting
from rvjax.report.blocks import Drawing, Section
from rvjax.report.number_format import axis_label, count, quantity
from rvjax.run_folder.tuning_record import Searched

OWN = 0


def shown(found: Searched, objective: int, value: float) -> float:
    """What is drawn: a share in percent."""
    return 100.0 * value if found.objectives[objective].share else value


def label(found: Searched, objective: int) -> str:
    """Of an axis with an objective."""
    one = found.objectives[objective]
    return axis_label(one.text, "%" if one.share else one.unit)


def section(found: Searched) -> Section:
    """The first objective of every candidate in their order, and the best so far."""
    figure, (axis,) = plotting.axes(1, 1, 2.8)
    rows = [row for row in found.rows if row.candidate and row.objectives]
    groups = (
        ("left in a race", [row for row in rows if row.left], plotting.SKY, 10, 0.55),
        ("missed a requirement", [row for row in rows if not row.left and row.violation > 0], plotting.ORANGE, 22, 0.9),
        ("flew all samples", [row for row in rows if not row.left and row.violation == 0], plotting.BLUE, 26, 1.0),
    )
    for name, members, colour, size, alpha in groups:
        points = [(row.candidate, shown(found, 0, row.objectives[0])) for row in members if math.isfinite(row.objectives[0])]
        if points:
            axis.scatter(*zip(*points, strict=True), s=size, color=colour, alpha=alpha, lw=0, label=name)
    line = best_so_far(found)
    if line and found.goal != "pareto":
        x, y = zip(*[(number, shown(found, 0, value)) for number, value in line], strict=True)
        axis.step([*x, max(len(rows), x[-1])], [*y, y[-1]], where="post", color=plotting.INK, lw=1.2, label="best so far")
    values = [shown(found, 0, row.objectives[0]) for row in rows if math.isfinite(row.objectives[0])]
    own = found.row[OWN].objectives[0]
    if math.isfinite(own):
        axis.axhline(shown(found, 0, own), color=plotting.RED, lw=1.0, ls=(0, (4, 3)), label="campaign as it is")
    if values and min(values) > 0 and max(values) > 20 * min(values):
        plotting.logarithmic(axis.yaxis, max(values) / min(values))
    axis.set_xlabel("candidate, in the order in which they were proposed")
    axis.set_ylabel(label(found, 0))
    axis.legend(loc="best")
    lost = sum(1 for row in rows if not math.isfinite(row.objectives[0]))
    infinite = f" {count(lost)} candidates without a finite value are not drawn." if lost else ""
    caption = (
        "Each candidate with the samples that it has flown: few of those that left early, so their values scatter. The best "
        f"so far is chosen among those that flew all {count(found.cost.sizes[-1])}, requirements first.{infinite}"
    )
    return Section("course", "Course of the search", _lead(found), (Drawing("tuning-course", caption, figure),))


def best_so_far(found: Searched) -> list[tuple[int, float]]:
    """(candidate, first objective) of each that was better than all before it."""
    best, line = found.row[OWN], [(0, found.row[OWN].objectives[0])]
    for row in sorted(found.rows, key=lambda row: row.candidate):
        if not row.left and row.score and (row.violation, row.score) < (best.violation, best.score):
            best = row
            line.append((row.candidate, row.objectives[0]))
    return [(number, value) for number, value in line if math.isfinite(value)]


def _lead(found: Searched) -> str:
    line = best_so_far(found)
    if not found.best or not line:
        return "No candidate was better than the campaign as it is."
    one = found.objectives[0]
    value = found.row[found.best].objectives[0]
    text = f"{100 * value:.4g} %" if one.share else quantity(value, one.unit)
    return f"{one.text}: {text} with candidate {found.best}, on the {count(found.row[found.best].samples)} draws of the search."
