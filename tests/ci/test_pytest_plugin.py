"""The plugin of pytest, in processes of their own, as users have it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from rvjax.campaign.overrides import override
from rvjax.campaign.source import read
from rvjax.pytest_plugin import CAMPAIGN as MARK
from rvjax.pytest_plugin import folder_name
from tests.short import CAMPAIGN, SHORT

REQUIRE = (
    "require=[{metric: captured, at_least: 0.9}, {metric: captured, at_least: 0.99}, "
    "{name: 'slow [x]', metric: delta_v_m_s, below: 1.0e-6, at_least: 0.5}]"
)
WATCH = """import os, sys
def pytest_unconfigure():
    with open(f"heavy-{os.getpid()}.txt", "w") as file:
        file.write(" ".join(sorted({"jax", "rvjax.execution.run"} & set(sys.modules))))
"""


def write(path: Path, *sets: str) -> None:
    """A campaign of forty short flights."""
    with path.open("w") as file:
        YAML(typ="safe").dump(override(read(CAMPAIGN), [*SHORT, "keep={worst: 1}", REQUIRE, *sets]).value, file)


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A folder with a campaign, and YAML that is none."""
    (tmp_path / "ci").mkdir()
    (tmp_path / "ci" / "other.yaml").write_text("jobs: {}\n")
    write(tmp_path / "ci" / "short.yaml", "controller={use: pd-plus}")
    return tmp_path


def pytested(folder: Path, *arguments: str, **environment: str) -> tuple[int, str]:
    """Exit code and output of pytest, as outside of a CI service: there, pytest writes its summary lines whole."""
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *arguments]
    services = ("PYTEST_", "GITHUB_", "CI", "BUILD_NUMBER")
    outside = {name: value for name, value in os.environ.items() if not name.startswith(services)}
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=outside | environment)
    return done.returncode, done.stdout + done.stderr


def test_each_requirement_is_an_item_with_its_own_outcome(project: Path) -> None:
    """Kills: UNDECIDED as a pass or as a plain failure, a traceback, a mark that only xdist knows; JAX in the user's process,
    which may have started it with settings of its own; with xdist, a campaign that every process flies."""
    out = project / "out"
    (project / "conftest.py").write_text(WATCH)
    service = {"GITHUB_ACTIONS": "true", "GITHUB_STEP_SUMMARY": str(project / "s.md"), "GITHUB_WORKSPACE": str(project)}
    code, said = pytested(project, "--rvjax", "ci", "-v", "--rvjax-out", str(out), "-n", "2", **service)
    assert code == 1, said
    assert "1 failed, 1 passed, 1 undecided" in said
    assert "PASSED ci/short.yaml::[1] captured: at least 0.9" in said
    assert "UNDECIDED ci/short.yaml::[2] captured: at least 0.99" in said
    assert "FAILED ci/short.yaml::[3] slow [x]" in said
    assert "FAIL: slow [x]: delta_v_m_s below" in said
    assert "Traceback" not in said
    assert [path.read_text() for path in project.glob("heavy-*.txt")] == ["", "", ""]
    (folder,) = (path for path in out.iterdir() if path.is_dir())
    assert folder.name == folder_name(project / "ci" / "short.yaml", project)
    assert said.count(f"rvjax replay {folder} --sample ") == 2
    assert (project / "s.md").read_text().count("### quickstart: 1 PASS, 1 FAIL, 1 UNDECIDED") == 1
    assert said.count("\n::error file=ci/short.yaml,line=") == 1
    assert said.count("\n::warning file=ci/short.yaml,line=") == 1
    session = json.loads((out / f"{folder.name}.json").read_text())["session"]
    (project / "pytest.ini").write_text("[pytest]\nrvjax_undecided = pass\n")
    arguments = ("--rvjax", "ci", "-q", "--rvjax-out", str(out), "-p", "no:xdist", "--strict-markers", "-k", "captured")
    code, said = pytested(project, *arguments, PYTEST_XDIST_TESTRUNUID=session)
    assert code == 0, said
    assert "1 passed, 1 deselected, 1 undecided" in said
    assert "::warning" not in said


def test_mistakes_are_told_with_their_places(project: Path) -> None:
    """Kills: a traceback out of a campaign file; YAML that is collected without being asked for."""
    (project / "ci" / "short.yaml").write_text("rvjax: 1\nname: x\nsampels: 3\n")
    code, said = pytested(project, "--rvjax", "ci", "-q")
    assert code == 2
    assert "short.yaml:3:1: sampels: unknown key; did you mean samples?" in said
    assert "Traceback" not in said
    code, said = pytested(project, "ci", "-q")
    assert code == 5
    assert "no tests ran" in said
    (project / "pytest.ini").write_text("[pytest]\nrvjax_undecided = maybe\n")
    code, said = pytested(project, "--rvjax", "ci", "-q")
    assert code == 4
    assert "rvjax_undecided: found 'maybe'; accepted: fail, pass" in said


def test_what_only_flying_finds_fails_every_requirement(project: Path) -> None:
    """A gain that the controller does not have. Kills: a traceback; a requirement that passes since nothing was judged."""
    write(project / "ci" / "short.yaml", "controller={use: pd-plus, gains: {nope: 1}}")
    code, said = pytested(project, "--rvjax", "ci", "-q")
    assert code == 1
    assert "3 failed" in said
    assert "short.yaml:" in said
    assert "gains.nope: unknown key" in said
    assert "Traceback" not in said


def test_no_two_campaigns_have_the_same_folder() -> None:
    """Kills: a campaign that is judged by the flights of another; a campaign outside of the root that ends in a traceback."""
    root = Path("/project")
    paths = [root / "a" / "b.yaml", root / "a-b.yaml", root / "a-b.yml", Path("/else where/a-b.yaml"), root / f"{'x' * 300}.yaml"]
    names = [folder_name(path, root) for path in paths]
    assert len(set(names)) == len(names)
    assert all(name.replace("-", "").isalnum() and len(name) < 100 for name in names)
    assert folder_name(Path("/other/a/b.yaml"), Path("/other")) == names[0]


@pytest.mark.parametrize(
    "text", ["rvjax: 1\n", "# x\n\n'rvjax': 1\n", '"rvjax" : 1\n', "\ufeffrvjax: 1\n", "name: x\nrvjax: 1\n"]
)
def test_a_campaign_is_known_by_its_key(text: str) -> None:
    """Kills: a campaign that nobody tests since its first line is another."""
    assert MARK.search(text.encode())
    assert not MARK.search(b"jobs: {rvjax: 1}\n  rvjax: 1\n# rvjax: 1\n")


def test_pytest_starts_without_anything_heavy(project: Path) -> None:
    """Kills: a plugin that imports NumPy or JAX into every test run of everybody who has it installed."""
    look = "import sys, pytest; pytest.main(['-q', '-p', 'no:cacheprovider', 'ci']); print({'jax', 'numpy'} & set(sys.modules))"
    alone = {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTEST_PLUGINS": "rvjax.pytest_plugin"}
    done = subprocess.run([sys.executable, "-c", look], cwd=project, capture_output=True, text=True, check=True, env=alone)
    assert done.stdout.rstrip().endswith("set()")
