"""Section: the draws and their distributions, aleatory and epistemic ones apart."""

from __future__ import annotations

import numpy as np

from rvjax.columns import ALEATORY, EPISTEMIC, Column, draw_column
from rvjax.report.blocks import Cell, Code, Section, Table
from rvjax.report.number_format import capital, count, quantity, share
from rvjax.report.run_view import REJECTED, Run

_MEANING = {
    ALEATORY: "random: the value differs from flight to flight",
    EPISTEMIC: "uncertain: the value is fixed in reality but not known exactly",
}
_HEAD = ("draw", "unit", "distribution", "smallest", "median", "largest")


def section(run: Run) -> Section:
    """A table for each kind of draw, with distributions and observed ranges; the number of rejected draws."""
    title = "Dispersions"
    drawn = {kind: [path for path in run.draws() if (_column(run, path).kind or ALEATORY) == kind] for kind in _MEANING}
    if not any(drawn.values()):
        return Section("dispersions", title, "Nothing is drawn: every number is fixed.")
    lead = ", ".join(f"{count(len(paths))} {kind}" for kind, paths in drawn.items() if paths) + " draws for each sample."
    body = (*_rejections(run), *(_table(run, kind, paths) for kind, paths in drawn.items() if paths))
    return Section("dispersions", title, lead, body)


def _column(run: Run, path: str) -> Column:
    return run.totals.columns[draw_column(path)]


def _table(run: Run, kind: str, paths: list[str]) -> Table:
    caption = (
        f"{capital(kind)} draws ({_MEANING[kind]}). Distributions are in the unit of the draw. Smallest and largest values are "
        f"the finite ones of all samples (an onset is infinite where a fault does not occur), medians those{_of(run)}."
    )
    return Table(caption, _HEAD, tuple(_row(run, path) for path in paths))


def _of(run: Run) -> str:
    return run.head_note.rstrip(".").replace(" Of", " of") or " of all samples"


def _row(run: Run, path: str) -> tuple[Cell, ...]:
    column = _column(run, path)
    low, high = run.totals.reach[path]
    middle = float(np.median(run.draw_of_head(path))) if len(run.head) else float("nan")
    return (Code(path), column.unit, column.law, *(quantity(value, column.unit) for value in (low, middle, high)))


def _rejections(run: Run) -> tuple[str, ...]:
    """How many drawn inertias of each body were rejected."""
    sentences: list[str] = []
    for path in run.rejections():
        counts = run.draw_of_head(path)
        accepted = len(counts) / (len(counts) + counts.sum()) if len(counts) else 1.0
        sentences.append(
            f"{path.removesuffix(REJECTED)}: {count(int(counts.sum()))} draws were rejected as unphysical and redrawn, "
            f"for {count(len(counts))} samples ({share(accepted)} of the draws were accepted).{run.head_note}"
        )
    return tuple(sentences)
