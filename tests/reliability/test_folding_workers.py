"""Totals that real Dask workers accumulate: the files, the summary and the verdicts are those of one process, and the client
reads no table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from rvjax.analysis.accumulator import RunAccumulator
from rvjax.components.samplers import sampling_design_of
from rvjax.execution import run as running
from rvjax.execution.chunks import ChunkResult, ChunkRunner
from rvjax.execution.executors import ExecutorFactory
from rvjax.execution.executors.dask_client import workers
from rvjax.execution.executors.threads import local_threads
from rvjax.execution.identity import identity
from rvjax.run_folder import RunFolder
from rvjax.simulation.batch import LANES
from rvjax.simulation.problem import load
from tests.reliability.cluster import CHUNKS, OVERRIDES, SAMPLES, data, dead, scheduler, worker
from tests.reliability.plain import proved
from tests.reliability.test_executors import described
from tests.short import CAMPAIGN

MADE = ("summary.json", "judged.parquet")
"""Files that are made from the totals of all samples."""

REQUIRE = """require=[
    {metric: captured, at_least: 0.5, method: sequential},
    {metric: settling_time_s, quantile: 0.5, below: 200, method: sequential}]"""


@pytest.fixture
def unaudited(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is audited."""
    monkeypatch.setattr(running, "prove", proved)


@pytest.fixture
def reads(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The chunks whose tables this process reads."""
    read, seen = RunFolder._table, list[int]()

    def table(self: RunFolder, key: object) -> object:
        if str(key.part) == "samples":  # pyright: ignore[reportAttributeAccessIssue]
            seen.append(key.number)  # pyright: ignore[reportAttributeAccessIssue]
        return read(self, key)  # pyright: ignore[reportArgumentType]

    monkeypatch.setattr(RunFolder, "_table", table)
    return seen


def bits(folder: Path) -> dict[str, bytes | str]:
    return data(folder) | {name: (folder / name).read_bytes() for name in MADE}


@pytest.mark.usefixtures("bare", "unaudited")
def test_the_summary_is_that_of_one_process_and_the_client_reads_no_table(tmp_path: Path, reads: list[int], full: bool) -> None:
    """A run of some chunks, resumed with more, and then with one file damaged. Kills: totals that depend on who accumulates
    them, chunks of an earlier run or damaged ones that are forgotten, and the way back of all tables to one process."""
    few, more = ([*OVERRIDES, REQUIRE, f"samples={samples}"] for samples in (3 * LANES, SAMPLES))
    running.run(CAMPAIGN, tmp_path / "inline", few, progress=False)
    running.run(CAMPAIGN, tmp_path / "inline", more, progress=False)
    reads.clear()
    for count in (1, 2, 4) if full else (2,):
        folder = tmp_path / f"{count}"
        for overrides in (few, more):
            running.run(CAMPAIGN, folder, overrides, progress=False, executor=workers(count, lambda text: None))
            assert reads == []
        assert bits(folder) == (expected := bits(tmp_path / "inline"))
        reads.clear()
        (chunk, *_) = RunFolder.open(folder).chunks
        (folder / chunk.file).write_bytes(b"?" * chunk.bytes)
        running.run(CAMPAIGN, folder, more, progress=False, executor=workers(count, lambda text: None))
        assert bits(folder) == expected
        reads.clear()


@pytest.mark.usefixtures("bare", "unaudited")
def test_a_run_stops_where_one_process_would_stop(tmp_path: Path, reads: list[int]) -> None:
    """Of 30 chunks. Kills: looks between which other numbers of samples fly, evidence that is not collected at a look."""
    overrides = [*OVERRIDES, REQUIRE, f"samples={30 * LANES}"]
    running.run(CAMPAIGN, tmp_path / "inline", overrides, progress=False, until_decided=True)
    reads.clear()
    running.run(
        CAMPAIGN, tmp_path / "dask", overrides, progress=False, until_decided=True, executor=workers(2, lambda text: None)
    )
    assert reads == []
    assert RunFolder.open(tmp_path / "dask").requested == RunFolder.open(tmp_path / "inline").requested < 30 * LANES
    assert bits(tmp_path / "dask") == bits(tmp_path / "inline")


def test_a_worker_killed_after_its_flights_costs_no_sample(tmp_path: Path, reads: list[int]) -> None:
    """SIGKILL to one of two workers between flying and collecting. Kills: waiting for the totals of the dead; samples lost."""
    problem = load(CAMPAIGN, OVERRIDES)
    runner = ChunkRunner(problem, identity(problem))
    spec = problem.spec

    def totals(place: Path, crew: ExecutorFactory, kill: Callable[[], None]) -> bytes:
        results = RunAccumulator(spec.require, sampling_design_of(spec), spec.keep)
        segments: set[object] = set()
        with RunFolder.create(place, described(runner)) as folder, crew(runner, folder) as executor:

            def take(arrived: Sequence[ChunkResult]) -> None:
                folder.take_all(file for result in arrived for file in result.files)
                segments.update(result.segment for result in arrived)

            executor.fly(range(CHUNKS), take)
            kill()
            executor.fold(range(CHUNKS), results)
        assert crew is local_threads or len(segments - {None}) == 2
        return results.encode()

    inline = totals(tmp_path / "inline", local_threads, lambda: None)
    reads.clear()
    with scheduler() as (address, _), worker(address) as first, worker(address):
        found = totals(tmp_path / "dask", workers(address, lambda text: None), lambda: dead(first))
    assert found == inline
    assert reads == []
