"""A run knows the code that it flew: every file beside the campaign that is executed, and no other code is mixed into it."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

from rvjax.analysis.compare import _code  # pyright: ignore[reportPrivateUsage]
from rvjax.campaign.python_files import PythonFile, read_file
from rvjax.components import installed_code, registry, user_code
from rvjax.errors import CampaignError, FolderError
from rvjax.execution.identity import identity
from rvjax.execution.replay import replay
from rvjax.execution.run import run
from rvjax.run_folder import RunDescription, RunFolder
from rvjax.simulation.engines.choice import engine_of
from rvjax.simulation.problem import load
from rvjax.testing import check_component
from tests.program import Run
from tests.user_code.mistakes import LAW
from tests.user_code.test_user_mistakes import project

HELPED = LAW.replace("import numpy as np\n", "import numpy as np\nfrom gains_of import FACTOR\n").replace("-100.0 *", "-FACTOR *")
METRIC = """
import jax.numpy as jnp
from rvjax.components import Metric, Parameters, Signal, scalar


class Ball(Parameters):
    radius_m: float = scalar("m", default=2.0, above=0.0, doc="radius")


def start(numbers):
    return {"clear_m": jnp.inf}


def update(acc, instant, numbers):
    return {"clear_m": jnp.minimum(acc["clear_m"], jnp.linalg.norm(instant.rho) - numbers.radius_m)}


METRIC = Metric(Ball, {"clear_m": Signal("m", "distance", "higher")}, start, update)
"""

pytestmark = pytest.mark.usefixtures("bare")


@pytest.fixture
def campaign(tmp_path: Path) -> Path:
    """A law with a helper, and a metric."""
    (tmp_path / "gains_of.py").write_text("FACTOR = 100.0\n")
    (tmp_path / "ball.py").write_text(METRIC)
    path = project(tmp_path, HELPED)
    path.write_text(path.read_text() + "metrics: [{use: ./ball.py, radius_m: {uniform: [1, 2]}}]\n")
    return path


EDITS = {
    "law.py": ("-3.0 * measured.sigma", "-3.1 * measured.sigma"),
    "gains_of.py": ("100.0", "101.0"),
    "ball.py": ("- numbers.radius_m", "- 2.0 * numbers.radius_m"),
}


def edit(folder: Path, name: str) -> None:
    """Changes one of the files."""
    old, new = EDITS[name]
    text = (folder / name).read_text()
    assert old in text
    (folder / name).write_text(text.replace(old, new))


def test_the_identity_has_every_file_that_is_executed(campaign: Path) -> None:
    """Kills: a helper, or a metric, that is not part of the identity."""
    found = identity(load(campaign))
    assert set(found["components"]) == {"law.py", "gains_of.py", "ball.py"}
    assert {"numpy", "scipy"} <= set(found["packages"])  # which may compute the constants of such code


@pytest.mark.parametrize("name", EDITS)
def test_an_edited_file_is_the_new_one_in_a_running_process(campaign: Path, name: str) -> None:
    """Another identity, another compiled program, other code. Kills: a module that Python keeps, a program found by the text of
    the campaign."""
    before = load(campaign)
    edit(campaign.parent, name)
    after = load(campaign)
    old, new = identity(before)["components"], identity(after)["components"]
    assert {file for file in old if old[file] != new[file]} == {name}
    assert engine_of(before) is not engine_of(after)
    assert before.fingerprint != after.fingerprint


def test_the_bytes_that_are_digested_are_those_that_are_executed(campaign: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The file changes after it was read, before it is executed. Kills: a second reading."""
    whole = user_code.module_of

    def late(file: PythonFile) -> ModuleType:
        (campaign.parent / "gains_of.py").write_text("FACTOR = 7.0\n")
        return whole(file)

    monkeypatch.setattr(user_code, "module_of", late)
    problem = load(campaign)
    law = problem.spec.controller.use
    assert isinstance(law, PythonFile)
    assert whole(law).FACTOR == 100.0
    assert law.sources["gains_of.py"] == b"FACTOR = 100.0\n"


