"""Does the same small job in rvjax and in its peers: `python -m benchmarks.peers NAME… | --all [--samples N] [--rounds R]`.

    python -m benchmarks.peers --all --rounds 3 --python vbar=/path/to/its/bin/python --python basilisk=…

The requirements of the peers conflict, so each may have an environment; without --python it is that of this command. rvjax draws,
and every peer flies these draws. Whole processes are timed, on one core and on all. Ends with 1 where a final distance differs by
more than the tolerance of the peer, and with 2 where a name is wrong. What came out: docs/peers.md.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from benchmarks.peers import HERE, PEERS, Peer, job, table
from rvjax import __version__
from rvjax.stats.binomial import clopper_pearson_lower, clopper_pearson_upper

ROOT = HERE.parents[1]
ALL = tuple(sorted(os.sched_getaffinity(0))) if hasattr(os, "sched_getaffinity") else tuple(range(os.cpu_count() or 1))
RVJAX = ("hold.yaml", "pd.py")


class Ran(NamedTuple):
    """seconds: of the whole process, by the clock. processor: seconds of it and its children. code: its exit code."""

    result: job.Result
    seconds: float
    processor: float
    code: int


def timed(command: Sequence[str], cores: Sequence[int]) -> tuple[float, float, int, str]:
    """Seconds of a process on some cores, by the clock and of the processor, its exit code, and what it printed."""

    def pin() -> None:
        if hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, cores)

    began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    ended = subprocess.run(
        command,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        preexec_fn=pin,
        capture_output=True,
        text=True,
        check=False,
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return time.perf_counter() - began, processor, ended.returncode, ended.stdout + ended.stderr


def by_rvjax(samples: int, place: Path, cores: Sequence[int]) -> tuple[Ran, job.Array]:
    """A run with its report, and the values that it drew."""
    folder = place / "run"
    command = [
        sys.executable,
        "-m",
        "rvjax",
        "run",
        str(HERE / "hold.yaml"),
        f"--samples={samples}",
        f"--out={folder}",
        "--timings",
    ]
    spent, processor, code, said = timed(command, cores)
    if code not in (0, 1, 3):
        raise RuntimeError(said)
    samples_table = pd.concat([pd.read_parquet(path) for path in sorted((folder / "samples").glob("*.parquet"))])
    summary: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    distances = samples_table["metric.final_position_error_m"].to_numpy(np.float64)
    inside = int(np.sum(distances < job.TUBE))
    bounds = clopper_pearson_lower(inside, samples, 0.95), clopper_pearson_upper(inside, samples, 0.95)  # as it prints them
    result = job.Result(
        distances.tolist(),
        __version__,
        bounds,
        summary["timings"]["main_thread_s"]["fly"],
        summary["verdict"],
    )
    draws = samples_table.filter(like="draw.").to_numpy(np.float64)
    return Ran(result, spent, processor, code), draws


def by_peer(name: str, python: str, draws: job.Array, place: Path, cores: Sequence[int]) -> Ran:
    """A script of this package in another environment. Errors: RuntimeError with what it printed."""
    given, came = place / "draws.csv", place / f"{name}.json"
    job.save(draws, given)
    command = [python, "-m", f"benchmarks.peers.with_{name}", str(given), str(came), str(len(cores))]
    spent, processor, code, said = timed(command, cores)
    if code:
        raise RuntimeError(said)
    return Ran(job.Result(**json.loads(came.read_text())), spent, processor, code)


def lacking(peer: Peer, python: str) -> str:
    """Why a peer is not run, "" if it is."""
    look = f"import importlib.util, sys; sys.exit(importlib.util.find_spec({peer.package!r}) is None)"
    try:
        ended = subprocess.run([python, "-c", look], capture_output=True, check=False)
    except OSError as error:
        return f"{python}: {error.strerror}"
    return f"{peer.package} is not installed; accepted: {peer.install}" if ended.returncode else ""


def compare(names: Sequence[str], pythons: dict[str, str], samples: int, rounds: int) -> bool:
    """Prints the table; whether every peer agrees."""
    runs: dict[str, dict[bool, list[Ran]]] = {}
    away = {name: why for name in names if (why := lacking(PEERS[name], pythons.get(name, sys.executable)))}
    for number in range(rounds):
        for single in (True, False):
            cores = ALL[:1] if single else ALL
            print(f"round {number + 1}, {len(cores)} of {len(ALL)} cores", file=sys.stderr, flush=True)
            with tempfile.TemporaryDirectory() as place:
                base, draws = by_rvjax(samples, Path(place), cores)
                runs.setdefault("rvjax", {}).setdefault(single, []).append(base)
                for name in names:
                    if name not in away:
                        ran = by_peer(name, pythons.get(name, sys.executable), draws, Path(place), cores)
                        runs.setdefault(name, {}).setdefault(single, []).append(ran)
    print(f"{datetime.now(UTC):%Y-%m-%d}; {samples} flights; {rounds} rounds, median (least); {len(ALL)} cores")
    print(table.head())
    agree = True
    for name, ran in runs.items():
        measured = summed(name, ran, runs["rvjax"])
        agree &= name == "rvjax" or measured.apart <= PEERS[name].tolerance
        print(table.row(measured))
    for name, why in away.items():
        print(f"\n{name} was not run: {why}")
    return agree


def summed(name: str, ran: dict[bool, list[Ran]], base: dict[bool, list[Ran]]) -> table.Measured:
    """All rounds of a peer."""
    last = ran[False][-1]
    files = RVJAX if name == "rvjax" else PEERS[name].files
    return table.Measured(
        name,
        sum(table.lines_of(HERE / file) for file in files),
        [each.seconds for each in ran[True]],
        [each.seconds for each in ran[False]],
        [each.seconds / other.seconds for each, other in zip(ran[False], base[False], strict=True)],
        [each.processor for each in ran[False]],
        last.result,
        job.TUBE,
        last.code,
        float(np.abs(np.array(last.result.distances) - np.array(base[False][-1].result.distances)).max()),
    )


def main() -> int:
    """Runs what the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(PEERS))
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--samples", type=int, default=512)
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--python", action="append", default=[], metavar="NAME=PATH")
    given = parser.parse_args()
    pythons = dict(pair.partition("=")[::2] for pair in given.python)
    names = list(PEERS) if given.all else given.names
    if unknown := [name for name in (*names, *pythons) if name not in PEERS]:
        print(f"unknown: {', '.join(unknown)}; accepted: {', '.join(PEERS)}", file=sys.stderr)
        return 2
    if not names:
        print("no peer is named; accepted: names or --all", file=sys.stderr)
        return 2
    return 0 if compare(names, pythons, given.samples, given.rounds) else 1


if __name__ == "__main__":
    sys.exit(main())
