"""Multilevel splitting against margins whose probability is known; its levels, atoms, noise keys, and what it refuses."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from scipy import integrate, stats

from benchmarks import rare_margins
from benchmarks.rare_coverage import CHAINS, LEARNERS, repeats_of
from benchmarks.rare_margins import CASES, Case
from rvjax.stats.rare import splitting
from rvjax.stats.rare.level_check import check_levels
from rvjax.stats.rare.points import KEYS, Points, Values

SMALL: dict[str, Case] = {
    "linear 1e-5": rare_margins.linear(1e-5, 30),
    "linear 1e-6": rare_margins.linear(1e-6, 30),
    "linear 1e-7": rare_margins.linear(1e-7, 30),
    "linear 1e-9": rare_margins.linear(1e-9, 30),
    "two-sided 1e-6": rare_margins.two_sided(30),
    "4 half-spaces": rare_margins.half_spaces(4, 30),
    "10 half-spaces": rare_margins.half_spaces(10, 30),
    "χ² of 100": rare_margins.far_out(100),
    "convex": rare_margins.bent(False, 30),
    "concave": rare_margins.bent(True, 30),
    "100 exponentials": rare_margins.waiting(),
    "rounded and capped": rare_margins.rounded(30),
    "noise in flight": rare_margins.end_value(10),
}


def estimates(case: Case, seed: int, chains: int = 52, count: int = 20) -> tuple[splitting.Ladder, list[splitting.Replicate]]:
    """The ladder and the replicates of a case."""

    def margin(points: Points) -> Values:
        return case.margin(points.z, points.keys)

    ladder = splitting.learn(margin, case.dimension, seed, chains=208, noisy=case.noisy)
    return ladder, splitting.replicates(margin, ladder, seed, range(count), chains=chains)


def unbiased(values: list[float], p: float, risk: float = 1e-4) -> bool:
    """Whether Student's t at this risk finds no bias. The seed is fixed; for a fresh seed the test would fail with this risk."""
    error = float(np.std(values, ddof=1)) / math.sqrt(len(values))
    return abs(float(np.mean(values)) - p) <= float(stats.t.isf(risk / 2, len(values) - 1)) * error


def test_the_answers_are_exact() -> None:
    """Every probability of the cases, by mpmath or by integration. Kills: a wrong constant in a case."""
    for p, beta in rare_margins.LINEAR.items():
        assert float(mpmath.ncdf(-beta)) == pytest.approx(p, rel=1e-12)
    assert float(2 * mpmath.ncdf(-mpmath.mpf("4.891638475698591"))) == pytest.approx(1e-6, rel=1e-12)
    for count, beta in ((4, 5.0), (10, 4.5)):
        exact = float(1 - mpmath.ncdf(beta) ** count)
        assert rare_margins.half_spaces(count).probability == pytest.approx(exact, rel=1e-10)
    for d, limit in ((100, 182.1267771), (300, 431.1413577)):
        assert stats.chi2.sf(limit, d) == pytest.approx(1e-6, rel=1e-7)
    for inwards, beta, bend in ((False, 4.0, 0.1), (True, 5.0, -0.025)):
        exact = integrate.quad(
            lambda x, beta=beta, bend=bend: stats.norm.sf(beta + bend * x) * stats.chi2.pdf(x, 9), 0, 400, epsabs=0, limit=200
        )[0]
        assert rare_margins.bent(inwards).probability == pytest.approx(exact, rel=1e-6)
    assert stats.gamma.sf(150.0, 100) == pytest.approx(rare_margins.waiting().probability, rel=1e-10)


@pytest.mark.parametrize("name", SMALL)
def test_the_probability_is_met(name: str) -> None:
    """The mean of 20 replicates differs from p by no more than chance allows in 9,999 of 10,000; some of each replicate's states
    failed. Kills: a level that does not count its equals, seeds that are not drawn from all survivors, moves accepted above
    the level, ρ and √(1 − ρ²) exchanged."""
    case = SMALL[name]
    ladder, came = estimates(case, 11)
    values = [replicate.probability for replicate in came]
    assert ladder.reached
    assert unbiased(values, case.probability)
    assert 0.05 < float(np.std(values, ddof=1) / np.mean(values)) < 2.5
    assert all(replicate.flights == splitting.flights_of(ladder, 52) for replicate in came)
    for replicate in came:
        assert np.all(case.margin(replicate.failing.z, replicate.failing.keys) <= 0.0)


