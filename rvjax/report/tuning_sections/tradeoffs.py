"""Section: objectives against each other."""

from __future__ import annotations

import math
from itertools import combinations

from rvjax.report import plotting
from rvjax.report.blocks import Cell, Drawing, Mark, Number, Section, Table
from rvjax.report.tuning_sections.course import OWN, label, shown
from rvjax.report.tuning_sections.values import said
from rvjax.run_folder.tuning_record import Row, Searched
from rvjax.stats.sampling_design import Observed

MOST_PAIRS = 3

FIGURE = "Candidates that flew all samples and miss the requirements the least, on the draws of the search."


def section(found: Searched) -> Section | None:
    """Candidates that flew all samples in the plane of two objectives; None where there is one objective."""
    count = len(found.objectives)
    if count < 2:
        return None
    pairs = list(combinations(range(count), 2))[:MOST_PAIRS]
    figure, panels = plotting.axes(1, len(pairs), 3.2)
    whole = [row for row in found.rows if not row.left and row.objectives]
    least = min(row.violation for row in whole)
    whole = [row for row in whole if row.violation == least]
    front = set(found.front) or {row.candidate for row in _undominated(found, whole)}
    for axis, (i, j) in zip(panels, pairs, strict=True):
        for rows, colour, size, name in (
            ([row for row in whole if row.candidate not in front], plotting.SKY, 14, "others"),
            ([row for row in whole if row.candidate in front], plotting.BLUE, 30, "best trade-offs"),
            ([found.row[found.best]] if found.best else [], plotting.GREEN, 60, "winner"),
            ([found.row[OWN]], plotting.RED, 44, "campaign as it is"),
        ):
            points = [(shown(found, i, row.objectives[i]), shown(found, j, row.objectives[j])) for row in rows]
            points = [point for point in points if all(map(math.isfinite, point))]
            if points:
                axis.scatter(*zip(*points, strict=True), s=size, color=colour, lw=0, label=name)
        axis.set_xlabel(label(found, i))
        axis.set_ylabel(label(found, j))
    panels[0].legend(loc="best")
    names = [one.name for one in found.parameters]
    sign = -1.0 if found.objectives[0].largest else 1.0
    listed = sorted((found.row[one] for one in front), key=lambda row: sign * row.objectives[0])[:20]
    rows = tuple(_row(found, row, names) for row in listed)
    head = ("candidate", *(one.text for one in found.objectives), *names)
    some = ", the first 20" if len(front) > 20 else ""
    caption = f"Best trade-offs among candidates that flew all samples{some}; on the draws of the search."
    body = (Drawing("tuning-trade-offs", FIGURE, figure), Table(caption, head, rows))
    missed = "" if not least else f"; all of them miss the requirements by {least:.3g} or more"
    lead = f"{len(front)} of {len(whole)} candidates that flew all samples are beaten by no other in everything{missed}."
    return Section("trade-offs", "Objectives against each other", lead, body)


def _row(found: Searched, row: Row, names: list[str]) -> tuple[Cell, ...]:
    who: Cell = Mark("WINNER") if row.candidate == found.best else "as it is" if row.candidate == OWN else str(row.candidate)
    values = (
        Number(f"front.{row.candidate}.{k}", Observed(value, row.samples), one.unit, percent=one.share)
        for k, (value, one) in enumerate(zip(row.objectives, found.objectives, strict=True))
    )
    return (who, *values, *(said(row.values.get(name)) for name in names))


def _undominated(found: Searched, rows: list[Row]) -> list[Row]:
    signs = [-1.0 if one.largest else 1.0 for one in found.objectives]

    def losses(row: Row) -> list[float]:
        return [sign * value for sign, value in zip(signs, row.objectives, strict=True)]

    known = [(row, losses(row)) for row in rows]
    return [
        row
        for row, own in known
        if not any(other != own and all(x <= y for x, y in zip(other, own, strict=True)) for _, other in known)
    ]
