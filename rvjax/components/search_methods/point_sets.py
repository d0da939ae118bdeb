"""Points that are known before anything is told, and how they are proposed."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.stats import qmc

from rvjax.components.search_methods.interface import Evaluate, Task, Values, snapped

BITS = 30
BATCH = 64
"""Points in a batch where neither the batch nor the number of candidates is said."""

SEEDS = 2**32
"""Seeds that generators of other packages take are below this."""


def number(seed: int, name: str) -> int:
    """A number of 128 bits of (seed, name)."""
    return int.from_bytes(hashlib.sha256(f"{seed}:{name}".encode()).digest()[:16], "little")


def spread(dimensions: int, key: int) -> Callable[[int], Values]:
    """A scrambled Sobol sequence: of a number of points, the next ones, (points, dimensions)."""
    generator = np.random.Generator(np.random.Philox(np.random.SeedSequence(key)))
    make: Any = qmc.Sobol  # `rng` to type checkers, which releases before 1.15 do not know
    sequence = make(dimensions, scramble=True, bits=BITS, seed=generator)
    first: Values = sequence.random(1)  # by itself: of others at once SciPy wants a power of two

    def following(count: int) -> Values:
        nonlocal first
        ahead, first = first[:count], first[count:]
        rest = count - len(ahead)
        return np.concatenate([ahead, sequence.random(rest)]) if rest else ahead

    return following


def propose(task: Task, evaluate: Evaluate, following: Callable[[int], Values], batch: int | None) -> None:
    """The start, if there is one, and then points as they follow: as many as there are candidates, all at once or in batches."""
    left = task.candidates
    first = np.empty((0, len(task.axes))) if task.start is None else task.start[None]
    while left is None or left > 0:
        size = batch or left or BATCH
        count = size if left is None else min(size, left)
        evaluate(snapped(task.axes, np.concatenate([first, following(count - len(first))])))
        first = first[:0]
        left = None if left is None else left - count
