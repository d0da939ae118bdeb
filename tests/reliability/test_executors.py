"""Whoever flies the chunks, and whoever of them dies: the same bits, or a message that says which chunk and why."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

import pytest
from distributed import Client

from rvjax.errors import IncompleteError, UsageError
from rvjax.execution.chunks import ENVELOPE_CHUNKS, ChunkResult, ChunkRunner
from rvjax.execution.executors import ExecutorFactory
from rvjax.execution.executors.dask_client import workers
from rvjax.execution.executors.threads import local_threads
from rvjax.execution.identity import identity, provenance
from rvjax.run_folder import RunDescription, RunFolder
from rvjax.simulation.batch import LANES
from rvjax.simulation.problem import load
from tests.program import Run
from tests.reliability.cluster import CHUNKS, OVERRIDES, SAMPLES, data, dead, ended, process, run, scheduler, worker
from tests.short import CAMPAIGN


@pytest.fixture(scope="module")
def runner() -> ChunkRunner:
    """Of the campaign, in this process."""
    problem = load(CAMPAIGN, OVERRIDES)
    return ChunkRunner(problem, identity(problem))


@pytest.fixture(scope="module")
def compiled() -> ChunkRunner:
    """The same with XLA, whose bits depend on its settings."""
    problem = load(CAMPAIGN, [*OVERRIDES, "engine=xla"])
    return ChunkRunner(problem, identity(problem))


@pytest.fixture(scope="module")
def inline(runner: ChunkRunner, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The bits of the campaign, flown by one process."""
    folder = tmp_path_factory.mktemp("inline") / "run"
    fly(runner, folder, local_threads)
    return data(folder)


@pytest.fixture(scope="module")
def address(request: pytest.FixtureRequest) -> Iterator[str]:
    """Of a scheduler for several tests. By default it forgives no death of a worker, so that fewer have to die."""
    forgiven = "1" if request.config.getoption("--long") else "0"
    with scheduler(DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES=forgiven) as (address, _):
        yield address


def described(runner: ChunkRunner) -> RunDescription:
    """The run of this module."""
    problem = runner.problem
    return RunDescription(
        identity=identity(problem),
        provenance=provenance([], [*OVERRIDES, f"engine={problem.spec.engine}"]),
        campaign_text=problem.spec.source.text,
        samples=SAMPLES,
        name="short",
    )


def fly(
    runner: ChunkRunner, place: Path, crew: ExecutorFactory, seen: Callable[[ChunkResult], None] = lambda result: None
) -> None:
    """Flies all chunks into a new folder, the last ones first. seen: called with each, once it is committed."""
    with RunFolder.create(place, described(runner)) as folder, crew(runner, folder) as executor:

        def take(results: Sequence[ChunkResult]) -> None:
            for result in results:
                folder.take_all(result.files)
                seen(result)

        executor.fly(reversed(range(CHUNKS)), take)


def go_on(runner: ChunkRunner, place: Path) -> None:
    """Flies what the folder lacks, without Dask."""
    with (
        RunFolder.resume(place, described(runner), LANES) as folder,
        local_threads(runner, folder) as executor,
    ):
        executor.fly(
            folder.missing(CHUNKS, ENVELOPE_CHUNKS),
            lambda results: folder.take_all(file for result in results for file in result.files),
        )


def first_chunk(folder: Path, running: subprocess.Popen[str]) -> None:
    """Waits until something is committed."""
    while running.poll() is None:
        journal = folder / "journal.jsonl"
        if journal.exists() and journal.read_bytes().count(b"samples/"):
            return
        time.sleep(0.02)
    pytest.fail(f"ended before its first chunk: {running.communicate()[1]}")


@pytest.mark.parametrize("count", [1, 2, 4])
def test_workers_of_this_machine_fly_the_same_bits(
    tmp_path: Path, runner: ChunkRunner, inline: dict[str, str], count: int, full: bool, figure: Callable[[str], None]
) -> None:
    """Kills: another compiler setting in a worker, draws that depend on the process, a chunk that comes twice."""
    if count != 2 and not full:
        pytest.skip("half a minute; with --long")
    said: list[str] = []
    fly(runner, tmp_path / "run", workers(count, said.append))
    assert said[0].startswith("Dask: http://127.0.0.1:")
    assert data(tmp_path / "run") == inline
    assert not list((tmp_path / "run").glob(".workers.*"))
    figure(f"Dask with {count} local worker(s): {CHUNKS} chunks bit-identical to inline")


