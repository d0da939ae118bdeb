"""Every wait for a scheduler, a worker or another process says so, and has an end. Dask is replaced by fakes."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError
from pathlib import Path
from queue import Queue
from types import SimpleNamespace
from typing import Any

import pytest
from distributed import KilledWorker

from rvjax.errors import IncompleteError, UsageError
from rvjax.execution import run as running
from rvjax.execution.bench import measurement
from rvjax.execution.executors import dask_client, dask_connection, dask_folding, waiting
from rvjax.execution.executors.dask_client import Workers
from rvjax.execution.executors.dask_worker import Unlike
from rvjax.simulation import jax_config
from tests.program import Run
from tests.reliability.cluster import free_port
from tests.short import CAMPAIGN


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """Limits of a fraction of a second."""
    for name in ("ANSWER_S", "READY_S", "WORKER_S", "STALL_S"):
        for module in (dask_client, dask_connection, dask_folding):
            monkeypatch.setattr(module, name, 0.3, raising=False)
    for module in (dask_client, dask_folding):
        monkeypatch.setattr(module, "LOOK_S", 0.05)
    monkeypatch.setattr(waiting, "LOOK_S", 0.05)


def never() -> Any:
    """Does not return while the test runs."""
    threading.Event().wait(30.0)


class Asked:
    """A future of Dask. status: or what it becomes once it is asked for."""

    def __init__(self, status: str = "pending", result: Callable[[], Any] = lambda: None) -> None:
        self.status, self.result, self.cancelled = status, result, False

    def cancel(self) -> None:
        self.cancelled = True


class Dask:
    """A client. workers: address and threads, or a call that gives them; asked: the futures of what is submitted, in turn."""

    status = "running"

    def __init__(self, workers: Callable[[], dict[str, int]], asked: list[Asked] | None = None) -> None:
        self.nthreads, self.asked = workers, iter(asked or [])

    def submit(self, *given: Any, **more: Any) -> Asked:
        return next(self.asked)


def crew(client: Dask, said: list[str]) -> Workers:
    """The workers behind a client."""
    return Workers(client, "name", Path(), said.append, SimpleNamespace())  # pyright: ignore[reportArgumentType]


def test_a_call_that_never_returns_ends_with_its_reason() -> None:
    """Kills: a wait without a limit, or without a word; an error of the call that is lost in its thread."""
    said: list[str] = []
    with pytest.raises(IncompleteError, match=r"^the oracle does not answer for 0\.3 s; .*the same command"):
        waiting.within(0.3, never, "the oracle does not answer", said.append)
    assert said
    assert set(said) == {"waiting: the oracle does not answer"}
    assert waiting.within(0.3, lambda: 7, "x") == 7
    with pytest.raises(ZeroDivisionError):
        waiting.within(0.3, lambda: 1 // 0, "x")
    with pytest.raises(CancelledError):
        waiting.within(0.3, lambda: (_ for _ in ()).throw(CancelledError()), "x")


def test_a_scheduler_that_does_not_answer_ends_the_run() -> None:
    """It has the connection open, and is stopped. Kills: waiting for ever for the number of threads, or for a dismissal."""
    said: list[str] = []
    with pytest.raises(IncompleteError, match="the Dask scheduler does not answer"):
        crew(Dask(never), said)._count()
    assert said
    client = Dask(lambda: {"a": 1})
    client.retire_workers = lambda *_, **__: never()  # pyright: ignore[reportAttributeAccessIssue]
    with pytest.raises(IncompleteError, match="the Dask scheduler does not answer"):
        crew(client, said)._retire("a")


def test_no_worker_comes() -> None:
    """Kills: waiting for ever for the first worker, silently."""
    said: list[str] = []
    with pytest.raises(IncompleteError, match=r"no Dask worker for 0\.3 s; start one"):
        crew(Dask(dict), said)._count()
    assert said == ["waiting for a Dask worker, up to 0 s"]


def test_workers_that_do_not_say_what_they_would_fly() -> None:
    """As of another version of Dask: the worker dies of the question. Kills: `future.result()` without a limit; waiting for a
    worker that is gone; an answer of another worker that is lost with it."""
    said: list[str] = []
    silent = crew(Dask(lambda: {"tcp://a": 1}, [Asked()]), said)
    with pytest.raises(IncompleteError, match=r"^tcp://a: no answer for 0\.3 s when asked what they would fly"):
        silent._compare()
    assert any("waiting for 1 Dask workers to say what they would fly" in text for text in said)

    there = iter([{"tcp://a": 1, "tcp://b": 1}] * 2)
    leaving = lambda: next(there, {"tcp://b": 1})  # noqa: E731
    dead = Asked()
    with pytest.raises(UsageError, match=r"would fly other bits(.|\n)*tcp://b:\nother flags"):
        crew(Dask(leaving, [dead, Asked("finished", lambda: Unlike("tcp://b", "other flags"))]), said)._compare()
    assert dead.cancelled

    gone = iter([{"tcp://a": 1}] * 2)
    with pytest.raises(IncompleteError, match="every Dask worker died when asked"):
        crew(Dask(lambda: next(gone, {}), [Asked()]), said)._compare()

    def killed() -> None:
        raise KilledWorker("task", SimpleNamespace(address="tcp://a"), 3)  # pyright: ignore[reportArgumentType]

    crew(Dask(lambda: {"tcp://a": 1}, [Asked("error", killed)]), said)._compare()


def test_an_answer_or_a_chunk_that_is_not_sent() -> None:
    """The task has ended, but its worker does not send the result. Kills: `future.result()` without a limit."""
    workers = crew(Dask(lambda: {"a": 1}), [])
    with pytest.raises(IncompleteError, match="does not send its answer"):
        workers._answer(Asked("finished", never))  # pyright: ignore[reportArgumentType]
    with pytest.raises(IncompleteError, match="does not send its chunk"):
        workers._outcome(Asked("finished", never))  # pyright: ignore[reportArgumentType]
    assert dask_client._at_hand(Asked("finished", never)) is None  # pyright: ignore[reportArgumentType]
    assert dask_client._at_hand(Asked("finished", lambda: 7)) == 7  # pyright: ignore[reportArgumentType]
    with pytest.raises(IncompleteError, match=r"sent no chunk for 0\.3 s"):
        workers._next(Queue(), lambda: None)


@pytest.mark.parametrize(("who", "version"), [("tcp://w", "2020.1.0"), ("the scheduler", "2020.1.0"), ("", "2026.8.0")])
def test_another_version_of_dask_is_refused_before_it_is_sent_anything(who: str, version: str) -> None:
    """Kills: a worker that dies of what it cannot read; a refusal that does not say who has which version."""
    mine = {"packages": {"dask": "2026.8.0", "distributed": "2026.8.0", "numpy": "1"}}
    other = {"packages": {"dask": "2026.8.0", "distributed": version, "numpy": "2"}}
    found = {"client": mine, "scheduler": other if who == "the scheduler" else mine, "workers": {"tcp://v": mine}}
    found["workers"]["tcp://w"] = other if who == "tcp://w" else mine
    client: Any = SimpleNamespace(get_versions=lambda: found)
    if not who:
        dask_connection.check_versions(client, print)
        return
    with pytest.raises(UsageError, match=f"{who}: distributed 2020.1.0, here 2026.8.0$"):
        dask_connection.check_versions(client, print)
    with pytest.raises(IncompleteError, match="does not answer"):
        dask_connection.check_versions(SimpleNamespace(get_versions=never), lambda _: None)  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize(
    "place", ["tcp://127.0.0.1:{}", "tcp://127.0.0.1", "tcp://127.0.0.1:99999999", "tcp://no.such.host.invalid:1"]
)
def test_a_wrong_address_is_told_before_anything_is_loaded(
    place: str, rvjax: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Kills: half a minute of silence after an audit and a compilation; a port that is no number as a traceback."""
    from dask import config

    place = place.format(free_port())
    monkeypatch.setattr(running, "fly", lambda *_: pytest.fail("it flies"))
    with config.set({"distributed.comm.timeouts.connect": "1s"}):
        code, _, err = rvjax("run", CAMPAIGN, "--out", tmp_path / "run", "--dask", place)
    assert code == 2, err
    assert f"--dask {place}: " in err
    assert "accepted: the address that `dask scheduler` prints" in err
    if ":" in place[6:] and not place.endswith("99999999"):
        assert err.count("waiting for the Dask scheduler at ") == 1