@pytest.mark.parametrize("name", CASES)
def test_the_intervals_hold_as_often_as_they_say(name: str, full: bool) -> None:
    """200 repeats of each case with `--long`, 2 of some without: the mean over all is p; the proved bound errs in no more
    repeats than chance allows at 5 % in 9,999 of 10,000; Student's interval at 95 % holds in at least 85 % in the same sense.
    Kills: a bound at another risk, a bias that a single repeat does not show."""
    if not (full or name in ("linear 1e-6", "noise in flight")):
        pytest.skip("200 repeats: --long")
    case = CASES[name]() if full else SMALL[name]
    came = repeats_of(case, 200 if full else 2, "splitting", 1, LEARNERS, CHAINS if full else 13)
    assert unbiased([repeat.estimate for repeat in came], case.probability) or not full
    wrong = sum(repeat.proved > case.probability for repeat in came)
    missed = sum(not repeat.low <= case.probability <= repeat.high for repeat in came)
    assert wrong <= stats.binom.isf(1e-4, len(came), 0.05)
    assert missed <= stats.binom.isf(1e-4, len(came), 0.15)


def test_a_replicate_is_a_function_of_its_number() -> None:
    """Replicates of a group are those of each alone, bit for bit. Kills: a generator that replicates share."""
    case = SMALL["noise in flight"]

    def margin(points: Points) -> Values:
        return case.margin(points.z, points.keys)

    ladder = splitting.learn(margin, case.dimension, 5, chains=52, noisy=True)
    together = splitting.replicates(margin, ladder, 5, range(4), chains=26)
    alone = [splitting.replicates(margin, ladder, 5, [number], chains=26)[0] for number in (3, 1)]
    for one, other in zip((together[3], together[1]), alone, strict=True):
        assert one.shares == other.shares
        assert np.array_equal(one.failing.z, other.failing.z)
        assert np.array_equal(one.failing.keys, other.failing.keys)


@pytest.mark.parametrize("chains", [5, 7, 26])
def test_survivors_begin_equally_many_chains(chains: int) -> None:
    """Seven survivors begin ⌊M/7⌋ chains or one more, M in all and M/7 in the mean, within chance of 1 in 10,000. Kills: seeds
    that are drawn independently, a remainder that the first survivors always have."""
    rng, rows, n = np.random.default_rng(8), np.arange(10, 17), 4000
    counts = np.array([np.bincount(splitting._seeds(rng, rows, chains), minlength=17)[10:] for _ in range(n)])
    every, rest = divmod(chains, len(rows))
    assert np.all(counts.sum(axis=1) == chains)
    assert np.all((counts == every) | (counts == every + (rest > 0)))
    share = rest / len(rows)
    limit = stats.norm.isf(5e-5 / len(rows)) * math.sqrt(share * (1 - share) / n)
    assert np.all(np.abs(counts.mean(axis=0) - chains / len(rows)) <= limit + 1e-12)


def test_moves_keep_the_normal_law_and_the_keys() -> None:
    """Moves at a level that accepts everything leave N(0, I) and uniform keys: the mean, the variance and the correlation of a
    move, each within chance of 1 in 10,000; a key is kept in four moves of five. Kills: a step that is not divided, keys that
    are never or always drawn again."""
    rng = np.random.default_rng(3)
    n = 40_000
    points = Points(rng.standard_normal((n, 2)), rng.integers(KEYS, size=n))
    moved = splitting._moved(rng, points, 0.6, True)
    limit = stats.norm.isf(5e-5)
    assert np.all(np.abs(moved.z.mean(axis=0)) < limit / math.sqrt(n))
    assert np.all(np.abs(moved.z.var(axis=0) - 1.0) < limit * math.sqrt(2 / n))
    correlation = np.mean(points.z[:, 0] * moved.z[:, 0])
    assert abs(correlation - 0.8) < limit * math.sqrt((1 + 0.8**2) / n)
    kept = int(np.sum(points.keys == moved.keys))
    assert stats.binom.ppf(5e-5, n, 0.8) <= kept <= stats.binom.isf(5e-5, n, 0.8)
    assert np.array_equal(splitting._moved(rng, points, 0.6, False).keys, points.keys)


