"""Tallies: the counts of a run that its requirements are judged by."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import singledispatch
from typing import TYPE_CHECKING

from rvjax.analysis.verdicts.mean_tally import MeanTally
from rvjax.analysis.verdicts.share_tally import ShareTally
from rvjax.columns import Column
from rvjax.errors import UsageError
from rvjax.run_folder import Samples
from rvjax.run_folder.named_arrays import Record
from rvjax.stats.sampling_design import Exploration, Independent, SamplingDesign

if TYPE_CHECKING:
    import pandas as pd

    from rvjax.analysis.verdicts.verdict import Verdict
    from rvjax.campaign import Requirement


class Tallies:
    """Counts independent samples for several requirements, chunk by chunk in any order."""

    def __init__(self, requirements: Iterable[Requirement], design: Independent) -> None:
        self._tallies = tuple(
            MeanTally(requirement) if requirement.mean else ShareTally(requirement, design) for requirement in requirements
        )

    def columns(self, names: Sequence[str]) -> list[str]:
        """The columns that the requirements need of a table. UsageError names every metric, channel or draw it lacks."""
        needed: dict[str, None] = {}
        complaints: list[str] = []
        for tally in self._tallies:
            try:
                needed |= dict.fromkeys(tally.evaluator.columns(names))
            except UsageError as error:
                complaints.append(str(error))
        if complaints:
            raise UsageError("\n".join(complaints))
        return list(needed)

    def add(self, frame: pd.DataFrame, columns: Mapping[str, Column], begins: Sequence[int] = (0,)) -> None:
        """Counts the samples of a table of chunks, which begin at the rows `begins`.

        UsageError names every metric, channel or draw that the table lacks.
        """
        complaints: list[str] = []
        for tally in self._tallies:
            try:
                tally.add(frame, columns, begins)
            except UsageError as error:
                complaints.append(str(error))
        if complaints:
            raise UsageError("\n".join(complaints))

    def prepare(self, columns: Mapping[str, Column]) -> None:
        """Learns what `add` would learn from a table with these columns."""
        for tally in self._tallies:
            tally.evaluator.prepare(columns)

    def merge(self, other: Tallies) -> None:
        """Counts the samples of other tallies of the same requirements; no chunk may be in both."""
        for tally, others in zip(self._tallies, other._tallies, strict=True):
            tally.merge(others)  # pyright: ignore[reportArgumentType]  # of the same requirement, so of the same type

    def record(self) -> Record:
        """All counts, for `restore`."""
        return Record.joined({str(place): tally.record() for place, tally in enumerate(self._tallies)})

    def restore(self, record: Record, columns: Mapping[str, Column], firsts: Sequence[int]) -> None:
        """Takes over the counts of a record; only where nothing was counted. columns, firsts: those of the table that was
        counted, and the first samples of its chunks. ValueError or KeyError if the record contradicts itself or these."""
        self.prepare(columns)
        for place, tally in enumerate(self._tallies):
            tally.restore(record.part(str(place)), firsts)

    def decided(self) -> bool:
        """Whether every requirement is decided, so that no further sample is needed."""
        return bool(self._tallies) and all(tally.decided() for tally in self._tallies)

    def verdicts(self) -> tuple[Verdict, ...]:
        """The verdict on each requirement from the samples counted so far."""
        return tuple(tally.verdict() for tally in self._tallies)


class Unjudged:
    """Samples that cannot be judged, such as explorations. UsageError if the campaign has requirements."""

    def __init__(self, requirements: Iterable[Requirement], design: Exploration) -> None:
        if any(True for _ in requirements):
            raise UsageError(f"{design.sentence}; accepted: a campaign without requirements, or sampler: {{use: monte-carlo}}")

    def columns(self, names: Sequence[str]) -> list[str]:
        """No column is needed."""
        return []

    def add(self, frame: pd.DataFrame, columns: Mapping[str, Column], begins: Sequence[int] = (0,)) -> None:
        """Counts nothing."""

    def prepare(self, columns: Mapping[str, Column]) -> None:
        """Learns nothing."""

    def merge(self, other: Unjudged) -> None:
        """Merges nothing."""

    def record(self) -> Record:
        """Empty."""
        return Record()

    def restore(self, record: Record, columns: Mapping[str, Column], firsts: Sequence[int]) -> None:
        """Takes over nothing."""

    def decided(self) -> bool:
        """Never decided."""
        return False

    def verdicts(self) -> tuple[Verdict, ...]:
        """There are no verdicts."""
        return ()


@singledispatch
def tallies(design: SamplingDesign, requirements: Iterable[Requirement]) -> Tallies | Unjudged:
    """The tallies of samples from a sampling design; only independent samples are judged."""
    raise TypeError(f"internal error (a bug in rvjax): unknown sampling design {design}")


@tallies.register(Independent)
def _(design: Independent, requirements: Iterable[Requirement]) -> Tallies:
    return Tallies(requirements, design)


@tallies.register(Exploration)
def _(design: Exploration, requirements: Iterable[Requirement]) -> Unjudged:
    return Unjudged(requirements, design)


def judge(requirement: Requirement, table: Samples | pd.DataFrame, design: Independent) -> Verdict:
    """The verdict from a table of independent samples. UsageError if the table lacks the metric or channel."""
    return judge_all([requirement], table, design)[0]


def judge_all(requirements: Iterable[Requirement], table: Samples | pd.DataFrame, design: Independent) -> tuple[Verdict, ...]:
    """The verdict on each requirement. UsageError names every metric or channel that the table lacks."""
    counted = Tallies(requirements, design)
    if isinstance(table, Samples):
        counted.add(table.frame, table.columns)
    else:
        counted.add(table, {})
    return counted.verdicts()
