"""RunAccumulator: collects from the samples of a run all that its report and its verdicts need."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import pandas as pd

from rvjax.analysis.run_totals import Totals
from rvjax.analysis.verdicts import Verdict, tallies
from rvjax.campaign import Keep, Requirement
from rvjax.campaign.requirement import TRACED
from rvjax.columns import Column
from rvjax.errors import DamagedError
from rvjax.run_folder.entries import EntryRows
from rvjax.run_folder.manifest import json_bytes
from rvjax.run_folder.named_arrays import Record
from rvjax.run_folder.verdict_columns import Extract
from rvjax.stats.sampling_design import SamplingDesign

FORMAT = "rvjax totals 2"
"""What encoded totals call themselves; another number where their contents have another meaning."""


class RunAccumulator:
    """Totals and verdicts of a run, chunk by chunk in any order, from a folder or during the flights.

    Chunks may be added in several accumulators, in several processes, which are merged: the result is the same, bit for bit.
    """

    def __init__(self, require: Iterable[Requirement], design: SamplingDesign, keep: Keep | None = None) -> None:
        self._made_of = tuple(require), design, keep
        self.totals = Totals(keep)
        self._tallies = tallies(design, self._made_of[0])
        self._extract = Extract()
        self._needed: list[str] | None = None
        self._purpose = _purpose(self._made_of[0], design, self.totals.keep)

    def add(self, chunk: int, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Adds the table of a chunk; the table must not be changed afterwards.

        FolderError if it does not fit the other chunks or was added before, UsageError if it lacks a required column.
        """
        self.totals.add(chunk, frame, columns)
        self._tallies.add(frame, columns)
        self._extract.add(chunk, frame, self._names(columns))

    def __contains__(self, chunk: int) -> bool:
        """Whether a chunk was added."""
        return chunk in self.totals

    def _names(self, columns: Mapping[str, Column]) -> list[str]:
        """The columns that the requirements need."""
        if self._needed is None:
            self._needed = self._tallies.columns(list(columns))
        return self._needed

    def merge(self, other: RunAccumulator) -> None:
        """Adds the chunks of another accumulator of the same requirements, which must not be used afterwards.

        FolderError if they do not fit the chunks here or were added before; then nothing has changed.
        """
        if other._purpose != self._purpose:
            raise ValueError("accumulators of different requirements cannot be merged")
        if not other.totals.n:
            return
        self.totals.merge(other.totals)
        self._names(self.totals.columns)
        self._tallies.prepare(self.totals.columns)
        self._tallies.merge(other._tallies)  # pyright: ignore[reportArgumentType]  # of one design, so of one type
        self._extract.merge(other._extract)

    def encode(self) -> bytes:
        """All of it as bytes. The same chunks give the same bytes, in whatever order and grouping they came."""
        parts = {"totals": self.totals.record(), "tallies": self._tallies.record(), "extract": self._extract.record()}
        return Record.joined(parts, format=FORMAT, purpose=self._purpose).encode()

    @classmethod
    def decode(
        cls, data: bytes, require: Iterable[Requirement], design: SamplingDesign, keep: Keep | None = None
    ) -> RunAccumulator:
        """As `decoded`, for these requirements, design and kept flights."""
        return cls(require, design, keep).decoded(data)

    def decoded(self, data: bytes) -> RunAccumulator:
        """The accumulator that `encode` made these bytes of, for the same requirements, design and kept flights as this one.

        DamagedError if the bytes are not such totals, are of other requirements, or contradict themselves.
        """
        accumulator = RunAccumulator(*self._made_of)
        try:
            record = Record.decode(data)
            if (found := record.document.get("format")) != FORMAT:
                raise ValueError(f"the format is {found!r}; accepted: {FORMAT!r}")
            if record.document["purpose"] != accumulator._purpose:
                raise ValueError("they were made for other requirements, another sampling design or other kept flights")
            accumulator._restore(record)
        except (ValueError, KeyError, TypeError, AttributeError, IndexError, OSError) as error:
            raise DamagedError(f"encoded totals cannot be used: {error}; accumulate the chunks again") from error
        return accumulator

    def _restore(self, record: Record) -> None:
        self.totals = Totals.of(record.part("totals"), self.totals.keep)
        names = self._names(self.totals.columns) if self.totals.n else []
        self._extract = Extract.of(record.part("extract"), names)
        if self.totals.n != self._extract.n:
            raise ValueError(f"{self.totals.n} samples, but {self._extract.n} in the extract")
        if self.totals.n:
            self._tallies.restore(record.part("tallies"), self.totals.columns, self.totals.firsts)

    def extract(self, chunks: EntryRows) -> bytes | None:
        """The columns of the requirements in these chunks, as a file; None unless all of the chunks were added."""
        return self._extract.encoded(chunks)

    @property
    def decided(self) -> bool:
        """Whether every requirement is decided by a sequential method, so that no further sample is needed."""
        return self._tallies.decided()

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """The verdict on each requirement from the samples added so far."""
        return self._tallies.verdicts()


def _purpose(require: Sequence[Requirement], design: SamplingDesign, keep: Keep) -> str:
    """What totals are made for: with another purpose they have other contents."""
    models = [model.model_dump(mode="json", exclude=set(TRACED)) for model in (*require, keep)]
    laws = [repr(requirement.thinning) for requirement in require if requirement.thinning is not None]
    return json_bytes({"models": models, "laws": laws, "design": [type(design).__name__, design.sentence]}).decode()
