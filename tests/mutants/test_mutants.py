"""A test is believed after it has been seen to fail: every mutant of the table is flown against the test that must notice it.

`pytest --mutants` copies the package and its tests, applies one mutant to the copy and runs its killer there. Without the
option only the table itself is checked: that every mutant can be applied and every killer exists.
"""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.mutants.mutant import Mutant
from tests.mutants.table import MUTANTS

ROOT = Path(__file__).parents[2]
FAILED = 1
"""Exit code of pytest where tests ran and some failed; a mutant that cannot even be imported is not killed but broken."""

each_mutant = pytest.mark.parametrize("mutant", MUTANTS, ids=[mutant.name for mutant in MUTANTS])


def copy_to(folder: Path) -> Path:
    """The package, its tests, the campaigns and margins that they read and the project's settings, in a separate folder."""
    for part in ("rvjax", "tests", "campaigns", "benchmarks"):
        shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    return folder


def run(folder: Path, killers: list[str]) -> subprocess.CompletedProcess[str]:
    """pytest on some tests of the copy; PYTHONPATH puts the copy before whatever is installed. It is no worker of this session,
    and so shares no fixture with the copies of other mutants."""
    inherited = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_XDIST")}
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-x", "--slow", *(f"tests/{killer}" for killer in killers)],
        cwd=folder,
        env=inherited | {"PYTHONPATH": str(folder), "HYPOTHESIS_PROFILE": "mutant"},
        capture_output=True,
        text=True,
        check=False,
    )


@each_mutant
def test_table(mutant: Mutant) -> None:
    """The old text stands in its file exactly once, the new text of a Python file is Python, the killer exists."""
    source = (ROOT / "rvjax" / mutant.file).read_text(encoding="utf-8")
    assert source.count(mutant.old) == 1
    if mutant.file.endswith(".py"):
        ast.parse(source.replace(mutant.old, mutant.new))
    file, test = mutant.killer.split("::")
    tests = ast.parse((ROOT / "tests" / file).read_text(encoding="utf-8"))
    assert any(isinstance(node, ast.FunctionDef) and node.name == test for node in tests.body)


def test_names_are_distinct() -> None:
    """Each mutant has a name of its own."""
    assert len({mutant.name for mutant in MUTANTS}) == len(MUTANTS) >= 15


@pytest.fixture(scope="session")
def wanted(pytestconfig: pytest.Config) -> None:
    """Skips unless mutants were asked for."""
    if not pytestconfig.getoption("mutants"):
        pytest.skip("mutants run with --mutants (minutes)")


@pytest.mark.usefixtures("wanted")
def test_without_a_mutant_every_killer_passes(tmp_path: Path) -> None:
    """The copy as it is: what kills a mutant below is the mutant."""
    done = run(copy_to(tmp_path), sorted({mutant.killer for mutant in MUTANTS}))
    assert done.returncode == 0, done.stdout[-3000:]


@pytest.mark.usefixtures("wanted")
@each_mutant
def test_killed(mutant: Mutant, tmp_path: Path) -> None:
    """The killer fails on the copy with this mutant."""
    file = copy_to(tmp_path) / "rvjax" / mutant.file
    file.write_text(file.read_text(encoding="utf-8").replace(mutant.old, mutant.new), encoding="utf-8")
    done = run(tmp_path, [mutant.killer])
    assert done.returncode == FAILED, done.stdout[-3000:]
