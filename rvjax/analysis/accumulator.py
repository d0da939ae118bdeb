"""RunAccumulator: collects from the samples of a run all that its report and its verdicts need."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import pandas as pd

from rvjax.analysis.run_totals import Totals
from rvjax.analysis.verdicts import Verdict, tallies
from rvjax.campaign import Keep, Requirement
from rvjax.columns import Column
from rvjax.run_folder.manifest import Entry
from rvjax.run_folder.verdict_columns import Extract
from rvjax.stats.sampling_design import SamplingDesign


class RunAccumulator:
    """Totals and verdicts of a run, chunk by chunk in any order, from a folder or during the flights."""

    def __init__(self, require: Iterable[Requirement], design: SamplingDesign, keep: Keep | None = None) -> None:
        self.totals = Totals(keep)
        self._tallies = tallies(design, require)
        self._extract = Extract()
        self._needed: list[str] | None = None

    def add(self, chunk: int, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Adds the table of a chunk; the table must not be changed afterwards.

        FolderError if it does not fit the other chunks or was added before, UsageError if it lacks a required column.
        """
        self.totals.add(chunk, frame, columns)
        self._tallies.add(frame, columns)
        if self._needed is None:
            self._needed = self._tallies.columns(list(columns))
        self._extract.add(chunk, frame, self._needed)

    def extract(self, chunks: Sequence[Entry]) -> bytes | None:
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
