"""`rvjax check FILE --against BASELINE` with components of a user, also after their files have changed."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.program import Run
from tests.user_code.mistakes import LAW
from tests.user_code.test_user_identity import METRIC
from tests.user_code.test_user_mistakes import project

pytestmark = pytest.mark.usefixtures("bare")
ENDS = """samples: 32
metrics: [{use: ./ball.py, radius_m: 0.5}]
require: [{metric: clear_m, above: 0.0, at_least: 0.5, confidence: 0.5}]
"""


@pytest.fixture
def campaign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A law and a metric of the user, with a requirement on the metric."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ball.py").write_text(METRIC)
    path = project(tmp_path, LAW)
    path.write_text(path.read_text().replace("samples: 8\n", ENDS))
    return path


def worse(out: str) -> set[str]:
    """What the table of the command calls worse."""
    return {words[1] for line in out.splitlines() if (words := line.split()) and words[0] == "WORSE"}


def test_an_edited_file_is_judged_with_its_new_code(campaign: Path, rvjax: Run) -> None:
    """The same files are no worse than their baseline. With an edited law another run flies, whose ∆v is worse; with an edited
    metric, the requirement on it. Kills: a run of the old code judged again, a baseline that does not know the user's metric."""
    code, out, err = rvjax("check", campaign, "--write-baseline", "b.json")
    assert code == 0, err
    code, out, err = rvjax("check", campaign, "--against", "b.json")
    assert (code, worse(out)) == (0, set()), out + err
    assert "1. " in out.partition("against b.json")[2]
    (campaign.parent / "law.py").write_text(LAW.replace("-100.0 *", "-150.0 *"))
    code, out, err = rvjax("check", campaign, "--against", "b.json")
    assert (code, "delta_v_m_s" in worse(out)) == (1, True), out + err
    (campaign.parent / "law.py").write_text(LAW)
    (campaign.parent / "ball.py").write_text(METRIC.replace("- numbers.radius_m", "- 100.0 * numbers.radius_m"))
    code, out, err = rvjax("check", campaign, "--against", "b.json")
    assert (code, worse(out)) == (1, {"1."}), out + err
    assert len(list(Path("reports/mine").iterdir())) == 3


def test_a_mistake_in_an_edited_file_leaves_the_baseline(campaign: Path, rvjax: Run) -> None:
    """Exit code 2 with the user's line. Kills: a baseline of a run that has not flown."""
    (campaign.parent / "law.py").write_text(LAW.replace("gains.kp * measured.rho", "gains.kq * measured.rho"))
    code, _, err = rvjax("check", campaign, "--write-baseline", "b.json")
    line = next(n for n, text in enumerate(LAW.splitlines(), start=1) if "gains.kp * measured.rho" in text)
    assert code == 2
    assert f"law.py:{line}: respond: there is no kq here" in err
    assert not Path("b.json").exists()
