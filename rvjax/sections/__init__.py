"""The sections of a report, one file each; a section is a function of the opened run, None where it has nothing to show.

A new section is a new file and a line in SECTIONS, in the order of the page.
"""

from __future__ import annotations

from collections.abc import Callable

from rvjax.sections import (
    adaptation,
    captured,
    comparison,
    dispersions,
    drivers,
    envelopes,
    evidence,
    others,
    provenance,
    saturation,
    settling,
    verdicts,
    worst,
)
from rvjax.sections.opened import Run
from rvjax.sections.page import Section

SECTIONS: tuple[Callable[[Run], Section | None], ...] = (
    verdicts.section,
    evidence.section,
    captured.section,
    settling.section,
    comparison.section,
    envelopes.section,
    saturation.section,
    adaptation.section,
    others.section,
    worst.section,
    drivers.section,
    dispersions.section,
    provenance.section,
)


def sections(run: Run) -> list[Section]:
    """All that a run has, in the order of the page."""
    return [made for section in SECTIONS if (made := section(run)) is not None]
