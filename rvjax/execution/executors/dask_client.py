"""Executor: Dask workers, processes on this machine or on many.

A task is the numbers of a few chunks. Where a worker is lost, the scheduler gives its chunks to others. A worker that sees the
run folder at the same path writes its data files itself and adds them to totals, which are collected at the end (`dask_folding`).
Any other worker sends its files. Only the client commits files, so a single process writes the journal.
"""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false, reportMissingTypeStubs=false
# (Dask says little about its types)

from __future__ import annotations

import time
import uuid
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterable, Mapping
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from itertools import count
from pathlib import Path
from queue import Empty, Queue
from typing import Any, NamedTuple, cast

from rvjax.components.extras import lacking
from rvjax.errors import IncompleteError, UsageError

if lack := lacking("dask", "distributed"):
    raise UsageError(f"--dask needs {lack}; accepted: pip install 'rvjax[dask]'")

from distributed import Client, Future, KilledWorker

from rvjax.analysis.accumulator import RunAccumulator
from rvjax.execution.chunks import ChunkResult, ChunkRunner
from rvjax.execution.executors import ExecutorFactory, Take, look_at_nothing
from rvjax.execution.executors.dask_connection import ANSWER_S, check_versions, connect, parse, silence, try_address
from rvjax.execution.executors.dask_folding import Folding
from rvjax.execution.executors.dask_worker import DaskWorkerState, TaskResult, Unlike, WorkOrder, fly, ready
from rvjax.execution.executors.waiting import LOOK_S, Say, within
from rvjax.execution.identity import packages
from rvjax.run_folder import RunFolder
from rvjax.simulation.batch import LANES

__all__ = ["Workers", "parse", "workers"]

AHEAD = 2
"""Tasks in flight for each thread of the workers: one flies, one waits."""

TASK_S = 2.0
"""Seconds that a task shall take: the scheduler and this process have about a millisecond of work with each."""

TASKS_A_SECOND = 100
"""With more threads than fit, tasks are longer, so that no more of them end in a second."""

MOST_CHUNKS = 64
"""The largest number of chunks in a task. If its worker dies, all of them are flown again."""

RETRIES = 2
"""Retries of a chunk whose flight raises an error. Where its worker dies, Dask gives the chunk to others, as often as
`distributed.scheduler.allowed-failures` says."""

MOST_LOST = 3
"""The run gives up after this number of chunks that cannot be flown."""

MOST_SUSPECT = 16
"""Up to this number of chunks whose workers died are flown again, each alone, before others."""

PATIENCE_S = 60.0
"""How long a file that a worker has written may take to appear here: network file systems show names late."""

READY_S = 600.0
"""How long workers may take to import their packages and say what they would fly."""

WORKER_S = 600.0
"""How long there may be no worker."""

WAITING_S = 30.0
"""Seconds between two messages that there is no worker."""

STALL_S = 3600.0
"""How long no chunk may arrive."""

_DEAF = "the Dask scheduler does not answer"
_CANNOT = "a Dask worker cannot fly: {}; install the same rvjax[dask] there"


def workers(place: int | str, say: Say) -> ExecutorFactory:
    """An executor of Dask workers: N processes on this machine, or those of a scheduler. say: gets messages on progress.

    UsageError where nobody listens at the scheduler's address, which is tried at once.
    """
    if isinstance(place, str):
        try_address(place, say)

    @contextmanager
    def executor(runner: ChunkRunner, folder: RunFolder) -> Generator[Workers, None, None]:
        with ExitStack() as stack:
            stack.enter_context(silence())
            client = stack.enter_context(connect(place, stack))
            say(f"Dask: {client.dashboard_link or 'no dashboard'}")
            token = f".workers.{uuid.uuid4().hex}"  # a temporary name: it is removed later where this process is killed
            if isinstance(folder.path, Path):  # workers that do not see it send their files
                (folder.path / token).touch()
                stack.callback((folder.path / token).unlink, missing_ok=True)
            state = DaskWorkerState(_order(runner, folder, token, isinstance(place, int)))
            check_versions(client, say)
            try:
                within(READY_S, lambda: client.register_plugin(state), "a Dask worker or the scheduler does not answer", say)
            except IncompleteError:
                raise
            except Exception as error:  # any error of a worker
                raise UsageError(_CANNOT.format(error)) from error
            stack.callback(_dismiss, client, state.name)
            folding = Folding(client, state.name, folder, say)
            yield Workers(client, state.name, Path(folder.path), say, folding)

    return executor


