"""Pareto dominance of scores with constraints, and the fronts of nondominated sorting.

    a dominates b    a violates less, or as much with a_k ≤ b_k for all objectives k and a_k < b_k for at least one

Deb et al., A fast and elitist multiobjective genetic algorithm: NSGA-II, IEEE Trans. Evol. Comp. 6, 2002.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class Score(NamedTuple):
    """violation: total violation of the requirements, 0 if all hold; objectives: as losses, so that smaller is better."""

    violation: float
    objectives: tuple[float, ...]


def dominates(a: Score, b: Score) -> bool:
    """Whether a dominates b."""
    if a.violation != b.violation:
        return a.violation < b.violation
    return a.objectives != b.objectives and all(x <= y for x, y in zip(a.objectives, b.objectives, strict=True))


def undominated(scores: Sequence[Score]) -> list[int]:
    """Indices of the scores that no other score dominates, ascending."""
    return [i for i, score in enumerate(scores) if not any(dominates(other, score) for other in scores)]


def front_of(scores: Sequence[Score]) -> list[int]:
    """The front of each score: 0 if no score dominates it, 1 if only scores of front 0 do, and so on."""
    fronts = [-1] * len(scores)
    left, front = list(range(len(scores))), 0
    while left:
        best = {left[k] for k in undominated([scores[i] for i in left])}
        for i in best:
            fronts[i] = front
        left, front = [i for i in left if i not in best], front + 1
    return fronts
