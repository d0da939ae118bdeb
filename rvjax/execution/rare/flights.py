"""The flights of a search of rare failures: points ─chunks of LANES→ flights → margins, kept in the folder of the search.

A search asks for the same points in the same order whenever it runs, because it is a function of its seed and of the margins. So
a search that was killed is resumed by running it again: chunks that the folder holds are read, the others are flown.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

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

GROWTH = 256
"""Chunks by which the folder of a search grows; growing writes its manifest."""


class RareFlights:
    """Every flight of a search; within a `with` statement, at whose end all of them are on the disk. on_flights: called with the
    number of flights so far, after each chunk."""

    def __init__(self, space: DrawSpace, folder: RunFolder, on_flights: Callable[[int], None], look: Callable[[], None]) -> None:
        self._space, self._folder, self._on_flights, self._look = space, folder, on_flights, look
        held = folder.requested // LANES
        self._held = set(range(held)) - set(folder.missing(held))
        self._writer, self._writing = ThreadPoolExecutor(1), list[Future[None]]()
        self._chunks = 0
        self.flights = 0

    def __enter__(self) -> RareFlights:
        return self

    def __exit__(self, *raised: object) -> None:
        """Writes what was flown. Errors as in `RunFolder.take_all`."""
        self._writer.shutdown(wait=True)
        self._written()
        if raised == (None, None, None):
            self._folder.grow(max(1, self._chunks) * LANES)

    def margin(self, points: Points) -> Values:
        """(n,) margins of n points, flown or read. They are written while the next ones fly. Errors as in `RunFolder.take_all`,
        of these flights or of those before."""
        chunks = [points.rows(np.arange(first, min(first + LANES, len(points)))) for first in range(0, len(points), LANES)]
        begin, self._chunks = self._chunks, self._chunks + len(chunks)
        margins: dict[int, Values] = {}
        files: list[DataFile] = []

        def enter(number: int, values: Values) -> None:
            margins[number] = values[: len(chunks[number - begin])]
            self.flights += len(margins[number])
            self._on_flights(self.flights)

        def keep(flown: tuple[int, Values, DataFile]) -> None:
            files.append(flown[2])
            enter(*flown[:2])

        self._written(1)
        todo = list[tuple[int, Points]]()
        for number, chunk in enumerate(chunks, begin):
            if number in self._held:
                enter(number, self._read(number, chunk))
            else:
                todo.append((number, chunk))
        try:
            map_in_threads(lambda order: self._fly(*order), todo, keep, self._space.flyer.stop, self._look)
        finally:
            self._writing.append(self._writer.submit(self._write, files, self._chunks))
        return np.concatenate([margins[number] for number in range(begin, self._chunks)])

    def _write(self, files: list[DataFile], chunks: int) -> None:
        if chunks * LANES > self._folder.requested:
            self._folder.grow((chunks + GROWTH) * LANES)
        self._folder.take_all(files)

    def _written(self, most: int = 0) -> None:
        """Waits until at most `most` calls are not written. Errors as in `RunFolder.take_all`."""
        while len(self._writing) > most:
            self._writing.pop(0).result()

    def _fly(self, number: int, points: Points) -> tuple[int, Values, DataFile]:
        """Flies a chunk: its number, its margins, and its table of LANES rows. Those after its last point repeat the first, and
        are not counted."""
        _, frame = self._space.fly_chunk(points.z, points.keys, number)
        rows = np.arange(LANES)
        rows[len(points) :] = 0
        frame = frame.iloc[rows].reset_index(drop=True)
        margins = self._space.failure_margins(frame)
        table = pd.DataFrame(
            {
                "sample": np.arange(number * LANES, (number + 1) * LANES, dtype=np.int64),
                "outcome": frame["outcome"],
                MARGIN.name: margins,
                POINTS.name: np.full(LANES, _mark(points), dtype=np.int64),
            }
        )
        file = DataFile.of(Key("samples", number), table, {MARGIN.name: MARGIN, POINTS.name: POINTS}, self._folder.digest)
        return number, margins, file

    def _read(self, number: int, points: Points) -> Values:
        """The margins of a chunk that the folder holds."""
        self._written()
        _, table, _ = next(iter(self._folder.tables([number])))
        if len(table) != LANES or int(table[POINTS.name].iloc[0]) != _mark(points):
            raise FolderError(
                f"{self._folder.path}: chunk {number} is of other points than this search asks for; "
                "search again with another --out"
            )
        return table[MARGIN.name].to_numpy(dtype=np.float64)


def _mark(points: Points) -> int:
    """Of the points and the keys of their noise."""
    data = np.ascontiguousarray(points.z).tobytes() + np.ascontiguousarray(points.keys).tobytes()
    return int(hashlib.sha256(data).hexdigest()[:12], 16)