class _Task(NamedTuple):
    """Chunks that fly together."""

    chunks: tuple[int, ...]
    future: Future


class Workers:
    """The workers of a scheduler."""

    def __init__(self, client: Client, name: str, folder: Path, say: Say, folding: Folding) -> None:
        self._client, self._name, self._folder, self._say, self._folding = client, name, folder, say, folding
        self._threads, self._counted = 0, -LOOK_S
        self._numbers, self._pace = count(), 0.0

    def fly(self, chunks: Iterable[int], take: Take, look: Callable[[], None] = look_at_nothing) -> None:
        """As `Executor.fly`, in order of completion. UsageError where a worker would fly other bits than the client."""
        self._compare()
        todo, lost = deque(chunks), dict[int, str]()
        while len(lost) < MOST_LOST:
            suspects = self._fly(todo, AHEAD, take, lost, look)
            for chunk in suspects:  # each alone: other chunks on a worker that dies are lost with it
                for _ in self._fly(deque([chunk]), 1, take, lost, look):
                    lost[chunk] = f"every worker that flew it died, also when it flew alone; {suspects[chunk]}"
            if not suspects:
                break
        if lost:
            raise IncompleteError("\n".join(_lost(chunk, why) for chunk, why in sorted(lost.items())))

    def fold(self, chunks: Iterable[int], results: RunAccumulator, look: Callable[[], None] = look_at_nothing) -> None:
        """As `Executor.fold`: the workers do it, and merge their totals."""
        self._folding.collect(chunks, results, look, self._count)

    def _fly(self, todo: deque[int], ahead: int, take: Take, lost: dict[int, str], look: Callable[[], None]) -> dict[int, str]:
        """Flies the chunks of `todo`; returns those whose workers died, some more than `MOST_SUSPECT` at most; the rest stays in
        `todo`."""
        flying, failures, suspects = dict[int, _Task](), Counter[int](), dict[int, str]()
        done, arrived = Queue[int](), list[ChunkResult]()
        try:
            while True:
                on = len(lost) < MOST_LOST and len(suspects) < MOST_SUSPECT
                while on and todo and len(flying) < ahead * self._count():
                    self._submit(self._group(todo, ahead), flying, done)
                if not flying:
                    return suspects
                for number in self._next(done, look):
                    outcome = self._outcome(flying[number].future)
                    if outcome is None:
                        _tell(flying[number].future, number, done)
                        continue
                    task = flying.pop(number)
                    if isinstance(outcome, TaskResult):
                        arrived += outcome.flown
                        self._pace = _average(self._pace, outcome.seconds / len(task.chunks))
                        for failed in outcome.failed:
                            failures[failed.chunk] += 1
                            if failures[failed.chunk] > RETRIES:
                                lost[failed.chunk] = f"{failures[failed.chunk]} times {failed.why}"
                            else:
                                self._submit((failed.chunk,), flying, done)
                    elif isinstance(outcome, Unlike):
                        self._say(f"worker {outcome.worker} is retired, since it would fly other bits:\n{outcome.why}")
                        self._retire(outcome.worker)
                        self._submit(task.chunks, flying, done)
                    else:
                        suspects |= dict.fromkeys(task.chunks, f"the last at {outcome.last_worker.address}")
                self._hand_over(arrived, take)
        except BaseException:
            for task in flying.values():
                if isinstance(outcome := _at_hand(task.future), TaskResult):
                    arrived += outcome.flown
            self._hand_over(arrived, take)
            raise
        finally:
            with suppress(IncompleteError):
                within(LOOK_S, lambda: self._client.cancel([task.future for task in flying.values()]), _DEAF)

    def _group(self, todo: deque[int], ahead: int) -> tuple[int, ...]:
        """The chunks of the next task: enough for `TASK_S`, and fewer towards the end, so that all threads end together."""
        threads = self._count()
        long_enough = int(max(TASK_S, threads / TASKS_A_SECOND) / self._pace) if self._pace else 1
        size = max(1, min(long_enough, MOST_CHUNKS, len(todo) // (ahead * threads)))
        return tuple(todo.popleft() for _ in range(size))

    def _submit(self, chunks: tuple[int, ...], flying: dict[int, _Task], done: Queue[int]) -> None:
        number = next(self._numbers)
        key = f"{self._name}-chunk-{chunks[0]}-{uuid.uuid4().hex[:8]}"
        flying[number] = _Task(chunks, self._client.submit(fly, self._name, chunks, key=key))
        _tell(flying[number].future, number, done)

    def _hand_over(self, arrived: list[ChunkResult], take: Take) -> None:
        """Hands over all that has arrived, once the files that workers have written are visible here, and empties the list."""
        batch = arrived.copy()
        arrived.clear()
        late = time.monotonic() + PATIENCE_S
        for file in (file for result in batch for file in result.files if file.data is None):
            while not (self._folder / file.entry.file).exists() and time.monotonic() < late:
                time.sleep(0.1)
        if batch:
            take(batch)
            self._folding.note(batch)

    def _next(self, done: Queue[int], look: Callable[[], None]) -> list[int]:
        """The tasks that are done, flown or failed, at least one. IncompleteError where none comes for `STALL_S`."""
        end = time.monotonic() + STALL_S
        while time.monotonic() < end:
            try:
                tasks = [done.get(timeout=LOOK_S)]
            except Empty:
                self._count()
                look()
                continue
            while not done.empty():
                tasks.append(done.get())
            return tasks
        raise IncompleteError(
            f"the Dask workers have sent no chunk for {STALL_S:g} s; look at them, then give the same command again"
        )

    def _retire(self, worker: str) -> None:
        """Dismisses a worker."""
        within(ANSWER_S, lambda: self._client.retire_workers([worker], close_workers=True), _DEAF, self._say)

    def _outcome(self, future: Future) -> TaskResult | Unlike | KilledWorker | None:
        """The result of a task, or that its workers died; None where the result was lost and the task runs again."""
        if future.status in ("pending", "lost"):
            return None
        if future.status == "cancelled":
            raise IncompleteError("the Dask scheduler was lost: its tasks are gone")
        try:
            return within(ANSWER_S, future.result, "a Dask worker does not send its chunk", self._say)
        except IncompleteError:
            raise
        except KilledWorker as error:
            return error
        except CancelledError:
            return None
        except Exception as error:  # any other reason for which Dask gives up
            raise IncompleteError(f"Dask gave up a chunk: {type(error).__name__}: {error}") from error

    def _count(self) -> int:
        """Threads of all workers, counted every few seconds; waits for a worker. IncompleteError after `WORKER_S` without any."""
        end = time.monotonic() + WORKER_S
        told = -WAITING_S
        while not self._threads or time.monotonic() - self._counted > LOOK_S:
            self._threads, self._counted = sum(self._there().values()), time.monotonic()
            if self._threads:
                break
            if self._counted >= end:
                raise IncompleteError(f"no Dask worker for {WORKER_S:g} s; start one, then give the same command again")
            if self._counted - told >= WAITING_S:
                told = self._counted
                self._say(f"waiting for a Dask worker, up to {end - told:.0f} s")
            time.sleep(1.0)
        return self._threads

    def _there(self) -> dict[str, int]:
        """Address and threads of every worker. IncompleteError where the scheduler does not answer."""
        try:
            if self._client.status == "running":
                return dict(cast("dict[str, int]", within(ANSWER_S, self._client.nthreads, _DEAF, self._say)))
            why = "the connection is gone"
        except (OSError, TimeoutError) as error:
            why = str(error)
        raise IncompleteError(f"the Dask scheduler was lost: {why}")

    def _compare(self) -> None:
        """Asks every connected worker whether it would fly the same bits. UsageError where one would not.

        A worker that goes away meanwhile is not waited for: its replacement is asked when it flies. IncompleteError where
        a worker does not answer for `READY_S`.
        """
        self._count()
        asked = {
            address: self._client.submit(ready, self._name, workers=[address], allow_other_workers=True, pure=False)
            for address in self._there()
        }
        answers = [self._answer(future) for future in self._answered(asked)]
        differing = [answer for answer in answers if isinstance(answer, Unlike)]
        if differing:
            what = "\n".join(f"{answer.worker}:\n{answer.why}" for answer in differing)
            raise UsageError(f"these Dask workers would fly other bits; start them with the same rvjax and packages\n{what}")

    def _answered(self, asked: Mapping[str, Future]) -> list[Future]:
        """The futures of workers that have answered or failed, once none is left that may answer."""
        end, looked, gone = time.monotonic() + READY_S, time.monotonic(), set[str]()
        while silent := [address for address in asked if asked[address].status == "pending" and address not in gone]:
            now = time.monotonic()
            if now >= end:
                raise IncompleteError(
                    f"{', '.join(silent)}: no answer for {READY_S:g} s when asked what they would fly; look at the log of these "
                    "Dask workers, then give the same command again"
                )
            if now - looked >= LOOK_S:
                looked, there = now, self._there()
                gone.update(address for address in silent if address not in there)
                self._say(f"waiting for {len(silent)} Dask workers to say what they would fly, up to {end - now:.0f} s")
            time.sleep(0.05)
        if gone and len(gone) == len(asked):
            raise IncompleteError(
                f"{', '.join(sorted(gone))}: every Dask worker died when asked what it would fly; install the same rvjax[dask] "
                "there and look at the logs of the workers"
            )
        for address in gone:
            asked[address].cancel()
        return [future for address, future in asked.items() if address not in gone]

    def _answer(self, future: Future) -> Any:
        try:
            return within(ANSWER_S, future.result, "a Dask worker does not send its answer", self._say)
        except IncompleteError:
            raise
        except (KilledWorker, CancelledError):
            return None  # its replacement is asked when it flies
        except Exception as error:  # any error of a worker
            raise UsageError(_CANNOT.format(error)) from error


def _average(so_far: float, latest: float) -> float:
    """A running average that follows the latest values; 0: there is none yet."""
    return (so_far + latest) / 2 if so_far else latest


def _at_hand(future: Future) -> Any:
    """The result of a finished task, where it comes soon; else None."""
    if future.status != "finished":
        return None
    with suppress(Exception):
        return within(LOOK_S, future.result, "")
    return None


def _tell(future: Future, number: int, done: Queue[int]) -> None:
    """Puts the number of a task into `done` when it ends."""
    future.add_done_callback(lambda _: done.put(number))


def _order(runner: ChunkRunner, folder: RunFolder, token: str, local: bool) -> WorkOrder:
    return WorkOrder(
        campaign=runner.problem.spec.source.text,
        inputs=runner.problem.spec.source.inputs,
        overrides=tuple(map(str, folder.provenance["overrides"])),
        identity=folder.identity,
        packages=packages(),
        folder=str(folder.path.resolve() if isinstance(folder.path, Path) else folder.path),
        token=token,
        local=local,
    )


def _dismiss(client: Client, name: str) -> None:
    """Makes the workers forget the campaign; does not wait for a worker that does not answer."""
    with suppress(Exception):
        within(LOOK_S, lambda: client.unregister_worker_plugin(name), _DEAF)


def _lost(chunk: int, why: str) -> str:
    return f"chunk {chunk} (samples {chunk * LANES} to {(chunk + 1) * LANES - 1}) could not be flown: {why}"
