"""The sections of a tuning report, each in its file. A section is a function Searched → Section, or None if it has nothing to
show."""

from __future__ import annotations

from collections.abc import Callable

from rvjax.report.blocks import Section
from rvjax.report.tuning_sections import confirmation, course, races, sensitivity, slices, tradeoffs, values
from rvjax.run_folder.tuning_record import Searched

SECTIONS: tuple[Callable[[Searched], Section | None], ...] = (
    confirmation.section,
    values.section,
    course.section,
    tradeoffs.section,
    slices.section,
    sensitivity.section,
    races.section,
)


def sections(search: Searched) -> list[Section]:
    """All sections of a search, in the order of the page."""
    return [made for section in SECTIONS if (made := section(search)) is not None]
