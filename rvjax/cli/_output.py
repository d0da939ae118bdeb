"""What the program prints: results on stdout, everything else on stderr; with --json one document on stdout."""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TextIO

from rvjax.cli._streams import is_unicode
from rvjax.errors import Finding, visible

if TYPE_CHECKING:
    from rvjax.analysis.verdicts import Verdict
    from rvjax.execution.run import Progress

AFTERWARDS = "tracing the kept samples, writing the report"


def say(text: str, stream: TextIO) -> None:
    """Prints a text and a line end; control characters are made visible."""
    print(visible(text), file=stream, flush=True)


@dataclass(frozen=True)
class Output:
    """as_json: one JSON document on stdout. quiet: no progress and no hints."""

    as_json: bool = False
    quiet: bool = False

    def text(self, *lines: str) -> None:
        """Lines of the result; nothing with --json."""
        if not self.as_json:
            say("\n".join(lines), sys.stdout)

    def document(self, value: Mapping[str, Any]) -> None:
        """The result as one JSON document, only with --json; numbers that are not finite are null."""
        if self.as_json:
            text = json.dumps(_plain(value), indent=2, allow_nan=False, ensure_ascii=not is_unicode(sys.stdout))
            print(visible(text, lambda character: f"\\u{ord(character):04x}"), flush=True)

    def annotate(self, commands: Sequence[str]) -> None:
        """Commands for the CI service, which reads both streams."""
        for command in commands:
            say(command, sys.stderr if self.as_json else sys.stdout)

    def note(self, text: str) -> None:
        """A note on stderr; nothing with --quiet."""
        if not self.quiet:
            say(text, sys.stderr)

    def warnings(self, findings: Sequence[Finding]) -> None:
        """What is hardly meant in a campaign, on stderr, a line each."""
        for finding in findings:
            say(f"warning: {finding}", sys.stderr)

    def table(self, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        """A plain table as wide as the terminal; nothing with --json."""
        if self.as_json:
            return
        from rvjax.cli._tables import drawn

        print(drawn(head, rows, sys.stdout), flush=True)

    def verdicts(self, verdicts: Sequence[Verdict]) -> None:
        """A row for each requirement; nothing with --json."""
        if verdicts:
            self.table(
                ("verdict", "requirement"),
                [(verdict.verdict, verdict.text.removeprefix(f"{verdict.verdict}: ")) for verdict in verdicts],
            )

    @contextmanager
    def progress(self) -> Iterator[Progress]:
        """Progress of the flights: a bar on a terminal, a line for each chunk elsewhere."""
        if self.quiet:
            yield lambda done, total: None
        elif not sys.stderr.isatty():
            yield _Lines()
        else:
            with _bar() as bar:
                yield bar


class _Lines:
    """A line on stderr for each call."""

    def __init__(self) -> None:
        self.started = 0.0
        self.calls = 0
        self.first = 0
        self.over = False

    def __call__(self, done: int, total: int) -> None:
        self.calls = 1 if self.over else self.calls + 1  # a call after the end belongs to another run
        self.over = done == total
        if self.calls == 1:
            say(f"flying {total - done} of {total} samples", sys.stderr)
        elif self.calls == 2:  # the first chunk includes compiling: the clock starts after it
            self.first, self.started = done, time.monotonic()
            say(f"{done}/{total} samples", sys.stderr)
        else:
            spent = time.monotonic() - self.started
            rate = (done - self.first) / spent if spent > 1.0 else 0.0  # too short to measure the speed
            speed = f", {rate:.0f} samples/s, {(total - done) / rate:.0f} s left" if rate else ""
            say(f"{done}/{total} samples{speed}", sys.stderr)
        if done == total:
            say(AFTERWARDS, sys.stderr)


@contextmanager
def _bar() -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeRemainingColumn

    class Speed(TextColumn):
        def render(self, task: Any) -> Any:
            from rich.text import Text

            return Text(f"{task.speed:.0f} samples/s" if task.speed else "compiling")

    columns = (
        SpinnerColumn("dots" if is_unicode(sys.stderr) else "line"),
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        Speed(""),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("flying", total=None)

        def show(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total, description=AFTERWARDS if done == total else "flying")

        yield show


def verdict_documents(verdicts: Sequence[Verdict]) -> list[dict[str, Any]]:
    """Verdicts as plain values."""
    return [
        {
            "requirement": verdict.requirement.model_dump(exclude_none=True),
            "verdict": verdict.verdict,
            "successes": verdict.successes,
            "samples": verdict.n,
            "required": verdict.limit,
            "share": verdict.estimate.value,
            "share_low": verdict.low_bound,
            "share_high": verdict.high_bound,
            "quantile": None if verdict.quantity is None else vars(verdict.quantity),
            "more_samples": verdict.more,
            "text": verdict.text,
        }
        for verdict in verdicts
    ]


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
