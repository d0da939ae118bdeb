"""Section: sensitivity of the objective to the parameters."""

from __future__ import annotations

from rvjax.report.blocks import Code, Number, Section, Table
from rvjax.run_folder.tuning_record import Searched
from rvjax.stats import Estimate

LEVEL = 0.05
CONFIDENCE = 0.95


def section(search: Searched) -> Section | None:
    """First-order share of the objective's variance per parameter; None if there were too few candidates."""
    if not search.sensitivity:
        return None
    n = sum(1 for row in search.rows if row.u and row.first)
    ordered = sorted(search.sensitivity, key=lambda parameter: -parameter.share.value)
    rows = tuple(
        (
            Code(parameter.name),
            Number(
                f"sensitivity.{parameter.name}",
                Estimate(parameter.share.value, parameter.share.low, parameter.share.high, n, CONFIDENCE, "given data"),
                percent=True,
            ),
            f"{parameter.p:.2g}",
        )
        for parameter in ordered
    )
    clear = [parameter.name for parameter in ordered if parameter.p * len(ordered) <= LEVEL]
    caption = (
        "First-order sensitivity: the share of the variance of the ranks of the first objective, after the first round of the "
        "race, that a parameter explains alone (given-data estimate over classes of equal size, with mean 0 without an effect); "
        "p by permutation. An adaptive search does not spread its candidates evenly: parameters that it changed together share "
        "their effect."
    )
    lead = (
        f"{', '.join(clear)} clearly influence the objective."
        if len(clear) > 1
        else f"{clear[0]} clearly influences the objective."
        if clear
        else "No single parameter clearly influences the objective."
    )
    return Section("sensitivity", "Sensitivity", lead, (Table(caption, ("parameter", "share of variance", "p"), rows),))
