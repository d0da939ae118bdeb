"""Sketch: the distribution of a stream of numbers in bounded memory, independent of their order.

Every number is counted in a bucket: its sign, its exponent and the first `BITS` bits of its mantissa. So a bucket is 2⁻¹⁰ of
its values wide, and an order statistic from it is right to 2⁻¹¹ (0.05 %). The `EXACT` smallest and the `EXACT` largest numbers
are kept exactly: up to 2 `EXACT` numbers nothing is rounded; beyond that, both tails are still exact.

Counts are added and extremes are compared, so merging is exact and independent of order and grouping, unlike t-digests. The
buckets are those of HdrHistogram (G. Tene) and of DDSketch (C. Masson et al., PVLDB 12 (2019) 2195), here with binary edges.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

BITS = 10
"""Bits of the mantissa that a bucket keeps."""

EXACT = 4096
"""How many of the smallest and of the largest numbers are kept exactly."""

RELATIVE_ERROR = 2.0 ** -(BITS + 1)
"""Of an order statistic between the exact tails: half the width of a bucket."""

_SHIFT = 52 - BITS


class Sketch:
    """Counts and extremes of numbers; infinities are numbers, NaN is refused: replace it first."""

    def __init__(self, values: ArrayLike = ()) -> None:
        self.n = 0
        self._smallest = self._largest = np.empty(0)
        self._keys, self._counts = np.empty(0, np.int64), np.empty(0, np.int64)
        self.add(values)

    def add(self, values: ArrayLike) -> None:
        """Adds numbers, of any shape."""
        x = np.sort(np.asarray(values, dtype=float).ravel() + 0.0)  # + 0.0: −0 becomes 0
        if not x.size:
            return
        if np.isnan(x[-1]):
            raise ValueError("NaN has no rank; accepted: numbers and infinities")
        keys, counts = np.unique(_key(x), return_counts=True)
        self._take(x.size, keys, counts, x[:EXACT], x[-EXACT:])

    def merge(self, other: Sketch) -> None:
        """Adds the numbers of another sketch."""
        self._take(other.n, other._keys, other._counts, other._smallest, other._largest)

    TYPES: ClassVar[Mapping[str, type[np.generic]]] = {
        "smallest": np.float64,
        "largest": np.float64,
        "keys": np.int64,
        "counts": np.int64,
    }
    """The arrays that hold all of a sketch, and the types of their numbers."""

    def arrays(self) -> dict[str, NDArray[Any]]:
        """All of it, for `Sketch.of`: equal sketches have equal arrays."""
        return {name: getattr(self, f"_{name}") for name in self.TYPES}

    @classmethod
    def of(
        cls,
        smallest: NDArray[np.float64],
        largest: NDArray[np.float64],
        keys: NDArray[np.int64],
        counts: NDArray[np.int64],
    ) -> Sketch:
        """The sketch of these arrays, which must not be changed afterwards. ValueError if they contradict each other."""
        sketch = cls()
        sketch.n = int(counts.sum())
        sketch._smallest, sketch._largest, sketch._keys, sketch._counts = smallest, largest, keys, counts
        tails = smallest.size == largest.size == min(sketch.n, EXACT)
        ranked = all(np.all(x[1:] >= x[:-1]) and not np.isnan(x).any() for x in (smallest, largest))
        if not (tails and ranked and keys.size == counts.size and np.all(counts > 0) and np.all(keys[1:] > keys[:-1])):
            raise ValueError("a sketch whose numbers and counts contradict each other")
        return sketch

    def _take(
        self,
        n: int,
        keys: NDArray[np.int64],
        counts: NDArray[np.int64],
        smallest: NDArray[np.float64],
        largest: NDArray[np.float64],
    ) -> None:
        self.n += n
        self._smallest = np.sort(np.concatenate([self._smallest, smallest]))[:EXACT]
        self._largest = np.sort(np.concatenate([self._largest, largest]))[-EXACT:]
        self._keys, place = np.unique(np.concatenate([self._keys, keys]), return_inverse=True)
        total = np.zeros(self._keys.size, np.int64)
        np.add.at(total, place, np.concatenate([self._counts, counts]))
        self._counts = total

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sketch) and all(np.array_equal(value, vars(other)[name]) for name, value in vars(self).items())

    __hash__ = None  # pyright: ignore[reportAssignmentType]

    def low(self, rank: int) -> float:
        """A lower bound of the number of this rank; equal to it in the tails."""
        return self._number(rank)[0]

    def value(self, rank: int) -> float:
        """The number of this rank: exact in the tails, else within `RELATIVE_ERROR` of it."""
        low, high = self._number(rank)
        return low if low == high else low / 2 + high / 2

    def high(self, rank: int) -> float:
        """An upper bound of the number of this rank; equal to it in the tails."""
        return self._number(rank)[1]

    def at_least(self, limit: float) -> int:
        """How many numbers are ≥ limit. ValueError if that is not known: limit is neither an edge of a bucket nor in a tail.

        Powers of two, 10 and ∞ are edges; negative numbers are not.
        """
        for tail, rest in ((self._smallest, 0), (self._largest, self.n - self._largest.size)):
            if tail.size == self.n or (tail.size and tail[0] < limit <= tail[-1]):
                return self.n - rest - int(np.searchsorted(tail, limit))
        key = int(_key(np.array([float(limit)]))[0])
        if _edges(key)[0] != limit:
            raise ValueError(f"{limit} is no edge of a bucket, so the numbers beyond it are not counted")
        return int(self._counts[self._keys >= key].sum())

    @property
    def exact(self) -> bool:
        """Whether every number is known exactly."""
        return self.n <= 2 * EXACT

    @property
    def positive(self) -> int:
        """How many numbers are > 0."""
        return int(self._counts[self._keys > 0].sum())

    @property
    def finite(self) -> int:
        """How many numbers are below ∞."""
        return self.n - self.at_least(math.inf)

    def _number(self, rank: int) -> tuple[float, float]:
        """Bounds of the number of a rank."""
        if not 0 <= rank < self.n:
            raise IndexError(f"rank {rank} of {self.n} numbers")
        if rank < self._smallest.size:
            return float(self._smallest[rank]), float(self._smallest[rank])
        if (from_end := rank - (self.n - self._largest.size)) >= 0:
            return float(self._largest[from_end]), float(self._largest[from_end])
        low, high = _edges(int(self._keys[np.searchsorted(np.cumsum(self._counts), rank, side="right")]))
        return max(low, float(self._smallest[-1])), min(high, float(self._largest[0]))


def _key(x: NDArray[np.float64]) -> NDArray[np.int64]:
    """The bucket of each number: increasing, 0 around zero, opposite for opposite numbers."""
    magnitude = np.abs(x).view(np.int64) >> _SHIFT
    return np.where(x < 0, -magnitude, magnitude)


def _edges(key: int) -> tuple[float, float]:
    """The ends of a bucket."""
    if key == 0:
        return 0.0, 0.0  # numbers below 1e-310 count as 0
    near, far = np.array([abs(key), abs(key) + 1], np.int64) << _SHIFT
    inner = float(near.view(np.float64))
    outer = math.inf if math.isinf(inner) else float(far.view(np.float64))
    return (inner, outer) if key > 0 else (-outer, -inner)
