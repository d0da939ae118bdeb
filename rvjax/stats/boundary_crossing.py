"""Decisions by counts of failures while samples come, and the exact probability of each decision.

A boundary has the numbers of samples at which the failures are counted (looks), the most failures for PASS and the least
for FAIL. The first decision stands. The probabilities of all decisions are sums over the lattice of (samples, failures),
carried from look to look: no simulation and no approximation.

Source: P. Armitage, C. K. McPherson & B. C. Rowe, J. R. Stat. Soc. A 132 (1969) 235 (the recursion from look to look).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rvjax.stats._binomial import binomial_pmf, invalid, whole

NEGLIGIBLE = 1e-40
"""States at either end with a smaller probability are dropped, which keeps the cost of a walk linear in the spread."""


class Boundary(NamedTuple):
    """At looks[j] samples, PASS with at most passes[j] failures, FAIL with at least fails[j], neither in between.

    passes[j] = -1: never PASS. fails[j] > looks[j]: never FAIL. If both hold, the decision is PASS.
    """

    looks: NDArray[np.int64]
    passes: NDArray[np.int64]
    fails: NDArray[np.int64]


class Walk(NamedTuple):
    """Probabilities of the decisions of a boundary if a sample fails with probability 1 - p.

    `passed`, `failed`: of PASS and FAIL at each look. `undecided`: of no decision at the last look. `samples`: the expected
    number of samples; without a decision it is that of the last look.
    """

    passed: NDArray[np.float64]
    failed: NDArray[np.float64]
    undecided: float
    samples: float

    @property
    def passes(self) -> float:
        """The probability of PASS at any look: the type-I error if p is too low, else the power."""
        return float(self.passed.sum())

    @property
    def fails(self) -> float:
        """The probability of FAIL at any look: the type-II error (producer's risk) if p is high enough."""
        return float(self.failed.sum())


def schedule(most: int, every: int = 1) -> NDArray[np.int64]:
    """every, 2 every, ... and `most`: a look after each chunk of samples and at the end.

    ValueError unless both are whole numbers >= 1.
    """
    for name, number in (("most", most), ("every", every)):
        whole(name, number, 1)
    return np.append(np.arange(every, most, every, dtype=np.int64), most)


def walk(p: float, boundary: Boundary) -> Walk:
    """P(first end at look j is PASS), P(... FAIL), P(no end), E[samples], for independent samples that succeed with p.

    Between two looks the distribution of the failures is convolved with that of the new failures; then the part past the
    boundary is removed. Costs about looks x chunk x (spread of the failures); ValueError unless 0 <= p <= 1 and the looks rise.
    """
    if not 0 <= p <= 1:
        raise invalid("p must be between 0 and 1", p)
    looks = _looks(boundary)
    passed, failed = np.zeros(looks.size), np.zeros(looks.size)
    law, first, flown, samples = np.ones(1), 0, 0, 0.0
    steps: dict[int, NDArray[np.float64]] = {}
    for j, (n, most, least) in enumerate(zip(looks.tolist(), boundary.passes.tolist(), boundary.fails.tolist(), strict=True)):
        new = n - flown
        if new not in steps:
            steps[new] = binomial_pmf(new, 1 - p) if new > 1 else np.array([p, 1 - p])
        samples += new * float(law.sum())
        law, flown = np.asarray(np.convolve(law, steps[new]), dtype=float), n
        few = min(max(most + 1 - first, 0), law.size)
        many = min(max(least - first, few), law.size)
        passed[j], failed[j] = law[:few].sum(), law[many:].sum()
        law, first = law[few:many], first + few
        law, cut = _trimmed(law)
        first += cut
        if not law.size:
            break
    return Walk(passed, failed, float(law.sum()), samples)


def decisions(failures: ArrayLike, boundary: Boundary) -> NDArray[np.int8]:
    """1 (PASS), -1 (FAIL) or 0 (undecided) after each look; the first decision stands.

    `failures`: (..., looks) failures among the first looks[j] samples; the result has that shape. ValueError unless
    they are whole numbers that neither fall nor exceed the samples.
    """
    counts, looks = whole("failures", failures), _looks(boundary)
    rises = np.diff(counts, axis=-1, prepend=0)
    if counts.shape[-1:] != looks.shape or np.any(rises < 0) or np.any(rises > np.diff(looks, prepend=0)):
        rule = "failures must be one count per look, each between the last one and the samples since"
        raise invalid(rule, failures)
    alone = np.where(counts <= boundary.passes, 1, np.where(counts >= boundary.fails, -1, 0)).astype(np.int8)
    first = np.where((alone != 0).any(axis=-1), (alone != 0).argmax(axis=-1), looks.size)[..., None]
    at_first = np.take_along_axis(alone, np.minimum(first, looks.size - 1), axis=-1)
    return np.where(np.arange(looks.size) >= first, at_first, np.int8(0))


def _looks(boundary: Boundary) -> NDArray[np.int64]:
    looks = whole("looks", boundary.looks, 1)
    if looks.ndim != 1 or not looks.size or np.any(np.diff(looks) < 1):
        raise invalid("looks must be one row of rising numbers of samples", looks)
    return looks


def _trimmed(law: NDArray[np.float64]) -> tuple[NDArray[np.float64], int]:
    """The distribution without negligible ends, and the number of states dropped at its beginning."""
    kept = np.flatnonzero(law > NEGLIGIBLE)
    return (law[kept[0] : kept[-1] + 1], int(kept[0])) if kept.size else (law[:0], 0)
