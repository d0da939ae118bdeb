"""Section: what the search has cost, and how candidates left."""

from __future__ import annotations

from rvjax.report.blocks import Number, Section, Table
from rvjax.report.number_format import count
from rvjax.run_folder.tuning_record import Searched


def section(found: Searched) -> Section:
    """One row for each round of the races."""
    cost = found.cost
    columns = zip(cost.sizes, cost.begun, cost.by_test, cost.by_halving, strict=True)
    rows = tuple(
        (
            str(n + 1),
            Number(f"race.{n}.samples", size),
            Number(f"race.{n}.begun", begun),
            Number(f"race.{n}.by_test", tested),
            Number(f"race.{n}.by_halving", halved),
        )
        for n, (size, begun, tested, halved) in enumerate(columns)
    )
    share = cost.flights / cost.full if cost.full else 0.0
    lead = (
        f"{count(cost.flights)} flights of candidates, {100 * share:.3g} % of the {count(cost.full)} that all samples of all "
        f"candidates would have been; {'one program was' if cost.programs == 1 else f'{cost.programs} programs were'} compiled."
    )
    idle = cost.lanes - cost.flights - cost.own
    caption = (
        "Candidates that began a round, and how many left after it: by a test that they are worse than the best, or by halving. "
        f"{count(cost.own)} flights more of the campaign as it is; {count(idle)} lanes filled chunks up."
    )
    return Section(
        "races",
        "Races and cost",
        lead,
        (Table(caption, ("round", "samples", "began", "left by a test", "left by halving"), rows),),
    )
