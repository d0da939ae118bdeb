"""Real Dask schedulers and workers, as processes of this machine; a campaign of nine short chunks; and its bits."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path

from rvjax.run_folder import RunFolder
from rvjax.simulation.batch import LANES
from tests.reliability.plain import PLAIN
from tests.short import CAMPAIGN, SHORT

CHUNKS = 9
SAMPLES = (CHUNKS - 1) * LANES + 100
STEP = "horizon.step_s=0.04"
OVERRIDES = [*SHORT, f"samples={SAMPLES}", *PLAIN, "keep={worst: 0}", STEP]
SETS = [part for one in OVERRIDES for part in ("--set", one)]

PROGRAM = [sys.executable, "-m", "tests.reliability.bare"]
"""The program; it audits nothing, and its reports have no sections."""

QUICK = {
    "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1",
    "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "3s",
    "DASK_LOGGING__DISTRIBUTED": "error",
}
"""One death of a worker is forgiven, not three, and who is gone is given up soon."""


def program(*arguments: object, **more: str) -> subprocess.Popen[str]:
    """The program in a separate process, without the audit and the sections of the report."""
    return process([*PROGRAM, *map(str, arguments)], more)


def run(out: Path, *arguments: object, **more: str) -> subprocess.Popen[str]:
    """Flies the campaign. more: environment."""
    return program("run", CAMPAIGN, "--out", out, *SETS, *arguments, **more)


def process(command: list[str], more: Mapping[str, str]) -> subprocess.Popen[str]:
    """A process in a group of its own, which takes an interrupt as one in a terminal does."""
    environment = {**os.environ, "COLUMNS": "200", "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", **QUICK, **more}
    restored, pipe = ["env", "--default-signal=INT", *command], subprocess.PIPE
    return subprocess.Popen(restored, env=environment, start_new_session=True, stdin=pipe, stdout=pipe, stderr=pipe, text=True)


def ended(running: subprocess.Popen[str], within: float = 120) -> tuple[int, str, str]:
    """Exit code, stdout, stderr."""
    out, err = running.communicate(timeout=within)
    return running.returncode, out, err


def dead(running: subprocess.Popen[str]) -> None:
    """Ends a process and all that it has started."""
    if running.poll() is None or running.returncode is not None:
        for number in (signal.SIGTERM, signal.SIGKILL):
            try:
                os.killpg(running.pid, number)
            except ProcessLookupError:
                break
            time.sleep(0.2)
    running.communicate()


def free_port() -> int:
    """A port that nobody listens to."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


@contextmanager
def scheduler(**more: str) -> Generator[tuple[str, subprocess.Popen[str]], None, None]:
    """A scheduler: its address and its process. more: environment."""
    port = free_port()
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", str(port)]
    running = process([*command, "--no-dashboard"], more)
    try:
        for _ in range(200):
            with socket.socket() as one:
                if one.connect_ex(("127.0.0.1", port)) == 0:
                    break
            time.sleep(0.1)
        yield f"tcp://127.0.0.1:{port}", running
    finally:
        dead(running)


@contextmanager
def worker(address: str, *arguments: str, **more: str) -> Generator[subprocess.Popen[str], None, None]:
    """A worker, or as many as the arguments say, each under a nanny that restarts it when it dies, unless they say --no-nanny."""
    always = ["--nthreads", "1", "--memory-limit", "0", "--no-dashboard"]
    running = process([sys.executable, "-m", "distributed.cli.dask_worker", address, *always, *arguments], more)
    try:
        yield running
    finally:
        dead(running)


def data(folder: Path) -> dict[str, str]:
    """Name and SHA-256 of the samples and envelopes of a run that is whole."""
    opened = RunFolder.open(folder)
    opened.verify()
    assert opened.account().missing == 0
    document = opened.chunks
    names = {entry.file: entry.sha256 for entry in document}
    return names | {path.name: path.name for path in (folder / "envelopes").iterdir()}
