"""Section: the values that were searched."""

from __future__ import annotations

from rvjax.report.blocks import Code, Section, Table
from rvjax.report.number_format import setting
from rvjax.run_folder.tuning_record import Searched, Value


def said(value: Value | None) -> str:
    """A value of a campaign."""
    if value is None:
        return "drawn, or not one value"
    return setting(float(value)) if isinstance(value, int | float) and not isinstance(value, bool) else str(value)


def section(found: Searched) -> Section:
    """Every parameter with its range, the campaign's own value and the winner's."""
    rows = tuple(
        (
            Code(one.name),
            one.range if one.free else f"tied: {one.range}",
            said(one.own),
            said(one.best if found.best else one.own),
        )
        for one in found.parameters
    )
    lead = f"{sum(one.free for one in found.parameters)} values were searched by {found.method}."
    edge = [one.name for one in found.parameters if one.free and found.best and _at_the_edge(found, one.name)]
    notes = (f"At the edge of its range: {', '.join(edge)}. A wider one may hold something better.",) if edge else ()
    return Section(
        "values", "Values", lead, (Table("In the units of the campaign file.", ("value", "range", "own", "winner"), rows), *notes)
    )


def _at_the_edge(found: Searched, name: str) -> bool:
    free = [one for one in found.parameters if one.free]
    index = [one.name for one in free].index(name)
    if free[index].scale == "levels":
        return False
    u = found.row[found.best].u[index]
    return u < 0.02 or u > 0.98
