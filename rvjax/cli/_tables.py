"""Tables as wide as the terminal. Where not even the longest words fit side by side, each row becomes a block of lines."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from typing import TextIO

from rich import box
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

from rvjax.cli._streams import is_unicode, printable
from rvjax.errors import visible

STYLES = {"PASS": "bold green", "FAIL": "bold red", "UNDECIDED": "bold yellow"}

WHOLE = 16
"""A cell up to this length, such as a number with its unit, stays on one line."""

LONGEST = 40
"""A longer word, such as a path, may be broken."""

_EDGES, _BETWEEN = 2, 3
_ASCII = box.Box("\n".join(str(box.SIMPLE_HEAD).replace("─", "-").splitlines()) + "\n", ascii=True)


def drawn(head: Sequence[str], rows: Sequence[Sequence[str]], stream: TextIO) -> str:
    """A table for a stream, without the last line end."""
    head, rows = [printable(name, stream) for name in head], [[printable(visible(cell), stream) for cell in row] for row in rows]
    console = Console(file=stream)
    widths = fitted(head, rows, console.width)
    with console.capture() as printed:
        if widths is None:
            for row in rows:
                for line in _block(head, row, console.width):
                    console.print(line, soft_wrap=True)
        else:
            table = Table(box=box.SIMPLE_HEAD if is_unicode(stream) else _ASCII, pad_edge=False, header_style="bold")
            for name, width in zip(head, widths, strict=True):
                table.add_column(name, overflow="fold", width=width)
            for row in rows:
                table.add_row(*(Text(cell, style=STYLES.get(cell, "")) for cell in row))
            console.print(table)
    return printed.get().rstrip("\n")


def fitted(head: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> list[int] | None:
    """The widths of the columns of a table of this width: the widest columns give way first. None where it is too narrow."""
    columns = list(zip(head, *rows, strict=True))
    least = [max((1, *_least(name), *(n for cell in cells for n in _least(cell, WHOLE)))) for name, *cells in columns]
    widths = [max(1, *(cell_len(line) for cell in cells for line in cell.split("\n"))) for cells in columns]
    surplus = sum(widths) + _EDGES + _BETWEEN * (len(columns) - 1) - width
    while surplus > 0:
        wide = [k for k in range(len(columns)) if widths[k] > least[k]]
        if not wide:
            return None
        widths[max(wide, key=lambda k: widths[k])] -= 1
        surplus -= 1
    return widths


def _least(cell: str, whole: int = 0) -> list[int]:
    """The lengths that must fit on one line: of the whole line if it is short, else of each word."""
    lines = cell.split("\n")
    parts = [part for line in lines for part in ([line] if cell_len(line) <= whole else line.split(" "))]
    return [min(cell_len(part), LONGEST) for part in parts]


def _block(head: Sequence[str], row: Sequence[str], width: int) -> Iterator[Text]:
    """The lines of a row: the first cell, below it each other cell after its heading."""
    for number, (name, cell) in enumerate(zip(head, row, strict=True)):
        label = f"{name}: " if name else ""
        first, rest = ("", "    ") if number == 0 else ("  ", "    ")
        if cell in STYLES:
            yield Text.assemble(first, label, (cell, STYLES[cell]))
            continue
        for part, line in enumerate(cell.split("\n")):
            start = first + label if part == 0 else rest
            broken = textwrap.wrap(
                start.lstrip() + line, width, initial_indent=first if part == 0 else rest, subsequent_indent=rest,
                break_long_words=False, break_on_hyphens=False,
            )  # fmt: skip
            yield from map(Text, broken)
