"""A file that an option promises is there however the command ends, and an output that cannot be written is refused at once."""

from __future__ import annotations

import json
import os
import shlex
import signal
import socket
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from rvjax.cli import _ci_outputs
from rvjax.errors import IncompleteError
from rvjax.execution import preparation
from rvjax.execution import run as running
from rvjax.run_folder import atomic_files
from tests.program import Run
from tests.short import CAMPAIGN

NAMED = ("--set", "name=two words")


def suite(path: Path) -> tuple[str, str]:
    """The name of the only suite in a JUnit XML file, and the message of its only case, an error."""
    (only,) = ElementTree.parse(path).getroot()
    (case,) = only
    (error,) = case.findall("error")
    return only.get("name") or "", error.get("message") or ""


def ends(monkeypatch: pytest.MonkeyPatch, end: Callable[[Path], object]) -> None:
    """Instead of flying, the folder is opened and `end` is called with it."""

    def fly(file: Path, out: Path | None, values: object, options: running.RunOptions, prepared: object) -> None:
        del file, values
        place = out or Path("reports/x/1")
        place.mkdir(parents=True, exist_ok=True)
        options.on_open(place)
        end(place)

    monkeypatch.setattr(preparation, "prepare", lambda *_: None)
    monkeypatch.setattr(running, "fly", fly)


def raises(error: BaseException) -> Callable[[Path], object]:
    """Raises the error."""

    def end(place: Path) -> None:
        raise error

    return end


def terminated(place: Path) -> None:
    """The process receives SIGTERM."""
    del place
    os.kill(os.getpid(), signal.SIGTERM)
    signal.sigtimedwait([signal.SIGUSR1], 5.0)  # the handler interrupts this


