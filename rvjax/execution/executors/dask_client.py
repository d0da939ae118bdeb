"""Executor: Dask workers, processes on this machine or on many.

A task is a chunk's number. Where a worker is lost, the scheduler gives its chunks to others. A worker that sees the run folder
at the same path writes its data files itself, any other worker sends them. Only the client commits files, so a single process
writes the journal.
"""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false, reportMissingTypeStubs=false
# (Dask says little about its types)

from __future__ import annotations

import logging
import time
import uuid
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from queue import Empty, Queue
from typing import Any, cast

from rvjax.components.extras import lacking
from rvjax.cores import cores
from rvjax.errors import IncompleteError, UsageError

if lack := lacking("dask", "distributed"):
    raise UsageError(f"--dask needs {lack}; accepted: pip install 'rvjax[dask]'")

from dask import config
from dask.utils import parse_timedelta
from distributed import Client, Future, KilledWorker, LocalCluster
from distributed.comm.addressing import parse_host_port

from rvjax.execution.chunks import ChunkResult, ChunkRunner
from rvjax.execution.executors import ExecutorFactory
from rvjax.execution.executors.dask_worker import DaskWorkerState, Failed, Unlike, WorkOrder, fly, ready
from rvjax.execution.executors.waiting import LOOK_S, Say, reach, within
from rvjax.execution.identity import packages
from rvjax.run_folder import RunFolder
from rvjax.simulation.batch import LANES

AHEAD = 2
"""Chunks in flight for each thread of the workers: one flies, one waits."""

RETRIES = 2
"""Retries of a chunk whose flight raises an error. Where its worker dies, Dask gives the chunk to others, as often as
`distributed.scheduler.allowed-failures` says."""

MOST_LOST = 3
"""The run gives up after this number of chunks that cannot be flown."""

MOST_SUSPECT = 16
"""Up to this number of chunks whose workers died are flown again, each alone, before others."""

PATIENCE_S = 60.0
"""How long a file that a worker has written may take to appear here: network file systems show names late."""

ANSWER_S = 120.0
"""How long the scheduler may take to answer."""

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


def parse(text: str) -> int | str:
    """`local:4` → 4 workers; `tcp://host:8786` → that address. UsageError for anything else."""
    kind, _, rest = text.partition(":")
    if kind == "local" and rest.isdecimal() and 0 < int(rest) <= 1024:
        return int(rest)
    if kind in ("tcp", "tls", "ws", "wss", "ucx") and rest.startswith("//") and len(rest) > 2:
        return text
    raise UsageError(f"--dask {text}: accepted: local:N with N worker processes here, or a scheduler's tcp://host:port")


def workers(place: int | str, say: Say) -> ExecutorFactory:
    """An executor of Dask workers: N processes on this machine, or those of a scheduler. say: gets messages on progress.

    UsageError where nobody listens at the scheduler's address, which is tried at once.
    """
    if isinstance(place, str):
        _try_address(place, say)

    @contextmanager
    def executor(runner: ChunkRunner, folder: RunFolder) -> Generator[Workers, None, None]:
        with ExitStack() as stack:
            stack.enter_context(_silence())
            client = stack.enter_context(_client(place, stack))
            say(f"Dask: {client.dashboard_link or 'no dashboard'}")
            token = f".workers.{uuid.uuid4().hex}"  # a temporary name: it is removed later where this process is killed
            (folder.path / token).touch()
            stack.callback((folder.path / token).unlink, missing_ok=True)
            state = DaskWorkerState(_order(runner, folder, token, isinstance(place, int)))
            _check_versions(client, say)
            try:
                within(READY_S, lambda: client.register_plugin(state), "a Dask worker or the scheduler does not answer", say)
            except IncompleteError:
                raise
            except Exception as error:  # any error of a worker
                raise UsageError(_CANNOT.format(error)) from error
            stack.callback(_dismiss, client, state.name)
            yield Workers(client, state.name, folder.path, say)

    return executor


