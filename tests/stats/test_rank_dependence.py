"""Chatterjee's ξ, its null laws and the rank estimate of a Sobol index against brute force and closed forms."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from scipy.stats import binom

from rvjax.stats.rank_dependence import Dependence, order_of, rank_index, rank_sobol, runs_cdf

ISHIGAMI = (0.31390519, 0.44241114, 0.0)


def generator(key: int) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(key=key))


def ishigami(x: Any) -> Any:
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def xi_by_definition(y: Any) -> float:
    """ξ of y in the order of x, by the sums of its definition."""
    n = len(y)
    r = [sum(other <= one for other in y) for one in y]
    rest = [sum(other >= one for other in y) for one in y]
    steps = sum(abs(r[i + 1] - r[i]) for i in range(n - 1))
    return 1.0 - n * steps / (2.0 * sum(count * (n - count) for count in rest))


@pytest.mark.parametrize("values", [(3.0, 1.0, 2.0, 9.0, -4.0), (1.0, 1.0, 5.0, math.inf, math.inf, 0.0), (0.0, 1.0, 1.0, 0.0)])
def test_xi_is_its_definition(values: tuple[float, ...]) -> None:
    """Kills: #{y_j < y_i} in place of #{y_j ≤ y_i}, n − 1 in place of n, lost flights left out."""
    y, x = np.array(values), np.arange(len(values))[::-1]
    xi = Dependence(y, generator(0)).xi(order_of(x, generator(0)))
    assert xi == pytest.approx(xi_by_definition(y[::-1]), abs=1e-14)


def test_a_function_has_xi_near_1_whatever_its_form() -> None:
    """Kills: a correlation, which is 0 here. With n distinct values, all rising, ξ = (n − 2)/(n + 1)."""
    x = np.linspace(-1.0, 1.0, 1000)
    assert Dependence(x, generator(1)).xi(order_of(x, generator(1))) == pytest.approx(998 / 1001, abs=1e-12)
    assert Dependence(x**2, generator(1)).xi(order_of(x, generator(1))) > 0.98


def test_the_normal_p_has_the_exact_null_variance() -> None:
    """Kills: 2/5 n in place of the variance for n values. Of all 5,040 orders of 7 values."""
    y = np.arange(7.0)
    dependence = Dependence(y, generator(2))
    all_xi = np.array([xi_by_definition(order) for order in itertools.permutations(y)])
    assert dependence.way == "normal"
    assert all_xi.mean() == pytest.approx(0.0, abs=1e-12)
    assert dependence.p(float(all_xi.std())) == pytest.approx(0.15865525393145707, abs=1e-9)


@pytest.mark.parametrize(("few", "many"), [(1, 6), (3, 5), (4, 4)])
def test_runs_have_their_exact_law(few: int, many: int) -> None:
    """Kills: the terms of even and odd numbers of runs exchanged, the factor 2 lost. Against every order."""
    n = few + many
    marks = [[i in chosen for i in range(n)] for chosen in itertools.combinations(range(n), few)]
    runs = np.array([1 + sum(a != b for a, b in itertools.pairwise(order)) for order in marks])
    for most in range(1, n + 1):
        assert runs_cdf(most, few, many) == pytest.approx(np.mean(runs <= most), abs=1e-12)


def test_a_failure_indicator_has_the_exact_p() -> None:
    """Kills: P(ξ > x) in place of P(ξ ≥ x). ξ of an indicator falls with the number of runs."""
    y = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    dependence = Dependence(y, generator(3))
    assert dependence.way == "runs"
    assert dependence.p(dependence.xi(np.arange(8))) == pytest.approx(2 / math.comb(8, 3), abs=1e-12)
    everyone = [dependence.xi(np.array(order)) for order in itertools.islice(itertools.permutations(range(8)), 0, 40320, 97)]
    reference = [xi_by_definition(y[list(order)]) for order in itertools.islice(itertools.permutations(range(8)), 0, 40320, 97)]
    assert everyone == pytest.approx(reference, abs=1e-12)


@pytest.mark.parametrize(("share", "variance"), [(0.01, 0.39), (0.1, 0.38), (0.5, 0.70), (0.9, 0.97)])
def test_ties_change_the_null_variance(share: float, variance: float) -> None:
    """Kills: the normal law without ties where many values are equal. n Var ξ of permutations, an atom of lost flights."""
    n = 1000
    y = generator(4).random(n)
    y[: int(share * n)] = math.inf
    dependence = Dependence(y, generator(5))
    assert dependence.way == ("permutation" if share >= 0.1 else "normal")
    assert n * dependence._null().var() == pytest.approx(variance, rel=0.06)  # pyright: ignore[reportPrivateUsage]


