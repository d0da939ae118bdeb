"""Other controllers on the same draws: runs of their own in the run folder, beside each other in its report."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from rvjax.errors import FolderError
from rvjax.execution.audit import Audit
from rvjax.execution.run import run
from rvjax.report import build, run_view, sections
from rvjax.report.sections import comparison, verdicts
from rvjax.run_folder import RunFolder
from rvjax.simulation.batch import Flyer
from rvjax.simulation.problem import Problem
from tests.short import CAMPAIGN, SHORT

OVERRIDES = (
    *SHORT,
    "controller={use: pd-plus, name: stiff}",
    "baselines=[{use: pd-plus, name: soft, gains: {k_rho: 0.0005}}]",
    "keep={worst: 0}",
)


SHOWN = (verdicts.section, comparison.section)
"""Sections of a report here: drawing all of them takes longer than the flights."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of two controllers."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(sections, "SECTIONS", SHOWN)
        return run(CAMPAIGN, tmp_path_factory.mktemp("baselines") / "run", OVERRIDES)


@pytest.fixture(autouse=True)
def _shown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sections, "SECTIONS", SHOWN)


def test_both_fly_the_same_draws_and_stand_beside_each_other(folder: Path) -> None:
    """Kills: draws that depend on the controller, the controller under test flown twice, a comparison with itself."""
    own, other = RunFolder.open(folder), RunFolder.open(folder / "baselines" / "soft")
    (_, mine, _), (_, its, _) = next(own.tables()), next(other.tables())
    drawn = [name for name in mine if name.startswith("draw.")]
    assert drawn
    assert mine[drawn].equals(its[drawn])
    assert (mine["metric.delta_v_m_s"] > its["metric.delta_v_m_s"]).all()  # a fifth of the stiffness asks for less
    numbers = json.loads((folder / "summary.json").read_text())["numbers"]
    stiff, soft = (numbers[f"comparison.{name}.delta_v_m_s.q50"]["value"] for name in ("stiff", "soft"))
    assert stiff == mine["metric.delta_v_m_s"].sort_values().iloc[19]
    assert soft == its["metric.delta_v_m_s"].sort_values().iloc[19]
    assert "| soft | 100" in (folder / "report.md").read_text()
    own.verify()
    other.verify()


def test_a_baseline_is_flown_again_where_it_is_missing(folder: Path) -> None:
    """Its name is no part of the identity. Kills: a finished run that does not look at its baselines."""
    before = {path: path.read_bytes() for path in (folder / "baselines").rglob("*.parquet")}
    shutil.rmtree(folder / "baselines")
    build(folder)
    assert "comparison." not in (folder / "summary.json").read_text()
    run(CAMPAIGN, folder, OVERRIDES)
    assert {path: path.read_bytes() for path in (folder / "baselines").rglob("*.parquet")} == before


def test_only_the_campaign_itself_has_to_show_that_its_draws_act(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a comparison that is refused because one of its controllers loses every flight before a fault comes."""
    asked: list[bool] = []

    def prove(problem: Problem, flyer: Flyer, baseline: bool) -> Audit:
        asked.append(baseline)
        return Audit(0, 0, (), {}, {})

    monkeypatch.setattr("rvjax.execution.run.prove", prove)
    monkeypatch.setattr("rvjax.report.sections.SECTIONS", ())
    run(CAMPAIGN, tmp_path / "run", OVERRIDES)
    assert asked == [False, True]


def test_what_was_folded_while_flying_is_what_a_report_reads(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: every sample of every baseline read once more at the end of a run; a comparison that depends on who made it."""
    shutil.copytree(folder, tmp_path / "run")
    shutil.rmtree(tmp_path / "run" / "baselines")
    with monkeypatch.context() as patched:
        patched.setattr(run_view, "RunFolder", None)  # nothing is opened there
        run(CAMPAIGN, tmp_path / "run", OVERRIDES)
    made = {name: (tmp_path / "run" / name).read_bytes() for name in ("summary.json", "report.html", "report.md")}
    assert b"comparison.soft." in made["summary.json"]
    build(tmp_path / "run")
    assert {name: (tmp_path / "run" / name).read_bytes() for name in made} == made


def test_other_draws_are_not_compared(folder: Path, tmp_path: Path) -> None:
    """Kills: totals of two folders beside each other, whatever they hold."""
    shutil.copytree(folder, tmp_path / "run")
    place = tmp_path / "run" / "baselines" / "soft"
    shutil.rmtree(place)
    run(CAMPAIGN, place, (*OVERRIDES, "baselines=[]", "seed=2"))
    with pytest.raises(FolderError, match="soft: the draws differ from those of the run"):
        build(tmp_path / "run")