def test_two_files_of_the_same_name_do_not_meet(tmp_path: Path) -> None:
    """Each law has its helper. Kills: helpers found by name in `sys.modules`."""
    for name, factor in (("a", "1.0"), ("b", "2.0")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "gains_of.py").write_text(f"FACTOR = {factor}\n")
        (tmp_path / name / "law.py").write_text(HELPED)
    modules = [user_code.module_of(read_file(tmp_path / name / "law.py")) for name in ("a", "b")]
    assert [module.FACTOR for module in modules] == [1.0, 2.0]
    assert "gains_of" not in sys.modules


def test_the_same_code_in_two_folders_has_two_places(tmp_path: Path) -> None:
    """A copy of a file: a mistake is named in the folder whose file flies, and its reads of files are found there too. Kills:
    modules that are shared by their code, whose lines are those of the first folder."""
    law = LAW.replace("    force = ", '    open("gains.txt")\n    force = ')
    line = 1 + next(i for i, text in enumerate(law.splitlines()) if "open(" in text)
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "law.py").write_text(law)
        with pytest.raises(CampaignError, match=r"the code opens a file \(gains.txt\)") as caught:
            check_component(tmp_path / name / "law.py")
        assert str(caught.value).startswith(f"{tmp_path / name / 'law.py'}:{line}: ")


def test_packages_beside_the_file(tmp_path: Path) -> None:
    """Absolute and relative imports, of modules and of names. Kills: a package whose parts are other modules than itself."""
    (tmp_path / "laws" / "deep").mkdir(parents=True)
    (tmp_path / "laws" / "__init__.py").write_text("from .one import ONE\nfrom . import two\n")
    (tmp_path / "laws" / "one.py").write_text("ONE = 1.0\n")
    (tmp_path / "laws" / "two.py").write_text("from .one import ONE\nTWO = ONE + ONE\n")
    (tmp_path / "laws" / "deep" / "__init__.py").write_text("")
    (tmp_path / "laws" / "deep" / "three.py").write_text("from ..two import TWO\nfrom laws import one\nTHREE = TWO + one.ONE\n")
    text = "import laws.deep.three\nfrom laws.deep import three as t\nSIX = laws.deep.three.THREE * laws.two.TWO\n"
    (tmp_path / "law.py").write_text(f"{text}assert t.THREE == 3\n{LAW}")
    file = read_file(tmp_path / "law.py")
    assert user_code.module_of(file).SIX == 6.0
    assert len(file.sources) == 6


def test_a_folder_flies_its_copy(campaign: Path, tmp_path: Path) -> None:
    """The files are edited and removed: the folder is replayed from `inputs/`, and the campaign in it flies the same identity.
    Kills: a replay of the edited file."""
    folder = run(campaign, tmp_path / "run", progress=False)
    copied = {path.name for path in (folder / "inputs").iterdir()}
    assert copied == {"law.py", "gains_of.py", "ball.py"}
    for name in EDITS:
        edit(campaign.parent, name)
    replay(folder, 3)
    (campaign.parent / "law.py").unlink()
    replay(folder, 3)
    assert identity(load(folder / "campaign.yaml")) == RunFolder.open(folder).identity


@pytest.mark.parametrize("name", EDITS)
def test_other_code_does_not_resume_a_folder(campaign: Path, tmp_path: Path, rvjax: Run, name: str) -> None:
    """Exit code 5 and the file that differs. Kills: samples of two laws in one table."""
    assert rvjax("run", campaign, "--out", tmp_path / "run", "--quiet")[0] == 0
    edit(campaign.parent, name)
    code, _, err = rvjax("run", campaign, "--out", tmp_path / "run", "--quiet")
    assert code == 5
    assert f"components.{name}" in err
    assert len(RunFolder.open(tmp_path / "run").samples().frame) == 8


def test_a_copy_that_was_changed_is_refused(campaign: Path, tmp_path: Path) -> None:
    """Kills: a replay that executes whatever stands in the folder."""
    folder = run(campaign, tmp_path / "run", progress=False)
    (folder / "inputs" / "law.py").write_text("raise SystemExit('executed')\n" + LAW)
    with pytest.raises((FolderError, CampaignError)) as refused:
        replay(folder, 3)
    assert "executed" not in str(refused.value)


