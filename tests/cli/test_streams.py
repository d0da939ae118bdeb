"""What the program prints, in every encoding of a terminal and into pipes that nobody reads."""

from __future__ import annotations

import ast
import fcntl
import io
import json
import os
import subprocess
import sys
import threading
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest

import rvjax
from rvjax.cli import COMMANDS, main
from rvjax.cli._output import Output
from rvjax.cli._streams import prepare, printable
from rvjax.components import manual
from rvjax.errors import Finding
from rvjax.execution.progress import Progress
from tests.program import Run
from tests.short import CAMPAIGN, QUICK, SHORT

ENCODINGS = ("latin-1", "ascii", "cp1252", "cp437")

Printed = Callable[..., tuple[int, str, str]]


@pytest.fixture
def printed(monkeypatch: pytest.MonkeyPatch) -> Printed:
    """Runs the program with streams of an encoding; the output must decode with it: (exit code, stdout, stderr)."""

    def run(encoding: str, *arguments: object) -> tuple[int, str, str]:
        out, err = io.BytesIO(), io.BytesIO()
        streams = io.TextIOWrapper(out, encoding), io.TextIOWrapper(err, encoding, "backslashreplace")
        with monkeypatch.context() as patch:
            patch.setattr(sys, "argv", ["rvjax", *map(str, arguments)])
            patch.setattr(sys, "stdout", streams[0])
            patch.setattr(sys, "stderr", streams[1])
            with pytest.raises(SystemExit) as ended:
                main()
        assert isinstance(ended.value.code, int)
        result = ended.value.code, out.getvalue().decode(encoding), err.getvalue().decode(encoding)
        for stream in streams:
            stream.close()
        return result

    return run


@pytest.mark.parametrize("blank", ["\u00a0", "\u2009", "\u3000", "\u200b", "\t"])
def test_a_finding_shows_characters_that_look_like_nothing(blank: str) -> None:
    """Kills: `rvjax: unknown key; did you mean rvjax?`, where the key begins with a space of another kind."""
    told = str(Finding("a.yaml:1:1", f"{blank}rvjax", "unknown key", "did you mean rvjax?"))
    assert told == f"a.yaml:1:1: {blank.encode('unicode_escape').decode()}rvjax: unknown key; did you mean rvjax?"


def calls(encoding: str, flown: Path, tmp_path: Path) -> Iterator[tuple[Sequence[object], int]]:
    """Calls that fly a single sample at most, with their exit codes."""
    yield from (([name, "--help"], 0) for name in (COMMANDS if encoding == "ascii" else ("bench", "validate")))
    yield from ((["--help"], 0), (["list"], 0), (["explain", "dynamics"], 0), (["explain", "nothing"], 2))
    yield from ((["plan", "--at-least", 0.99], 0), (["plan", CAMPAIGN], 0), (["validate", CAMPAIGN], 0))
    yield from ((["doctor", flown], 0), (["compare", flown, flown], 3), (["check", flown], 3))
    yield ["replay", flown, "--sample", 1, "--every", 40, "--out", tmp_path / "t.csv"], 0
    yield ["init", tmp_path / "new"], 0


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_an_encoding_costs_neither_the_output_nor_the_exit_code(
    encoding: str, printed: Printed, flown: Path, tmp_path: Path
) -> None:
    """Kills: a character that cannot be printed and ends a command with 4; help in UTF-8 on a terminal of ASCII; an escape
    where a spelling exists."""
    for words, right in calls(encoding, flown, tmp_path):
        code, out, err = printed(encoding, *words)
        assert code == right, words
        assert bool(out.strip()) == (code != 2), words
        assert "Traceback" not in err
        assert "\\x" not in out, words
        assert "\\u" not in out, words


