"""The plugin of pytest, in processes of their own, as users have it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from rvjax.spec.overrides import override
from rvjax.spec.source import read
from tests.short import CAMPAIGN, SHORT

REQUIRE = (
    "require=[{metric: captured, at_least: 0.9}, {metric: captured, at_least: 0.99}, "
    "{name: 'slow [x]', metric: delta_v_m_s, below: 1.0e-6, at_least: 0.5}]"
)


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A folder with a campaign, and YAML that is none."""
    (tmp_path / "ci").mkdir()
    (tmp_path / "ci" / "other.yaml").write_text("jobs: {}\n")
    with (tmp_path / "ci" / "short.yaml").open("w") as file:
        YAML(typ="safe").dump(
            override(read(CAMPAIGN), [*SHORT, "controller={use: pd-plus}", "keep={worst: 1}", REQUIRE]).value, file
        )
    return tmp_path


def pytested(folder: Path, *arguments: str) -> tuple[int, str]:
    """Exit code and output of pytest."""
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def test_each_requirement_is_an_item_with_its_own_outcome(project: Path) -> None:
    """Kills: UNDECIDED as a pass or as a plain failure, a traceback, a campaign that is flown for every requirement."""
    out = project / "out"
    code, said = pytested(project, "--rvjax", "ci", "-v", "--rvjax-out", str(out))
    assert code == 1
    assert "1 failed, 1 passed, 1 undecided" in said
    assert "ci/short.yaml::[1] captured: at least 0.9 PASSED" in said
    assert "ci/short.yaml::[2] captured: at least 0.99 UNDECIDED" in said
    assert "ci/short.yaml::[3] slow [x] FAILED" in said
    assert "FAIL: slow [x]: delta_v_m_s below" in said
    assert "rvjax replay" in said
    assert "Traceback" not in said
    assert [path.name for path in out.iterdir() if path.is_dir()] == ["ci-short"]
    (project / "pytest.ini").write_text("[pytest]\nrvjax_undecided = pass\n")
    code, said = pytested(project, "--rvjax", "ci", "-q", "--rvjax-out", str(out), "-k", "captured")
    assert code == 0, said
    assert "1 passed, 1 deselected, 1 undecided" in said


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


def test_pytest_starts_without_anything_heavy(project: Path) -> None:
    """Kills: a plugin that imports NumPy or JAX into every test run of everybody who has it installed."""
    look = "import sys, pytest; pytest.main(['-q', '-p', 'no:cacheprovider', 'ci']); print({'jax', 'numpy'} & set(sys.modules))"
    alone = {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTEST_PLUGINS": "rvjax.pytest_plugin"}
    done = subprocess.run([sys.executable, "-c", look], cwd=project, capture_output=True, text=True, check=True, env=alone)
    assert done.stdout.rstrip().endswith("set()")
