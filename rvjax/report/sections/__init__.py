"""The sections of a run's report, each in its file. A section is a function Run → Section, or None if it has nothing to show.

To add a section, add a file and a line in SECTIONS, which is in the order of the page.
"""

from __future__ import annotations

from collections.abc import Callable

from rvjax.report.blocks import Section
from rvjax.report.run_view import Run
from rvjax.report.sections import (
    adaptation,
    captured,
    comparison,
    dispersions,
    envelopes,
    epistemic,
    evidence,
    fixed_values,
    other_metrics,
    provenance,
    rare_failures,
    safety,
    saturation,
    settling,
    trajectories,
    verdicts,
    which_draws,
    worst,
)

SECTIONS: tuple[Callable[[Run], Section | None], ...] = (
    verdicts.section,
    evidence.section,
    rare_failures.section,
    captured.section,
    settling.section,
    trajectories.section,
    safety.section,
    comparison.section,
    envelopes.section,
    saturation.section,
    adaptation.section,
    other_metrics.section,
    worst.section,
    which_draws.section,
    epistemic.section,
    dispersions.section,
    fixed_values.section,
    provenance.section,
)


def sections(run: Run) -> list[Section]:
    """All sections of a run, in the order of the page."""
    return [made for section in SECTIONS if (made := section(run)) is not None]
