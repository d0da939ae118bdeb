"""Tables in Markdown, as the benchmarks print them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def row(cells: Iterable[str]) -> str:
    """A row."""
    return f"| {' | '.join(cells)} |"


def head(columns: Sequence[str]) -> str:
    """The names of the columns, and the rule below them."""
    return f"{row(columns)}\n|{'---|' * len(columns)}"
