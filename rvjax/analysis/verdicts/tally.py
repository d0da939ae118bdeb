"""The samples of a run, folded into what each requirement needs of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import singledispatch
from typing import TYPE_CHECKING

from rvjax.analysis.verdicts.mean_tally import MeanTally
from rvjax.analysis.verdicts.share_tally import ShareTally
from rvjax.columns import Column
from rvjax.errors import UsageError
from rvjax.run_folder import Samples
from rvjax.stats.sampling_design import Exploration, Independent, SamplingDesign

if TYPE_CHECKING:
    import pandas as pd

    from rvjax.analysis.verdicts.verdict import Verdict
    from rvjax.campaign import Requirement


class Tallies:
    """One fold of independent samples for several requirements, chunk by chunk in any order."""

    def __init__(self, requirements: Iterable[Requirement], basis: Independent) -> None:
        self._tallies = tuple(MeanTally(one) if one.mean else ShareTally(one, basis) for one in requirements)

    def columns(self, names: Sequence[str]) -> list[str]:
        """The columns that are needed of a table with these; UsageError names every metric, channel or draw that it lacks."""
        needed: dict[str, None] = {}
        complaints: list[str] = []
        for tally in self._tallies:
            try:
                needed |= dict.fromkeys(tally.reading.columns(names))
            except UsageError as error:
                complaints.append(str(error))
        if complaints:
            raise UsageError("\n".join(complaints))
        return list(needed)

    def add(self, frame: pd.DataFrame, columns: Mapping[str, Column], begins: Sequence[int] = (0,)) -> None:
        """Counts the samples of a chunk, or of several, which begin at these rows; UsageError names every metric, channel or
        draw that their table lacks."""
        complaints: list[str] = []
        for tally in self._tallies:
            try:
                tally.add(frame, columns, begins)
            except UsageError as error:
                complaints.append(str(error))
        if complaints:
            raise UsageError("\n".join(complaints))

    def decided(self) -> bool:
        """Whether every requirement is decided, so that no further sample is needed."""
        return bool(self._tallies) and all(tally.decided() for tally in self._tallies)

    def verdicts(self) -> tuple[Verdict, ...]:
        """What the samples counted so far say of each requirement."""
        return tuple(tally.verdict() for tally in self._tallies)


class Unjudged:
    """The fold of samples that no verdict can be issued on. UsageError where one is required of them."""

    def __init__(self, requirements: Iterable[Requirement], basis: Exploration) -> None:
        if any(True for _ in requirements):
            raise UsageError(f"{basis.sentence}; accepted: a campaign without requirements, or sampler: {{use: monte-carlo}}")

    def columns(self, names: Sequence[str]) -> list[str]:
        """None is needed."""
        return []

    def add(self, frame: pd.DataFrame, columns: Mapping[str, Column], begins: Sequence[int] = (0,)) -> None:
        """Counts nothing."""

    def decided(self) -> bool:
        """Never."""
        return False

    def verdicts(self) -> tuple[Verdict, ...]:
        """None."""
        return ()


@singledispatch
def tallies(basis: SamplingDesign, requirements: Iterable[Requirement]) -> Tallies | Unjudged:
    """The fold of samples that stand on a basis: one that judges only if they are independent."""
    raise TypeError(f"{basis} is no basis")


@tallies.register(Independent)
def _(basis: Independent, requirements: Iterable[Requirement]) -> Tallies:
    return Tallies(requirements, basis)


@tallies.register(Exploration)
def _(basis: Exploration, requirements: Iterable[Requirement]) -> Unjudged:
    return Unjudged(requirements, basis)


def judge(requirement: Requirement, table: Samples | pd.DataFrame, basis: Independent) -> Verdict:
    """The verdict of a table of independent samples; UsageError where the table lacks the requirement's metric or channel."""
    return judge_all([requirement], table, basis)[0]


def judge_all(requirements: Iterable[Requirement], table: Samples | pd.DataFrame, basis: Independent) -> tuple[Verdict, ...]:
    """The verdict on each requirement; UsageError names every metric or channel that the table lacks."""
    counted = Tallies(requirements, basis)
    if isinstance(table, Samples):
        counted.add(table.frame, table.columns)
    else:
        counted.add(table, {})
    return counted.verdicts()
