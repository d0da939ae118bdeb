"""What the Tab key offers, asked as bash asks."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rvjax.campaign import Spec
from rvjax.campaign.distribution_notation import forms
from rvjax.campaign.overrides import value_at
from rvjax.campaign.source import read
from rvjax.cli import COMMANDS, _completion
from rvjax.components import manual
from tests.program import Run
from tests.short import CAMPAIGN, SHIPPED


def test_topics_are_those_of_explain() -> None:
    """Every name of the manual, read from its modules. Kills: a table that is not read, a family that is left out."""
    components = {name for _, name, _ in manual.components()}
    assert {*components, *manual.CHAPTERS, *Spec.keys()} <= {*_completion.topics("")}
    assert {*_completion.topics("")} <= {*components, *manual.CHAPTERS, *Spec.keys(), *forms()}
    assert _completion.topics("saturated") == ["saturated-adaptive"]


def test_places_of_set_are_those_of_the_campaign(tmp_path: Path) -> None:
    """Each place exists for `--set`. Kills: a place in a list by a number that moves, a place that `--set` does not know."""
    for file in (CAMPAIGN, *sorted((SHIPPED / "ci").glob("*.yaml"))):
        places = [*_completion._paths(_completion._value(file))]
        assert len(places) >= 20
        value = read(file).value
        for place in places:
            assert value_at(value, place)[0], place
    assert {"pursuer.mass_kg", "controller.use", "faults.bias.onset_s"} <= {*_completion._paths(_completion._value(CAMPAIGN))}
    (tmp_path / "bad.yaml").write_text("a: [1, {")
    assert [*_completion._paths(_completion._value(tmp_path / "bad.yaml"))] == []
    two = {"faults": [{"use": "bias"}, {"use": "bias"}, {"use": "bias", "name": "third"}]}
    assert {"faults.bias", "faults.bias-2", "faults.third"} <= {*_completion._paths(two)}


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("rvjax ch", {"check", "check-component"}),
        ("rvjax check --js", {"--json"}),
        ("rvjax explain pd-", {"pd-plus"}),
        ("rvjax run {campaign} --set controller.us", {"controller.use="}),
        ("rvjax run {folder}/", {"{folder}/a.yaml", "{folder}/sub/"}),
        ("rvjax check rep", {"reports/", "reports/x/1a"}),
        ("rvjax replay reports/x/1a --sample 1", {"17", "104"}),
        ("rvjax compare reports/x/1a --baseline p", {"pd-plus"}),
    ],
)
def test_what_a_tab_offers(words: str, offered: set[str], rvjax: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: an argument without its function, the words before an option that are lost, files that are no campaign."""
    for name in ("a.yaml", "b.csv", "sub/c.yaml", "reports/x/1a/manifest.json"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    for name in ("traces/sample-0000017-ab.parquet", "traces/sample-0000104-cd.parquet", "traces/sample-0000002-ef.parquet"):
        (tmp_path / "reports/x/1a" / name).parent.mkdir(exist_ok=True)
        (tmp_path / "reports/x/1a" / name).touch()
    (tmp_path / "reports/x/1a/baselines/pd-plus").mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    line = words.format(campaign=CAMPAIGN, folder=tmp_path)
    monkeypatch.setenv("_RVJAX_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(line.split()) - 1))
    code, out, err = rvjax()
    assert (code, err) == (0, "")
    wanted = {text.format(folder=tmp_path) for text in offered}
    assert {*out.split()} - {f"{tmp_path}/reports/"} == wanted


def test_a_tab_imports_nothing_heavy() -> None:
    """Kills: a Tab that waits for JAX, SciPy or pydantic."""
    look = "import sys; from rvjax.cli import _completion as c; c.topics(''); c.campaigns(''); c.run_folders('')\n"
    look += "from rvjax.cli._app import program; program(); print({'jax', 'numpy', 'scipy', 'pydantic'} & {*sys.modules})"
    done = subprocess.run([sys.executable, "-c", look], capture_output=True, text=True, check=True, env=os.environ)
    assert done.stdout == "set()\n"


def test_the_script_and_an_unknown_shell(rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a script for `python -m rvjax`; the code 1, a failed requirement, where the shell is not known."""
    monkeypatch.setattr("typer.completion._get_shell_name", lambda: "bash")
    code, out, _ = rvjax("--show-completion")
    assert code == 0
    assert "_RVJAX_COMPLETE=complete_bash" in out
    monkeypatch.setattr("typer.completion._get_shell_name", lambda: None)
    assert rvjax("--show-completion")[0] == 2
    assert len(COMMANDS) >= 15
