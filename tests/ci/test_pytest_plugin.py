"""The plugin of pytest, in processes of their own, as users have it."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from _pytest.junitxml import mangle_test_address
from ruamel.yaml import YAML
from xdist.scheduler import LoadGroupScheduling

from rvjax.campaign.overrides import override
from rvjax.campaign.source import read
from rvjax.pytest_plugin import CAMPAIGN as MARK
from rvjax.pytest_plugin import NotShown, _alone, _check, _kept, folder_name, item_names, joined  # pyright: ignore[reportPrivateUsage]
from tests.short import CAMPAIGN, QUICK, SHORT

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
    write(tmp_path / "ci" / "short.yaml", QUICK, "faults=[]", "disturbances=[]")
    return tmp_path


def pytested(folder: Path, *arguments: str, **environment: str) -> tuple[int, str]:
    """Exit code and output of pytest, as outside of a CI service: there, pytest writes its summary lines whole."""
    cache = [] if "cacheprovider" in arguments else ["-p", "no:cacheprovider"]
    command = [sys.executable, "-m", "pytest", *cache, *arguments]
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
    assert "PASSED ci/short.yaml::captured: at least 0.9" in said
    assert "UNDECIDED ci/short.yaml::captured: at least 0.99" in said
    assert "FAILED ci/short.yaml::slow (x)" in said
    assert "FAIL: slow [x]: delta_v_m_s below" in said
    assert "Traceback" not in said
    assert [path.read_text() for path in project.glob("heavy-*.txt")] == ["", "", ""]
    (folder,) = (path for path in out.iterdir() if path.is_dir())
    assert folder.name == folder_name(project / "ci" / "short.yaml")
    assert said.count(f"rvjax replay {folder} --sample ") == 2
    assert (project / "s.md").read_text().count("### short: 1 PASS, 1 FAIL, 1 UNDECIDED") == 1
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
    (project / "pytest.ini").write_text("[pytest]\nrvjax_undecided = maybe\nrvjax_timeout_min = soon\n")
    code, said = pytested(project, "--rvjax", "ci", "-q")
    assert code == 4
    assert "rvjax_undecided: found 'maybe'; accepted: fail, pass" in said
    assert "rvjax_timeout_min: found 'soon'; accepted: minutes above 0, up to 10000" in said


def test_what_only_flying_finds_fails_every_requirement(project: Path) -> None:
    """A gain that the controller does not have. Kills: a traceback; a requirement that passes since nothing was judged."""
    write(project / "ci" / "short.yaml", "controller={use: pd-plus, gains: {nope: 1}}")
    code, said = pytested(project, "--rvjax", "ci", "-q")
    assert code == 1
    assert "3 failed" in said
    assert "short.yaml:" in said
    assert "gains.nope: unknown key" in said
    assert "Traceback" not in said


def test_no_two_campaigns_have_the_same_folder(tmp_path: Path) -> None:
    """Kills: a campaign that is judged by the flights of another; a folder that has another name in another clone."""
    for clone in ("one", "two"):
        (tmp_path / clone / "a").mkdir(parents=True)
        (tmp_path / clone / "pyproject.toml").touch()
    root = tmp_path / "one"
    paths = [root / "a" / "b.yaml", root / "a-b.yaml", root / "a-b.yml", Path("/else where/a-b.yaml"), root / f"{'x' * 300}.yaml"]
    names = [folder_name(path) for path in paths]
    assert len(set(names)) == len(names)
    assert all(name.replace("-", "").isalnum() and len(name) < 100 for name in names)
    assert folder_name(tmp_path / "two" / "a" / "b.yaml") == names[0]


TITLES = [
    *("captured: at least 0.9", "[1] captured", "slow [x] more", "a::b", "a:::", "::", "", "[", "]", "x@y]", "two\nlines"),
    *(
        "captured: at least 0.9",
        "a:b",
        "a:::b",
        "tab\tand\x1b",
        "captured: at least 0.9 (2)",
        "captured: at least 0.9",
        "p[a::b]",
    ),
]


def test_names_are_taken_apart_by_no_tool() -> None:
    """By the code of the installed pytest and xdist that reads ids. Kills: `0.999]`, a name that is read as parameters or as two;
    two requirements with one name; a group of xdist that is cut."""
    names = item_names(TITLES)
    assert len(set(names)) == len(TITLES)
    for name in names:
        address = f"ci/a.yaml::{name}"
        assert mangle_test_address(address)[1:] == [name]
        assert name.split("[")[0] == name, "what pytest does with an argument without parameters"
        assert address.rsplit("::", 1) == ["ci/a.yaml", name], "what xdist does with --dist loadscope"
        group = folder_name(Path("/x]y@z/a.yaml"))
        assert LoadGroupScheduling._split_scope(None, f"{address}@{group}") == group  # pyright: ignore[reportArgumentType]
        assert name.isprintable()
    assert names[0] == "captured: at least 0.9"


def test_names_stay_when_a_requirement_is_inserted() -> None:
    """Kills: a number in the name, after which `--last-failed` selects the neighbour."""
    titles = ["captured", "delta_v_m_s below 3", "settled"]
    before = item_names(titles)
    assert [name for name in item_names([titles[0], "new [x]", *titles[1:]]) if name != "new (x)"] == before


COUNTED = """import json, pathlib
import rvjax.pytest_plugin as plugin
def check(campaign, folder, limit_s):
    with open("flown.txt", "a") as file:
        file.write(f"{folder}\\n")
    document = {"verdicts": [
        {"verdict": verdict, "text": "x", "worst_sample": None} for verdict in ("PASS", "PASS", "FAIL")
    ]}
    return document | {"commands": []}
