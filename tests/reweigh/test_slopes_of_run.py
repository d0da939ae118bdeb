"""`rvjax reweigh --slopes`: the slopes of a run of real flights, from its table."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from rvjax.execution.slopes import SlopesOfRun, slopes
from rvjax.run_folder import RunFolder
from rvjax.stats import clopper_pearson
from tests.program import Run


@pytest.fixture(scope="module")
def found(folder: Path) -> SlopesOfRun:
    return slopes(folder)


def test_a_slope_is_that_of_the_table(folder: Path, found: SlopesOfRun) -> None:
    """The lower end of the remaining effectiveness, [0, 1], by hand; bounds for all rows together. Kills: slopes of the complying
    share, of another draw or requirement, bounds of one row alone."""
    frame, table = RunFolder.open(folder).samples().frame, found.tables[1]
    assert table.name == "not: delta_v_m_s below 0.5: at least 0.5"
    x, bad = frame["draw.faults.effectiveness.remaining.fx"].to_numpy(), ~(frame["metric.delta_v_m_s"].to_numpy() < 0.5)
    row = next(row for row in table.rows if row.draw == "faults.effectiveness.remaining.fx" and row.slope.parameter == "low")
    assert row.slope.estimate is not None
    each = 1.0 - 0.025 / len(table.rows)
    out, inside = (clopper_pearson(int(np.sum(bad & part)), int(np.sum(part)), each) for part in (x < 0.1, x >= 0.1))
    assert row.slope.estimate.value == pytest.approx(-(out.value - inside.value))
    assert row.slope.estimate.low == pytest.approx(-(out.high - inside.low))
    assert row.slope.estimate.high == pytest.approx(-(out.low - inside.high))
    assert row.change == pytest.approx(row.slope.estimate.value * 0.01 / np.sqrt(12.0), rel=1e-4)
    assert table.failing.value == float(np.mean(bad))


def test_clear_slopes_come_first(found: SlopesOfRun) -> None:
    """Speed of the start decides the fuel: its radius leads. Kills: the order of the names, uncertain ones first."""
    rows = found.tables[1].rows
    clear = [row.is_clear for row in rows]
    assert clear[0]
    assert rows[0].draw == "start.nu_m_s"
    assert clear == sorted(clear, reverse=True)
    sizes = [abs(row.change) for row in rows[: sum(clear)]]
    assert sizes == sorted(sizes, reverse=True)


def test_what_is_left_out_is_named(found: SlopesOfRun) -> None:
    """Kills: slopes of correlated draws, of onsets that the table lacks, of classes."""
    shown = {row.draw for row in found.tables[0].rows}
    assert found.left_out["pursuer.mass_kg"] == "is correlated with others"
    assert found.left_out["faults.some.onset_s.fx"].startswith("belongs to a fault with a schedule")
    assert any(" with faults.effectiveness.remaining.fx < 0.5" in name for name in found.left_out)
    assert not shown & found.left_out.keys()
    assert {"start.nu_m_s", "actuators.spread.upper.fx", "faults.effectiveness.onset_s.fx"} <= shown


def test_the_command(folder: Path, found: SlopesOfRun, rvjax: Run) -> None:
    """Kills: numbers that differ between the table and the document, slopes of other laws."""
    code, told, _ = rvjax("reweigh", folder, "--slopes", "--show", "2")
    assert code == 0
    assert "start.nu_m_s: radius¹" in told
    document = json.loads(rvjax("reweigh", folder, "--slopes", "--json")[1])
    assert [row["draw"] for row in document["tables"][1]["rows"]] == [row.draw for row in found.tables[1].rows]
    estimate = found.tables[1].rows[0].slope.estimate
    assert document["tables"][1]["rows"][0]["slope"]["low"] == getattr(estimate, "low", None)
    assert document["left_out"] == found.left_out
    code, _, said = rvjax("reweigh", folder, "--slopes", "--set", "start.nu_m_s={ball: 0.1}")
    assert code == 2
    assert "--slopes with other laws; accepted: --slopes alone" in said
