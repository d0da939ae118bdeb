"""The program as a user meets it: exit codes, JSON on stdout, messages on stderr, no traceback."""

from __future__ import annotations

import json
import os
import queue
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from rvjax.cli import COMMANDS, _app
from rvjax.components import manual
from rvjax.run_folder import RunFolder
from tests.program import Run
from tests.short import CAMPAIGN, SHIPPED, SHORT
from tests.spec.corpus import bad_files

QUICK = [part for one in (*SHORT, "controller={use: pd-plus}") for part in ("--set", one)]


def test_help_and_import_do_without_jax() -> None:
    """Kills: an import at the top of a command's module that pulls in JAX, NumPy or pandas."""
    look = "import sys, rvjax, rvjax.cli; print(sorted({'jax', 'numpy', 'pandas', 'pydantic'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", look], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
    assert done.stderr == ""


def test_every_command_has_help(rvjax: Run) -> None:
    """Kills: a command without help, or without an answer for programs."""
    assert len(COMMANDS) >= 15
    for command in COMMANDS:
        code, out, _ = rvjax(command, "--help")
        assert code == 0
        assert "--json" in out


def test_version(rvjax: Run) -> None:
    assert rvjax("--version")[:2] == (0, "rvjax 0.1.0\n")


@pytest.mark.parametrize(
    "wrong", [["fly"], ["run"], ["run", "--samples", "0", "x"], ["replay", "x"], ["check", "--nonsense", "x"]]
)
def test_a_wrong_command_is_exit_2_and_one_message(rvjax: Run, wrong: list[str]) -> None:
    code, out, err = rvjax(*wrong)
    assert (code, out) == (2, "")
    assert err.startswith("rvjax: ")
    assert "Traceback" not in err


def test_a_wrong_campaign_is_exit_2_with_its_place(rvjax: Run, tmp_path: Path) -> None:
    bad = tmp_path / "bad.yaml"
    bad.write_text(CAMPAIGN.read_text().replace("mass_kg", "mass_g").replace("saturated-adaptive", "saturated-adaptve"))
    code, out, err = rvjax("run", bad)
    assert (code, out) == (2, "")
    lines = err.splitlines()
    assert len(lines) == 3  # the unknown key, the missing one, the unknown controller
    assert all(line.startswith(f"{bad}:") for line in lines)
    code, out, _ = rvjax("validate", bad, "--json")
    assert code == 2
    paths = [finding["path"] for finding in json.loads(out)["findings"]]
    assert sorted(paths) == ["controller.use", "pursuer.mass_g", "pursuer.mass_kg"]


def test_validate_counts_the_flights_of_every_baseline(rvjax: Run) -> None:
    """Kills: a cost of the controller under test alone, a table's time for each; "1 chunks"."""
    two = "baselines=[{use: pd-plus}, {use: pd-plus, name: soft}]"
    code, out, err = rvjax("validate", CAMPAIGN, "--samples", 4096, "--set", two)
    assert code == 0, err
    assert "4,096 samples and 2 baselines, 12,288 flights in 30 chunks; " in out
    alone, both = (
        json.loads(rvjax("validate", CAMPAIGN, "--json", "--samples", 4096, "--set", said)[1])[str(CAMPAIGN)]
        for said in ("baselines=[]", two)
    )
    assert (alone["baselines"], alone["flights"], both["baselines"], both["flights"]) == (0, 4096, 2, 12288)
    for name in ("chunks", "steps", "seconds"):
        assert both[name] == pytest.approx(3 * alone[name])
    assert (both["samples"], both["drawn"]) == (alone["samples"], alone["drawn"])
    assert (
        f": 1 sample in 1 chunk, {alone['drawn']} numbers"
        in rvjax("validate", CAMPAIGN, "--samples", 1, "--set", "require=[]")[1]
    )
    one = rvjax("validate", CAMPAIGN, "--samples", 416, "--set", "baselines=[{use: pd-plus}]")[1]
    assert "416 samples and 1 baseline, 832 flights in 2 chunks; " in one