plugin._check = check
"""


def test_an_output_folder_that_exists_is_not_the_root(project: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    """`--rvjax-out DIR` in two words, first in PYTEST_ADDOPTS; the second time DIR exists.

    Kills: another root, so that the failed test is not selected again and the campaign flies into another folder; an id in the
    JUnit XML or in the list that is cut at a point or a bracket.
    """
    out = tmp_path_factory.mktemp("elsewhere") / "out"
    (project / "conftest.py").write_text(COUNTED)
    words = ("--rvjax-out", str(out))
    arguments = ["-p", "cacheprovider", "--rvjax", str(project / "ci"), "-p", "no:xdist", "--junit-xml", "j.xml"]
    code, said = pytested(project, *arguments, "-v", PYTEST_ADDOPTS=shlex.join(words))
    assert code == 1, said
    assert "1 failed, 2 passed" in said
    assert "::captured: at least 0.9 PASSED" in said
    names = [case.get("name") for case in ElementTree.parse(project / "j.xml").iter("testcase")]
    assert names == ["captured: at least 0.9", "captured: at least 0.99", "slow (x)"]
    code, said = pytested(project, *arguments, *words, "--last-failed", "--last-failed-no-failures", "none")
    assert "1 failed" in said
    assert "passed" not in said
    assert len(set((project / "flown.txt").read_text().splitlines())) == 1


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--rvjax-out", "a b", "ci"], ["--rvjax-out=a b", "ci"]),
        (["--rvjax-out=x", "ci"], ["--rvjax-out=x", "ci"]),
        (["ci", "--rvjax-out"], ["ci", "--rvjax-out"]),
        (["--", "--rvjax-out", "x"], ["--", "--rvjax-out", "x"]),
    ],
)
def test_the_output_folder_becomes_one_word(words: list[str], expected: list[str]) -> None:
    """Kills: joining what is no option; a missing value that ends in a traceback."""
    assert joined(words) == expected
    assert joined(expected) == expected


def test_an_output_folder_that_cannot_be_written_is_a_mistake_of_the_command(project: Path) -> None:
    """Kills: `INTERNALERROR`, or an error of every requirement."""
    (project / "file").write_text("x")
    code, said = pytested(project, "--rvjax", "ci", "-q", "--rvjax-out=file/below")
    assert code == 4
    assert "--rvjax-out=file/below: cannot be written: Not a directory; accepted: a folder" in said


def test_another_pytest_is_not_waited_for_without_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a test run that hangs and says nothing while another process has the campaign."""
    monkeypatch.setattr("rvjax.pytest_plugin._MESSAGE_S", 0.0)
    folder, said = tmp_path / "a-0", list[str]()
    with _alone(folder, 1.0, said.append):
        with (
            pytest.raises(NotShown, match="another pytest has been flying") as caught,
            _alone(folder, 0.3, said.append),
        ):
            raise AssertionError("two at a time")
        assert caught.value.verdict == "ERROR"
    assert said == [f"waiting for another pytest, which flies into {folder}, up to 0.005 min"]
    with _alone(folder, 0.3, said.append):
        assert len(said) == 1


def test_a_campaign_that_takes_too_long_is_an_error(tmp_path: Path) -> None:
    """Kills: a child that is waited for without an end; an error without the command that resumes the flights."""
    found = _check(CAMPAIGN, tmp_path / "run", 0.001)
    assert "not decided within" in found["error"]
    assert f"-m rvjax check {CAMPAIGN} --out {tmp_path / 'run'}" in found["error"]
    assert found["commands"] == []


@pytest.mark.parametrize("content", [None, b"", b'{"session": "x", "verd', b"[1]", b"\xff\xfe{}"])
def test_kept_verdicts_that_are_damaged_are_not_used(content: bytes | None, tmp_path: Path) -> None:
    """Kills: a traceback of a file that a stopped process has left half written."""
    file = tmp_path / "a-0.json"
    if content is not None:
        file.write_bytes(content)
    assert _kept(file) == {}


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
