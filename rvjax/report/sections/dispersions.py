"""Section: what was drawn, from which laws, apart by what is chance and what is not known."""

from __future__ import annotations

import numpy as np

from rvjax.columns import ALEATORY, EPISTEMIC, Column
from rvjax.report.blocks import Cell, Code, Section, Table
from rvjax.report.number_format import capital, count, quantity
from rvjax.report.run_view import REJECTED, Run

_MEANING = {
    ALEATORY: "chance: it differs from flight to flight",
    EPISTEMIC: "not known: one number in reality, whose spread over the samples is what we do not know",
}
_HEAD = ("draw", "unit", "law", "smallest", "median", "largest")


def section(run: Run) -> Section:
    """Each draw with its law and its observed range, one table for each kind; how many draws were rejected."""
    title = "Dispersions"
    drawn = {kind: [path for path in run.draws() if (_column(run, path).kind or ALEATORY) == kind] for kind in _MEANING}
    if not any(drawn.values()):
        return Section("dispersions", title, "Nothing is drawn: every number is fixed.")
    lead = ", ".join(f"{count(len(paths))} {kind}" for kind, paths in drawn.items() if paths) + " draws for each sample."
    body = (*_rejections(run), *(_table(run, kind, paths) for kind, paths in drawn.items() if paths))
    return Section("dispersions", title, lead, body)


def _column(run: Run, path: str) -> Column:
    return run.totals.columns[f"draw.{path}"]


def _table(run: Run, kind: str, paths: list[str]) -> Table:
    caption = f"{capital(kind)} draws ({_MEANING[kind]}). Laws in the unit of the draw. Observed values; medians{_of(run)}."
    return Table(caption, _HEAD, tuple(_row(run, path) for path in paths))


def _of(run: Run) -> str:
    return run.of_head.rstrip(".").replace(" Of", " of") or " of all samples"


def _row(run: Run, path: str) -> tuple[Cell, ...]:
    column = _column(run, path)
    low, high = run.totals.reach[path]
    middle = float(np.median(run.draw_of_head(path))) if len(run.head) else float("nan")
    return (Code(path), column.unit, column.law, *(quantity(value, column.unit) for value in (low, middle, high)))


def _rejections(run: Run) -> tuple[str, ...]:
    """How many draws of each body were rejected because no body can have them."""
    told: list[str] = []
    for path in run.rejections():
        counts = run.draw_of_head(path)
        accepted = len(counts) / (len(counts) + counts.sum()) if len(counts) else 1.0
        told.append(
            f"{path.removesuffix(REJECTED)}: {count(int(counts.sum()))} draws were rejected because no body can have them, "
            f"and drawn again, for {count(len(counts))} samples ({100 * accepted:.3g} % of the draws were accepted).{run.of_head}"
        )
    return tuple(told)