@pytest.mark.parametrize("atom", [0, 15, 60])
def test_p_is_uniform_where_nothing_depends(atom: int) -> None:
    """Kills: a permutation that keeps the pairs, a tail of the wrong side. 600 independent pairs at the level 5 %: the number
    of rejections lies in a binomial interval that a right test leaves once in a million."""
    trials, rejected, source = 600, 0, generator(6)
    y = source.random(60)
    y[:atom] = 7.0
    if atom == 60:
        y = (source.random(60) < 0.2).astype(float)
    dependence = Dependence(y, generator(7))
    for _ in range(trials):
        rejected += dependence.p(dependence.xi(source.permutation(60))) <= 0.05
    assert rejected <= binom.isf(1e-6, trials, 0.05)
    if atom != 60:  # the exact law of runs has steps, so it may reject less
        assert rejected >= binom.ppf(1e-6, trials, 0.05)


def test_far_tails_fall_and_never_reach_0() -> None:
    """Kills: p = 0 beyond the last permutation, a p that is stuck at 1/(B + 1), so that Holm never rejects."""
    y = np.concatenate([np.full(120, math.inf), generator(8).random(280)])
    dependence = Dependence(y, generator(9))
    assert dependence.way == "permutation"
    p = [dependence.p(xi) for xi in (0.0, 0.1, 0.3, 0.6)]
    assert p == sorted(p, reverse=True)
    assert 0.0 < p[-1] < 1e-9
    assert p[0] == pytest.approx(0.5, abs=0.05)


def test_a_constant_depends_on_nothing() -> None:
    """Kills: a division by 0."""
    dependence = Dependence(np.full(50, 3.0), generator(10))
    assert (dependence.xi(np.arange(50)), dependence.p(0.0)) == (0.0, 1.0)
    assert rank_index(np.full(50, 3.0), np.arange(50)) == (0.0, 0.0)


def test_equal_x_are_in_a_random_order() -> None:
    """Kills: equal x left in the order of the samples, which would make anything depend on a constant."""
    y = np.sort(generator(11).random(400))
    assert abs(Dependence(y, generator(12)).xi(order_of(np.zeros(400), generator(12)))) < 5.0 * math.sqrt(0.4 / 400)


def test_ishigami() -> None:
    """Kills: squares of neighbours in place of products, the mean not taken off. 5 standard errors of the estimate itself."""
    x = generator(13).uniform(-np.pi, np.pi, (20_000, 3))
    for column, exact in zip(x.T, ISHIGAMI, strict=True):
        index = rank_index(ishigami(x), order_of(column, generator(14)))
        assert abs(index.value - exact) < 5.0 * index.error < 0.06


def test_the_interval_covers_ishigami() -> None:
    """Kills: γ_2 not taken off, γ_1 left out, √n lost. 300 repeats of 400 pairs at 95 %, beside a coverage of 92.5 % to 97.5 %,
    which the approximation keeps, the interval of a binomial number that is left once in a thousand."""
    source, covered = generator(15), np.zeros(3)
    for _ in range(300):
        x = source.uniform(-np.pi, np.pi, (400, 3))
        y = ishigami(x)
        for k, exact in enumerate(ISHIGAMI):
            estimate = rank_sobol(x[:, k], y, rng=source)
            covered[k] += estimate.low <= exact <= estimate.high
    assert covered.min() >= binom.ppf(1e-3, 300, 0.925)
    assert covered[1] <= binom.isf(1e-3, 300, 0.975)


@pytest.mark.parametrize("square", [False, True])
def test_the_error_is_the_spread(square: bool) -> None:
    """Kills: γ_1 or γ_2 left out (15 %), a first pair that follows the last, whose x is far away. y = x or x² with noise as large
    as it, S = ½ or ⅔: 2,000 repeats of 400 pairs, whose spread is known to 1.6 %; and no bias beyond 8/n."""
    source, found = generator(17), list[tuple[float, float]]()
    for _ in range(2000):
        x = source.standard_normal(400)
        y = (x**2 if square else x) + source.standard_normal(400)
        found.append(rank_index(y, np.argsort(x)))
    values, errors = np.array(found).T
    assert errors.mean() == pytest.approx(values.std(), rel=0.08)
    assert values.mean() == pytest.approx(2 / 3 if square else 0.5, abs=8 / 400)


@pytest.mark.parametrize("values", [[1.0, math.nan, 2.0, 3.0], [1.0, 2.0, 3.0]])
def test_what_is_no_sample_is_refused(values: list[float]) -> None:
    """Kills: the checks."""
    with pytest.raises(ValueError, match="4 or more"):
        Dependence(values, generator(16))
    with pytest.raises(ValueError, match="4 or more"):
        rank_index(values, np.arange(len(values)))
