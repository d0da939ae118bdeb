"""A user's mistakes end with exit code 2, the user's line and words, without a traceback of rvjax, and leave no folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.program import Run
from tests.user_code.mistakes import LAW, MISTAKES, Mistake

CAMPAIGN = """rvjax: 1
name: mine
samples: 8
horizon: {duration_s: 4, step_s: 0.1}
target: {rate_deg_s: [0.2, -0.3, 0.1], port_m: [5, 0, 0]}
pursuer: {mass_kg: {uniform: [90, 110]}, inertia_kgm2: {principal: [22, 20, 23]}}
start: {rho_m: {box: 5}, sigma: {box: 0.2}}
actuators: {upper: [4, 4, 4, 0.8, 0.8, 0.8], lower: [3, 3, 3, 0.6, 0.6, 0.6]}
capture: {window_s: 1}
controller: {use: USE, gains: GAINS}
"""


def project(folder: Path, law: str, use: str = "./law.py", gains: str = "{}") -> Path:
    """A campaign that flies a law."""
    (folder / "law.py").write_text(law)
    campaign = folder / "mine.yaml"
    campaign.write_text(CAMPAIGN.replace("USE", use).replace("GAINS", gains))
    return campaign


@pytest.mark.parametrize("mistake", MISTAKES, ids=[mistake.name for mistake in MISTAKES])
def test_a_mistake_has_its_line_and_words(mistake: Mistake, tmp_path: Path, rvjax: Run) -> None:
    """Kills: a traceback, a message without a line, a message about a draw, a file that is executed to its end."""
    assert mistake.old in LAW
    law = LAW.replace(mistake.old, mistake.new) if mistake.old else LAW
    for name, text in mistake.files.items():
        (tmp_path / name).write_text(text)
    code, out, err = rvjax("validate", project(tmp_path, law, mistake.use, mistake.gains or "{}"))
    assert code == 2, out + err
    for words in mistake.words:
        assert words in err
    if mistake.at is not None:
        line = next((i for i, text in enumerate(law.splitlines(), start=1) if mistake.at and mistake.at in text), 1)
        assert f"law.py:{line}" in err
    assert "Traceback" not in err
    assert "rvjax_user_" not in err
    assert len(err.splitlines()) == 1, err


def test_the_law_without_a_mistake_is_accepted(tmp_path: Path, rvjax: Run) -> None:
    """What the catalogue changes is right before it is changed."""
    code, _, err = rvjax("validate", project(tmp_path, LAW))
    assert (code, err) == (0, "")
