"""Campaigns and runs as Python objects: the same flights as the command line's."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pandas as pd
import pytest

import rvjax
from rvjax.errors import UsageError
from rvjax.run_folder import RunFolder
from tests.program import Run as Program
from tests.user_code.mistakes import LAW
from tests.user_code.test_user_identity import METRIC
from tests.user_code.test_user_mistakes import project

pytestmark = pytest.mark.usefixtures("bare")
REQUIRE = "require: [{metric: captured, at_least: 0.01, confidence: 0.5}, {metric: delta_v_m_s, below: 1e3, at_least: 0.9}]\n"


@pytest.fixture
def campaign(tmp_path: Path) -> Path:
    """A campaign that flies a law of the user, with two requirements."""
    path = project(tmp_path, LAW)
    path.write_text(path.read_text() + REQUIRE)
    return path


def test_an_object_flies_what_the_program_flies(campaign: Path, tmp_path: Path, rvjax: Program) -> None:
    """Changed values are those of `--set`; the table, the verdicts and the identity are the same. Kills: a value that is lost, a
    number that is written with fewer digits, a campaign that changes itself."""
    from rvjax import Campaign

    first = Campaign(campaign)
    changed = first.with_({"controller.gains.kp": 0.1 + 0.2}, samples=6)
    run = changed.fly(tmp_path / "object", progress=False)
    words = ("--set", "controller.gains.kp=0.30000000000000004", "--samples", 6)
    assert rvjax("run", campaign, "--out", tmp_path / "program", "--quiet", *words)[0] in (0, 1, 3)
    other = RunFolder.open(tmp_path / "program")
    pd.testing.assert_frame_equal(run.samples, other.samples().frame)
    assert run.folder.identity == other.identity
    assert first.overrides == ()
    assert [verdict.requirement.metric for verdict in run.verdicts] == ["captured", "delta_v_m_s"]
    assert run.columns["metric.delta_v_m_s"].unit == "m/s"
    assert run.report.name == "report.html"
    assert run.summary["samples"]["requested"] == 6 if "samples" in run.summary else run.account.requested == 6
    assert len(run.replay(2)) == 41
    assert run.compare(run).n == 6


def test_a_run_is_shown_shortly(campaign: Path, tmp_path: Path) -> None:
    """One line, and a table for a notebook in which a name from the campaign is text. Kills: a repr of a thousand numbers, markup
    that comes from a file."""
    run = rvjax.Campaign(campaign).with_(name="mine").fly(tmp_path / "<b>", progress=False)
    assert len(repr(run).splitlines()) == 1
    assert "of 8 captured" in repr(run)
    shown = run._repr_html_()
    assert shown.count("<tr>") == 2
    assert "<b>/report" not in shown
    assert repr(rvjax.Campaign(campaign).with_(samples=3)) == f"Campaign({str(campaign)!r}, ['samples=3'])"


def test_a_component_object_stands_for_its_file(campaign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The law and a metric come from modules that the user has imported; the run folder keeps their files and is replayed without
    them. Kills: a run without its code, parameters that are lost."""
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "lawful_here.py").write_text(LAW)
    (tmp_path / "elsewhere" / "balls_here.py").write_text(METRIC)
    monkeypatch.syspath_prepend(tmp_path / "elsewhere")
    law, ball = (importlib.import_module(name) for name in ("lawful_here", "balls_here"))
    changed = rvjax.Campaign(campaign).with_(
        controller=(law.CONTROLLER, {"gains": {"kp": 0.02}}), metrics=[(ball.METRIC, {"radius_m": 1.5})], samples=4
    )
    run = changed.fly(tmp_path / "run", progress=False)
    assert set(run.folder.identity["components"]) == {"lawful_here.py", "balls_here.py"}
    for name in ("lawful_here", "balls_here"):
        (tmp_path / "elsewhere" / f"{name}.py").unlink()
        monkeypatch.delitem(sys.modules, name)
    assert len(rvjax.Run(tmp_path / "run").replay(3)) == 41
    assert "metric.clear_m" in run.samples


def test_an_object_without_a_file_is_refused(campaign: Path) -> None:
    """Kills: a run whose code nobody can fly again."""
    space: dict[str, object] = {"__name__": "__nowhere__"}
    exec(LAW, space)
    with pytest.raises(UsageError, match="in no Python file"):
        rvjax.Campaign(campaign).with_(controller=space["CONTROLLER"])
