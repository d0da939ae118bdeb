"""Points of standard normal space with the key of their noise, and tasks that ask for the margins of points.

A task is a generator: it yields points, gets their margins and returns its result. Tasks in step share each call of the margin,
so that small tasks fill whole batches; none of them sees the numbers of another.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
Keys = NDArray[np.int64]

KEYS = 2**40
"""Keys of noise are 0 … KEYS − 1, all equally probable."""

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class Points:
    """z: (n, d) of standard normal space. keys: (n,) of the noise in flight, whole numbers below KEYS."""

    z: Values
    keys: Keys

    def __len__(self) -> int:
        return len(self.keys)

    def rows(self, chosen: NDArray[np.int64] | NDArray[np.bool_]) -> Points:
        """Some of the points."""
        return Points(self.z[chosen], self.keys[chosen])


Margin = Callable[[Points], Values]
"""(n,) margins of n points; 0 or below, or no number: the flight fails."""

Task = Generator[Points, Values, Result]


def joined(parts: Sequence[Points]) -> Points:
    """All points of the parts, in their order."""
    return Points(np.concatenate([part.z for part in parts]), np.concatenate([part.keys for part in parts]))


def normal_points(rng: np.random.Generator, count: int, dimension: int) -> Points:
    """Independent points of N(0, I), each with a key."""
    return Points(rng.standard_normal((count, dimension)), rng.integers(KEYS, size=count))


def failed(margins: Values) -> NDArray[np.bool_]:
    """(n,) which flights fail: g ≤ 0 or no number."""
    return ~(margins > 0.0)


def in_step(tasks: Sequence[Task[Result]], margin: Margin) -> list[Result]:
    """The results of the tasks. Each call of the margin takes the next points of every task that is not over."""
    results: dict[int, Result] = {}
    asked = {number: next(task) for number, task in enumerate(tasks)}
    while asked:
        margins = np.asarray(margin(joined(list(asked.values()))), dtype=np.float64)
        margins = np.where(np.isnan(margins), -np.inf, margins)
        behind, following = 0, dict[int, Points]()
        for number, points in asked.items():
            first, behind = behind, behind + len(points)
            try:
                following[number] = tasks[number].send(margins[first:behind])
            except StopIteration as end:
                results[number] = end.value
        asked = following
    return [results[number] for number in range(len(tasks))]
