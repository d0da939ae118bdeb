"""Pick-freeze indices of groups against closed forms, lost flights, functions of time, and SALib where it is installed."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from scipy.stats import binom

from rvjax.stats.pick_freeze import RunningSums, correlation, indices, most_that_matter, of_marks, over_time, ranks

FIRST, TOTAL = (0.31390519, 0.44241114, 0.0), (0.55758886, 0.44241114, 0.24368366)


def generator(key: int) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(key=key))


def ishigami(x: Any) -> Any:
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def designed(f: Callable[[Any], Any], a: Any, b: Any, groups: Mapping[str, list[int]]) -> tuple[Any, Any, dict[str, Any]]:
    """f of A, of B, and of A with each group from B."""
    swapped: dict[str, Any] = {}
    for name, columns in groups.items():
        c = a.copy()
        c[:, columns] = b[:, columns]
        swapped[name] = f(c)
    return f(a), f(b), swapped


def cube(n: int, d: int, key: int, low: float = 0.0, high: float = 1.0) -> tuple[Any, Any]:
    source = generator(key)
    return source.uniform(low, high, (n, d)), source.uniform(low, high, (n, d))


SINGLE = {"x1": [0], "x2": [1], "x3": [2]}


def test_ishigami() -> None:
    """Kills: a and b exchanged in S or T, S in place of T, the factor ½ lost. 5 standard errors."""
    values = designed(ishigami, *cube(8192, 3, 1, -np.pi, np.pi), SINGLE)
    found = indices(*values, rng=generator(2), resamples=100)
    z = 5.0 / 2.638257273476751  # the intervals are those of Bonferroni for six of them at 95 %
    for name, first, total in zip(SINGLE, FIRST, TOTAL, strict=True):
        for estimate, exact in ((found[name].first, first), (found[name].total, total)):
            assert abs(estimate.value - exact) < z * (estimate.high - estimate.value) < 0.1
        assert found[name].checked
        assert found[name].low <= (first + total) / 2 <= found[name].high


def test_groups_of_the_g_function() -> None:
    """Kills: columns of a group swapped one by one. f = Π (|4x − 2| + a)/(1 + a), V = Π (1 + v_i) − 1, v_i = 1/(3 (1 + a_i)²);
    S of a group (Π_g (1 + v) − 1)/V, T = Π_rest (1 + v) (Π_g (1 + v) − 1)/V."""
    a = np.array([0.0, 1.0, 4.5, 9.0])
    v = 1.0 / (3.0 * (1.0 + a) ** 2)
    groups = {"first": [0, 2], "second": [1, 3]}
    values = designed(lambda x: np.prod((np.abs(4.0 * x - 2.0) + a) / (1.0 + a), axis=1), *cube(16_384, 4, 3), groups)
    found = indices(*values, rng=generator(4), resamples=0)
    whole = np.prod(1.0 + v) - 1.0
    for name, columns in groups.items():
        inside = np.prod(1.0 + v[columns]) - 1.0
        exact = inside / whole, inside * (whole + 1.0) / (inside + 1.0) / whole
        for estimate, index in zip((found[name].first, found[name].total), exact, strict=True):
            assert abs(estimate.value - index) < 2.0 * (estimate.high - estimate.value) < 0.06


def test_linear_gaussian_groups_with_correlation_inside() -> None:
    """Kills: a group whose draws are swapped apart. y = c·x, groups independent: S = T = c_g' R_g c_g/Σ, whatever is inside."""
    c = np.array([1.0, 2.0, -1.0, 0.5])
    inside = np.array([[1.0, 0.8], [0.8, 1.0]])
    factor = np.linalg.cholesky(np.kron(np.eye(2), inside))
    source = generator(5)
    a, b = (source.standard_normal((16_384, 4)) @ factor.T for _ in range(2))
    groups = {"first": [0, 1], "second": [2, 3]}
    found = indices(*designed(lambda x: x @ c, a, b, groups), rng=generator(6), resamples=0)
    parts = {name: float(c[columns] @ inside @ c[columns]) for name, columns in groups.items()}
    for name, part in parts.items():
        exact = part / sum(parts.values())
        for estimate in (found[name].first, found[name].total):
            assert abs(estimate.value - exact) < 2.0 * (estimate.high - estimate.value) < 0.05


