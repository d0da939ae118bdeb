"""The sections of a report, one file each; a section is a function of the opened run.

A new section is a new file and a line in SECTIONS, in the order of the page.
"""

from __future__ import annotations

from collections.abc import Callable

from rvjax.sections import (
    adaptation,
    captured,
    drivers,
    envelopes,
    others,
    provenance,
    saturation,
    settling,
    verdicts,
    worst,
)
from rvjax.sections.opened import Run
from rvjax.sections.page import Section

SECTIONS: tuple[Callable[[Run], Section], ...] = (
    verdicts.section,
    captured.section,
    settling.section,
    envelopes.section,
    saturation.section,
    adaptation.section,
    others.section,
    worst.section,
    drivers.section,
    provenance.section,
)
