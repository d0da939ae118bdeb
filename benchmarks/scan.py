"""How long it takes to open a run folder of many chunks, and to go on with it: `python -m benchmarks.scan [CHUNKS]`.

The chunks are small files of no meaning, so what is timed are names, sizes, manifest and journal, not what the files hold. Once
with everything in the manifest, as a run leaves that has ended; once with everything in the journal, as one that was killed.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest.mock import patch

from rvjax.run_folder import CAMPAIGN, RunDescription, RunFolder, atomic_files
from rvjax.run_folder.journal import Journal
from rvjax.run_folder.manifest import Entry, Head, Key, Manifest

LANES = 416
CHUNKS = 100_000
IDENTITY: dict[str, Any] = {"campaign": "made up"}
TEXT = "rvjax: 1\n"


def build(root: Path, chunks: int, closed: bool) -> None:
    """A run folder of so many chunks; closed: its journal is folded into the manifest."""
    samples = chunks * LANES
    head = Head(name="scan", samples=samples, identity=IDENTITY, provenance={}, campaign=atomic_files.sha256(TEXT.encode()))
    (root / "samples").mkdir(parents=True)
    (root / CAMPAIGN).write_text(TEXT)
    journal, manifest = Journal(root), Manifest(head)
    with patch("os.fsync"):
        journal.fold(manifest)
        for chunk in range(chunks):
            data = b"%d" % chunk
            digest = atomic_files.sha256(data)
            name = Key("samples", chunk).file(digest)
            (root / name).write_bytes(data)
            entry = Entry(file=name, sha256=digest, bytes=len(data), first=chunk * LANES, count=LANES)
            manifest.entries[entry.key] = entry
            journal.append([entry])
        if closed:
            journal.fold(manifest)
    journal.close()


def resume(root: Path, chunks: int) -> None:
    """Opens the folder to fly what it lacks, which is nothing, and closes it again."""
    description = RunDescription(identity=IDENTITY, provenance={}, campaign_text=TEXT, samples=chunks * LANES, name="scan")
    with RunFolder.resume(root, description, LANES) as folder:
        assert folder.missing(chunks) == []


def seconds(action: Callable[[], object]) -> float:
    """How long it takes."""
    start = time.perf_counter()
    action()
    return time.perf_counter() - start


def measure(chunks: int) -> dict[str, float]:
    """Seconds by what was done."""
    found: dict[str, float] = {}
    for closed in (True, False):
        with tempfile.TemporaryDirectory() as place:
            root, state = Path(place) / "run", "ended" if closed else "killed"
            build(root, chunks, closed)
            found[f"open, {state}"] = seconds(lambda root=root: RunFolder.open(root))
            found[f"go on, {state}"] = seconds(lambda root=root: resume(root, chunks))
    return found


def main() -> None:
    """Prints the seconds."""
    chunks = int(sys.argv[1]) if len(sys.argv) > 1 else CHUNKS
    for what, time_s in measure(chunks).items():
        print(f"{chunks} chunks: {what}: {time_s:.2f} s")


if __name__ == "__main__":
    main()
