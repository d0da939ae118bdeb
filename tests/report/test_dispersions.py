"""The section that lists the draws: by kind, with law, observed values and rejections."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from rvjax.analysis.run_totals import Totals
from rvjax.columns import Column
from rvjax.report.blocks import Code, Table
from rvjax.report.run_view import Run, open_run
from rvjax.report.sections import dispersions, which_draws, worst

LAW = "uniform (low 80, high 120)"


@pytest.fixture(scope="module")
def run(made: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Sixty samples, a mass that is not known, a body whose draws were rejected."""
    opened = open_run(made(tmp_path_factory.mktemp("run") / "run", kept=0))
    frame, columns = opened.head.copy(), dict(opened.totals.columns)
    mass = columns["draw.pursuer.mass_kg"]
    columns["draw.pursuer.mass_kg"] = replace(mass, kind="epistemic", law=LAW)
    frame["draw.pursuer.inertia_kgm2.rejected"] = np.arange(60) % 3
    columns["draw.pursuer.inertia_kgm2.rejected"] = Column("draw.pursuer.inertia_kgm2.rejected", "1", "rejected")
    totals = Totals()
    totals.add(0, frame, columns)
    return replace(opened, totals=totals, head=totals.head)


def test_every_draw_is_in_the_table_of_its_kind(run: Run) -> None:
    """Kills: a draw that is in none or in both, the largest for the smallest, a count of rejections among the draws."""
    section = dispersions.section(run)
    chance, unknown = (block for block in section.body if isinstance(block, Table))
    assert section.lead == f"{len(run.draws()) - 1} aleatory, 1 epistemic draws for each sample."
    assert [row[0] for row in unknown.rows] == [Code("pursuer.mass_kg")]
    assert {row[0].text for row in chance.rows if isinstance(row[0], Code)} == set(run.draws()) - {"pursuer.mass_kg"}
    values = run.head["draw.pursuer.mass_kg"]
    low, middle, high = (float(str(cell).split("\u00a0")[0]) for cell in unknown.rows[0][3:])
    assert unknown.rows[0][1:3] == ("kg", LAW)
    assert (low, middle, high) == pytest.approx((values.min(), values.median(), values.max()), rel=0.01)


def test_rejections_are_told(run: Run) -> None:
    """(0 + 1 + 2) · 20 rejected draws for 60 samples: half are accepted."""
    (told,) = (block for block in dispersions.section(run).body if isinstance(block, str))
    assert told.startswith("pursuer.inertia_kgm2: 60 draws were rejected")
    assert "for 60 samples (50\u00a0% of the draws were accepted)." in told


def test_a_count_of_rejections_drives_nothing(run: Run) -> None:
    """Kills: the count among the draws that go with the result, or that stand out."""
    assert run.rejections() == ["pursuer.inertia_kgm2.rejected"]
    assert not set(run.rejections()) & set(run.draws())
    for section in (which_draws.section(run), worst.section(run)):
        assert "rejected" not in str(section)


def test_without_draws_the_section_says_so(run: Run) -> None:
    frame: pd.DataFrame = run.head[[name for name in run.head if not str(name).startswith("draw.")]]
    totals = Totals()
    totals.add(0, frame, {name: column for name, column in run.totals.columns.items() if not name.startswith("draw.")})
    assert dispersions.section(replace(run, totals=totals)).lead.startswith("Nothing is drawn")