class Workers:
    """The workers of a scheduler."""

    def __init__(self, client: Client, name: str, folder: Path, say: Say) -> None:
        self._client, self._name, self._folder, self._say = client, name, folder, say
        self._threads, self._counted = 0, -LOOK_S

    def fly(self, chunks: Iterable[int], take: Callable[[ChunkResult], None], look: Callable[[], None] = lambda: None) -> None:
        """As `Executor.fly`, in order of completion. `look` is not called: workers do not report flights under way. UsageError
        where a worker would fly other bits than the client."""
        self._compare()
        todo, lost = iter(chunks), dict[int, str]()
        while len(lost) < MOST_LOST:
            suspects = self._fly(todo, AHEAD, take, lost)
            for chunk in suspects:  # each alone: other chunks on a worker that dies are lost with it
                for _ in self._fly(iter([chunk]), 1, take, lost):
                    lost[chunk] = f"every worker that flew it died, also when it flew alone; {suspects[chunk]}"
            if not suspects:
                break
        if lost:
            raise IncompleteError("\n".join(_lost(chunk, why) for chunk, why in sorted(lost.items())))

    def _fly(self, todo: Iterator[int], ahead: int, take: Callable[[ChunkResult], None], lost: dict[int, str]) -> dict[int, str]:
        """Flies the chunks of `todo`; returns those whose workers died, up to `MOST_SUSPECT`; the rest stays in `todo`."""
        flying, failures, suspects = dict[int, Future](), Counter[int](), dict[int, str]()
        done: Queue[int] = Queue()
        try:
            while True:
                on = len(lost) < MOST_LOST and len(suspects) < MOST_SUSPECT
                while on and len(flying) < ahead * self._count() and (chunk := next(todo, None)) is not None:
                    flying[chunk] = self._submit(chunk, done)
                if not flying:
                    return suspects
                chunk = self._next(done)
                outcome = self._outcome(flying[chunk])
                if outcome is None:
                    _tell(flying[chunk], chunk, done)
                    continue
                del flying[chunk]
                if isinstance(outcome, ChunkResult):
                    take(self._arrived(outcome))
                elif isinstance(outcome, Failed):
                    failures[chunk] += 1
                    if failures[chunk] > RETRIES:
                        lost[chunk] = f"{failures[chunk]} times {outcome.why}"
                    else:
                        flying[chunk] = self._submit(chunk, done)
                elif isinstance(outcome, Unlike):
                    self._say(f"worker {outcome.worker} is retired, since it would fly other bits:\n{outcome.why}")
                    self._retire(outcome.worker)
                    flying[chunk] = self._submit(chunk, done)
                else:
                    suspects[chunk] = f"the last at {outcome.last_worker.address}"
        except BaseException:
            for future in flying.values():
                if isinstance(outcome := _at_hand(future), ChunkResult):
                    take(self._arrived(outcome))
            raise
        finally:
            with suppress(IncompleteError):
                within(LOOK_S, lambda: self._client.cancel(list(flying.values())), _DEAF)

    def _submit(self, chunk: int, done: Queue[int]) -> Future:
        key = f"{self._name}-chunk-{chunk}-{uuid.uuid4().hex[:8]}"
        future = self._client.submit(fly, self._name, chunk, key=key)
        _tell(future, chunk, done)
        return future

    def _next(self, done: Queue[int]) -> int:
        """The next chunk that is done, flown or failed. IncompleteError where none comes for `STALL_S`."""
        end = time.monotonic() + STALL_S
        while time.monotonic() < end:
            try:
                return done.get(timeout=LOOK_S)
            except Empty:
                self._count()
        raise IncompleteError(
            f"the Dask workers have sent no chunk for {STALL_S:g} s; look at them, then give the same command again"
        )

    def _retire(self, worker: str) -> None:
        """Dismisses a worker."""
        within(ANSWER_S, lambda: self._client.retire_workers([worker], close_workers=True), _DEAF, self._say)

    def _outcome(self, future: Future) -> ChunkResult | Unlike | Failed | KilledWorker | None:
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

    def _arrived(self, result: ChunkResult) -> ChunkResult:
        """The result, once the files that its worker has written are visible here."""
        late = time.monotonic() + PATIENCE_S
        for file in result.files:
            while file.data is None and not (self._folder / file.entry.file).exists() and time.monotonic() < late:
                time.sleep(0.1)
        return result


