"""What a report is made of: sections of paragraphs, drawings and tables, whose cells are numbers, text or verdicts.

A section says *what* is shown; `rvjax.report` says how it looks in HTML and in Markdown. Every number that is an
estimate travels as a `Number` with its interval, so the page and `summary.json` cannot differ.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from matplotlib.figure import Figure

from rvjax.stats import Estimate
from rvjax.stats.sampling_design import Observed


@dataclass(frozen=True)
class Number:
    """One number of the report: an estimate with its interval, what was observed, or a count.

    `name` is its key in `summary.json`; `value` is in SI `unit` ("1" = dimensionless); `percent` shows a share in %.
    """

    name: str
    value: Estimate | Observed | int
    unit: str = "1"
    percent: bool = False

    @property
    def estimate(self) -> Estimate | Observed:
        """The value of a number that is no count."""
        if isinstance(self.value, int):
            raise TypeError(f"{self.name} is a count")
        return self.value


@dataclass(frozen=True)
class Code:
    """Text to be typed or compared letter by letter: a command, a hash, a column name."""

    text: str


@dataclass(frozen=True)
class Mark:
    """A verdict or an outcome: shown as its word, and in its colour."""

    word: str


@dataclass(frozen=True)
class Named:
    """A row's name with one line saying what it means."""

    name: str
    meaning: str


Cell = str | Number | Code | Mark | Named


@dataclass(frozen=True)
class Table:
    """Rows of cells under a head; every row has as many cells as the head."""

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


@dataclass(frozen=True)
class Drawing:
    """A figure: `name` is its file name without suffix, `caption` says what is drawn and how many samples are in it."""

    name: str
    caption: str
    figure: Figure


@dataclass(frozen=True)
class Section:
    """A chapter of the report: a title, one sentence with what it found, then paragraphs, drawings and tables."""

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
    """The top of the page: the campaign, the verdict in one word and one sentence, and facts as label and cell.

    kind: of report; outcomes add up to all that were `whole`.
    """

    name: str
    description: str
    verdict: Mark
    sentence: str
    facts: tuple[tuple[str, Cell], ...]
    outcomes: tuple[tuple[str, int], ...]
    kind: str = "Monte-Carlo campaign report"
    whole: str = "requested"

    @property
    def requested(self) -> int:
        """How many samples the outcomes account for."""
        return sum(number for _, number in self.outcomes)
