"""Waiting for what is outside of this process: with messages, and never without an end."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from queue import Empty, Queue
from threading import Thread
from typing import TypeVar

from rvjax.errors import IncompleteError

T = TypeVar("T")

LOOK_S = 5.0
"""Seconds between two looks, and between two messages."""

Say = Callable[[str], None]


def within(seconds: float, call: Callable[[], T], silence: str, say: Say = lambda _: None) -> T:
    """The result of a call that waits. silence: a sentence that says who does not answer, printed every few seconds.

    IncompleteError after `seconds`; the call then stays in a thread that does not keep the process alive.
    """
    answers: Queue[tuple[bool, object]] = Queue()

    def ask() -> None:
        try:
            answers.put((True, call()))
        except BaseException as error:  # noqa: BLE001
            answers.put((False, error))

    Thread(target=ask, daemon=True).start()
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0.0:
        try:
            good, answer = answers.get(timeout=min(LOOK_S, left))
        except Empty:
            say(f"waiting: {silence}")
            continue
        if good:
            return answer  # pyright: ignore[reportReturnType]
        assert isinstance(answer, BaseException)
        raise answer
    raise IncompleteError(f"{silence} for {seconds:g} s; what was flown is kept, give the same command again")


def reach(host: str, port: int, seconds: float, say: Say) -> None:
    """Waits until a port accepts a connection; OSError with the last reason where it does not within `seconds`."""
    end = time.monotonic() + seconds
    told = False
    while True:
        try:
            socket.create_connection((host, port), timeout=max(0.1, min(LOOK_S, end - time.monotonic()))).close()
        except OSError as error:
            if time.monotonic() >= end:
                raise
            if not told:
                say(f"waiting for the Dask scheduler at {host}:{port}, up to {seconds:g} s: {error}")
            told = True
            time.sleep(0.3)
        else:
            return
