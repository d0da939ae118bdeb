"""The lines of a job, the measures of a run and their table in Markdown."""

from __future__ import annotations

import ast
import io
import tokenize
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import NamedTuple

from benchmarks import markdown
from benchmarks.peers.job import Result

COLUMNS = (
    "peer",
    "version",
    "lines",
    "one core, s",
    "all cores, s",
    "over rvjax",
    "processor, s",
    "flights alone, s",
    "share",
    "95 % interval",
    "verdict, exit code",
    "furthest from rvjax, m",
)

_LAYOUT = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}


class Measured(NamedTuple):
    """A peer in all rounds.

    one, every: seconds of the whole process on one core and on all, round by round. over: on all cores, over those of rvjax in
    the same round. processor: seconds of all its processes, on all cores. apart: largest difference of a final distance from that
    of rvjax [m].
    """

    name: str
    lines: int
    one: Sequence[float]
    every: Sequence[float]
    over: Sequence[float]
    processor: Sequence[float]
    result: Result
    tube: float
    exit: int
    apart: float


def lines_of(path: Path) -> int:
    """Lines that hold code: without blank lines, comments and docstrings."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return sum(bool(line.strip()) and not line.lstrip().startswith("#") for line in text.splitlines())
    used: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in _LAYOUT:
            used.update(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            used.difference_update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return len(used)


def seconds(times: Sequence[float]) -> str:
    """Median, and in brackets the least."""
    return f"{median(times):.1f} ({min(times):.1f})" if times else ""


def row(measured: Measured) -> str:
    """A row of the table."""
    result = measured.result
    inside = sum(distance < measured.tube for distance in result.distances)
    low, high = result.interval or (0.0, 0.0)
    cells = (
        measured.name,
        result.version,
        str(measured.lines),
        seconds(measured.one),
        seconds(measured.every),
        f"{median(measured.over):.2f}" if measured.over else "",
        seconds(measured.processor),
        "" if result.fly_s is None else f"{result.fly_s:.2f}",
        f"{inside} of {len(result.distances)}",
        f"{100 * low:.1f} to {100 * high:.1f} %" if result.interval else "none",
        f"{result.verdict or 'none'}, {measured.exit}",
        f"{measured.apart:.0e}" if measured.apart else "0",
    )
    return markdown.row(cells)


def head() -> str:
    """The names of the columns."""
    return markdown.head(COLUMNS)