def test_a_scheduler_that_starts_a_moment_later_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a job that starts it and the client together. Kills: giving up at the first refusal."""
    tries: list[object] = []

    def connect(address: object, timeout: float) -> Any:
        tries.append(address)
        assert timeout > 0
        if len(tries) < 2:
            raise ConnectionRefusedError
        return SimpleNamespace(close=lambda: None)

    monkeypatch.setattr("socket.create_connection", connect)
    said: list[str] = []
    dask_connection.try_address("tls://[::1]:8786", said.append)
    assert tries == [("::1", 8786)] * 2
    assert len(said) == 1


def test_a_child_of_jax_that_does_not_start_ends(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Kills: `subprocess.run` without a limit, when a device hangs."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(jax_config, "PROBE_S", 0.3)
    monkeypatch.setattr(jax_config, "_PROBE", "import time; time.sleep(30)")
    with pytest.raises(IncompleteError, match=r"JAX has not started in 0\.3 s"):
        jax_config._known("--xla_x=1")


def test_a_process_of_the_benchmark_that_hangs_or_fails_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: reading for ever; a traceback where the process that measures growth fails."""
    monkeypatch.setattr(measurement, "ANSWER_S", 0.3)
    command = [sys.executable, "-c", "import time; time.sleep(30)"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        with pytest.raises(IncompleteError, match=r"rvjax has not answered for 0\.3 s"), measurement._limited(process, "rvjax"):
            process.stdout.read()
    honest = subprocess.run
    for code, said in (("import time; time.sleep(30)", "has not ended in"), ("raise SystemExit(3)", "ended with exit code 3")):
        run = lambda _, code=code, **more: honest([sys.executable, "-c", code], **more)  # noqa: E731
        monkeypatch.setattr(measurement.subprocess, "run", run)
        monkeypatch.setattr(measurement, "ANSWER_S", 0.3 if "sleep" in code else 30.0)
        with pytest.raises(IncompleteError, match=said):
            measurement.growth_of(CAMPAIGN, 1000)
