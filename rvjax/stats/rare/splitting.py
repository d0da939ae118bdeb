"""Two-pass waste-free multilevel splitting: P(g(z) ≤ 0), z ~ N(0, I), as a product of probabilities of about 1/P.

    pass 1 (learns)     N = M P states;  L_j = M-th smallest margin, 0 if it is below;  seeds: M survivors;  P − 1 moves each
                            z' = ρ_j z + √(1 − ρ_j²) ξ,   accepted iff g(z') ≤ L_j;    ρ_j is adapted until 35 % are accepted
    pass 2 (estimates)  the same on fresh numbers, L_j and ρ_j frozen, all states of all chains kept; each of the S survivors
                        begins ⌊M/S⌋ chains or one more, chosen at random, M/S in the mean:
                            p̂ = Π_j #{g ≤ L_j among N}/N

Frozen levels make E[p̂] = p exactly, however badly the chains mix (the normalising constant of a Feynman-Kac model); bad mixing
shows as variance. Seeds drawn independently of each other would leave a third of the survivors without a chain and make p̂
scatter by a quarter more. A move is reversible for N(0, I) in any dimension.

Symbols

    z    point of standard normal space, (d,)      g     margin; ≤ 0, or no number: failure       L_j   level, falling with j
    M    chains, and seeds of a level              P     states of a chain                       ρ_j   correlation of a move
    ξ    N(0, I)                                   key   of the noise in flight: a block of the state of its own

Noise in flight: the key of a state is kept with probability 0.8 and drawn again otherwise; z and key are accepted together.

Atoms: where so many margins are equal that L_j is the largest margin, no state would be cut off. The level is then the largest
value below, if at least 20 states are there; otherwise `Stalled`. A margin that hardly approaches 0 ends pass 1 at a floor of the
probability; the last factor then counts failures beyond the last level, and mostly there are none.

Sources: N. Chopin, H.-D. Dau, "Waste-free sequential Monte Carlo", JRSS B 84 (2022) 114, arXiv:2011.02328; S. L. Cotter and
others, "MCMC methods for functions", Stat. Sci. 28 (2013) 424 (the move); F. Cérou, A. Guyader, "Adaptive multilevel splitting
for rare event analysis", Stoch. Anal. Appl. 25 (2007) 417.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rvjax.stats.rare.points import KEYS, Margin, Points, Task, Values, failed, in_step, joined, normal_points

STATES = 10
"""P: states of a chain, so that a level has a probability of about 1/P."""

ACCEPTED = 0.35
"""Share of accepted moves that ρ is adapted to."""

REDRAWN = 0.2
"""Probability that a move draws the key of the noise again."""

FEWEST = 20
"""States below an atom that a level needs."""

MOST_LEVELS = 200

FIRST_STEP = 0.5
"""√(1 − ρ²) of the first move of pass 1."""


class Stalled(ValueError):
    """The margin has no order where splitting needs it. value: of the atom. share: probability of the last level."""

    def __init__(self, value: float, share: float) -> None:
        self.value, self.share = value, share
        super().__init__(f"nearly all margins beyond a level of probability {share:.2g} are {value:.6g}: nothing leads on")


@dataclass(frozen=True)
class Ladder:
    """What pass 1 learned. dimension: d. noisy: whether a flight depends on its key. levels: L_1 > L_2 > … > 0, without the last
    level, 0. correlations: ρ of the moves below each. shares: of the states below each level, and failed at last. accepted: share
    of the moves at each level. reached: whether failures were reached; otherwise pass 1 ended at its floor. failing: states."""

    dimension: int
    noisy: bool
    levels: tuple[float, ...]
    correlations: tuple[float, ...]
    shares: tuple[float, ...]
    accepted: tuple[float, ...]
    reached: bool
    failing: Points

    @property
    def probability(self) -> float:
        """The estimate of pass 1, biased."""
        return math.prod(self.shares)


@dataclass(frozen=True)
class Replicate:
    """An independent unbiased estimate. shares: of its states at each level that were below it, failed at last; shorter where
    none was. accepted: share of the moves at each level. flights: margins that were asked for. failing: its failed states."""

    shares: tuple[float, ...]
    accepted: tuple[float, ...]
    flights: int
    failing: Points

    @property
    def probability(self) -> float:
        """p̂"""
        return math.prod(self.shares)

    def below(self, level: int) -> float:
        """The estimate of P(g ≤ L) of a level, from 0; 0 where the replicate ended before it."""
        return math.prod(self.shares[: level + 1])


OnLevel = Callable[[int, float], None]
"""Called with the number of levels so far and the probability of the last."""


def flights_of(ladder: Ladder, chains: int, states: int = STATES) -> int:
    """The most flights of a replicate: N for the first level, M (P − 1) for each further."""
    return chains * (states + len(ladder.levels) * (states - 1))


def learn(
    margin: Margin,
    dimension: int,
    seed: int,
    *,
    chains: int = 416,
    states: int = STATES,
    noisy: bool = False,
    floor: float = 1e-12,
    on_level: OnLevel = lambda level, share: None,
) -> Ladder:
    """Pass 1. floor: probability of a level at which the way to 0 is given up. A function of the seed.

    ValueError unless dimension ≥ 1, chains ≥ 20 and states ≥ 2. Stalled: see above.
    """
    if dimension < 1 or chains < FEWEST or states < 2:
        raise ValueError(f"dimension >= 1, chains >= {FEWEST} and states >= 2; found {dimension}, {chains} and {states}")
    rng = np.random.default_rng([seed, 0])
    return in_step([_learn(rng, dimension, chains, states, noisy, floor, on_level)], margin)[0]


def replicates(
    margin: Margin, ladder: Ladder, seed: int, numbers: Sequence[int], *, chains: int = 416, states: int = STATES
) -> list[Replicate]:
    """Pass 2: the replicates of these numbers, each a function of (seed, number), independent of all others."""
    rngs = [np.random.default_rng([seed, 1, number]) for number in numbers]
    return in_step([_replicate(rng, ladder, chains, states) for rng in rngs], margin)


def _learn(
    rng: np.random.Generator, dimension: int, chains: int, states: int, noisy: bool, floor: float, on_level: OnLevel
) -> Task[Ladder]:
    levels, correlations, shares, accepted = list[float](), list[float](), list[float](), list[float]()
    points = normal_points(rng, chains * states, dimension)
    margins = yield points
    step = FIRST_STEP
    while True:
        level = _level(margins, chains, math.prod(shares))
        below = margins <= level
        shares.append(float(np.mean(below)))
        on_level(len(shares), math.prod(shares))
        reached = level == 0.0
        if reached or math.prod(shares) < floor or len(shares) == MOST_LEVELS:
            break
        levels.append(level)
        rows = np.flatnonzero(below)
        seeds = rng.choice(rows, chains, replace=len(rows) < chains)
        points, margins, steps, share = yield from _chains(rng, points.rows(seeds), margins[seeds], level, states, noisy, step)
        step = math.exp(float(np.mean(np.log(steps[len(steps) // 2 :]))))
        correlations.append(math.sqrt(1.0 - step * step))
        accepted.append(share)
    if not reached:
        levels.append(level)
        correlations.append(correlations[-1] if correlations else math.sqrt(1.0 - step * step))
    failing = points.rows(failed(margins))
    return Ladder(dimension, noisy, tuple(levels), tuple(correlations), tuple(shares), tuple(accepted), reached, failing)


def _level(margins: Values, chains: int, share: float) -> float:
    """The next level. share: probability of the last."""
    level = float(np.partition(margins, chains - 1)[chains - 1])
    if level <= 0.0:
        return 0.0
    if level < float(np.max(margins)):
        return level
    smaller = margins[margins < level]
    if len(smaller) < FEWEST:
        raise Stalled(level, share or 1.0)
    return max(float(np.max(smaller)), 0.0)


def _chains(
    rng: np.random.Generator,
    points: Points,
    margins: Values,
    level: float,
    states: int,
    noisy: bool,
    step: float,
    rate: float = 1.0,
) -> Task[tuple[Points, Values, list[float], float]]:
    """All states of the chains that begin at these points, their margins, √(1 − ρ²) of each move, and the share of accepted
    moves.

    rate: of the adaptation of ρ; 0: frozen.
    """
    every, values, steps, accepted = [points], [margins], list[float](), list[float]()
    for _ in range(states - 1):
        steps.append(step)
        moved = _moved(rng, points, step, noisy)
        came = yield moved
        inside = came <= level
        points = Points(np.where(inside[:, None], moved.z, points.z), np.where(inside, moved.keys, points.keys))
        margins = np.where(inside, came, margins)
        every.append(points)
        values.append(margins)
        accepted.append(float(np.mean(inside)))
        step = min(max(step * math.exp(rate * (accepted[-1] - ACCEPTED)), 1e-3), 1.0) if rate else step
    return joined(every), np.concatenate(values), steps, float(np.mean(accepted))


def _moved(rng: np.random.Generator, points: Points, step: float, noisy: bool) -> Points:
    """ρ z + √(1 − ρ²) ξ, and the keys, some of them drawn again."""
    z = math.sqrt(1.0 - step * step) * points.z + step * rng.standard_normal(points.z.shape)
    if not noisy:
        return Points(z, points.keys)
    fresh, again = rng.integers(KEYS, size=len(points)), rng.random(len(points)) < REDRAWN
    return Points(z, np.where(again, fresh, points.keys))


def _seeds(rng: np.random.Generator, rows: NDArray[np.intp], chains: int) -> NDArray[np.intp]:
    """(M,) survivors that begin a chain, each M/S times in the mean: residual resampling."""
    every, rest = divmod(chains, len(rows))
    return np.concatenate([np.repeat(rows, every), rng.choice(rows, rest, replace=False)])


def _replicate(rng: np.random.Generator, ladder: Ladder, chains: int, states: int) -> Task[Replicate]:
    shares, accepted = list[float](), list[float]()
    points = normal_points(rng, chains * states, ladder.dimension)
    margins = yield points
    flights = len(points)
    for level, correlation in zip(ladder.levels, ladder.correlations, strict=True):
        rows = np.flatnonzero(margins <= level)
        shares.append(len(rows) / len(points))
        if not len(rows):
            return Replicate(tuple(shares), tuple(accepted), flights, points.rows(rows))
        seeds = _seeds(rng, rows, chains)
        step = math.sqrt(1.0 - correlation * correlation)
        points, margins, _, share = yield from _chains(
            rng, points.rows(seeds), margins[seeds], level, states, ladder.noisy, step, 0.0
        )
        flights += chains * (states - 1)
        accepted.append(share)
    fails = failed(margins)
    shares.append(float(np.mean(fails)))
    return Replicate(tuple(shares), tuple(accepted), flights, points.rows(fails))
