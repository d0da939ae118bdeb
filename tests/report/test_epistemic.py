"""The section of the report on failures over epistemic draws."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rvjax.analysis.run_totals import Totals
from rvjax.report.blocks import Code, Drawing, Number, Table
from rvjax.report.run_view import Run, open_run
from rvjax.report.sections import epistemic
from rvjax.stats import clopper_pearson
from rvjax.stats.sampling_design import Exploration
from tests.once import made_once

UNKNOWN = ("faults.effectiveness.remaining.fx", "pursuer.mass_kg")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory, made: Callable[..., Path]) -> Run:
    """900 samples, of which those with the weakest third of a channel are not captured; two draws are not known."""
    opened = open_run(made_once(tmp_path_factory, "which-draws", lambda path: made(path, 900, kept=0)))
    frame, columns = opened.head.copy(), dict(opened.totals.columns)
    for name in UNKNOWN:
        columns[f"draw.{name}"] = replace(columns[f"draw.{name}"], kind="epistemic")
    x = frame[f"draw.{UNKNOWN[0]}"].to_numpy()
    frame["outcome"] = np.where(x < np.quantile(x, 1.0 / 3.0), "not_settled", "captured")
    totals = Totals()
    totals.add(0, frame, columns)
    return replace(opened, totals=totals, head=totals.head)


def test_the_curves_are_the_classes_with_bars_for_all(run: Run) -> None:
    """By hand: tenths of 90 samples, bounds at 1 − 0.05/20. Kills: bars of one class or one draw alone, aleatory draws, captured
    for not captured, another number of classes, the order of the names."""
    section = epistemic.section(run)
    assert section is not None
    drawing, table = section.body
    assert isinstance(drawing, Drawing)
    assert isinstance(table, Table)
    assert [row[0] for row in table.rows] == [Code(name) for name in UNKNOWN]
    order = np.argsort(run.head[f"draw.{UNKNOWN[0]}"].to_numpy())
    failing = (run.head["outcome"] != "captured").to_numpy()[order].reshape(10, 90).sum(axis=1)
    least, most = table.rows[0][2:]
    for cell, k in ((least, failing.min()), (most, failing.max())):
        assert isinstance(cell, Number)
        bounds = clopper_pearson(int(k), 90, 1.0 - 0.05 / 20.0)
        assert (cell.estimate.value, cell.estimate.low, cell.estimate.high) == pytest.approx(
            (bounds.value, bounds.low, bounds.high), rel=1e-9
        )
    assert section.lead.startswith(
        "The share of flights that are not captured changes most over faults.effectiveness.remaining.fx: "
    )


def test_without_any_there_is_no_section(run: Run) -> None:
    """Kills: a section of aleatory draws, bars of samples that are not independent."""
    columns = {name: replace(column, kind="aleatory") for name, column in run.totals.columns.items()}
    totals = Totals()
    totals.add(0, run.head, columns)
    assert epistemic.section(replace(run, totals=totals, head=totals.head)) is None
    assert epistemic.section(replace(run, design=Exploration("a plan"))) is None