def test_who_only_reads_executes_nothing(campaign: Path, tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """`check DIR`, `report`, `compare`, `doctor`, of folders whose code must not run. Kills: a report that loads the campaign's
    components, a comparison that looks up a default in the user's file."""
    campaign.write_text(campaign.read_text() + "require: [{metric: clear_m, at_least: 0.5, below: 100}]\n")
    folder = run(campaign, tmp_path / "run", progress=False)
    other = run(campaign, tmp_path / "other", ["controller.gains.kp=0.02"], progress=False)

    def never(file: object) -> None:
        raise AssertionError(f"{file} is executed")

    monkeypatch.setattr(user_code, "module_of", never)
    for words in (["check", folder], ["report", folder], ["compare", folder, other], ["doctor", folder]):
        code, _, err = rvjax(*words)
        assert code in (0, 1, 3), (words, err)
        assert "Traceback" not in err


def test_a_comparison_says_that_the_code_differs(campaign: Path, tmp_path: Path, rvjax: Run) -> None:
    """Which file differs, on the terminal and in the document. Kills: two laws compared as if they were one."""
    folder = run(campaign, tmp_path / "run", progress=False)
    edit(tmp_path, "gains_of.py")
    other = run(campaign, tmp_path / "other", progress=False)
    _, out, _ = rvjax("compare", folder, other)
    assert re.search(r"^  gains_of\.py's code differs \(digests [0-9a-f]{16} and [0-9a-f]{16}\)$", out, re.MULTILINE)
    assert "law.py" not in out
    (tmp_path / "law.py").write_text(LAW)
    third = run(campaign, tmp_path / "third", progress=False)
    _, out, _ = rvjax("compare", other, third)
    assert "\n  only A flies the code of gains_of.py\n  law.py's code differs" in out
    _, same, _ = rvjax("compare", folder, folder)
    assert "code" not in same


def test_a_comparison_says_that_the_code_of_rvjax_or_of_a_package_differs(tmp_path: Path) -> None:
    """Kills: a digest without a sentence, the version of a package left out, equal code named."""
    sides = [
        RunFolder.create(
            tmp_path / name,
            RunDescription(
                identity={"code": name * 16, "components": {"laws.pid": {"code": name, "laws": name}, "same.py": "1"}},
                provenance={},
                name=name,
                campaign_text="",
                samples=1,
            ),
        )
        for name in ("a", "b")
    ]
    assert _code(*sides) == (
        "laws.pid's code differs (digests a of laws a and b of laws b)",
        f"rvjax's code differs (digests {'a' * 16} and {'b' * 16})",
    )
    assert _code(sides[0], sides[0]) == ()


def test_an_installed_package_that_changes_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Python keeps the module that it has imported. Kills: the digest of a file that is not what flies."""
    package = tmp_path / "mylaws_pkg"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "part.py").write_text("GAIN = 1.0\n")
    (package / "law.py").write_text("from mylaws_pkg.part import GAIN\n" + LAW)
    monkeypatch.syspath_prepend(tmp_path)
    table = {**registry.members("controllers"), "mine": "mylaws_pkg.law:CONTROLLER"}
    monkeypatch.setattr(registry, "members", lambda family: table if family == "controllers" else {})
    registry.component("controllers", "mine")
    before = installed_code.identity("mylaws_pkg.law")
    assert set(before) == {"code"}
    (package / "part.py").write_text("GAIN = 2.0\n")
    with pytest.raises(FolderError, match="mylaws_pkg have changed"):
        installed_code.identity("mylaws_pkg.law")
    (package / "part.py").write_text("GAIN = 1.0\n")
    assert installed_code.identity("mylaws_pkg.law") == before


def test_a_package_that_changed_before_its_first_use_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It was imported, then edited, then flown. Kills: the digest of the edited file for the module that was imported."""
    (tmp_path / "mylaws_old.py").write_text(LAW)
    monkeypatch.syspath_prepend(tmp_path)
    __import__("mylaws_old")
    (tmp_path / "mylaws_old.py").write_text(LAW.replace("-3.0", "-4.0"))
    with pytest.raises(FolderError, match="mylaws_old have changed"):
        installed_code.imported("mylaws_old")
