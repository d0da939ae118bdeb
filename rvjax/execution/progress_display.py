"""How progress is shown: a bar in a terminal, a line that is updated in a notebook, lines elsewhere."""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false
# (IPython is not a dependency: its display is there only in a notebook)

from __future__ import annotations

import sys
from collections.abc import Callable, Generator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any

from rvjax.execution.progress import OnProgress, Progress

LINES_S = 5.0
"""Seconds between two lines of a phase; later 2 % of the time that it has taken, so that the log of a long run stays readable."""

DOING = {
    "audit": "auditing",
    "flights": "flying",
    "rare failures": "searching rare failures,",
    "traces": "tracing",
    "report": "writing the report",
}
"""What a phase does, in a word or two."""


def shown(progress: bool | OnProgress) -> AbstractContextManager[OnProgress]:
    """What gets the progress. True: a display in a terminal and in a notebook; False: nobody; a function: itself."""
    return nullcontext(progress) if callable(progress) else display(elsewhere=False) if progress else nullcontext(_ignore)


def _ignore(progress: Progress) -> None:
    """Shows nothing."""


@contextmanager
def display(*, elsewhere: bool) -> Generator[OnProgress, None, None]:
    """Shows progress on stderr or in the notebook. elsewhere: lines where there is neither a terminal nor a notebook."""
    if sys.stderr.isatty():
        with _bar() as bar:
            yield bar
    elif _in_notebook():
        yield _NotebookLine()
    elif elsewhere:
        yield ProgressLines(lambda text: print(text, file=sys.stderr, flush=True))
    else:
        yield _ignore


@contextmanager
def lines(progress: bool | OnProgress) -> Generator[Callable[[str], None], None, None]:
    """What gets the lines of a search that has no phases. True: a line that is updated in a notebook, lines in a terminal;
    otherwise nobody."""
    if progress is not True or not (sys.stderr.isatty() or _in_notebook()):
        yield lambda _: None
    elif sys.stderr.isatty():
        yield lambda text: print(text, file=sys.stderr, flush=True)
    else:
        yield _NotebookLine().say


class PhaseText:
    """The line that states the progress of a phase: when it begins, while it lasts, when it has ended."""

    def __init__(self) -> None:
        self._open = self.begins = False
        self._first = self._flown = Progress(phase="audit")

    def line(self, progress: Progress) -> str:
        """`flying 104 of 416 samples`, `flights: 34 %, 104 of 416 samples, 40 samples/s, 7 s left` or `flights: 416 samples in
        4.1 s`. Afterwards `begins` says whether the phase began with this call."""
        self.begins, self._open = not self._open, not progress.ended
        if self.begins:
            self._first = self._flown = progress
        elif self._flown.share == self._first.share:  # the clock starts with the first steps: before them the program is compiled
            self._flown = progress
        name, count = progress.phase, f"{progress.total:,} samples"
        note = f"; {progress.note}" if progress.note else ""
        if progress.ended:
            return f"{name}: {f'{progress.done:,} samples in ' if progress.total else ''}{progress.seconds:.1f} s{note}"
        if self.begins:
            return f"{DOING[name]} {progress.total - progress.done:,} of {count}" if progress.total else DOING[name]
        return f"{name}: {100.0 * progress.share:.0f} %, {progress.done:,} of {count}{self._speed(progress)}{note}"

    def _speed(self, progress: Progress) -> str:
        """Samples per second and the time left; empty while the speed is not known."""
        share, spent = progress.share - self._flown.share, progress.seconds - self._flown.seconds
        if share <= 0.0 or spent <= 1.0:  # too short to measure
            return ""
        rate = share * progress.total / spent
        speed = f"{rate:,.0f}" if rate >= 10.0 else f"{rate:.2g}"
        return f", {speed} samples/s, {(1.0 - progress.share) * spent / share:.0f} s left"


class ProgressLines:
    """A line when a phase begins, now and then while it lasts, and when it has ended."""

    def __init__(self, write: Callable[[str], None]) -> None:
        self._write = write
        self._text = PhaseText()
        self._next = 0.0

    def __call__(self, progress: Progress) -> None:
        line = self._text.line(progress)
        if self._text.begins or progress.ended or progress.seconds >= self._next:
            self._write(line)
            self._next = progress.seconds + max(LINES_S, 0.02 * progress.seconds)


def _in_notebook() -> bool:
    """Whether this process is the kernel of a notebook."""
    module = sys.modules.get("IPython")
    shell = module.get_ipython() if module is not None else None
    return type(shell).__name__ == "ZMQInteractiveShell"


class _NotebookLine:
    """A line per phase in the output of a notebook's cell, updated in place."""

    def __init__(self) -> None:
        self._text = PhaseText()
        self._handle: Any = None

    def __call__(self, progress: Progress) -> None:
        line = self._text.line(progress)
        if self._text.begins:
            self._handle = None
        self.say(line)

    def say(self, text: str) -> None:
        """Replaces the text shown before."""
        from IPython.display import display as show  # pyright: ignore[reportMissingImports]

        content = {"text/plain": text}
        if self._handle is None:
            self._handle = show(content, raw=True, display_id=True)
        else:
            self._handle.update(content, raw=True)


@contextmanager
def _bar() -> Generator[OnProgress, None, None]:
    """A bar of rich for the phase under way; above it a line for each phase that has ended."""
    from rich.console import Console
    from rich.progress import BarColumn, SpinnerColumn, TextColumn
    from rich.progress import Progress as Bar

    columns = (SpinnerColumn("line"), BarColumn(bar_width=20), TextColumn("{task.description}", markup=False))
    text = PhaseText()
    with Bar(*columns, console=Console(stderr=True, highlight=False), transient=True) as bar:

        def show(progress: Progress) -> None:
            line = text.line(progress)
            if text.begins:
                bar.add_task(line, total=1.0 if progress.total else None)
            (task,) = bar.task_ids
            bar.update(task, description=line, completed=progress.share)
            if progress.ended:
                bar.remove_task(task)
                bar.console.print(line, markup=False)

        yield show
