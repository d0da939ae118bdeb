"""Watches a user's code while it is executed or traced: it may not read files, start programs or use the network.

What it reads would decide the flights without being part of a run's identity. Imports may read what they need.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Set
from contextlib import contextmanager
from functools import cache
from threading import local
from types import FrameType
from typing import Any

from rvjax.components.user_mistakes import UserMistake

_EVENTS = {
    "open": "opens a file",
    "os.system": "starts a program",
    "subprocess.Popen": "starts a program",
    "socket.connect": "uses the network",
    "socket.getaddrinfo": "uses the network",
}
_ALLOWED = ("importlib", "<frozen importlib", "/jax/", "/jaxlib/", "linecache", "zipimport")
"""Parts of the names of files whose code may read: it imports, or compiles."""

_state = local()


@contextmanager
def watched(paths: Set[str]) -> Iterator[None]:
    """Watches the code of these files in this thread."""
    _install()
    before = getattr(_state, "paths", frozenset[str]())
    _state.paths = frozenset(paths)
    try:
        yield
    finally:
        _state.paths = before


def refuse_flights() -> None:
    """UserMistake in the code of a user that is executed or traced as a component: it would fly in itself."""
    if getattr(_state, "paths", None):
        raise UserMistake("the code of a component flies a campaign", "accepted: definitions only; fly in another cell or file")


@cache
def _install() -> None:
    """An audit hook cannot be removed; this one does nothing outside of `watched`."""
    sys.addaudithook(_look)


def _look(event: str, arguments: tuple[Any, ...]) -> None:
    if event not in _EVENTS or not getattr(_state, "paths", None):
        return
    frame: FrameType | None = sys._getframe(1)
    while frame is not None:
        name = frame.f_code.co_filename
        if name in _state.paths:
            what = f" ({arguments[0]})" if event == "open" else ""
            raise UserMistake(f"the code {_EVENTS[event]}{what}", "accepted: numbers in the code or in the campaign")
        if any(part in name for part in _ALLOWED):
            return
        frame = frame.f_back
