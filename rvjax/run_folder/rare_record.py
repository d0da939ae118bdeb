"""The record of a search of rare failures, `rare.json` in the folder `rare-N` of a run, for requirement N.

Verdict and report are made from this record; the flights beside it show how it came about.
"""

from __future__ import annotations

from typing import Literal

from rvjax.places import Place
from rvjax.run_folder import search_records
from rvjax.run_folder.search_records import RecordPart
from rvjax.run_folder.storages import storage_of

NAME = "rare.json"
FAILING, POINTS = "failing.yaml", "failing.csv"
"""The campaign that flies failing flights again, and their points."""
FORMAT = 1


def folder_of(number: int) -> str:
    """The folder of the search for a requirement, inside the run folder. number: from 1."""
    return f"rare-{number}"


class Interval(RecordPart):
    """A value and its interval."""

    value: float
    low: float
    high: float


class Level(RecordPart):
    """A level of the margin; 0: failure. share: of the states at the level above that are below it. accepted: share of the moves
    that led to it; None at the first. count: ordinary flights below it. counted, split: its probability by counting them and by
    splitting, each with an interval that holds for all levels together at 99 %. agrees: the two have a number in common."""

    level: float
    share: float
    accepted: float | None
    count: int
    counted: Interval
    split: Interval
    agrees: bool


class Moved(RecordPart):
    """A coordinate of the draws with its mean and its standard deviation among the flights of a region, in σ; 0 and 1 for all."""

    name: str
    mean: float
    deviation: float


class Region(RecordPart):
    """Failing flights whose points are near each other. points: number; share: of all failing points. distance: |z| of the most
    probable one, whose margin and draws are given. moved: the coordinates that tell its flights from all. sample: of the most
    probable one in the campaign of failing flights."""

    points: int
    share: float
    distance: float
    margin: float
    outcome: str
    draws: dict[str, float]
    moved: list[Moved]
    sample: int


class Weights(RecordPart):
    """Importance sampling. coordinates: names of the tilted ones; parts: of the mixture; blocks: unbiased estimates."""

    flights: int
    failing: int
    effective: float
    largest: float
    shape: float
    coordinates: list[str]
    parts: int
    blocks: list[float]


class RareRecord(RecordPart):
    """method: splitting or importance. dimension: of the draws. chains, states: of a level of a replicate. reached: whether the
    first pass reached failures. learning: flights of the first pass; flights: of all passes. replicates: unbiased estimates by
    splitting. ordinary, failing: samples of the run, and those that fail. refusals: why the estimate is not to be trusted."""

    format: int = FORMAT
    requirement: int
    condition: str
    method: Literal["splitting", "importance"]
    seed: int
    dimension: int
    chains: int
    states: int
    reached: bool
    learning: int
    flights: int
    replicates: list[float]
    levels: list[Level]
    ordinary: int
    failing: int
    weights: Weights | None
    refusals: list[str]
    regions: list[Region]

    @property
    def estimates(self) -> list[float]:
        """The unbiased estimates of the method."""
        return self.replicates if self.weights is None else self.weights.blocks


def read(folder: Place | str, number: int) -> RareRecord | None:
    """The record of a finished search in a run folder; None where there is none. FolderError if the file was changed."""
    return read_from(storage_of(folder).place / folder_of(number))


def read_from(place: Place) -> RareRecord | None:
    """The record in the folder of a search; None where there is none. FolderError if the file was changed."""
    return search_records.read(storage_of(place), NAME, RareRecord, "rvjax run")
