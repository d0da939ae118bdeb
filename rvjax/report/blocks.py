"""The parts of a report: sections of paragraphs, drawings and tables, whose cells are numbers, text or verdicts.

A section defines the content; `html` and `markdown` define its appearance. Every estimate is a `Number` with its interval,
so that the page and `summary.json` cannot differ.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from matplotlib.figure import Figure

from rvjax.stats import Estimate
from rvjax.stats.sampling_design import Observed


@dataclass(frozen=True)
class Number:
    """A number of the report: an estimate with its interval, an observed value, or a count.

    name: its key in `summary.json`; value: in the SI unit `unit` ("1": dimensionless); percent: show a share in %.
    """

    name: str
    value: Estimate | Observed | int
    unit: str = "1"
    percent: bool = False

    @property
    def estimate(self) -> Estimate | Observed:
        """The value, unless it is a count; TypeError for a count."""
        if isinstance(self.value, int):
            raise TypeError(f"{self.name} is a count")
        return self.value


@dataclass(frozen=True)
class Code:
    """Literal text in a monospaced font: a command, a hash, a column name."""

    text: str


@dataclass(frozen=True)
class Mark:
    """A verdict or an outcome, shown as a coloured word."""

    word: str


@dataclass(frozen=True)
class Named:
    """The name of a row with a line that explains it."""

    name: str
    meaning: str


Cell = str | Number | Code | Mark | Named


@dataclass(frozen=True)
class Table:
    """Rows of cells below a head; each row has as many cells as the head."""

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


@dataclass(frozen=True)
class Drawing:
    """A figure. name: its file name without suffix; caption: what it shows, and for how many samples."""

    name: str
    caption: str
    figure: Figure


@dataclass(frozen=True)
class Section:
    """A section of the report: a title, a sentence with the main result, then paragraphs, drawings and tables."""

    key: str
    title: str
    lead: str
    body: tuple[str | Drawing | Table, ...] = ()

    @property
    def drawings(self) -> tuple[Drawing, ...]:
        """The figures of the section, in order."""
        return tuple(block for block in self.body if isinstance(block, Drawing))

    def numbers(self) -> Iterator[Number]:
        """Every number shown in the tables of the section, in order."""
        for block in self.body:
            if isinstance(block, Table):
                for row in block.rows:
                    yield from (cell for cell in row if isinstance(cell, Number))


@dataclass(frozen=True)
class Headline:
    """The top of the page: the campaign, the verdict as a word and as a sentence, and facts as (label, cell).

    outcomes: (label, count), whose sum is the total; kind: of the report; total_label: what the total counts.
    """

    name: str
    description: str
    verdict: Mark
    sentence: str
    facts: tuple[tuple[str, Cell], ...]
    outcomes: tuple[tuple[str, int], ...]
    kind: str = "Monte-Carlo campaign report"
    total_label: str = "requested"

    @property
    def total(self) -> int:
        """The sum of the outcomes."""
        return sum(number for _, number in self.outcomes)
