"""Totals that workers accumulate: whatever is lost or double on the way, the client has every chunk once, and the same bytes.

Dask is replaced by a fake that does each task at once, at the worker that it was meant for, or at another one if that is dead.
`test_folding_workers` does the same with real workers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rvjax.errors import FolderError, IncompleteError
from rvjax.execution.chunks import ChunkResult, Segment
from rvjax.execution.executors import dask_folding, dask_worker
from rvjax.execution.executors.dask_folding import Folding
from rvjax.execution.executors.dask_worker import DaskWorkerState, WorkOrder
from rvjax.run_folder import RunDescription, RunFolder
from rvjax.run_folder.data_file import DataFile
from rvjax.run_folder.entry import Key
from tests.stats.test_merging import COLUMNS, SIZE, TABLES, added, empty

CHUNKS = 24
TOKEN = ".workers.token"
FILES = [DataFile.of(Key("samples", number), TABLES[number][0], COLUMNS, "") for number in range(CHUNKS)]


class Task:
    """A future that is done."""

    status: str
    result: Callable[[], Any]

    def __init__(self, call: Callable[[], Any]) -> None:
        try:
            value = call()
        except Exception as error:  # noqa: BLE001
            self.status, self.result = "error", lambda error=error: self.fail(error)
        else:
            self.status, self.result = "finished", lambda: value

    def fail(self, error: Exception) -> None:
        raise error

    def add_done_callback(self, call: Callable[[Any], None]) -> None:
        call(self)


class Cluster:
    """A client, and the states of its workers by address. done: the names of the tasks that were done, and where."""

    def __init__(self, states: dict[str, DaskWorkerState], monkeypatch: pytest.MonkeyPatch) -> None:
        self.states, self.done, self._at = states, list[tuple[str, str]](), ""
        monkeypatch.setattr(dask_worker, "_state", lambda name: self.states[self._at])

    def submit(self, call: Callable[..., Any], *given: Any, workers: Sequence[str] = (), pure: bool, **more: Any) -> Task:
        assert not pure, "a result that Dask takes from an earlier task"
        assert more == ({"allow_other_workers": True} if workers else {}), "a task that waits for ever for a worker that is gone"
        self._at = next((address for address in workers if address in self.states), next(iter(self.states)))
        self.done.append((call.__name__, self._at))
        values = [value.result() if isinstance(value, Task) else value for value in given]
        return Task(lambda: call(*values))

    def count(self, name: str) -> int:
        """How many tasks of this name were done."""
        return sum(task == name for task, _ in self.done)


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[RunFolder]:
    """With all chunks."""
    run = RunDescription(identity={}, provenance={}, campaign_text="", samples=CHUNKS * SIZE, name="fold")
    with RunFolder.create(tmp_path / "run", run) as folder:
        (folder.path / TOKEN).touch()
        folder.take_all(FILES)
        yield folder


@pytest.fixture
def cluster(folder: RunFolder, monkeypatch: pytest.MonkeyPatch) -> Cluster:
    """Three workers that see the folder."""
    monkeypatch.setattr(DaskWorkerState, "no_totals", lambda self: empty())
    monkeypatch.setattr(DaskWorkerState, "runner", lambda self: None)
    order = WorkOrder("", {}, (), {}, {}, str(folder.path), TOKEN, local=False)
    states = {f"tcp://{name}": DaskWorkerState(order) for name in "abc"}
    for address, state in states.items():
        state.setup(SimpleNamespace(address=address, state=SimpleNamespace(nthreads=1)))  # pyright: ignore[reportArgumentType]
    return Cluster(states, monkeypatch)


def flown(cluster: Cluster, chunks: Sequence[int], address: str = "tcp://a") -> list[ChunkResult]:
    """What a worker answers that has flown these chunks."""
    data = [FILES[chunk].data or b"" for chunk in chunks]
    return [ChunkResult(n, (FILES[n],), cluster.states[address]._add(n, data)) for n, data in zip(chunks, data, strict=True)]


def collected(
    cluster: Cluster, folder: RunFolder, notes: Sequence[Sequence[ChunkResult]], said: list[str], chunks: int = CHUNKS
) -> bytes:
    """What the client has, after it has noted these results, of the first chunks, by default of all."""
    folding, results = Folding(cluster, "name", folder, said.append), empty()  # pyright: ignore[reportArgumentType]
    for note in notes:
        folding.note(note)
    folding.collect(range(chunks), results, lambda: None, lambda: 3)
    return results.encode()


@pytest.fixture
def reads(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The chunks whose tables the client reads."""
    read, seen = RunFolder._table, list[int]()
    monkeypatch.setattr(RunFolder, "_table", lambda self, key: (seen.append(key.number), read(self, key))[1])
    return seen


