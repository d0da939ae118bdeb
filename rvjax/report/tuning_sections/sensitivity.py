"""Section: which values matter."""

from __future__ import annotations

from rvjax.report.blocks import Code, Number, Section, Table
from rvjax.run_folder.tuning_record import Searched
from rvjax.stats import Estimate

LEVEL = 0.05
CONFIDENCE = 0.95


def section(found: Searched) -> Section | None:
    """Share of the variance of the objective that each value explains alone; None where there were too few candidates."""
    if not found.sensitivity:
        return None
    n = sum(1 for row in found.rows if row.u and row.first)
    ordered = sorted(found.sensitivity, key=lambda one: -one.share.value)
    rows = tuple(
        (
            Code(one.name),
            Number(
                f"sensitivity.{one.name}",
                Estimate(one.share.value, one.share.low, one.share.high, n, CONFIDENCE, "given data"),
                percent=True,
            ),
            f"{one.p:.2g}",
        )
        for one in ordered
    )
    clear = [one.name for one in ordered if one.p * len(ordered) <= LEVEL]
    caption = (
        "Share of the variance of the ranks of the first objective, after the first round of its race, that each value explains "
        "alone (given-data estimate over classes of equal size, 0 in the mean where there is none); p by permutation. Candidates "
        "of a search that follows what it finds are not spread evenly: values that it moved together share what they explain."
    )
    lead = (
        f"{', '.join(clear)} clearly decide the objective."
        if len(clear) > 1
        else f"{clear[0]} clearly decides the objective."
        if clear
        else "No value clearly decides the objective alone."
    )
    return Section("sensitivity", "Which values matter", lead, (Table(caption, ("value", "explains", "p"), rows),))
