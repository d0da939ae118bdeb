"""Campaign files that went wrong: `rvjax validate` accepts them, or says where not; quickly, and in little memory."""

from __future__ import annotations

import contextlib
import io
import re
import subprocess
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from rvjax.cli import main
from tests.reliability.mutations import GOOD, MUTATIONS, hostile, mutated

FILES = {False: 200, True: 20_000}
"""Mutated files, by whether the suite runs in its full numbers."""

PARTS = 2
EVERY = 10
"""One mutated file of so many is also parsed in the process whose memory is watched."""

MOST_SECONDS = 2.0
MOST_MEMORY_MB = 256.0

LISTED = {
    "billion laughs", "500 lists", "500 mappings", "500 block lists", "500 block mappings", "100 MB", "a million keys", "NUL",
    "tag that calls os.system",
}  # fmt: skip
"""What the promise names."""


@dataclass(frozen=True)
class Answer:
    """What the program said of a file; seconds of processor time."""

    code: object
    out: str
    err: str
    seconds: float


Validate = Callable[[Path], Answer]


@pytest.fixture
def validate(monkeypatch: pytest.MonkeyPatch) -> Iterator[Validate]:
    """`rvjax validate FILE` in this process, where JAX is imported once, before the clock starts; every warning is shown."""

    def run(path: Path) -> Answer:
        monkeypatch.setattr(sys, "argv", ["rvjax", "validate", str(path)])
        out, err = io.StringIO(), io.StringIO()
        started = time.process_time()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), pytest.raises(SystemExit) as ended:
            main()
        return Answer(ended.value.code, out.getvalue(), err.getvalue(), time.process_time() - started)

    with warnings.catch_warnings():
        warnings.simplefilter("always")
        assert [run(path).code for path in GOOD] == [0] * len(GOOD)
        yield run


def complaint(answer: Answer, path: Path) -> str:
    """Which part of the promise an answer breaks; empty where it keeps all."""
    if answer.code not in (0, 2) or "Traceback" in answer.err:
        return f"exit {answer.code}: {answer.err[-2000:]}"
    lines = answer.err.splitlines()  # also at U+0085, U+2028 and the like, which a finding must not hold
    warned = re.compile(rf"warning: {re.escape(str(path))}:[1-9]\d*:[1-9]\d*: \S")
    if answer.code == 0 and (not all(map(warned.match, lines)) or not answer.out.startswith(f"{path}: ")):
        return f"accepted, but says {answer.err or answer.out}"
    if answer.code == 2 and (answer.out or not lines):
        return "refused without a word on stderr alone"
    placed = re.compile(rf"{re.escape(str(path))}:[1-9]\d*:[1-9]\d*: \S")
    if answer.code == 2 and (wrong := [line for line in lines if not placed.match(line)]):
        return f"no line and column: {wrong[0]!r}"
    return f"{answer.seconds:.1f} s" if answer.seconds > MOST_SECONDS else ""


@pytest.mark.parametrize("part", range(PARTS))
def test_mutated_files_are_accepted_or_refused_with_their_places(
    part: int, full: bool, validate: Validate, tmp_path: Path, figure: Callable[[str], None]
) -> None:
    """A share of the mutations is accepted still, else the check would be one of files that are refused at a glance.

    Kills: an exception other than a finding out of any parser, model or distribution; a key with a line end in it, which
    tears its finding apart; a warning of NumPy let through; a finding without a place.
    """
    path = tmp_path / "mutated.yaml"
    codes: Counter[object] = Counter()
    broken: dict[int, str] = {}
    slowest = 0.0
    for number in range(part, FILES[full], PARTS):
        path.write_bytes(mutated(number))
        answer = validate(path)
        codes[answer.code] += 1
        slowest = max(slowest, answer.seconds)
        if found := complaint(answer, path):
            broken[number] = found
    assert not broken, f"{len(broken)} files break the promise, such as mutated({min(broken)}): {broken[min(broken)]}"
    files = codes.total()
    assert files == FILES[full] // PARTS
    assert 0.1 * files < codes[0] < 0.5 * files
    figure(
        f"fuzzed campaign files, part {part + 1} of {PARTS}: {files:,}; accepted {codes[0]:,}, refused {codes[2]:,}; "
        f"slowest {slowest:.2f} s; 0 tracebacks; each error with line and column"
    )


