"""The flights of candidates: candidates × samples as lanes of the same compiled program.

    (candidate, sample), … ─chunks of LANES→ Draws of each candidate ─beside each other→ Drawn ─fly→ rows of the search's table

Numbers fly in lanes, so candidates that differ in numbers share a program. Candidates that differ in functions need programs of
their kind, candidates that differ in the number of steps separate chunks. A flight is a function of its candidate and its sample
alone. So a resumed search asks for the same chunks in the same order, and does not fly those that the folder holds.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import jax
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.campaign.tuning_parameters import Value
from rvjax.columns import Column, draw_column, metric_column
from rvjax.components.search_methods.interface import Spent
from rvjax.errors import CampaignError, FolderError
from rvjax.execution.chunks import STRETCH
from rvjax.execution.executors.threads import map_in_threads
from rvjax.run_folder import DataFile, RunFolder
from rvjax.run_folder.entry import Key
from rvjax.search.tuning.space import Space
from rvjax.simulation import tables
from rvjax.simulation.batch import LANES, Flyer, devices
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem

CANDIDATE = Column("search.candidate", "", "number of the candidate; 0: the original campaign")
SAMPLE = Column("search.sample", "", "number of the sample of the search that it flew")
VALUES = Column("search.values", "", "of the candidate's values: the beginning of their SHA-256, as a number")
ALWAYS = (metric_column("captured"),)

Row = tuple[int, int]
"""A candidate and a sample."""


@dataclass(frozen=True)
class Candidate:
    """values: of the parameters; point: where it was proposed; problem: the campaign with them, None where it refuses them."""

    number: int
    values: dict[str, Value]
    point: NDArray[np.float64] | None
    problem: Problem | None

    @cached_property
    def mark(self) -> int:
        """Of the values."""
        return int(hashlib.sha256(_key(self.values).encode()).hexdigest()[:12], 16)


class Flights:
    """Every flight of a search, and the folder that keeps them. columns: of the table, beside sample and outcome."""

    def __init__(self, space: Space, folder: RunFolder, columns: Sequence[str], most: float) -> None:
        self.space, self._folder, self._columns = space, folder, list(dict.fromkeys((*columns, *ALWAYS)))
        self.candidates = [Candidate(0, space.original, None, space.problem)]
        self._numbers: dict[str, int] = {}
        self._flown: dict[int, dict[int, int]] = {}
        self._rows: list[pd.DataFrame] = []
        self._flyers: dict[str, Flyer] = {}
        self._structures: set[str] = set()
        self._chunks = 0
        self._most = most
        self.flights = 0

    @property
    def programs(self) -> int:
        """Number of programs: each set of functions has its program."""
        return len(self._structures)

    @property
    def lanes(self) -> int:
        """How many lanes have flown, those with nothing new among them."""
        return self._chunks * LANES

    def number(self, values: dict[str, Value], point: NDArray[np.float64]) -> int:
        """The candidate with these values; a new candidate where there is none."""
        key = _key(values)
        if key not in self._numbers:
            self._numbers[key] = len(self.candidates)
            self.candidates.append(Candidate(len(self.candidates), values, point, self.problem_at(values)))
        return self._numbers[key]

    def problem_at(self, values: dict[str, Value]) -> Problem | None:
        """The campaign with these values; None where it refuses them."""
        try:
            return self.space.load(values)
        except CampaignError:
            return None

    def knows(self, point: NDArray[np.float64]) -> bool:
        """Whether a candidate has the values of this point."""
        return _key(self.space.values(point)) in self._numbers

    def refused(self, candidate: int) -> bool:
        """Whether the campaign does not accept its values."""
        return self.candidates[candidate].problem is None

    def _todo(self, candidates: Sequence[int], samples: NDArray[np.int64]) -> list[Row]:
        return [(candidate, int(k)) for candidate in candidates for k in samples if int(k) not in self._flown.get(candidate, {})]

    def affordable(self, candidates: Sequence[int], samples: NDArray[np.int64]) -> list[int]:
        """The first of the candidates that the budget allows to fly these samples."""
        left, fit = self._most - self.flights, list[int]()
        for candidate in candidates:
            left -= len(self._todo([candidate], samples)) * (candidate != 0)
            if left < 0:
                break
            fit.append(candidate)
        return fit

    def spend(self, flights: int) -> None:
        """Counts flights that no candidate has a row of. Spent where that is more than the budget allows."""
        if self.flights + flights > self._most:
            raise Spent
        self.flights += flights

    def fly(self, candidates: Sequence[int], samples: NDArray[np.int64]) -> None:
        """Flies what of it has not been flown; on the disk on return. Spent where that is more than the budget allows."""
        todo = self._todo(candidates, samples)
        if not todo:
            return
        self.spend(sum(candidate != 0 for candidate, _ in todo))
        groups: dict[tuple[str, int], list[Row]] = {}
        for row in todo:
            problem = self._problem(row[0])
            self._structures.add(problem.structure)
            groups.setdefault((problem.structure, problem.spec.horizon.steps), []).append(row)
        chunks = [chunk for rows in groups.values() for chunk in _chunks(rows)]
        first, self._chunks = self._chunks, self._chunks + len(chunks)
        self._folder.grow(max(self._folder.requested, self._chunks * LANES))
        absent = set(self._folder.missing(self._chunks))
        orders = [(number, chunk) for number, chunk in enumerate(chunks, first) if number in absent]
        known = {number: table for number, table, _ in self._folder.tables(sorted(set(range(first, self._chunks)) - absent))}

        def keep(file: DataFile) -> None:
            self._folder.take(file)
            known.update((number, table) for number, table, _ in self._folder.tables([file.entry.number]))

        map_in_threads(lambda order: self._chunk(*order), orders, keep, self.stop)
        for number, chunk in enumerate(chunks, first):
            self._enter(number, chunk, known[number])

    def table(self, candidate: int, samples: NDArray[np.int64]) -> pd.DataFrame:
        """Its flights of these samples, in their order."""
        flown = self._flown[candidate]
        places = np.array([flown[int(k)] for k in samples])
        chunks, rows = np.divmod(places, LANES)
        frame = pd.concat([self._rows[chunk].iloc[rows[chunks == chunk]] for chunk in dict.fromkeys(chunks.tolist())])
        order = np.concatenate([np.flatnonzero(chunks == chunk) for chunk in dict.fromkeys(chunks.tolist())])
        return frame.iloc[np.argsort(order)].reset_index(drop=True)

    def samples(self, candidate: int) -> NDArray[np.int64]:
        """The samples that it has flown, ascending."""
        return np.array(sorted(self._flown.get(candidate, {})), dtype=np.int64)

    def stop(self) -> None:
        """Ends every flight soon."""
        for flyer in list(self._flyers.values()):
            flyer.stop()

    def _problem(self, candidate: int) -> Problem:
        problem = self.candidates[candidate].problem
        assert problem is not None, "a candidate that is refused does not fly"
        return problem

    def _enter(self, number: int, chunk: Sequence[Row], table: pd.DataFrame) -> None:
        """Takes in a chunk's table, which must be of the rows that are wanted."""
        names = (CANDIDATE.name, VALUES.name, SAMPLE.name)
        rows = list(zip(*(table[name].tolist() for name in names), strict=True))
        if rows != [(candidate, self.candidates[candidate].mark, sample) for candidate, sample in chunk]:
            raise FolderError(
                f"{self._folder.path}: chunk {number} is of other candidates than this search asks for; "
                "tune again with another --out"
            )
        assert len(self._rows) == number, "chunks come in their order"
        self._rows.append(table)
        for place, (candidate, sample) in enumerate(chunk):
            self._flown.setdefault(candidate, {}).setdefault(sample, number * LANES + place)

    def _chunk(self, number: int, rows: Sequence[Row]) -> DataFile:
        """Flies a chunk and encodes its tables."""
        parts = [(self._problem(run), np.array(samples, dtype=np.int64)) for run, samples in _runs(rows)]
        draws = [Draws.of(problem, samples) for problem, samples in parts]
        drawn = jax.tree.map(lambda *leaves: np.concatenate(leaves), *(numbers for _, numbers in draws))
        problem, place = parts[0][0], devices()[number % len(devices())]
        flown = self._flyer(problem).fly(drawn, problem.spec.horizon.steps, STRETCH, device=place)
        duration = np.concatenate([np.full(len(samples), problem.spec.horizon.duration_s) for problem, samples in parts])
        came = tables.outcomes(flown, duration, problem.metrics)
        drawn = {draw_column(name): [table.values[name] for table, _ in draws] for name in draws[0][0].values}
        came |= {name: np.concatenate(values) for name, values in drawn.items() if name in self._columns}
        frame = pd.DataFrame(
            {
                "sample": np.arange(number * LANES, number * LANES + len(rows), dtype=np.int64),
                "outcome": came["outcome"],
                CANDIDATE.name: np.array([row for row, _ in rows], dtype=np.int64),
                VALUES.name: np.array([self.candidates[row].mark for row, _ in rows], dtype=np.int64),
                SAMPLE.name: np.array([sample for _, sample in rows], dtype=np.int64),
            }
            | {name: came[name] for name in self._columns}
        )
        known = {metric_column(name): column for name, column in problem.metric_columns.items()}
        known |= {draw_column(name): column for name, column in draws[0][0].columns.items()}
        columns = {column.name: column for column in (CANDIDATE, VALUES, SAMPLE)} | {name: known[name] for name in self._columns}
        return DataFile.of(Key("samples", number), frame, columns, self._folder.digest)

    def _flyer(self, problem: Problem) -> Flyer:
        return self._flyers.setdefault(problem.structure, Flyer.of(problem))


def _key(values: dict[str, Value]) -> str:
    """Equal for equal values."""
    return json.dumps(values, sort_keys=True)


def _chunks(rows: Sequence[Row]) -> Iterator[list[Row]]:
    """Chunks of LANES rows; the last chunk is filled with its first rows again, which count once."""
    for first in range(0, len(rows), LANES):
        chunk = list(rows[first : first + LANES])
        yield [*chunk, *(rows[k % len(rows)] for k in range(LANES - len(chunk)))]


def _runs(rows: Sequence[Row]) -> Iterator[tuple[int, list[int]]]:
    """The samples of each candidate in neighbouring rows."""
    first = 0
    while first < len(rows):
        candidate, behind = rows[first][0], first
        while behind < len(rows) and rows[behind][0] == candidate:
            behind += 1
        yield candidate, [sample for _, sample in rows[first:behind]]
        first = behind