def test_a_worker_killed_while_flying_is_no_loss(
    tmp_path: Path, runner: ChunkRunner, inline: dict[str, str], full: bool, figure: Callable[[str], None]
) -> None:
    """SIGKILL to a worker and its nanny in the middle, later to the process of another one. Kills: waiting for the dead for ever,
    a chunk lost or double."""
    if not full:
        pytest.skip("a worker that dies of its chunk is tried by default: --long")
    flown: list[int] = []
    more = ("--nworkers", "2")
    with scheduler() as (address, _), worker(address) as first, worker(address, *more) as others:

        def kill(result: ChunkResult) -> None:
            flown.append(result.chunk)
            if len(flown) == 1:
                dead(first)
            if len(flown) == 2:
                os.kill(children(others.pid)[0], signal.SIGKILL)

        fly(runner, tmp_path / "run", workers(address, lambda text: None), kill)
    assert sorted(flown) == list(range(CHUNKS))
    assert data(tmp_path / "run") == inline
    figure("workers killed while flying: 2; 0 chunks lost or double, bit-identical")


def children(pid: int) -> list[int]:
    """The processes that a process has started."""
    found = subprocess.run(["ps", "-o", "pid=", "--ppid", str(pid)], capture_output=True, text=True, check=True).stdout.split()
    return [int(one) for one in found if b"spawn_main" in Path(f"/proc/{one}/cmdline").read_bytes()]


POISON = """
import os
from rvjax.execution.chunks import ChunkRunner

if not hasattr(ChunkRunner, "honest"):  # Dask reads this file twice
    ChunkRunner.honest = ChunkRunner.fly_chunk

def fly_chunk(self, chunk):
    if chunk == 4:
        {what}
    return self.honest(chunk)

ChunkRunner.fly_chunk = fly_chunk
"""


AFAR = """
from dataclasses import replace
from rvjax.execution.executors.dask_worker import DaskWorkerState

if not hasattr(DaskWorkerState, "honest"):
    DaskWorkerState.honest = DaskWorkerState.fly

def fly(self, chunk):
    self.order = replace(self.order, folder="/nowhere")
    return self.honest(chunk)

DaskWorkerState.fly = fly
"""


def test_a_chunk_that_kills_its_workers_is_named_and_all_others_are_kept(
    tmp_path: Path, address: str, runner: ChunkRunner, inline: dict[str, str], full: bool, figure: Callable[[str], None]
) -> None:
    """Through the program. Kills: a campaign that hangs, chunks that flew beside it being blamed, a traceback."""
    (tmp_path / "poison.py").write_text(POISON.format(what="os._exit(9)"))
    more = ("--nworkers", "2" if full else "1", "--preload", str(tmp_path / "poison.py"))
    with worker(address, *more):
        code, _, err = ended(run(tmp_path / "run", "--dask", address))
    assert code == 4, err
    assert f"chunk 4 (samples {4 * LANES} to {5 * LANES - 1}) could not be flown: every worker that flew it died" in err
    assert err.count("could not be flown") == 1
    assert "Traceback" not in err
    assert f"--dask {address}" in err
    assert RunFolder.open(tmp_path / "run").missing(CHUNKS) == [4]
    go_on(runner, tmp_path / "run")
    assert data(tmp_path / "run") == inline
    figure(f"a chunk that kills its workers: named, exit 4, the other {CHUNKS - 1} kept")


def test_a_chunk_whose_flight_raises_is_named_and_all_others_are_kept(
    tmp_path: Path, address: str, runner: ChunkRunner, figure: Callable[[str], None]
) -> None:
    """By a worker that does not see the run folder, so that the rest is sent. Kills: an error that does not survive its way to
    the client; results that only a shared file system brings."""
    (tmp_path / "poison.py").write_text(POISON.format(what="raise ValueError('no such orbit')") + AFAR)
    said = rf"^chunk 4 \(samples {4 * LANES} to {5 * LANES - 1}\) could not be flown: 3 times ValueError: no such orbit$"
    more = ("--no-nanny", "--preload", str(tmp_path / "poison.py"))
    with worker(address, *more), pytest.raises(IncompleteError, match=said):
        fly(runner, tmp_path / "run", workers(address, lambda text: None))
    folder = RunFolder.open(tmp_path / "run")
    assert folder.missing(CHUNKS) == [4]
    folder.verify()
    figure(f"a chunk whose flight raises: named, the other {CHUNKS - 1} kept")


OTHER = {"XLA_FLAGS": "--xla_cpu_prefer_vector_width=256"}


def test_compiler_settings_do_not_matter_to_the_engine_llvm(
    tmp_path: Path, address: str, runner: ChunkRunner, inline: dict[str, str]
) -> None:
    """Kills: an identity that keeps another machine out; bits that depend on it."""
    with worker(address, "--no-nanny", **OTHER):
        fly(runner, tmp_path / "run", workers(address, lambda text: None))
    assert data(tmp_path / "run") == inline


