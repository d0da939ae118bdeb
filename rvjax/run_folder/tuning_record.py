"""What a search found, as it is kept in `search.json` of its folder: candidates, how each came out, the confirmation. No flights.

The report of a tuning is drawn from this alone.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, ValidationError

from rvjax.campaign.tuning_parameters import Value
from rvjax.errors import FolderError
from rvjax.run_folder import checksums

NAME = "search.json"
TABLE = "candidates.csv"
BEST = "best.yaml"
TUNED, OWN = "tuned", "own"
"""Folders of the two confirming runs."""
FORMAT = 1

Left = Literal["", "refused", "test", "halving", "budget"]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", ser_json_inf_nan="strings")


class Axis(_Part):
    """A parameter: its range in words, the campaign's own value and the best one. free: it has a coordinate of its own."""

    name: str
    range: str
    free: bool
    scale: Literal["linear", "log", "levels"]
    own: Value | None
    best: Value | None


class Measured(_Part):
    """An objective in words, its unit, whether it is to be large, whether it is a share, and its weight in a sum."""

    text: str
    unit: str
    largest: bool
    share: bool
    weight: float


class Row(_Part):
    """A candidate. batch: that proposed it; u: its coordinates; values: of all parameters; round, samples: the last that it flew;
    left: how it left; violation; objectives: each as it is shown; score: what is compared. first: score after the first round."""

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


class Interval(_Part):
    """An estimate of a number with its interval."""

    value: float
    low: float
    high: float


class Confirmed(_Part):
    """An objective of the winner and of the campaign as it is, on fresh draws. difference: winner minus own, in pairs; searched:
    of the winner on the draws that chose it; optimism: by how much that was too good."""

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


class Kept(_Part):
    """A requirement: verdicts of the winner and of the campaign as it is, on fresh draws, and of a share how many samples comply
    with one alone, with McNemar's p-value."""

    text: str
    tuned: str
    own: str
    only_tuned: int | None
    only_own: int | None
    p_worse: float | None


class Confirmation(_Part):
    """samples, seed: of the fresh draws."""

    samples: int
    seed: int
    confidence: float
    objectives: list[Confirmed]
    requirements: list[Kept]


class Sensitivity(_Part):
    """First-order share of the variance of the ranks of the first objective, over the candidates, that a parameter explains."""

    name: str
    share: Interval
    p: float


class Cost(_Part):
    """flights: of candidates; own: of the campaign as it is; full: as if every candidate had flown all samples; lanes: that flew;
    programs: compiled; sizes, begun, by_test, by_halving: of each round of the races."""

    flights: int
    own: int
    full: int
    lanes: int
    programs: int
    sizes: list[int]
    begun: list[int]
    by_test: list[int]
    by_halving: list[int]


class Searched(_Part):
    """Everything. start: the coordinates of the campaign as it is, none where it is outside of the ranges. best: number of the
    best candidate, 0 the campaign as it is; front: the best ones of a goal with several."""

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
    sensitivity: list[Sensitivity]
    cost: Cost
    confirmation: Confirmation | None

    def encode(self) -> bytes:
        """Strict JSON; numbers that are not finite as text."""
        return f"{self.model_dump_json(indent=1)}\n".encode()

    @property
    def row(self) -> dict[int, Row]:
        """The candidates by their numbers."""
        return {row.candidate: row for row in self.rows}


def read(folder: Path) -> Searched | None:
    """What a finished search found; None where it has not finished. FolderError where it was changed since."""
    if not (folder / NAME).exists():
        return None
    data = checksums.verified(folder, NAME)
    try:
        if data is None:
            raise ValueError("it is not what SHA256SUMS says")
        return Searched.model_validate_json(data)
    except (ValidationError, ValueError) as error:
        raise FolderError(
            f"{folder / NAME}: damaged or edited ({error}); `rvjax tune` with the same --out makes it again"
        ) from error