def test_mutations_are_what_they_should_be() -> None:
    """The same files in every run, hardly any of them twice, and every kind of damage among them."""
    files = [mutated(number) for number in range(2_000)]
    assert files[:50] == [mutated(number) for number in range(50)]
    assert len(set(files)) > 0.95 * len(files)
    assert len(MUTATIONS) >= 25
    for mark in (b"\x00", b"\xff", b"\r\n", b"\xef\xbb\xbf", b"&a", b"<<: *a", b"!!", b"\xe2\x80\xa8", b"9" * 39, b"[" * 500):
        assert any(mark in file for file in files), mark


def test_hostile_files_are_refused_at_once(validate: Validate, tmp_path: Path, figure: Callable[[str], None]) -> None:
    """Also the longest good campaigns, which are accepted at once.

    Kills: looking through all installed packages for each component (5 s for 1,600 faults), a file read to its end before
    its size is known, a limit on values or depth lifted, a search for the nearest word without limit, a tag that is obeyed.
    """
    path = tmp_path / "hostile.yaml"
    broken: dict[str, str] = {}
    slowest: dict[str, float] = {}
    cases = hostile()
    assert {case.name for case in cases} >= LISTED
    for case in cases:
        path.write_bytes(case.content)
        answer = validate(path)
        slowest[case.name] = answer.seconds
        if found := complaint(answer, path) or ("" if (answer.code == 0) == case.accepted else f"exit {answer.code}"):
            broken[case.name] = found
    assert not broken
    assert complaint(validate(Path("/dev/zero")), Path("/dev/zero")) == ""
    assert not list(Path.cwd().glob("injected"))
    assert sorted(tmp_path.iterdir()) == [path]
    worst = max(slowest, key=slowest.__getitem__)
    figure(
        f"hostile campaign files: {len(cases)}; slowest {slowest[worst]:.2f} s ({worst}); 0 tracebacks; each error with its place"
    )


PARSER = """
import re, sys
from pathlib import Path
from rvjax.campaign import parse

def peak():
    return int(re.search(r"VmHWM:\\s+(\\d+) kB", Path("/proc/self/status").read_text())[1]) / 1024

print(peak(), "nothing yet", sep="\\t")
for path in sorted(Path(sys.argv[1]).iterdir()):
    spec, findings, _ = parse(path)
    assert (spec is None) == bool(findings), path
    print(peak(), path.stem, sep="\\t")
assert "jax" not in sys.modules
"""
"""Prints the most memory that was ever resident [MB] after each file. VmHWM, unlike ru_maxrss, starts anew at exec."""


def test_parsing_takes_little_memory(full: bool, tmp_path: Path, figure: Callable[[str], None]) -> None:
    """Hostile files and a share of the mutated ones, in one process that only parses. By default those that the promise names.

    Kills: a file read to its end before its size is known (100 MB), aliases that are followed (10^9 values).
    """
    cases = [case for case in hostile() if full or case.name in LISTED]
    for index, case in enumerate(cases):
        (tmp_path / f"{index:05d} {case.name}.yaml").write_bytes(case.content)
    for number in range(0, FILES[full], EVERY):
        (tmp_path / f"m{number:05d}.yaml").write_bytes(mutated(number))
    done = subprocess.run([sys.executable, "-c", PARSER, tmp_path], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    peaks = [(float(peak), name) for peak, name in (line.split("\t") for line in done.stdout.splitlines())]
    assert len(peaks) == 1 + len(cases) + FILES[full] // EVERY
    first = next((name for peak, name in peaks if peak > MOST_MEMORY_MB), "")
    assert not first, f"{peaks[-1][0]:.0f} MB, beyond {MOST_MEMORY_MB:.0f} MB from {first} on"
    before, most = peaks[0][0], peaks[-1][0]
    figure(f"memory while {len(peaks) - 1:,} hostile and fuzzed files are parsed: {most:.0f} MB; before them {before:.0f} MB")