def test_a_worker_that_would_fly_other_bits_is_refused(tmp_path: Path, address: str, compiled: ChunkRunner) -> None:
    """Kills: mixing compilers' settings in one table; a refusal that does not say what differs."""
    said = r"these Dask workers would fly other bits(.|\n)*xla_flags: the client has .*, the worker has .*=256"
    with worker(address, "--no-nanny", **OTHER), pytest.raises(UsageError, match=said):
        fly(compiled, tmp_path / "run", workers(address, lambda text: None))
    assert RunFolder.open(tmp_path / "run").chunks == ()


def test_a_worker_that_comes_late_and_would_fly_other_bits_is_sent_away(
    tmp_path: Path, compiled: ChunkRunner, full: bool
) -> None:
    """Kills: comparing only the workers that are there at the start; giving up the campaign for one of them."""
    if not full:
        pytest.skip("one that is there at the start is tried by default: --long")
    said: list[str] = []
    flown: list[int] = []
    with ExitStack() as stack:
        address, _ = stack.enter_context(scheduler())
        stack.enter_context(worker(address))

        def come(result: ChunkResult) -> None:
            flown.append(result.chunk)
            if len(flown) == 1:
                stack.enter_context(worker(address, **OTHER))
                stack.enter_context(Client(address)).wait_for_workers(2, timeout=60)

        fly(compiled, tmp_path / "run", workers(address, said.append), come)
    fly(compiled, tmp_path / "inline", local_threads)
    assert any("is retired, since it would fly other bits:\nxla_flags: the client has" in text for text in said)
    assert sorted(flown) == list(range(CHUNKS))
    assert data(tmp_path / "run") == data(tmp_path / "inline")


@pytest.mark.parametrize("who", ["scheduler", "client"])
def test_a_stopped_campaign_goes_on_without_dask(
    tmp_path: Path, runner: ChunkRunner, inline: dict[str, str], who: str, full: bool
) -> None:
    """The scheduler is killed, or Ctrl-C comes. Kills: hanging, a command to go on that lacks --dask, a traceback."""
    if who == "client" and not full:
        pytest.skip("Ctrl-C is tried with local workers: --long")
    (tmp_path / "poison.py").write_text(POISON.format(what="import time; time.sleep(60)"))  # it cannot end before
    with scheduler() as (address, its_process), worker(address, "--no-nanny", "--preload", str(tmp_path / "poison.py")):
        running = run(tmp_path / "run", "--dask", address)
        first_chunk(tmp_path / "run", running)
        if who == "scheduler":
            dead(its_process)
        else:
            running.send_signal(signal.SIGINT)
        code, _, err = ended(running)
    assert code == (4 if who == "scheduler" else 130), err
    assert "Traceback" not in err
    assert f"--dask {address}" in err
    go_on(runner, tmp_path / "run")
    assert data(tmp_path / "run") == inline
    assert RunFolder.open(tmp_path / "run").requested == SAMPLES


def test_ctrl_c_in_the_terminal_of_local_workers(tmp_path: Path, full: bool) -> None:
    """It reaches the workers as well. Kills: their tracebacks on the terminal, workers that are gone before the client stops."""
    place = "local:2" if full else "local:1"
    slowly = ("--set", "horizon.step_s=0.01")
    running = run(tmp_path / "run", "--dask", place, *slowly)
    first_chunk(tmp_path / "run", running)
    os.killpg(running.pid, signal.SIGINT)
    code, _, err = ended(running)
    assert code == 130, err
    assert "Traceback" not in err
    assert f"--dask {place}" in err
    assert RunFolder.open(tmp_path / "run").chunks


def test_without_the_extra_the_program_says_what_to_install(tmp_path: Path) -> None:
    """In a process that cannot import Dask. Kills: a traceback, as from a module that is imported before it is missed."""
    words = ["run", str(CAMPAIGN), "--out", str(tmp_path / "run"), "--dask", "local:2"]
    running = process([sys.executable, "-m", "tests.extras.core_only", "dask", "distributed"], {})
    ((code, _, err),) = json.loads(running.communicate(json.dumps([words]), timeout=120)[0])
    assert code == 2, err
    assert "pip install 'rvjax[dask]'" in err
    assert "Traceback" not in err
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("place", ["local:0", "local:x", "local:", "here", "tcp:/x", "file:///x", "tcp://127.0.0.1:1"])
def test_a_place_that_is_none_is_exit_2(tmp_path: Path, rvjax: Run, place: str) -> None:
    """Kills: a traceback from Dask, waiting for ever for a scheduler that is not there."""
    import dask

    with dask.config.set({"distributed.comm.timeouts.connect": "0.2s"}):
        code, _, err = rvjax("run", CAMPAIGN, "--out", tmp_path / "run", "--dask", place)
    assert code == 2, err
    assert "accepted: " in err
    assert "Traceback" not in err