def test_run_prints_its_verdicts_and_writes_utf_8(
    printed: Printed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, bare: None
) -> None:
    """The files stay in UTF-8. Kills: a report, a JUnit file or a job summary in the encoding of the terminal."""
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path / "summary.md"))
    file = tmp_path / "fenêtre.yaml"
    text = CAMPAIGN.read_text(encoding="utf-8").replace("description: ", "description: Größe ≥ 1; ")
    file.write_text(text, encoding="utf-8")
    sets = [word for value in (*SHORT, QUICK, "samples=4", "keep={worst: 0}") for word in ("--set", value)]
    code, out, err = printed("ascii", "run", file, "--out", tmp_path / "é", "--junit-xml", tmp_path / "é.xml", *sets)
    assert code == 3, err
    assert "UNDECIDED" in out
    assert "fen\\xeatre.yaml" in out
    assert "Größe ≥ 1" in (tmp_path / "é" / "campaign.yaml").read_text(encoding="utf-8")
    assert "❔" in (tmp_path / "summary.md").read_text(encoding="utf-8")
    ET.fromstring((tmp_path / "é.xml").read_bytes())
    assert "…" in (tmp_path / "é" / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("words", [["list"], ["explain", "saturated-adaptive"], ["schema"], ["check", "no ≥ folder"]])
def test_json_is_the_same_in_every_encoding(words: list[str], printed: Printed, rvjax: Run) -> None:
    """Kills: spellings inside JSON, which change its content; bytes that no reader of JSON takes for UTF-8."""
    code, out, _ = rvjax(*words, "--json")
    for encoding in ("latin-1", "ascii", "utf-16"):
        again, text, _ = printed(encoding, *words, "--json")
        assert again == code
        assert json.loads(text) == json.loads(out)
        assert text.isascii() or encoding.startswith("utf")


def test_every_manual_page_has_a_spelling_in_ascii(printed: Printed) -> None:
    """Kills: a sign of an equation that is missing in the table of spellings."""
    for name in (*(name for _, name, _ in manual.components()), *manual.CHAPTERS, "horizon", "uniform", "pursuer"):
        code, out, _ = printed("ascii", "explain", name)
        assert code == 0
        names = ("Ku\\u0107era", "\\xe9", "\\xfc", "\\xf8", "\\u0107", "\\u0161", "\\xc9")  # names of authors
        for author in names:
            out = out.replace(author, "")
        assert "\\u" not in out, name
        assert "\\x" not in out, name


@pytest.mark.parametrize(
    ("text", "spelt"),
    [
        ("p ≥ 0.5, q ≤ 1, r ≠ 2", "p >= 0.5, q <= 1, r != 2"),
        ("1 − 2e-06 – 3", "1 - 2e-06 - 3"),
        ("rvjax ×, Δ, ±1", "rvjax x, d, +/-1"),
        ("10⁻³ m/s², x₁₂", "10^-3 m/s^2, x_12"),
        ("σ̇ = ω, θ̂, ẋ, Λ", "sigma_dot = omega, theta_hat, x_dot, Lambda"),
        ("── │ ┌", "-- | +"),
        ("22.3\u00a0%", "22.3 %"),
        ("Größe ☃ 𝄞", "Gr\\xf6\\xdfe \\u2603 \\U0001d11e"),
    ],
)
def test_spellings(text: str, spelt: str) -> None:
    """Kills: a wrong sign, a mark at each digit of an exponent, a letter of a name that is taken for a symbol."""
    prepare()
    stream = io.TextIOWrapper(io.BytesIO(), "ascii")
    assert printable(text, stream) == spelt


def test_the_progress_bar_in_latin_1(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a spinner of characters that the terminal lacks."""

    class Terminal(io.TextIOWrapper):
        def isatty(self) -> bool:
            return True

    bytes_ = io.BytesIO()
    monkeypatch.setattr(sys, "stderr", Terminal(bytes_, "latin-1", "backslashreplace"))
    monkeypatch.setenv("TERM", "xterm")
    prepare()
    with Output().progress() as show:
        for done in range(4):
            show(Progress(phase="flights", done=done, total=3, share=done / 3, ended=done == 3))
    assert b"flying" in bytes_.getvalue()
    assert b"\\u" not in bytes_.getvalue()


class Pipe:
    """A stream of the program into a pipe that is as small as possible."""

    def __init__(self) -> None:
        self.reading, self.writing = os.pipe()
        fcntl.fcntl(self.writing, fcntl.F_SETPIPE_SZ, 4096)  # pyright: ignore[reportAttributeAccessIssue]
        self.stream = io.TextIOWrapper(io.BufferedWriter(io.FileIO(self.writing, "wb")), "utf-8")


PRINTING = [["schema"], ["list"], ["list", "--json"], ["check", "{flown}"]]
ANSWERING = [["--help"], ["tune", "--help"], ["--version"]]
"""Calls that print on stdout alone, whatever else stands on the line."""


@pytest.mark.parametrize(
    ("words", "stream"),
    [*((words, "stdout") for words in (*PRINTING, *ANSWERING)), *(([*words, "--nonsense"], "stderr") for words in PRINTING)],
)
def test_a_closed_pipe_is_141(
    words: list[str], stream: str, flown: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """From the start. Kills: the code 1 of typer, which is a failed requirement; the verdict's code; a traceback."""
    pipe = Pipe()
    os.close(pipe.reading)
    monkeypatch.setattr(sys, stream, pipe.stream)
    monkeypatch.setattr(sys, "argv", ["rvjax", *(word.format(flown=flown) for word in words)])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 141
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("words", [["schema"], ["list"], ["list", "--json"]])
def test_a_pipe_that_closes_in_the_middle_is_141(
    words: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The reader takes a few bytes of more than the pipe holds. Kills: a traceback from the middle of a table."""
    pipe = Pipe()

    def head() -> None:
        os.read(pipe.reading, 10)
        os.close(pipe.reading)

    reader = threading.Thread(target=head)
    reader.start()
    monkeypatch.setattr(sys, "stdout", pipe.stream)
    monkeypatch.setattr(sys, "argv", ["rvjax", *words])
    with pytest.raises(SystemExit) as ended:
        main()
    reader.join()
    assert ended.value.code == 141
    assert capsys.readouterr().err == ""


def test_a_flight_goes_on_without_readers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, bare: None) -> None:
    """Kills: a run that loses its folder, its report or its JUnit file because nobody reads the progress."""
    for stream in ("stdout", "stderr"):
        pipe = Pipe()
        os.close(pipe.reading)
        monkeypatch.setattr(sys, stream, pipe.stream)
    sets = [word for value in (*SHORT, QUICK, "samples=4", "keep={worst: 0}") for word in ("--set", value)]
    files = ["--out", str(tmp_path / "run"), "--junit-xml", str(tmp_path / "j.xml")]
    monkeypatch.setattr(sys, "argv", ["rvjax", "run", str(CAMPAIGN), *files, *sets])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 141
    assert (tmp_path / "j.xml").exists()
    assert (tmp_path / "run" / "report.html").exists()


def test_a_stop_keeps_its_code_without_readers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: 141 where Ctrl-C has ended the program."""

    def stopped(**_: object) -> None:
        print("something")
        raise KeyboardInterrupt

    pipe = Pipe()
    os.close(pipe.reading)
    monkeypatch.setattr(sys, "stdout", pipe.stream)
    monkeypatch.setattr("rvjax.cli._app.program", lambda: stopped)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 130


def test_a_full_disk_is_4_and_one_message(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Kills: a traceback, or the code of a verdict, where the verdict could not be written."""
    full = io.TextIOWrapper(io.BufferedWriter(io.FileIO("/dev/full", "wb")), "utf-8")
    monkeypatch.setattr(sys, "stdout", full)
    monkeypatch.setattr(sys, "argv", ["rvjax", "list"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 4
    assert capsys.readouterr().err == "rvjax: the output cannot be written: No space left on device\n"


def test_a_connection_that_breaks_is_no_verdict(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """As of a Dask scheduler. Kills: typer's code 1 for EPIPE from anywhere."""

    def broken(**_: object) -> None:
        try:
            raise BrokenPipeError(32, "Broken pipe")
        except BrokenPipeError:
            sys.exit(1)

    monkeypatch.setattr("rvjax.cli._app.program", lambda: broken)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 4
    assert "internal error" in capsys.readouterr().err


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_process_ends_with_141_and_silence(unbuffered: str) -> None:
    """With the flush at the end of the interpreter. Kills: "Exception ignored", the interpreter's code 120."""
    pipe = Pipe()
    os.close(pipe.reading)
    command = [sys.executable, "-m", "rvjax", "--version"]
    environment = os.environ | {"PYTHONUNBUFFERED": unbuffered}
    done = subprocess.run(command, stdout=pipe.writing, stderr=subprocess.PIPE, env=environment, check=False)
    assert (done.returncode, done.stderr) == (141, b"")


def test_streams_that_the_shell_has_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    """As `rvjax doctor >&- 2>&-`. Kills: a traceback from a stream that is None."""
    monkeypatch.setattr(sys, "stdout", None)
    monkeypatch.setattr(sys, "stderr", None)
    monkeypatch.setattr(sys, "argv", ["rvjax", "doctor"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 0


def test_every_text_file_names_its_encoding() -> None:
    """Of all modules, read as syntax. Kills: a file or a child process in the encoding of the terminal."""
    opening = ("read_text", "write_text", "open", "fdopen")
    for path in sorted(Path(rvjax.__file__).parent.rglob("*.py")):
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(call, ast.Call):
                continue
            given = {keyword.arg: keyword.value for keyword in call.keywords}
            place = f"{path}:{call.lineno}"
            owner = getattr(getattr(call.func, "value", None), "id", "")
            assert owner != "subprocess" or not {"text", "universal_newlines"} & given.keys(), place
            name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
            if name == "read_text" and not isinstance(call.func, ast.Attribute):  # of `campaign.source`
                continue
            if (
                name not in opening
                or owner in ("os", "RunFolder", "Store", "cls", "formatter", "webbrowser")
                or "encoding" in given
            ):
                continue
            if name == "write_text" and len(call.args) == 2:  # a run folder's
                continue
            modes = [arg.value for arg in (*call.args, *given.values()) if isinstance(arg, ast.Constant)]
            assert any(isinstance(mode, str) and "b" in mode for mode in modes), place
