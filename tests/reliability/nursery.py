"""A process that has imported the program and forks children which run it, so that a child costs no start-up; it kills them.

One request a line on stdin, one answer a line on stdout, both JSON. JAX's backend never runs here, so its threads are not lost
on forking. A child tells through a pipe where it is: at every entry of `PLACES`, which changes nothing of what it does.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

PLACES = ("start", "open", "fly", "take", "worst", "report", "write", "verdict")
"""What a run goes through; it comes more than once through `take`, and through `write` for every file of the report."""

SECTIONS = 2
"""Sections of a report, so that drawing it does not take longer than all the rest."""


class Nursery:
    """The other side: starts the process, asks it to raise children. before: words in front of its command, as `unshare`."""

    def __init__(self, before: Sequence[str] = ()) -> None:
        words = [*before, sys.executable, "-m", "tests.reliability.nursery"]
        root = Path(__file__).parents[2]
        self._process = subprocess.Popen(words, cwd=root, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def raise_child(self, arguments: Sequence[object], log: Path, place: str = "", nth: int = 1, delay: float = 0.0) -> Any:
        """Runs `rvjax ARGUMENTS`; killed `delay` seconds after its nth note of `place`, or of a later one where it never comes
        there. Answer: code (negative: the signal), at (the last place it told), flown (chunks it has begun), seconds.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        words = ["rvjax", *map(str, arguments)]
        request = {"argv": words, "log": str(log), "place": place, "nth": nth, "delay": delay}
        print(json.dumps(request), file=self._process.stdin, flush=True)
        return json.loads(self._process.stdout.readline())

    def root(self) -> Path:
        """The file systems as the process sees them."""
        return Path(f"/proc/{self._process.pid}/root")

    def close(self) -> None:
        """Ends the process."""
        self._process.communicate(timeout=60)


def watch(note: Callable[[str], None]) -> None:
    """Has the program tell where it is."""
    from rvjax import report
    from rvjax.cli import _fly_and_judge
    from rvjax.execution import chunks, run
    from rvjax.report import sections
    from rvjax.run_folder import RunFolder
    from tests.reliability.plain import proved

    sections.SECTIONS = sections.SECTIONS[:SECTIONS]
    run.prove = proved

    def told(name: Callable[..., str], call: Callable[..., Any]) -> Callable[..., Any]:
        def step(*given: Any, **more: Any) -> Any:
            note(name(*given))
            return call(*given, **more)

        return step

    at: Any = lambda place: lambda *given: place  # noqa: E731
    for owner, attribute, place in (
        (run, "_fly_and_fold", at("fly")),
        (run, "_keep_traces", at("worst")),
        (report, "write", at("report")),
        (_fly_and_judge, "_show", at("verdict")),
        (RunFolder, "take_all", at("take")),
        (RunFolder, "write_bytes", at("write")),
        (RunFolder, "seal", at("write")),
        (chunks.ChunkRunner, "fly_chunk", lambda _, chunk: f"chunk {chunk}"),
    ):
        setattr(owner, attribute, told(place, getattr(owner, attribute)))
    for attribute in ("create", "resume"):
        setattr(RunFolder, attribute, told(at("open"), getattr(RunFolder, attribute)))


def child(argv: list[str], log: str, pipe: int) -> int:
    """Runs the program in a forked process; its exit code."""
    from rvjax.cli import main

    handle = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(handle, 1)
    os.dup2(handle, 2)
    watch(lambda text: os.write(pipe, f"{text}\n".encode()) and None)
    sys.argv = argv
    os.write(pipe, b"start\n")
    try:
        main()
    except SystemExit as ended:
        sys.stdout.flush()
        sys.stderr.flush()
        return ended.code if isinstance(ended.code, int) else 1


def raised(request: dict[str, Any]) -> dict[str, Any]:
    """One child from its birth to its end."""
    reading, writing = os.pipe()
    born = time.monotonic()
    pid = os.fork()
    if not pid:
        os.close(reading)
        code = 99
        with contextlib.suppress(BaseException):
            code = child(request["argv"], request["log"], writing)
        os._exit(code)
    os.close(writing)
    told = _Notes(request)
    while True:
        ready, _, _ = select.select([reading], [], [], told.patience())
        if not ready or not told.hear(os.read(reading, 4096)):
            break  # the moment has come, or it has ended by itself
    if told.due is not None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    while told.hear(os.read(reading, 4096)):
        pass
    os.close(reading)
    return {"code": code, "at": told.at, "flown": told.flown, "seconds": time.monotonic() - born}


class _Notes:
    """What a child has told, and when it is to be killed."""

    def __init__(self, request: dict[str, Any]) -> None:
        self.at, self.flown = "", list[int]()
        self.due: float | None = None
        self._rest, self._seen, self._request = b"", 0, request
        self._place = PLACES.index(request["place"]) if request["place"] else len(PLACES)

    def hear(self, data: bytes) -> bool:
        """Whether there was anything."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        for word, *number in (line.decode().split() for line in lines):
            if number:
                self.flown.append(int(number[0]))
                continue
            self.at, now = word, PLACES.index(word)
            self._seen += now == self._place
            if self.due is None and (now > self._place or (now == self._place and self._seen == self._request["nth"])):
                self.due = time.monotonic() + self._request["delay"]
        return bool(data)

    def patience(self) -> float | None:
        """How long to wait for the next note [s]."""
        return None if self.due is None else max(0.0, self.due - time.monotonic())


def serve() -> None:
    """Raises a child for every request."""
    for module in (
        "execution.run",
        "report",
        "analysis.verdicts",
        "cli.run",
        "report.sections.worst",
        "report.run_view",
    ):
        __import__(f"rvjax.{module}")
    for line in sys.stdin:
        print(json.dumps(raised(json.loads(line))), flush=True)


if __name__ == "__main__":
    serve()