def test_check_gives_the_verdict_as_exit_code(rvjax: Run, flown: Path) -> None:
    """40 captured of 40 cannot show 99 %: undecided (3)."""
    code, out, _ = rvjax("check", flown)
    assert code == 3
    assert "40 samples: 40 captured" in out
    assert "UNDECIDED" in out
    code, out, err = rvjax("check", flown, "--json")
    document = json.loads(out)
    assert (code, document["exit_code"], err) == (3, 3, "")
    assert document["verdicts"][0]["verdict"] == "UNDECIDED"
    assert document["account"]["captured"] == 40


def test_run_ends_with_the_verdict(rvjax: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Flown once, judged by one requirement after the other. Kills: the verdict of the first one; a command without a report."""

    def ended(required: str, *words: str) -> tuple[int, str, str]:
        sets = [*QUICK, "--set", "keep={worst: 1}", "--set", f"require=[{{{required}}}]"]
        return rvjax("run", CAMPAIGN, "--out", tmp_path / "run", *sets, *words)

    code, out, err = ended("metric: captured, at_least: 0.5")
    assert code == 0
    assert str(tmp_path / "run" / "report.html") in out
    assert "flying 40 of 40 samples" in err
    assert (tmp_path / "run" / "report.html").stat().st_size > 100_000
    monkeypatch.setattr("rvjax.report.sections.SECTIONS", ())
    assert ended("metric: captured, at_least: 0.9999")[0] == 3
    code, out, _ = ended("metric: delta_v_m_s, above: 1.0e+6, at_least: 0.5", "--quiet")
    assert code == 1
    assert "FAIL" in out


def test_a_damaged_folder_is_exit_5(rvjax: Run, flown: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    subprocess.run(["cp", "-r", flown, copy], check=True)
    (chunk,) = (copy / "samples").iterdir()
    data = bytearray(chunk.read_bytes())
    data[len(data) // 2] ^= 1
    chunk.chmod(0o644)
    chunk.write_bytes(bytes(data))
    for command in (["check", copy], ["report", copy], ["doctor", copy]):
        code, _, err = rvjax(*command)
        assert code == 5, command
        assert "Traceback" not in err


def test_doctor_tells_what_was_audited(rvjax: Run, flown: Path) -> None:
    code, out, _ = rvjax("doctor", flown, "--json")
    assert code == 0
    assert "dispersions were audited: " in json.loads(out)["facts"]["audit"]


def test_no_run_folder(rvjax: Run, tmp_path: Path) -> None:
    code, out, err = rvjax("report", tmp_path)
    assert (code, out) == (5, "")
    assert str(tmp_path) in err


def test_replay_writes_a_trace(rvjax: Run, flown: Path, tmp_path: Path) -> None:
    code, out, _ = rvjax("replay", flown, "--sample", 3, "--every", 40, "--out", tmp_path / "t.csv", "--json")
    assert code == 0
    assert json.loads(out)["rows"] == 11
    assert len((tmp_path / "t.csv").read_text().splitlines()) == 12
    code, _, err = rvjax("replay", flown, "--sample", 3, "--out", tmp_path / "t.xlsx")
    assert code == 2
    assert "accepted: a name that ends in .parquet or .csv" in err


def test_init_gives_a_campaign_that_is_valid(rvjax: Run, tmp_path: Path) -> None:
    code, _, _ = rvjax("init", tmp_path / "new")
    assert code == 0
    code, out, _ = rvjax("validate", tmp_path / "new" / "campaign.yaml")
    assert code == 0
    assert "256 samples" in out
    code, _, err = rvjax("init", tmp_path / "new")
    assert code == 2
    assert "is there already" in err


def test_shipped_campaigns_are_valid(rvjax: Run) -> None:
    code, out, _ = rvjax("validate", *sorted(SHIPPED.glob("*.yaml")), "--json")
    assert code == 0
    assert {Path(name).stem for name in json.loads(out)} >= {
        "quickstart", "docking-nominal", "docking-faulted", "nussbaum-runaway", "envelope",
    }  # fmt: skip


def test_manual_pages(rvjax: Run) -> None:
    code, out, _ = rvjax("list", "--json")
    assert code == 0
    names = [entry["name"] for entry in json.loads(out)["components"]]
    assert {
        "saturated-adaptive",
        "pd-plus",
        "effectiveness",
        "bias",
        "constant",
        "sinusoid",
        "gravity-gradient",
        "hard-clip",
    } <= set(names)
    for name in (*names, *manual.CHAPTERS, "settling_time_s", "faults", "horizon", "dynamics", "uniform", "ball"):
        code, out, _ = rvjax("explain", name)
        assert (code, bool(out.strip())) == (0, True), name
    code, _, err = rvjax("explain", "efectiveness")
    assert code == 2
    assert "did you mean" in err


def test_schema_describes_every_component(rvjax: Run) -> None:
    code, out, _ = rvjax("schema")
    assert code == 0
    document = json.loads(out)
    assert "remaining" in json.dumps(document)
    assert "nussbaum" in json.dumps(document)
    assert {"samples", "horizon", "controller", "faults"} <= document["properties"].keys()


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_stopped_run_keeps_its_chunks_and_says_how_to_go_on(tmp_path: Path, number: int, code: int) -> None:
    """Kills: chunks lost at Ctrl-C, a traceback, a process that hangs in a thread."""
    command = [sys.executable, "-m", "rvjax", "run", CAMPAIGN, "--out", tmp_path / "run", *QUICK, "--set", "samples=40000"]
    running = subprocess.Popen(
        [*map(str, command)],
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
        env=os.environ | {"COLUMNS": "80"},
        preexec_fn=lambda: signal.signal(
            number, signal.SIG_DFL
        ),  # a test runner in the background passes on that it ignores SIGINT
    )
    assert running.stderr is not None
    while running.poll() is None and len([*(tmp_path / "run" / "samples").glob("*.parquet")]) < 2:
        time.sleep(0.02)  # the file of a second chunk comes when the first is in the journal
    running.send_signal(number)
    rest = running.stderr.read()
    assert running.wait(60) == code, rest
    assert "Traceback" not in rest
    assert f"rvjax run {CAMPAIGN} --out {tmp_path / 'run'}" in rest
    assert RunFolder.open(tmp_path / "run").chunks


def test_every_bad_file_is_exit_2_with_its_places_and_no_traceback(rvjax: Run, tmp_path: Path, full: bool) -> None:
    """Both corpora of bad campaign files, a third of them without `--long`, and paths that are no file, through the program
    itself."""
    tests = Path(__file__).parents[1]
    bad = [*bad_files(tests / "spec" / "bad"), *bad_files(tests / "campaign" / "bad")]
    assert len(bad) >= 130
    for path in (*bad[:: 1 if full else 3], tmp_path, tmp_path / "not-there.yaml"):
        code, out, err = rvjax("validate", path)
        assert (code, out) == (2, ""), path
        assert "Traceback" not in err
        assert all(re.match(rf"{re.escape(str(path))}:\d+:\d+: ", line) for line in err.splitlines()), err


@pytest.mark.parametrize(("lost", "number"), [(KeyboardInterrupt, signal.SIGINT), (_app.Terminated, signal.SIGTERM)])
def test_a_stop_that_a_callback_loses_comes_again(
    lost: type[BaseException], number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As from JAX's callback of the garbage collection, out of which nothing can be raised. Kills: a Ctrl-C that does nothing."""
    came: queue.Queue[tuple[int, int]] = queue.Queue()
    monkeypatch.setattr(os, "kill", lambda *stop: came.put(stop))
    _app._send_again(SimpleNamespace(exc_type=lost))
    assert came.get(timeout=10) == (os.getpid(), number)


def test_worst_flies_in_a_process_of_its_own(tmp_path: Path) -> None:
    """Kills: JAX asked for its devices before it is configured, which only a new process shows."""
    command = [sys.executable, "-m", "rvjax", "worst", str(CAMPAIGN), "--requirement", "1", "--flights", "416", *QUICK]
    fresh = {name: value for name, value in os.environ.items() if name != "XLA_FLAGS"}  # which this process has set
    done = subprocess.run([*command, "--out", str(tmp_path / "worst")], capture_output=True, text=True, check=False, env=fresh)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "worst" / "worst.yaml").is_file()