def test_an_atom_is_left_by_the_states_below() -> None:
    """93 % of the margins are the cap 3: the first level is the largest value below it. Kills: a level at the cap, which cuts
    off nothing."""
    ladder, _ = estimates(SMALL["rounded and capped"], 11, count=2)
    assert ladder.levels[0] == 2.75
    assert ladder.shares[0] < 0.1


def test_a_margin_without_a_slope_is_refused() -> None:
    """Only 1 and −1: nothing leads on. The message has the value of the atom. Kills: an endless first pass."""

    def margin(points: Points) -> Values:
        return np.where(points.z[:, 0] > 4.5, -1.0, 1.0)

    with pytest.raises(splitting.Stalled, match=r"nearly all margins .* are 1:"):
        splitting.learn(margin, 3, 1, chains=52)
    with pytest.raises(splitting.Stalled):
        splitting.learn(lambda points: np.full(len(points), np.inf), 3, 1, chains=52)


def test_no_number_is_a_failure() -> None:
    """NaN where z₁ > β fails like a negative margin. Kills: NaN that compares false counted as no failure."""
    beta = rare_margins.LINEAR[1e-5]

    def margin(points: Points) -> Values:
        g = beta - points.z[:, 0]
        return np.where(g <= 0.0, np.nan, g)

    ladder = splitting.learn(margin, 10, 4, chains=104)
    values = [r.probability for r in splitting.replicates(margin, ladder, 4, range(20), chains=26)]
    assert ladder.reached
    assert unbiased(values, 1e-5)


def test_a_margin_that_stays_positive_ends_at_the_floor() -> None:
    """e^−z₁ > 0 never fails: pass 1 ends at its floor, every replicate gives 0. Kills: no floor, a last level that counts as
    failure."""

    def margin(points: Points) -> Values:
        return np.exp(-points.z[:, 0])

    ladder = splitting.learn(margin, 5, 2, chains=52, floor=1e-6)
    assert not ladder.reached
    assert 1e-8 < ladder.probability < 1e-6
    assert [r.probability for r in splitting.replicates(margin, ladder, 2, range(3), chains=26)] == [0.0] * 3


def test_ordinary_flights_refute_levels() -> None:
    """By hand: replicates near 1e-6, and 11 of 8,000 ordinary flights below the level: refuted. None of 8,000: not. Replicates
    near 0.1 against 5 % of the flights: refuted from the other side. Kills: a comparison of one side only."""
    low, high = [1e-6, 1.2e-6, 0.9e-6, 1.1e-6], [0.1, 0.101, 0.099, 0.1]
    agreed = [check.agrees for check in check_levels([0.5, 0.4, 0.3, 0.2], [low, low, high, high], [11, 0, 400, 800], 8000)]
    assert agreed == [False, True, False, True]


def test_a_hidden_pocket_is_never_taken_for_rare() -> None:
    """A pocket of probability 2e-4 without a slope beside a decoy of 1e-6, in 10 repeats: 50,000 ordinary flights refute a level,
    or the interval reaches beyond 1e-5: no estimate says that failures are rarer than that. A plain margin is never refuted
    (chance of the contrary below 1 % each, and the seeds are fixed). Kills: levels that are checked only where many ordinary
    flights are."""
    hidden, plain = rare_margins.hidden(), rare_margins.linear(1e-6, 30)
    rng = np.random.default_rng(8)
    for case, seeds in ((hidden, range(10)), (plain, range(2))):
        z = rng.standard_normal((50_000, case.dimension))
        g = case.margin(z, np.zeros(len(z), dtype=np.int64))
        for seed in seeds:
            ladder, came = estimates(case, seed, chains=13)
            levels = [*ladder.levels, 0.0]
            below = [[r.below(j) for r in came] for j in range(len(levels))]
            checks = check_levels(levels, below, [int(np.sum(g <= level)) for level in levels], len(z))
            refuted = not all(check.agrees for check in checks)
            if case is plain:
                assert not refuted
            else:
                assert refuted or checks[-1].split.high > 1e-5
