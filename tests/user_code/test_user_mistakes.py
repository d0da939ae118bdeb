"""A user's mistakes end with exit code 2, the user's line and words, without a traceback of rvjax, and leave no folder: in every
command that executes a component."""

from __future__ import annotations

from collections.abc import Iterable
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


def broken(mistake: Mistake, folder: Path) -> tuple[str, Path]:
    """The law with a mistake, and a campaign that flies it."""
    assert mistake.old in LAW
    law = LAW.replace(mistake.old, mistake.new) if mistake.old else LAW
    for name, text in mistake.files.items():
        (folder / name).write_text(text)
    return law, project(folder, law, mistake.use, mistake.gains or "{}")


def check_named(result: tuple[int, str, str], law: str, words: tuple[str, ...], at: str | None) -> None:
    """One line on stderr, with the place and the words of a mistake. at: as of `Mistake`."""
    code, out, err = result
    assert code == 2, out + err
    assert out == ""
    for part in words:
        assert part in err
    if at is not None:
        line = next((i for i, text in enumerate(law.splitlines(), start=1) if at and at in text), 1)
        assert f"law.py:{line}: " in err
    assert "Traceback" not in err
    assert "rvjax_user_" not in err
    assert len(err.splitlines()) == 1, err


def names(mistakes: Iterable[Mistake]) -> list[str]:
    """Their names, for pytest."""
    return [mistake.name for mistake in mistakes]


@pytest.mark.parametrize("mistake", MISTAKES, ids=names(MISTAKES))
def test_a_mistake_has_its_line_and_words(mistake: Mistake, tmp_path: Path, rvjax: Run) -> None:
    """Kills: a traceback, a message without a line, a message about a draw, a file that is executed to its end."""
    law, campaign = broken(mistake, tmp_path)
    check_named(rvjax("validate", campaign), law, mistake.words, mistake.at)


@pytest.mark.parametrize("mistake", MISTAKES, ids=names(MISTAKES))
def test_a_run_names_it_and_leaves_no_folder(
    mistake: Mistake, tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same place and words from `run`, into a folder that is named and into `reports`. Kills: a folder that is made before
    the component is checked, a run that ends with a traceback of the flight."""
    law, campaign = broken(mistake, tmp_path)
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    for place in (["--out", tmp_path / "runs" / "mine"], []):
        check_named(rvjax("run", campaign, *place), law, mistake.words, mistake.at)
        assert sorted(tmp_path.rglob("*")) == before


NAMED_ALONE = [mistake for mistake in MISTAKES if not mistake.right_alone]
RIGHT_ALONE = [mistake for mistake in MISTAKES if mistake.right_alone]


@pytest.mark.parametrize("mistake", NAMED_ALONE, ids=names(NAMED_ALONE))
def test_the_check_of_the_file_names_it(mistake: Mistake, tmp_path: Path, rvjax: Run) -> None:
    """The same place and words from `check-component`, without a campaign. Kills: a check that finds less than a campaign."""
    law, _ = broken(mistake, tmp_path)
    at = mistake.at if mistake.alone_at is None else mistake.alone_at
    check_named(rvjax("check-component", tmp_path / mistake.use), law, mistake.alone or mistake.words, at)


@pytest.mark.parametrize("mistake", RIGHT_ALONE, ids=names(RIGHT_ALONE))
def test_a_mistake_of_the_campaign_is_none_of_the_file(mistake: Mistake, tmp_path: Path, rvjax: Run) -> None:
    """Kills: a check that refuses what another campaign can fly."""
    broken(mistake, tmp_path)
    code, _, err = rvjax("check-component", tmp_path / "law.py")
    assert (code, err) == (0, ""), mistake.right_alone


def test_the_law_without_a_mistake_is_accepted(tmp_path: Path, rvjax: Run) -> None:
    """What the catalogue changes is right before it is changed."""
    code, _, err = rvjax("validate", project(tmp_path, LAW))
    assert (code, err) == (0, "")
