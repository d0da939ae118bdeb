"""Section: the tuned parameters."""

from __future__ import annotations

from rvjax.report.blocks import Code, Section, Table
from rvjax.report.number_format import setting
from rvjax.run_folder.tuning_record import Searched, Value


def setting_text(value: Value | None) -> str:
    """A value of the campaign file as text."""
    if value is None:
        return "no single value"
    return setting(float(value)) if isinstance(value, int | float) and not isinstance(value, bool) else str(value)


def section(search: Searched) -> Section:
    """Every parameter with its range, the value of the original campaign and the winner's value."""
    rows = tuple(
        (
            Code(parameter.name),
            parameter.range if parameter.free else f"tied: {parameter.range}",
            setting_text(parameter.own),
            setting_text(parameter.best if search.best else parameter.own),
        )
        for parameter in search.parameters
    )
    lead = f"{sum(parameter.free for parameter in search.parameters)} tuned parameters; search method: {search.method}."
    free = [parameter.name for parameter in search.parameters if parameter.free]
    edge = [name for name in free if search.best and _at_the_edge(search, name)]
    notes = (f"At the edge of the range: {', '.join(edge)}. A wider range may contain better values.",) if edge else ()
    return Section(
        "values",
        "Tuned parameters",
        lead,
        (Table("Values in the units of the campaign file.", ("parameter", "range", "original campaign", "winner"), rows), *notes),
    )


def _at_the_edge(search: Searched, name: str) -> bool:
    free = [parameter for parameter in search.parameters if parameter.free]
    index = [parameter.name for parameter in free].index(name)
    if free[index].scale == "levels":
        return False
    u = search.row[search.best].u[index]
    return u < 0.02 or u > 0.98
