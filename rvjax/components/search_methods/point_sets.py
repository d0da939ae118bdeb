"""Sets of points that do not depend on results, and how they are proposed in batches."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.stats import qmc

from rvjax.components.search_methods.interface import Evaluate, Task, Values, snapped

BITS = 30
BATCH = 64
"""Points in a batch if neither the batch nor the number of candidates is given."""

SEEDS = 2**32
"""Seeds of generators in other packages are below this."""


def number(seed: int, name: str) -> int:
    """A number of 128 bits, the SHA-256 hash of (seed, name)."""
    return int.from_bytes(hashlib.sha256(f"{seed}:{name}".encode()).digest()[:16], "little")


def spread(dimensions: int, key: int) -> Callable[[int], Values]:
    """A scrambled Sobol sequence: number of points → the next points, (points, dimensions)."""
    generator = np.random.Generator(np.random.Philox(np.random.SeedSequence(key)))
    make: Any = qmc.Sobol  # `rng` to type checkers, which releases before 1.15 do not know
    sequence = make(dimensions, scramble=True, bits=BITS, seed=generator)
    first: Values = sequence.random(1)  # alone, because SciPy wants a power of two for the rest

    def following(count: int) -> Values:
        nonlocal first
        ahead, first = first[:count], first[count:]
        rest = count - len(ahead)
        return np.concatenate([ahead, sequence.random(rest)]) if rest else ahead

    return following


def propose(task: Task, evaluate: Evaluate, following: Callable[[int], Values], batch: int | None) -> None:
    """Proposes the start, if any, and then the following points up to the budget; batch: points per batch, None: all at once."""
    left = task.candidates
    first = np.empty((0, len(task.axes))) if task.start is None else task.start[None]
    while left is None or left > 0:
        size = batch or left or BATCH
        count = size if left is None else min(size, left)
        evaluate(snapped(task.axes, np.concatenate([first, following(count - len(first))])))
        first = first[:0]
        left = None if left is None else left - count
