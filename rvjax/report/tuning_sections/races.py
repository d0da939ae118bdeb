"""Section: the cost of the search, and the candidates that each round eliminated."""

from __future__ import annotations

from rvjax.report.blocks import Number, Section, Table
from rvjax.report.number_format import count, share
from rvjax.run_folder.tuning_record import Searched


def section(search: Searched) -> Section:
    """A row for each round of the races."""
    cost = search.cost
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
    flown = cost.flights / cost.full if cost.full else 0.0
    lead = (
        f"{count(cost.flights)} candidate flights, {share(flown)} of the {count(cost.full)} flights of all candidates on "
        f"all samples; {'1 program was' if cost.programs == 1 else f'{cost.programs} programs were'} compiled."
    )
    idle = cost.lanes - cost.flights - cost.own
    caption = (
        "Candidates at the start of each round, and those eliminated after it: by a test that they are worse than the best "
        f"candidate, or by halving. In addition: {count(cost.own)} flights of the original campaign, and {count(idle)} lanes "
        "that only filled up chunks."
    )
    return Section(
        "races",
        "Races and cost",
        lead,
        (Table(caption, ("round", "samples", "candidates", "eliminated by a test", "eliminated by halving"), rows),),
    )
