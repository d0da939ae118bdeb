"""The sections of the report of a search, one file each; a section is a function of what was found, None where it has nothing to
show."""

from __future__ import annotations

from collections.abc import Callable

from rvjax.searched import Searched
from rvjax.sections.page import Section
from rvjax.sections.tuning import confirmation, course, races, sensitivity, slices, tradeoffs, values

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
