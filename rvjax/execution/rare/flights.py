"""The flights of a search of rare failures: points ─chunks of LANES→ flights → margins, kept in the folder of the search.

A search asks for the same points in the same order whenever it runs, because it is a function of its seed and of the margins. So
a search that was killed is resumed by running it again: chunks that the folder holds are read, the others are flown.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable

import numpy as np
import pandas as pd

from rvjax.columns import Column
from rvjax.errors import FolderError
from rvjax.execution.draw_space import DrawSpace
from rvjax.execution.executors.threads import map_in_threads
from rvjax.run_folder import DataFile, RunFolder
from rvjax.run_folder.entry import Key
from rvjax.simulation.batch import LANES
from rvjax.stats.rare.points import Points, Values

MARGIN = Column("search.margin", "1", "margin of the requirement; 0 or below: the flight fails")
POINTS = Column("search.points", "", "of the chunk's points: the beginning of their SHA-256, as a number")


class RareFlights:
    """Every flight of a search. on_flights: called with the number of flights so far, after each chunk."""

    def __init__(self, space: DrawSpace, folder: RunFolder, on_flights: Callable[[int], None], look: Callable[[], None]) -> None:
        self._space, self._folder, self._on_flights, self._look = space, folder, on_flights, look
        self._chunks = 0
        self.flights = 0

    def margin(self, points: Points) -> Values:
        """(n,) margins of n points, flown or read; on the disk on return."""
        chunks = [points.rows(np.arange(first, min(first + LANES, len(points)))) for first in range(0, len(points), LANES)]
        begin, self._chunks = self._chunks, self._chunks + len(chunks)
        self._folder.grow(max(self._folder.requested, self._chunks * LANES))
        absent = set(self._folder.missing(self._chunks))
        todo = [(number, chunk) for number, chunk in enumerate(chunks, begin) if number in absent]
        margins: dict[int, Values] = {}

        def enter(number: int) -> None:
            chunk = chunks[number - begin]
            for _, table, _ in self._folder.tables([number]):
                margins[number] = self._checked(number, chunk, table)
            self.flights += len(chunk)
            self._on_flights(self.flights)

        def keep(file: DataFile) -> None:
            self._folder.take(file)
            enter(file.entry.number)

        for number in range(begin, self._chunks):
            if number not in absent:
                enter(number)
        map_in_threads(lambda order: self._fly(*order), todo, keep, self._space.flyer.stop, self._look)
        return np.concatenate([margins[number] for number in range(begin, self._chunks)])

    def _fly(self, number: int, points: Points) -> DataFile:
        """Flies a chunk and encodes its table; the lanes after its last point repeat the first and are flown, but not counted."""
        _, frame = self._space.fly_chunk(points.z, points.keys, number)
        table = pd.DataFrame(
            {
                "sample": np.arange(number * LANES, (number + 1) * LANES, dtype=np.int64),
                "outcome": frame["outcome"],
                MARGIN.name: self._space.failure_margins(frame),
                POINTS.name: np.full(LANES, _mark(points), dtype=np.int64),
            }
        )
        return DataFile.of(Key("samples", number), table, {MARGIN.name: MARGIN, POINTS.name: POINTS}, self._folder.digest)

    def _checked(self, number: int, points: Points, table: pd.DataFrame) -> Values:
        if len(table) != LANES or int(table[POINTS.name].iloc[0]) != _mark(points):
            raise FolderError(
                f"{self._folder.path}: chunk {number} is of other points than this search asks for; "
                "search again with another --out"
            )
        return table[MARGIN.name].to_numpy(dtype=np.float64)[: len(points)]


def _mark(points: Points) -> int:
    """Of the points and the keys of their noise."""
    data = np.ascontiguousarray(points.z).tobytes() + np.ascontiguousarray(points.keys).tobytes()
    return int(hashlib.sha256(data).hexdigest()[:12], 16)
