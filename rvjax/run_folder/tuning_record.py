"""The record of a search in `search.json` of its folder: the candidates, their results and the confirmation.

The report of a tuning is made from this record alone.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from rvjax.campaign.tuning_parameters import Value
from rvjax.places import Place
from rvjax.run_folder import search_records
from rvjax.run_folder.search_records import RecordPart
from rvjax.run_folder.storages import storage_of

NAME = "search.json"
TABLE = "candidates.csv"
BEST = "best.yaml"
TUNED, ORIGINAL = "tuned", "own"
"""Folders of the two confirming runs: the best candidate and the original campaign."""
FORMAT = 1

Left = Literal["", "refused", "test", "halving", "budget"]


class Axis(RecordPart):
    """A parameter: its range in words, its original value (`own`) and its best value. free: it has a coordinate."""

    name: str
    range: str
    free: bool
    scale: Literal["linear", "log", "levels"]
    own: Value | None
    best: Value | None


class Measured(RecordPart):
    """An objective in words, its unit, whether it should be large, whether it is a share, and its weight in a sum."""

    text: str
    unit: str
    largest: bool
    share: bool
    weight: float


class Row(RecordPart):
    """A candidate.

    batch: the batch that proposed it; u: coordinates; values: of all parameters; round, samples: its last round and its samples;
    left: how it left the race; objectives: as shown; score: the compared numbers; first: the score after the first round.
    """

    candidate: int
    batch: int
    u: list[float]
    values: dict[str, Value]
    round: int
    samples: int
    left: Left
    violation: float
    objectives: list[float]
    score: list[float]
    first: list[float]


class Interval(RecordPart):
    """An estimate of a number with its interval."""

    value: float
    low: float
    high: float


class Confirmed(RecordPart):
    """An objective of the winner and of the original campaign (`own`), on fresh draws.

    difference: winner minus original, in pairs; searched: the winner's value on the draws of the search; optimism: how much
    better `searched` is than the value on fresh draws.
    """

    text: str
    unit: str
    share: bool
    searched: float
    tuned: float
    own: float
    difference: Interval
    optimism: float
    method: str
    verdict: Literal["better", "worse", "not told apart"]


class Kept(RecordPart):
    """A requirement: its verdicts for the winner and for the original campaign (`own`), on fresh draws.

    only_tuned, only_own: samples that comply only with the winner, only with the original; p_worse: McNemar's p-value. All three
    are None unless the requirement is on a share.
    """

    text: str
    tuned: str
    own: str
    only_tuned: int | None
    only_own: int | None
    p_worse: float | None


class Confirmation(RecordPart):
    """The confirmation on fresh draws. samples, seed: of these draws."""

    samples: int
    seed: int
    confidence: float
    objectives: list[Confirmed]
    requirements: list[Kept]


class Missed(RecordPart):
    """A requirement that a candidate does not meet on the samples of the search.

    observed, limit: shares of the samples if `share`, else the mean of the metric and its bound.
    """

    text: str
    observed: float
    limit: float
    share: bool
    unit: str


class Sensitivity(RecordPart):
    """The first-order share of the variance of the first objective's ranks, over the candidates, that a parameter explains."""

    name: str
    share: Interval
    p: float


class Cost(RecordPart):
    """The cost of a search in flights.

    flights: of candidates; own: of the original campaign; full: if every candidate had flown all samples; lanes: that flew;
    programs: compiled; sizes, begun, by_test, by_halving: of each round of the races.
    """

    flights: int
    own: int
    full: int
    lanes: int
    programs: int
    sizes: list[int]
    begun: list[int]
    by_test: list[int]
    by_halving: list[int]


class Searched(RecordPart):
    """The whole record.

    start: coordinates of the original campaign, empty if it is outside of the ranges. best: number of the best candidate, 0 for
    the original campaign; front: the best candidates of a goal with several objectives. closest, missed: where no candidate meets
    the requirements, the candidate that comes closest and what it misses; the best is then the original campaign.
    """

    format: Literal[1] = FORMAT
    name: str
    description: str
    method: str
    goal: str
    seed: int
    requirements: int
    parameters: list[Axis]
    start: list[float]
    objectives: list[Measured]
    rows: list[Row]
    best: int
    front: list[int]
    closest: int | None = None
    missed: list[Missed] = Field(default_factory=list[Missed])
    sensitivity: list[Sensitivity]
    cost: Cost
    confirmation: Confirmation | None

    @property
    def row(self) -> dict[int, Row]:
        """The candidates by their numbers."""
        return {row.candidate: row for row in self.rows}


def read(folder: str | Place) -> Searched | None:
    """Reads the record of a finished search; None if the search has not finished. FolderError if the file was changed."""
    return search_records.read(storage_of(folder), NAME, Searched, "rvjax tune")
