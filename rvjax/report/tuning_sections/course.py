"""Section: the progress of the search."""

from __future__ import annotations

import math

from rvjax.report import plotting
from rvjax.report.blocks import Drawing, Section
from rvjax.report.number_format import axis_label, count, quantity, share
from rvjax.run_folder.tuning_record import Searched

ORIGINAL = 0
"""Number of the original campaign among the candidates."""


def plotted(search: Searched, objective: int, value: float) -> float:
    """The value of an objective in the unit of its axis: % for a share."""
    return 100.0 * value if search.objectives[objective].share else value


def label(search: Searched, objective: int) -> str:
    """The axis label of an objective."""
    measured = search.objectives[objective]
    return axis_label(measured.text, "%" if measured.share else measured.unit)


def section(search: Searched) -> Section:
    """The first objective of every candidate in order, and the best value so far."""
    figure, (axis,) = plotting.axes(1, 1, 2.8)
    rows = [row for row in search.rows if row.candidate and row.objectives]
    complete = [row for row in rows if not row.left]
    groups = (
        ("did not fly all samples", [row for row in rows if row.left], plotting.SKY, 10, 0.55),
        ("flew all, violates a requirement", [row for row in complete if row.violation > 0], plotting.ORANGE, 22, 0.9),
        ("flew all, meets the requirements", [row for row in complete if row.violation == 0], plotting.BLUE, 26, 1.0),
    )
    for name, members, colour, size, alpha in groups:
        points = [(row.candidate, plotted(search, 0, row.objectives[0])) for row in members if math.isfinite(row.objectives[0])]
        if points:
            axis.scatter(*zip(*points, strict=True), s=size, color=colour, alpha=alpha, lw=0, label=name)
    line = best_so_far(search)
    rule = ""
    if line and search.goal != "pareto":
        x, y = zip(*[(number, plotted(search, 0, value)) for number, value in line], strict=True)
        axis.step([*x, max(len(rows), x[-1])], [*y, y[-1]], where="post", color=plotting.INK, lw=1.2, label="best so far")
        rule = (
            f" The best so far is among the candidates that flew all {count(search.cost.sizes[-1])} samples; a smaller violation "
            "of the requirements comes first."
        )
    values = [plotted(search, 0, row.objectives[0]) for row in rows if math.isfinite(row.objectives[0])]
    original = search.row[ORIGINAL].objectives[0]
    if math.isfinite(original):
        axis.axhline(plotted(search, 0, original), color=plotting.RED, lw=1.0, ls=(0, (4, 3)), label="original campaign")
    if values and min(values) > 0 and max(values) > 20 * min(values):
        plotting.logarithmic(axis.yaxis, max(values) / min(values))
    axis.set_xlabel("candidate, in the order of proposal")
    axis.set_ylabel(label(search, 0))
    plotting.legend(axis)
    lost = sum(1 for row in rows if not math.isfinite(row.objectives[0]))
    infinite = f" Not drawn: {count(lost)} candidates without a finite value." if lost else ""
    caption = (
        "Each value is over the samples that the candidate has flown. With few samples, as of eliminated candidates, values "
        f"scatter.{rule}{infinite}"
    )
    return Section("course", "Progress of the search", _lead(search), (Drawing("tuning-course", caption, figure),))


def best_so_far(search: Searched) -> list[tuple[int, float]]:
    """(candidate, first objective) of each candidate that was better than all before it."""
    best, line = search.row[ORIGINAL], [(0, search.row[ORIGINAL].objectives[0])]
    for row in sorted(search.rows, key=lambda row: row.candidate):
        if not row.left and row.score and (row.violation, row.score) < (best.violation, best.score):
            best = row
            line.append((row.candidate, row.objectives[0]))
    return [(number, value) for number, value in line if math.isfinite(value)]


def _lead(search: Searched) -> str:
    line = best_so_far(search)
    if search.missed:
        return "No candidate meets the requirements."
    if not search.best or not line:
        return "No candidate was better than the original campaign."
    objective = search.objectives[0]
    best = search.row[search.best]
    value = best.objectives[0]
    text = share(value, 4) if objective.share else quantity(value, objective.unit)
    return f"{objective.text}: {text} with candidate {search.best}, on the {count(best.samples)} draws of the search."