def test_intervals_hold_together() -> None:
    """Kills: intervals of one index each at 95 %, σ in place of σ/√n. 400 repeats of 300 rows: all six intervals cover in 92 % or
    more of them (Bonferroni asks 95 %, the normal law loses a little); a binomial number falls below once in a thousand."""
    covered = 0
    for key in range(400):
        found = indices(*designed(ishigami, *cube(300, 3, 100 + key, -np.pi, np.pi), SINGLE), rng=generator(0), resamples=0)
        pairs = zip(found.values(), FIRST, TOTAL, strict=True)
        covered += all(g.first.low <= s <= g.first.high and g.total.low <= t <= g.total.high for g, s, t in pairs)
    assert covered >= binom.ppf(1e-3, 400, 0.92)


def test_the_bootstrap_finds_the_same_error() -> None:
    """Kills: an error by the delta method that forgets the spread of V. Heavy tails make them differ, and the larger counts."""
    source = generator(7)
    y = source.standard_normal(4000)
    z = 0.6 * y + 0.8 * source.standard_normal(4000)
    found = correlation(y, z, generator(8))
    assert found.value == pytest.approx(0.6, abs=5 * 0.64 / math.sqrt(4000))
    assert found.error == pytest.approx(0.64 / math.sqrt(4000), rel=0.1)  # (1 − ρ²)/√n of normal pairs
    assert found.resampled == pytest.approx(found.error, rel=0.15)
    wild = np.concatenate([y, [300.0, -250.0]])
    heavy = correlation(wild, np.concatenate([z, [-200.0, 400.0]]), generator(9))
    assert heavy.wider >= heavy.error


@pytest.mark.parametrize("lost", [0.0, 1e-3, 0.1])
def test_lost_flights(lost: float) -> None:
    """Kills: NaN that spreads, rows of other groups left out, lost flights forgotten in the ranks. Flights are lost where x1 is
    in its uppermost part: the indicator's S and T of x1 are 1, all others 0; the metric keeps a share of its rows."""
    n = 20_000
    a, b = cube(n, 3, 11, -np.pi, np.pi)
    edge = np.pi * (1.0 - 2.0 * lost)

    def flown(x: Any) -> Any:
        return np.where(x[:, 0] > edge, np.nan, ishigami(x))

    one, two, swapped = designed(flown, a, b, SINGLE)
    finite = indices(one, two, swapped, rng=generator(12), resamples=0)
    expected = {"x1": 1.0 - (1.0 - lost) ** 2, "x2": 1.0 - (1.0 - lost) ** 2, "x3": 1.0 - (1.0 - lost) ** 2}
    for name, share in expected.items():
        assert abs(finite[name].left_out - share) <= 5.0 * math.sqrt(share * (1 - share) / n)
        assert all(map(math.isfinite, (finite[name].first.value, finite[name].total.value)))
    worst = [np.where(np.isnan(x), math.inf, x) for x in (one, two, *swapped.values())]
    score_a, score_b, scores = ranks(worst[0], worst[1], dict(zip(SINGLE, worst[2:], strict=True)))
    scored = indices(score_a, score_b, scores, rng=generator(13), resamples=0)
    assert all(group.left_out == 0.0 for group in scored.values())
    if lost:
        marks = [np.isinf(x).astype(float) for x in worst]
        told = indices(marks[0], marks[1], dict(zip(SINGLE, marks[2:], strict=True)), rng=generator(14), resamples=0)
        assert told["x1"].first.value == told["x1"].first.high == 1.0
        assert told["x1"].total.low <= 1.0 <= told["x1"].total.high
        assert told["x2"].total.value == told["x3"].total.value == 0.0
        assert told["x2"].total.low == 0.0 < told["x2"].total.high < 0.5


@pytest.mark.parametrize(("p", "rho", "n"), [(0.01, 0.0, 1000), (0.01, 0.6, 1000), (0.5, 0.3, 200), (0.2, 0.9, 200)])
def test_a_rare_indicator_has_exact_bounds(p: float, rho: float, n: int) -> None:
    """Kills: the delta method, which has hardly any width where no row has both; u at its estimate; q of all rows. P(both) =
    p² + ρ p (1 − p): 1,500 repeats at 90 %, at most 10 % may miss."""
    both = p * p + rho * p * (1.0 - p)
    counts = generator(21).multinomial(n, [both, p - both, p - both, 1.0 - 2.0 * p + both], size=1500)
    missed = 0
    for row in counts:
        y, z = np.repeat([1, 1, 0, 0], row), np.repeat([1, 0, 1, 0], row)
        found = of_marks(y, z, 0.9)
        missed += not found.low <= rho <= found.high
        assert found.value == pytest.approx(correlation(y, z, generator(0), 0).value, abs=1e-12)
    assert missed <= binom.isf(1e-6, 1500, 0.1)