@pytest.mark.parametrize("command", ["run", "check"])
@pytest.mark.parametrize(
    ("end", "code", "said"),
    [
        (raises(KeyboardInterrupt()), 130, "stopped by SIGINT"),
        (terminated, 143, "stopped by SIGTERM"),
        (raises(IncompleteError("the disk is full")), 4, "the disk is full"),
        (raises(ZeroDivisionError("x")), 4, "internal error (a bug in rvjax): ZeroDivisionError: x"),
    ],
)
def test_whatever_ends_a_flight_is_in_the_junit_xml(
    command: str, end: Callable[[Path], object], code: int, said: str, tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: no file after a signal or a bug, the file of an earlier run, a suite that is named after the file; while the
    campaign flies, a file that a kill would leave absent."""
    path = tmp_path / "verdicts.xml"
    path.write_text("<testsuites/>")

    def look(place: Path) -> None:
        assert suite(path) == ("two words", "the run has not ended: it is running, or it was killed")
        end(place)

    ends(monkeypatch, look)
    assert rvjax(command, CAMPAIGN, "--out", tmp_path / "run", "--junit-xml", path, *NAMED)[0] == code
    name, message = suite(path)
    assert name == "two words"
    assert said in message


def test_a_second_interrupt_leaves_the_first_junit_xml(tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """It comes while the reason is being written. Kills: a file that is removed first and written at the end."""
    replace = atomic_files.replace

    def again(path: Path, data: bytes) -> None:
        if b"SIGINT" in data:
            raise KeyboardInterrupt
        replace(path, data)

    monkeypatch.setattr(atomic_files, "replace", again)
    ends(monkeypatch, raises(KeyboardInterrupt()))
    path = tmp_path / "verdicts.xml"
    assert rvjax("check", CAMPAIGN, "--out", tmp_path / "run", "--junit-xml", path)[0] == 130
    assert suite(path)[0] == "short"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--dask", "here"], "--dask here: accepted"),
        (["--dask", "local:2"], "pip install 'rvjax[dask]'"),
        (["--set", "sampels=3"], "sampels: unknown key"),
        (["--against", "nowhere.json"], "nowhere.json"),
    ],
    ids=["wrong place", "no package", "wrong campaign", "no baseline"],
)
def test_what_is_refused_before_flying_is_in_the_junit_xml(
    words: list[str], said: str, tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: an executor or a baseline that is looked at outside of what writes the file; a suite named `baseline`."""
    monkeypatch.chdir(tmp_path)
    if "local:2" in words:
        monkeypatch.setitem(sys.modules, "distributed", None)
        monkeypatch.delitem(sys.modules, "rvjax.execution.executors.dask_client", raising=False)
    code, _, err = rvjax("check", CAMPAIGN, "--junit-xml", "deep/er/j.xml", *words, *NAMED)
    assert code in (2, 5), err
    name, message = suite(tmp_path / "deep" / "er" / "j.xml")
    assert name == "two words"
    assert said in message
    assert not (tmp_path / "reports").exists()


@pytest.mark.parametrize("text", ["name: [", "samples: 3\n", "name: 7\n", "", "name: ' '\n"])
def test_a_campaign_without_a_name_is_known_by_its_file(text: str, tmp_path: Path, rvjax: Run) -> None:
    """Kills: a traceback out of a campaign that cannot be parsed; an empty name of a suite."""
    (tmp_path / "odd.yaml").write_text(text)
    assert rvjax("check", tmp_path / "odd.yaml", "--junit-xml", tmp_path / "j.xml")[0] == 2
    assert suite(tmp_path / "j.xml")[0] == "odd"


def test_a_folder_that_cannot_be_judged_has_the_name_of_its_campaign(tmp_path: Path, rvjax: Run) -> None:
    """`check DIR` of a folder whose manifest is damaged. Kills: the name of the folder."""
    (tmp_path / "manifest.json").write_text("{")
    (tmp_path / "campaign.yaml").write_text("rvjax: 1\nname: approach\n")
    assert rvjax("check", tmp_path, "--junit-xml", tmp_path / "j.xml")[0] == 5
    assert suite(tmp_path / "j.xml")[0] == "approach"


def test_junit_xml_may_lie_in_the_run_folder(tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """A new run folder must be empty. Kills: a file that is written into it too early; no file before the flights."""
    path = tmp_path / "run" / "j.xml"
    path.parent.mkdir()
    path.write_text("<testsuites/>")
    seen: list[list[str]] = []
    ends(monkeypatch, lambda place: seen.append(os.listdir(place)) or raises(KeyboardInterrupt())(place))
    honest = _ci_outputs.CiOutputs._begin
    monkeypatch.setattr(_ci_outputs.CiOutputs, "_begin", lambda *given: seen.append(os.listdir(path.parent)) or honest(*given))
    assert rvjax("check", CAMPAIGN, "--out", path.parent, "--junit-xml", path)[0] == 130
    assert seen == [[], ["j.xml"]]


@pytest.mark.parametrize("words", [["--samples", "0x"], ["--set", "sampels=3"], ["--nothing"]])
def test_a_command_that_is_refused_is_in_the_job_summary(
    words: list[str], tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: a wrong campaign or option of which the job's page says nothing; a text that acts as Markdown; a summary outside of
    GitHub Actions."""
    path = tmp_path / "summary.md"
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(path))
    monkeypatch.delenv("GITHUB_ACTIONS", raising=False)
    rvjax("check", CAMPAIGN, *words)
    assert not path.exists()
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    assert rvjax("check", CAMPAIGN, *words)[0] == 2
    heading, *rest = path.read_text().splitlines()
    assert heading.startswith("### rvjax check ")
    assert heading.endswith(": exit code 2")
    assert any(line.startswith("- ") and len(line) > 10 for line in rest)
    path.unlink()
    ends(monkeypatch, terminated)
    assert rvjax("check", CAMPAIGN, "--out", tmp_path / "run")[0] == 143
    assert "- stopped by SIGTERM before its end" in path.read_text()


PLACES = {"below a file": "file/below", "a name that is too long": "x" * 300}
FILES = PLACES | {"a folder": "folder", "a pipe": "pipe", "no room for a temporary name": "y" * 250}
FOLDERS = PLACES | {"a file": "file", "a broken link": "link/below", "long and deep": f"new/{'x' * 300}"}


@pytest.fixture
def places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder, with things in it that are no place to write. Nothing flies."""
    (tmp_path / "file").write_text("x")
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to("nowhere")
    os.mkfifo(tmp_path / "pipe")
    monkeypatch.chdir(tmp_path)
    refuse: Any = lambda *_, **__: pytest.fail("it flies")  # noqa: E731
    for name in (
        "rvjax.execution.run.fly",
        "rvjax.search.tuning.tune.tune",
        "rvjax.search.worst_case.worst",
        "rvjax.execution.replay.replay",
    ):
        monkeypatch.setattr(name, refuse)
    return tmp_path


def refused(rvjax: Run, *words: object) -> None:
    """Exit code 2 with a message that names the place and what is accepted; no traceback; nothing is changed."""
    before = sorted(path for path in Path().rglob("*") if path.name != "new")
    code, _, err = rvjax(*words)
    assert code == 2, err
    assert "; accepted: " in err
    assert "Traceback" not in err
    assert sorted(path for path in Path().rglob("*") if path.name != "new") == before
    assert Path("file").read_text() == "x"


@pytest.mark.usefixtures("places")
@pytest.mark.parametrize("place", FILES.values(), ids=FILES.keys())
@pytest.mark.parametrize("words", [["check", CAMPAIGN, "--junit-xml"], ["run", CAMPAIGN, "--junit-xml"]], ids=["check", "run"])
def test_a_file_that_cannot_be_written_is_refused_before_flying(place: str, words: list[object], rvjax: Run) -> None:
    """Kills: exit code 5, or the verdict's, after hours; a folder or a pipe that is taken for a file."""
    refused(rvjax, *words, place)
    if words[0] == "check":
        refused(rvjax, "check", CAMPAIGN, "--write-baseline", place)


@pytest.mark.usefixtures("places")
@pytest.mark.parametrize("place", ["file/below.csv", "folder.csv", f"{'x' * 300}.csv"])
def test_a_trace_that_cannot_be_written_is_refused_before_flying(place: str, rvjax: Run) -> None:
    """Kills: a flight whose trace is lost."""
    Path("folder.csv").mkdir()
    refused(rvjax, "replay", "run", "--sample", 0, "--out", place)


@pytest.mark.usefixtures("places")
@pytest.mark.parametrize("place", FOLDERS.values(), ids=FOLDERS.keys())
@pytest.mark.parametrize(
    "words",
    [
        *(["run", CAMPAIGN, "--out"], ["check", CAMPAIGN, "--out"], ["tune", CAMPAIGN, "--out"]),
        *(["worst", CAMPAIGN, "--set", "controller={use: pd-plus}", "--out"], ["init"]),
    ],
    ids=lambda words: words[0],
)
def test_a_folder_that_cannot_be_made_is_refused_before_flying(place: str, words: list[object], rvjax: Run) -> None:
    """Kills: exit code 5, which is that of a damaged run; a refusal that comes after loading, connecting or flying."""
    refused(rvjax, *words, place)


def test_files_of_a_search_or_a_start_are_checked_one_by_one(places: Path, rvjax: Run) -> None:
    """The folder can be written, but not a file in it. Kills: a campaign without its schema, that a second `init` refuses to
    write over; a search whose result has no place."""
    (places / "folder" / "campaign.schema.json").mkdir()
    refused(rvjax, "init", "folder")
    (places / "folder" / "worst.csv").mkdir()
    refused(rvjax, "worst", CAMPAIGN, "--set", "controller={use: pd-plus}", "--out", "folder")


@pytest.mark.usefixtures("places")
def test_a_default_place_that_cannot_be_written_is_refused(rvjax: Run) -> None:
    """`reports` is a file. Kills: checking only what --out names."""
    Path("reports").write_text("x")
    for command in ("run", "check", "tune"):
        refused(rvjax, command, CAMPAIGN)


def test_a_disk_that_refuses_is_told_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the rights of root. Kills: a check that looks only at the kinds of the files."""
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(Exception, match=f"cannot be written: {os.strerror(13)}; accepted"):
        atomic_files.check_folder(tmp_path / "run")
    (tmp_path / "file").write_text("x")
    with pytest.raises(Exception, match=f"cannot be written: {os.strerror(13)}; accepted"):
        atomic_files.check_file(tmp_path / "file")


@pytest.mark.parametrize("option", ["--junit-xml", "--write-baseline"])
def test_what_is_read_is_not_written_over(option: str, tmp_path: Path, rvjax: Run) -> None:
    """Kills: a campaign, or the baseline to compare with, that is replaced by XML."""
    campaign, baseline = tmp_path / "c.yaml", tmp_path / "b.json"
    campaign.write_bytes(CAMPAIGN.read_bytes())
    baseline.write_text("{}")
    (tmp_path / "link").symlink_to(campaign)
    for path in (campaign, tmp_path / "link"):
        code, _, err = rvjax("check", campaign, option, path)
        assert (code, "this file is the campaign; accepted: another path" in err) == (2, True), err
    assert campaign.read_bytes() == CAMPAIGN.read_bytes()
    code, _, err = rvjax("check", campaign, "--against", baseline, option, baseline)
    assert ("this file is the baseline" in err) == (option == "--junit-xml")
    code, _, err = rvjax("check", campaign, "--junit-xml", tmp_path / "x", "--write-baseline", tmp_path / "x")
    assert "this file is the file of --junit-xml" in err
    assert baseline.read_text() == "{}"


OPTIONS = ["--samples", "40", "--seed", "3", "--set", "description=two 'words'", "--junit-xml", "my verdicts.xml", "--json", "-q"]
CHECK = [*OPTIONS, "--against", "b.json", "--write-baseline=new.json", "--dask", "tcp://127.0.0.1:1"]


@pytest.mark.parametrize("out", [[], ["--out", "a run"], ["--out=a run"]], ids=["default", "--out", "--out="])
@pytest.mark.parametrize(("command", "options"), [("run", OPTIONS), ("check", CHECK)])
@pytest.mark.parametrize("end", [KeyboardInterrupt(), IncompleteError("lost")], ids=["SIGINT", "lost"])
def test_the_printed_command_resumes_with_every_option(
    end: BaseException,
    command: str,
    options: list[str],
    out: list[str],
    tmp_path: Path,
    rvjax: Run,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The command that is printed is run, and does the same. Kills: an option that is lost on the way, a name that the shell
    takes apart, a second folder, two JSON documents."""
    from rvjax.analysis import baseline
    from rvjax.cli import check
    from rvjax.cli import run as run_command

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(baseline, "read", lambda path: None)
    monkeypatch.setattr(baseline, "check", lambda *given: None)
    monkeypatch.setattr("rvjax.execution.executors.waiting.socket.create_connection", lambda *_, **__: socket.socket())
    calls: list[Any] = []
    for module in (check, run_command):
        honest = module.fly_and_judge
        monkeypatch.setattr(
            module, "fly_and_judge", lambda *given, _honest=honest, **more: calls.append((given, more)) or _honest(*given, **more)
        )
    ends(monkeypatch, raises(end))
    code, document, err = rvjax(command, CAMPAIGN, *out, *options)
    assert code == (130 if isinstance(end, KeyboardInterrupt) else 4), err
    words = shlex.split(err.partition("Resume with\n")[2].splitlines()[0])
    assert json.loads(document)["go_on_with"] == words
    assert words[0] == "rvjax"
    rvjax(*words[1:])
    (first, more), (second, again) = calls
    assert [str(part) for part in second[2:]] == [str(part) for part in first[2:]]
    assert (second[0], again) == (first[0], more)
    assert second[1] == Path("a run" if out else "reports/x/1")


def test_a_path_that_is_too_long_is_no_bug(rvjax: Run) -> None:
    """Kills: asking whether a path is a folder with a call that raises."""
    code, _, err = rvjax("check", "x" * 300)
    assert (code, "cannot be read: File name too long" in err) == (2, True), err


def test_a_double_dash_ends_the_options() -> None:
    """Kills: an --out that is taken for a file."""
    from rvjax.cli._resuming import resuming

    assert resuming(["run", "--", "-x.yaml"], Path("r")) == ["rvjax", "run", "--out", "r", "--", "-x.yaml"]
    assert resuming(["run", "--out=r", "x"], None) == ["rvjax", "run", "--out=r", "x"]