WHOLE = added(range(CHUNKS)).encode()


def test_segments_of_all_workers_are_merged_and_the_client_reads_nothing(
    cluster: Cluster, folder: RunFolder, reads: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: a segment that stays at its worker, chunks read again though they were accumulated, a tree that drops its last
    group, a table that the client reads."""
    monkeypatch.setattr(dask_folding, "TOGETHER", 2)
    notes = [flown(cluster, range(k, CHUNKS, 3), f"tcp://{name}") for k, name in enumerate("abc")]
    assert len({result.segment for note in notes for result in note}) == 3
    assert collected(cluster, folder, notes, []) == WHOLE
    assert reads == []
    assert (cluster.count("hand_over"), cluster.count("merge"), cluster.count("fold")) == (3, 3, 0)
    assert sorted(at for name, at in cluster.done if name == "hand_over") == ["tcp://a", "tcp://b", "tcp://c"]


def test_chunks_of_an_earlier_run_are_read_by_workers(cluster: Cluster, folder: RunFolder, reads: list[int]) -> None:
    """Kills: a client that reads them, one task for all of them, one that is read twice."""
    note = flown(cluster, range(5))
    assert collected(cluster, folder, [note], []) == WHOLE
    assert reads == []
    assert cluster.count("fold") == 3


@pytest.mark.parametrize("fate", ["dead", "restarted", "double", "unknown", "unsent"])
def test_a_segment_that_is_lost_or_differs_is_made_again_from_the_files(
    fate: str, cluster: Cluster, folder: RunFolder, reads: list[int]
) -> None:
    """dead: the worker is gone. restarted: another process has its address. double: a chunk is in two segments, since it flew
    again when its worker seemed to be lost. unknown, unsent: a worker has accumulated a chunk whose result never came.
    Kills: samples lost, counted twice, or waited for."""
    first, second = flown(cluster, range(12)), flown(cluster, range(12, CHUNKS), "tcp://b")
    if fate == "dead":
        del cluster.states["tcp://a"]
    elif fate == "restarted":
        cluster.states["tcp://a"].setup(  # as Dask does for a new process
            SimpleNamespace(address="tcp://a", state=SimpleNamespace(nthreads=1))  # pyright: ignore[reportArgumentType]
        )
        flown(cluster, [0])
    elif fate == "double":
        flown(cluster, [3], "tcp://b")
    elif fate == "unknown":
        first = first[:-1]
    else:
        first = []
    assert collected(cluster, folder, [first, second], []) == WHOLE
    assert reads == []


@pytest.mark.parametrize("noted", [True, False])
def test_a_chunk_that_is_not_asked_for_is_not_in_the_totals(noted: bool, cluster: Cluster, folder: RunFolder) -> None:
    """A worker has accumulated it, but it was never committed, or not kept. Kills: samples that the folder does not have."""
    first, last = flown(cluster, range(CHUNKS - 1)), flown(cluster, [CHUNKS - 1])
    assert collected(cluster, folder, [first, last if noted else []], [], CHUNKS - 1) == added(range(CHUNKS - 1)).encode()


def test_a_chunk_that_flies_twice_at_a_worker_is_added_once(cluster: Cluster, folder: RunFolder) -> None:
    """As where a task is done again, since its result was lost. Kills: an error instead of the result; samples counted twice."""
    first = flown(cluster, range(CHUNKS))
    assert [result.segment for result in flown(cluster, [7])] == [first[7].segment]
    assert collected(cluster, folder, [first], []) == WHOLE
    assert cluster.count("fold") == 0


def test_a_segment_is_handed_over_once(cluster: Cluster) -> None:
    """Kills: chunks that stay in the next segment; a segment under the name of another."""
    (result, *_) = flown(cluster, [0, 1])
    state, segment = cluster.states["tcp://a"], result.segment or Segment("", "")
    assert state.hand_over("another", [0, 1]) is None
    assert state.hand_over(segment.name, [0, 1]) == added([0, 1]).encode()
    assert state.hand_over(segment.name, [0, 1]) is None
    assert flown(cluster, [2])[0].segment != segment


def test_damaged_files_are_set_aside_and_the_rest_is_there(cluster: Cluster, folder: RunFolder) -> None:
    """Kills: a task that ends at the first damaged file; a damaged table in the totals."""
    path = folder.path / folder.chunks[6].file
    path.write_bytes(path.read_bytes()[:-1] + b"?")
    assert collected(cluster, folder, [], []) == added([n for n in range(CHUNKS) if n != 6]).encode()
    assert folder.missing(CHUNKS) == [6]
    assert (folder.path / "quarantine").exists()


def test_the_client_reads_where_no_worker_sees_the_folder(cluster: Cluster, folder: RunFolder, reads: list[int]) -> None:
    """Kills: results without samples on a cluster without a common disk."""
    (folder.path / TOKEN).unlink()
    assert collected(cluster, folder, [], []) == WHOLE
    assert sorted(reads) == list(range(CHUNKS))


def test_totals_that_are_damaged_on_their_way_are_made_again(
    cluster: Cluster, folder: RunFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: part of the totals unnoticed; a run that ends, though all files are there."""
    note, said = flown(cluster, range(CHUNKS)), list[str]()
    encode = cluster.states["tcp://a"].hand_over
    monkeypatch.setattr(cluster.states["tcp://a"], "hand_over", lambda *given: (encode(*given) or b"")[:-900])
    assert collected(cluster, folder, [note], said) == WHOLE
    assert said[0].startswith("totals of Dask workers are left out: encoded totals cannot be used")


def test_a_task_that_fails_costs_no_chunk(cluster: Cluster, folder: RunFolder, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a traceback of a worker at the client."""

    def failing(*_: object) -> None:
        raise MemoryError("too large")

    notes, said = [flown(cluster, [0]), flown(cluster, [1], "tcp://b")], list[str]()
    monkeypatch.setattr(dask_folding, "merge", failing)
    monkeypatch.setattr(dask_folding, "MOST_FILES", CHUNKS)
    assert collected(cluster, folder, notes, said) == WHOLE
    assert said[0] == "totals of Dask workers were lost: MemoryError: too large"


def test_a_chunk_that_does_not_fit_is_left_to_the_client(cluster: Cluster) -> None:
    """Other columns, as of another campaign. Kills: half a chunk in the totals; a flight that is flown again and again."""
    flown(cluster, [0])
    frame, columns = TABLES[1]
    odd = DataFile.of(Key("samples", 1), frame.drop(columns="draw.turn"), columns, "")
    assert cluster.states["tcp://a"]._add(1, odd.data or b"") is None
    assert cluster.states["tcp://a"].hand_over(cluster.states["tcp://a"]._segment.name, [0]) is None


def test_overlapping_parts_are_left_out_of_a_merge(cluster: Cluster) -> None:
    """Kills: an error that costs all parts; a chunk counted twice."""
    cluster._at = "tcp://a"
    parts = [added(chunks).encode() for chunks in ([0, 1], [1, 2], [3])]
    assert dask_worker.merge("name", None, *parts, None) == added([0, 1, 3]).encode()
    assert dask_worker.merge("name", None) is None
    with pytest.raises(FolderError):
        added([0, 1]).merge(added([1, 2]))


def test_merging_does_not_wait_for_ever(cluster: Cluster, folder: RunFolder, monkeypatch: pytest.MonkeyPatch) -> None:
    """The root never ends, or the scheduler is lost. Kills: silence; looking at nothing meanwhile."""
    for name in ("STALL_S", "LOOK_S"):
        monkeypatch.setattr(dask_folding, name, 0.05)
    looks = list[int]()
    folding = Folding(cluster, "name", folder, lambda _: None)  # pyright: ignore[reportArgumentType]
    silent: Any = SimpleNamespace(add_done_callback=lambda _: None, status="pending")
    with pytest.raises(IncompleteError, match=r"have not merged their totals for 0\.05 s"):
        folding._result(silent, lambda: looks.append(1), lambda: 1)
    assert looks
    gone: Any = SimpleNamespace(add_done_callback=lambda call: call(None), status="cancelled")
    with pytest.raises(IncompleteError, match="the Dask scheduler was lost"):
        folding._result(gone, lambda: None, lambda: 1)
