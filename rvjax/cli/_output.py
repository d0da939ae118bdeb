"""What the program prints: results on stdout, everything else on stderr; with --json one document on stdout."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TextIO

from rvjax.cli._streams import is_unicode
from rvjax.errors import Finding, visible

if TYPE_CHECKING:
    from rvjax.analysis.verdicts import Verdict
    from rvjax.execution.progress import OnProgress


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
    def progress(self) -> Iterator[OnProgress]:
        """Progress of a run: a bar on a terminal, lines elsewhere; nothing with --quiet."""
        if self.quiet:
            yield lambda progress: None
        else:
            from rvjax.execution.progress_display import display

            with display(elsewhere=True) as on_progress:
                yield on_progress


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
        | ({} if verdict.rare is None else {"rare": vars(verdict.rare)})
        | ({} if verdict.under is None else {"under": vars(verdict.under)})
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