def test_ranks_are_shares_in_one_order() -> None:
    """Kills: ranks of each part by itself, equal values apart."""
    a, b, swapped = ranks([1.0, 5.0], [3.0, math.inf], {"g": [5.0, math.inf]})
    assert (a.tolist(), b.tolist()) == ([1 / 12, 6 / 12], [3 / 12, 10 / 12])
    assert swapped["g"].tolist() == [6 / 12, 10 / 12]
    with pytest.raises(ValueError, match="lost flight"):
        ranks([math.nan], [0.0], {"g": [1.0]})


def test_a_group_that_changes_no_bit() -> None:
    """Kills: 1 − α/n, n + 1, a bound although a bit has changed. (1 − p)^n = α at the bound."""
    bound = most_that_matter(500, 500, 0.95)
    assert bound is not None
    assert (1.0 - bound) ** 500 == pytest.approx(0.05, rel=1e-9)
    assert most_that_matter(499, 500) is None
    found = indices(np.arange(9.0), np.arange(9.0)[::-1].copy(), {"none": np.arange(9.0)}, rng=generator(15))["none"]
    assert (found.total.value, found.total.low, found.total.high) == (0.0, 0.0, 0.0)


def test_over_time_from_running_sums() -> None:
    """Kills: the mean of the curves in place of Σ Cov/Σ V, sums of the last rows. y(t) = x1 + t x2: S_1 = 1/(1 + t²), over all
    times Σ 1/Σ (1 + t²)."""
    t = np.array([0.0, 1.0, 3.0])
    a, b = (generator(key).standard_normal((30_000, 2)) for key in (16, 17))

    def f(x: Any) -> Any:
        return x[:, :1] + t * x[:, 1:]

    c = np.column_stack([b[:, 0], a[:, 1]])
    shared, kept = RunningSums(3), RunningSums(3)
    for rows in np.array_split(np.arange(30_000), 7):
        shared.add(f(b[rows]), f(c[rows]))
        kept.add(f(a[rows]), f(c[rows]))
    found = over_time(shared, kept)
    exact, whole = 1.0 / (1.0 + t**2), 3.0 / np.sum(1.0 + t**2)
    assert found.first_of == pytest.approx(exact, abs=5 / math.sqrt(30_000))
    assert found.total_of == pytest.approx(exact, abs=5 / math.sqrt(30_000))
    assert (found.first, found.total) == pytest.approx((whole, whole), abs=5 / math.sqrt(30_000))
    together = indices(f(a), f(b), {"x1": f(c)}, rng=generator(18), resamples=0)["x1"]
    assert (together.first.value, together.total.value) == pytest.approx((found.first, found.total), abs=1e-9)


def test_a_lost_row_leaves_the_curves() -> None:
    """Kills: NaN in the sums."""
    y = np.array([[1.0, 2.0], [3.0, np.nan], [5.0, 9.0]])
    sums = RunningSums(2)
    sums.add(y, y)
    covariance, variance = sums.moments()
    assert covariance == pytest.approx(variance)
    assert (sums.n.tolist(), variance[1]) == ([3.0, 2.0], pytest.approx(3.5**2))


@pytest.mark.skipif(importlib.util.find_spec("SALib") is None, reason="SALib is not installed: the closed forms are the check")
def test_salib_agrees() -> None:
    """Kills: whatever the closed forms miss. The same function, SALib's sample and SALib's estimators, within both intervals."""
    from SALib.analyze import sobol as analyse  # pyright: ignore[reportMissingImports]
    from SALib.sample import sobol as sample  # pyright: ignore[reportMissingImports]

    problem = {"num_vars": 3, "names": list(SINGLE), "bounds": [[-np.pi, np.pi]] * 3}
    x = sample.sample(problem, 4096, calc_second_order=False, seed=1)
    theirs = analyse.analyze(problem, ishigami(x), calc_second_order=False, seed=1)
    ours = indices(*designed(ishigami, *cube(8192, 3, 19, -np.pi, np.pi), SINGLE), rng=generator(20), resamples=0)
    for k, name in enumerate(SINGLE):
        assert abs(ours[name].first.value - theirs["S1"][k]) < 2 * theirs["S1_conf"][k] + 0.05
        assert abs(ours[name].total.value - theirs["ST"][k]) < 2 * theirs["ST_conf"][k] + 0.05
