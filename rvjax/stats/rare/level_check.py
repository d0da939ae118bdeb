"""Ordinary flights against the levels of splitting: P(g ≤ L_j) by counting and by the product of levels.

    count k_j of n independent flights below L_j: Clopper-Pearson;   product of levels: Student's t over the replicates
    disagree  ⇔  the two intervals of some level have no number in common

Each of the 2 J intervals errs with probability ≤ risk/(2 J), so all of them hold with probability ≥ 1 − risk where the margin's
failure regions were reached (the half from Student's t is nominal). Levels that are far below 1/n are checked as well: a single
ordinary failure refutes an estimate of 10⁻⁹.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rvjax.stats.binomial import Estimate, clopper_pearson
from rvjax.stats.rare.replicates import student_interval

RISK = 0.01
"""Probability, at most, that levels that agree are refused."""


@dataclass(frozen=True)
class LevelCheck:
    """A level. count: ordinary flights at or below it, of counted.n; split: the estimate of splitting."""

    level: float
    count: int
    counted: Estimate
    split: Estimate

    @property
    def agrees(self) -> bool:
        """Whether the intervals have a number in common."""
        return self.counted.low <= self.split.high and self.split.low <= self.counted.high


def check_levels(
    levels: Sequence[float], below: Sequence[Sequence[float]], counts: Sequence[int], flights: int, risk: float = RISK
) -> list[LevelCheck]:
    """below: (levels, replicates) estimates of P(g ≤ L_j). counts: ordinary flights at or below each level, of `flights`."""
    confidence = 1.0 - risk / (2 * len(levels))
    return [
        LevelCheck(level, count, clopper_pearson(count, flights, confidence), student_interval(estimates, confidence))
        for level, estimates, count in zip(levels, below, counts, strict=True)
    ]