def _try_address(place: str, say: Say) -> None:
    """UsageError where nobody listens at a scheduler's address. `ucx` is left to Dask."""
    kind, _, rest = place.partition("://")
    accepted = "accepted: the address that `dask scheduler` prints"
    try:
        host, port = parse_host_port(rest.partition("/")[0])
    except ValueError as error:
        raise UsageError(f"--dask {place}: {error}; {accepted}") from error
    if kind == "ucx":
        return
    patience = parse_timedelta(config.get("distributed.comm.timeouts.connect", "30s"))
    try:
        reach(host, int(port), patience, say)
    except (OSError, OverflowError) as error:
        raise UsageError(f"--dask {place}: nobody listens there for {patience:g} s: {error}; {accepted}") from error


def _check_versions(client: Client, say: Say) -> None:
    """UsageError where a worker or the scheduler has another version of Dask: it may die of what it is sent."""
    found = cast("dict[str, Any]", within(ANSWER_S, client.get_versions, "a Dask worker or the scheduler does not answer", say))
    mine = found["client"]["packages"]
    others = {"the scheduler": found["scheduler"], **found["workers"]}
    differing = [
        f"{who}: {name} {theirs}, here {mine[name]}"
        for who, answer in others.items()
        for name in ("dask", "distributed")
        if (theirs := (answer or {}).get("packages", {}).get(name, mine[name])) != mine[name]
    ]
    if differing:
        raise UsageError("these Dask processes have other versions; install the same rvjax[dask] there\n" + "\n".join(differing))


def _at_hand(future: Future) -> Any:
    """The result of a finished task, where it comes soon; else None."""
    if future.status != "finished":
        return None
    with suppress(Exception):
        return within(LOOK_S, future.result, "")
    return None


def _tell(future: Future, chunk: int, done: Queue[int]) -> None:
    """Puts the chunk into `done` when its task ends."""
    future.add_done_callback(lambda _: done.put(chunk))


@contextmanager
def _silence() -> Generator[None, None, None]:
    """Silences Dask's log in this process: tracebacks of lost connections, for which rvjax prints messages."""
    names = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] in ("distributed", "tornado")]
    levels = {logger: logger.level for logger in map(logging.getLogger, names)}
    for logger in levels:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in levels.items():
            logger.setLevel(level)


def _client(place: int | str, stack: ExitStack) -> Client:
    if isinstance(place, int):
        threads = max(1, cores() // place)
        local = {"dashboard_address": "127.0.0.1:0", "memory_limit": 0, "silence_logs": "CRITICAL"}
        with config.set({"distributed.worker.profile.enabled": False}):  # 5 % of the speed
            cluster = LocalCluster(n_workers=place, threads_per_worker=threads, processes=True, **local)
        return Client(stack.enter_context(cluster))
    try:
        return Client(place)
    except (OSError, ValueError) as error:
        raise UsageError(f"--dask {place}: {error}; accepted: the address that `dask scheduler` prints") from error


def _order(runner: ChunkRunner, folder: RunFolder, token: str, local: bool) -> WorkOrder:
    return WorkOrder(
        campaign=runner.problem.spec.source.text,
        inputs=runner.problem.spec.source.inputs,
        overrides=tuple(map(str, folder.provenance["overrides"])),
        identity=folder.identity,
        packages=packages(),
        folder=str(folder.path.resolve()),
        token=token,
        local=local,
    )


def _dismiss(client: Client, name: str) -> None:
    """Makes the workers forget the campaign; does not wait for a worker that does not answer."""
    with suppress(Exception):
        within(LOOK_S, lambda: client.unregister_worker_plugin(name), _DEAF)


def _lost(chunk: int, why: str) -> str:
    return f"chunk {chunk} (samples {chunk * LANES} to {(chunk + 1) * LANES - 1}) could not be flown: {why}"
