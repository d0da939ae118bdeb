"""SIGKILL at random instants of real processes: a run that goes on ends with the same bits as one that nobody disturbed.

A chain is one run folder: its process is killed, another one goes on and is killed, …, the last one comes to the end.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from rvjax.execution.chunks import ENVELOPE_CHUNKS
from rvjax.run_folder import RunFolder, atomic_files, checksums
from rvjax.run_folder.entry import PARTS, Key
from rvjax.run_folder.local_storage import LocalStorage
from rvjax.simulation.batch import LANES
from tests.reliability.nursery import Nursery
from tests.reliability.plain import PLAIN
from tests.short import CAMPAIGN

CHUNKS = 10
SETS = (
    f"samples={CHUNKS * LANES - 60}",
    *PLAIN,
    "horizon={duration_s: 5, step_s: 0.1}",
    "capture={position_m: 100, attitude_mrp: 1, window_s: 1}",
)
"""10 chunks that take a second to fly, of which the last one is cut."""

PARTS_OF_SUITE = 2
CHAINS = {False: 1, True: 30}
"""Chains of a part, by whether the suite runs in its full numbers. By default there is one part."""

KILLS = 5
"""Kills of a chain in the full numbers; by default there is one for each place of `AIMS`."""

AIMS = (
    ("open", 1, 0.05),
    ("fly", 1, 0.8),
    ("take", 4, 0.03),
    ("take", 4, 0.03),
    ("worst", 1, 0.5),
    ("take", 9, 0.03),
    ("write", 8, 0.05),
    ("start", 1, 5.0),
)
"""Where a kill may fall, each as often: a place, which of how many passages, the most seconds after it. The last falls anywhere
in a run. The kills of a chain are in this order, else most would find nothing left to fly."""

EACH = np.array([AIMS.index(aim) for aim in dict.fromkeys(AIMS)])
"""Every place once."""


def words(out: Path) -> list[object]:
    """The command."""
    return ["run", CAMPAIGN, "--quiet", "--out", out, *(part for one in SETS for part in ("--set", one))]


@pytest.fixture(scope="module")
def nursery() -> Iterator[Nursery]:
    """One for all chains."""
    nursery = Nursery()
    yield nursery
    nursery.close()


@pytest.fixture(scope="module")
def whole(nursery: Nursery, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The undisturbed run."""
    path = tmp_path_factory.mktemp("whole")
    answer = nursery.raise_child(words(path / "run"), path / "log")
    assert (answer["code"], sorted(answer["flown"])) == (0, list(range(CHUNKS))), (path / "log").read_text()
    return path / "run"


def on_disk(path: Path) -> set[Key]:
    """The files of data that hold what their names say, in the manifest or not."""
    names = [name for name, _ in atomic_files.listing(path, PARTS, sweep=False)]
    keys = {name: Key.of(name) for name in names}
    return {key for name, key in keys.items() if key and key.file(atomic_files.sha256((path / name).read_bytes())) == name}


def state(path: Path) -> str:
    """Where the kill has hit, by what is on the disk."""
    if not (path / "manifest.json").exists():
        return "before there was a run"
    if any(atomic_files.is_temporary(file.name) for file in path.rglob("*")):
        return "in a write"
    entries = {entry.file for entry in RunFolder.open(path)._store.manifest.entries.values()}
    if any(Key.of(name) and name not in entries for name, _ in atomic_files.listing(path, PARTS, sweep=False)):
        return "between a file and its line"
    if len(RunFolder.open(path).chunks) < CHUNKS:
        return "between chunks"
    if len(RunFolder.open(path).trace_samples()) < 10:
        return "among the traces"
    if not (path / "SHA256SUMS").exists() or checksums.complaints(LocalStorage(path)):
        return "in the report"
    return "after the report"


def bits(path: Path) -> dict[str, bytes | list[dict[str, object]]]:
    """Everything that two runs with one identity have in common: all files but for when the run began."""
    names = [file.relative_to(path).as_posix() for file in path.rglob("*") if file.is_file()]
    own = {"manifest.json", "journal.jsonl", "report.html", "report.md", "SHA256SUMS"}
    entries = RunFolder.open(path)._store.manifest.entries
    return {name: (path / name).read_bytes() for name in names if name not in own} | {
        "entries": [entries[key].model_dump() for key in sorted(entries)]
    }


@pytest.mark.parametrize("part", range(PARTS_OF_SUITE))
def test_a_killed_run_goes_on_to_the_same_bits(
    part: int, nursery: Nursery, whole: Path, tmp_path: Path, full: bool, figure: Callable[[str], None]
) -> None:
    """Kills: a folder half created that is refused, a whole file that is set aside or flown again, a temporary file that stays.
    (What takes a moment only, as the order of two files, is broken call by call in test_disk_failures.)
    """
    if part and not full:
        pytest.skip("one chain by default: --long")
    expected = bits(whole)
    states: Counter[str] = Counter()
    flown = kills = 0
    for chain in range(CHAINS[full]):
        generator = np.random.default_rng([20181, part, chain])
        path, log = tmp_path / f"{chain}", tmp_path / f"{chain}.log"
        history: list[str] = []
        aims = np.sort(generator.integers(len(AIMS), size=KILLS)) if full else EACH
        hit = 0
        while True:
            there = on_disk(path) if path.exists() else set()
            place, nth, most = AIMS[aims[min(hit, len(aims) - 1)]]
            aim = (place, int(generator.integers(nth)) + 1, float(generator.uniform(0, most))) if hit < len(aims) else ()
            answer = nursery.raise_child(words(path), log, *aim)
            history.append(f"{aim} → {answer}")
            about = f"chain {part}.{chain}:\n" + "\n".join(history)
            flown += len(answer["flown"])
            again = {Key("samples", n) for n in answer["flown"] if n >= ENVELOPE_CHUNKS or Key("envelopes", n) in there} & there
            assert not again, f"flown again though they were there; {about}"
            assert not (path / "quarantine").exists(), about
            if not aim:
                break
            if answer["code"] == 0:
                continue  # it was done before: no kill
            assert answer["code"] == -9, f"{log.read_text()}\n{about}"
            hit += 1
            if path.exists():
                os.close(atomic_files.lock(path))
            states[state(path)] += 1
            if (path / "manifest.json").exists():
                for _ in RunFolder.open(path).tables():
                    pass
        assert answer["code"] == 0, f"{log.read_text()}\n{about}"
        folder = RunFolder.open(path)
        folder.verify()
        assert folder.samples().frame["sample"].tolist() == list(range(folder.requested)), about
        found = bits(path)
        assert found.keys() == expected.keys(), about
        assert not [name for name in expected if found[name] != expected[name]], about
        kills += hit
    hits = ", ".join(f"{count} {name}" for name, count in states.most_common())
    figure(
        f"kills, part {part + 1} of {PARTS_OF_SUITE}: {kills} SIGKILLs in {CHAINS[full]} run folders, 0 samples lost or double, "
        f"tables and summary bit-identical; hit {hits}; {flown} chunks begun for {CHAINS[full] * CHUNKS}, "
        "none that was on the disk"
    )
    assert kills == CHAINS[full] * (KILLS if full else len(EACH))
