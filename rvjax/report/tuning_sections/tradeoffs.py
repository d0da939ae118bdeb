"""Section: trade-offs between objectives."""

from __future__ import annotations

import math
from itertools import combinations

from rvjax.report import plotting
from rvjax.report.blocks import Cell, Drawing, Mark, Number, Section, Table
from rvjax.report.tuning_sections.course import ORIGINAL, label, plotted
from rvjax.report.tuning_sections.values import setting_text
from rvjax.run_folder.tuning_record import Row, Searched
from rvjax.stats.pareto import Score, undominated
from rvjax.stats.sampling_design import Observed

MOST_PAIRS = 3

FIGURE = "The candidates that flew all samples and have the smallest violation of the requirements, on the draws of the search."


def section(search: Searched) -> Section | None:
    """The candidates that flew all samples in the planes of two objectives; None for a single objective."""
    count = len(search.objectives)
    if count < 2:
        return None
    pairs = list(combinations(range(count), 2))[:MOST_PAIRS]
    figure, panels = plotting.axes(1, len(pairs), 3.2)
    complete = [row for row in search.rows if not row.left and row.objectives]
    least = min(row.violation for row in complete)
    finished = [row for row in complete if row.violation == least]
    front = set(search.front) or _front(search, finished)
    for axis, (i, j) in zip(panels, pairs, strict=True):
        for rows, colour, size, name in (
            ([row for row in finished if row.candidate not in front], plotting.SKY, 14, "dominated"),
            ([row for row in finished if row.candidate in front], plotting.BLUE, 30, "Pareto front"),
            ([search.row[search.best]] if search.best else [], plotting.GREEN, 60, "winner"),
            ([search.row[ORIGINAL]], plotting.RED, 44, "original campaign"),
        ):
            points = [(plotted(search, i, row.objectives[i]), plotted(search, j, row.objectives[j])) for row in rows]
            points = [point for point in points if all(map(math.isfinite, point))]
            if points:
                axis.scatter(*zip(*points, strict=True), s=size, color=colour, lw=0, label=name)
        axis.set_xlabel(label(search, i))
        axis.set_ylabel(label(search, j))
    plotting.legend(panels[0])
    names = [parameter.name for parameter in search.parameters]
    sign = -1.0 if search.objectives[0].largest else 1.0
    listed = sorted((search.row[candidate] for candidate in front), key=lambda row: sign * row.objectives[0])[:20]
    rows = tuple(_row(search, row, names) for row in listed)
    head = ("candidate", *(objective.text for objective in search.objectives), *names)
    limit = ", the first 20" if len(front) > 20 else ""
    caption = f"Pareto front of the candidates that flew all samples{limit}, on the draws of the search."
    body = (Drawing("tuning-trade-offs", FIGURE, figure), Table(caption, head, rows))
    violation = "" if not least else f"; each violates the requirements by {least:.3g} in total"
    least_words = " and violate the requirements least" if any(row.violation > least for row in complete) else ""
    lead = f"{len(front)} of {len(finished)} candidates that flew all samples{least_words} are Pareto-optimal{violation}."
    return Section("trade-offs", "Trade-offs between objectives", lead, body)


def _row(search: Searched, row: Row, names: list[str]) -> tuple[Cell, ...]:
    name: Cell = (
        Mark("WINNER") if row.candidate == search.best else "original" if row.candidate == ORIGINAL else str(row.candidate)
    )
    values = (
        Number(f"front.{row.candidate}.{k}", Observed(value, row.samples), objective.unit, percent=objective.share)
        for k, (value, objective) in enumerate(zip(row.objectives, search.objectives, strict=True))
    )
    return (name, *values, *(setting_text(row.values.get(parameter)) for parameter in names))


def _front(search: Searched, rows: list[Row]) -> set[int]:
    """Numbers of the Pareto-optimal candidates among rows with the same violation."""
    signs = [-1.0 if objective.largest else 1.0 for objective in search.objectives]
    losses = [tuple(sign * value for sign, value in zip(signs, row.objectives, strict=True)) for row in rows]
    return {rows[i].candidate for i in undominated([Score(0.0, values) for values in losses])}
