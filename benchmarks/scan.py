"""How long it takes to open a run folder of many chunks and to resume it, and the memory: `python -m benchmarks.scan [CHUNKS]`.

The chunks are small files of no meaning: names, sizes, manifest and journal are measured, not what the files hold. Once with
everything in the manifest, as a run leaves that has ended; once with as many lines in the journal as it may have, as a run leaves
that was killed. Each measurement is a new process; its memory is the peak of the whole process, imports included.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rvjax.run_folder import CAMPAIGN, RunDescription, RunFolder, atomic_files
from rvjax.run_folder.entry import Entry, Key
from rvjax.run_folder.journal import Journal
from rvjax.run_folder.local_storage import MOST_LINES, LocalStorage
from rvjax.run_folder.manifest import Head, Manifest

LANES = 416
CHUNKS = 1_000_000
IDENTITY: dict[str, Any] = {"campaign": "made up"}
TEXT = "rvjax: 1\n"
ACTIONS = ("open", "resume")


def build(root: Path, chunks: int) -> list[Entry]:
    """Writes the files of the chunks and returns their entries."""
    (root / "samples").mkdir(parents=True)
    (root / CAMPAIGN).write_text(TEXT)
    entries: list[Entry] = []
    for chunk in range(chunks):
        data = b"%d" % chunk
        digest = atomic_files.sha256(data)
        file = Key("samples", chunk).file(digest)
        entries.append(Entry(file=file, sha256=digest, bytes=len(data), first=chunk * LANES, count=LANES))
        (root / file).write_bytes(data)
    return entries


def enter(root: Path, entries: Sequence[Entry], lines: int) -> None:
    """Writes manifest and journal; the last entries are in lines of the journal."""
    samples, campaign = len(entries) * LANES, atomic_files.sha256(TEXT.encode())
    head = Head(name="scan", samples=samples, identity=IDENTITY, provenance={}, campaign=campaign)
    journal, folded = Journal(LocalStorage(root)), len(entries) - lines
    journal.fold(Manifest(head, entries[:folded]))
    if lines:
        journal.append(entries[folded:])
    journal.close()


def resume(root: Path) -> None:
    """Opens the folder to fly what it lacks, which is nothing, and closes it again."""
    samples = RunFolder.open(root).requested
    description = RunDescription(identity=IDENTITY, provenance={}, campaign_text=TEXT, samples=samples, name="scan")
    with RunFolder.resume(root, description, LANES) as folder:
        assert folder.missing(samples // LANES) == []


def report(action: str, root: Path) -> None:
    """Prints seconds, seconds of the processor and peak memory [MB] of an action in this process."""
    started, worked = time.perf_counter(), time.process_time()
    actions: dict[str, Callable[[Path], object]] = {"open": RunFolder.open, "resume": resume}
    actions[action](root)
    seconds = time.perf_counter() - started
    print(json.dumps([seconds, time.process_time() - worked, peak_mb()]))


def peak_mb() -> float:
    """The largest memory that this process has held, imports included [MB]; `ru_maxrss` includes its parent."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith("VmHWM:")) / 1024


def measure(chunks: int) -> dict[str, tuple[float, float, float]]:
    """Seconds, seconds of the processor and peak memory [MB] by what was done."""
    measured: dict[str, tuple[float, float, float]] = {}
    with tempfile.TemporaryDirectory() as place:
        root = Path(place) / "run"
        entries = build(root, chunks)
        for state, lines in (("ended", 0), ("killed", min(MOST_LINES, chunks // 2))):
            enter(root, entries, lines)
            for action in ACTIONS:
                command = [sys.executable, "-m", "benchmarks.scan", action, str(root)]
                answer = subprocess.run(command, check=True, capture_output=True, text=True).stdout
                seconds, processor, memory = json.loads(answer)
                measured[f"{action}, {state}"] = seconds, processor, memory
    return measured


def main() -> None:
    """Prints the figures."""
    if sys.argv[1:2] and sys.argv[1] in ACTIONS:
        report(sys.argv[1], Path(sys.argv[2]))
        return
    chunks = int(sys.argv[1]) if len(sys.argv) > 1 else CHUNKS
    for what, (seconds, processor, memory) in measure(chunks).items():
        print(f"{chunks} chunks: {what}: {seconds:.2f} s, {processor:.2f} s of the processor, {memory:.0f} MB")


if __name__ == "__main__":
    main()
