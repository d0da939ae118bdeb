"""The sections of the report of a search, one file each; a section is a function of what was found, None where it has nothing to
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


def sections(found: Searched) -> list[Section]:
    """All that a search has, in the order of the page."""
    return [made for section in SECTIONS if (made := section(found)) is not None]
