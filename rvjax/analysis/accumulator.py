"""RunAccumulator: the samples of a run as they come, into all that its report and its verdicts need."""

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
    """Totals and verdicts of a run, chunk by chunk, in any order: from a folder, or beside the flying."""

    def __init__(self, require: Iterable[Requirement], basis: SamplingDesign, keep: Keep | None = None) -> None:
        self.totals = Totals(keep)
        self._tallies = tallies(basis, require)
        self._extract = Extract()
        self._needed: list[str] | None = None

    def add(self, chunk: int, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Takes in the table of one chunk, which must not be changed afterwards.

        FolderError where it does not fit the others or was taken in before, UsageError where it lacks what is required.
        """
        self.totals.add(chunk, frame, columns)
        self._tallies.add(frame, columns)
        if self._needed is None:
            self._needed = self._tallies.columns(list(columns))
        self._extract.add(chunk, frame, self._needed)

    def extract(self, chunks: Sequence[Entry]) -> bytes | None:
        """The columns that the requirements look at, of these chunks, as a file; None where not all of them were taken in."""
        return self._extract.encoded(chunks)

    @property
    def decided(self) -> bool:
        """Whether every requirement is decided by a sequential method, so that no further sample is needed."""
        return self._tallies.decided()

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """On each requirement, from the samples taken in so far."""
        return self._tallies.verdicts()
