"""Thinning and weights: exact laws, coverage, and weights that must be refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import binom, kstest, norm

from rvjax.stats import clopper_pearson
from rvjax.stats.binomial import Estimate
from rvjax.stats.random_streams import uniforms
from rvjax.stats.reweighting import (
    control_variate,
    kept,
    quality,
    self_normalised,
    shares_of_classes,
    tail_shape,
    with_the_rest,
)


def generator(key: int) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(key=key))


def test_what_is_kept_has_the_new_law() -> None:
    """Kills: v > w/W, w without W, the square root of w. Uniform on (0, 1) thinned to the density 2x: the kept have F = x², and
    half of them are kept; Kolmogorov's test and a binomial interval at 1e-6."""
    x, v = generator(1).random(40_000), uniforms(7, "reweigh.thin", np.arange(40_000))[:, 0]
    mask = kept(np.log(2.0 * x), math.log(2.0), v)
    assert kstest(x[mask], lambda q: q**2).pvalue > 1e-6
    assert binom.ppf(1e-6, 40_000, 0.5) < mask.sum() < binom.isf(1e-6, 40_000, 0.5)


def test_a_narrower_uniform_is_a_subset() -> None:
    """Kills: thinning by chance where every weight is 0 or W."""
    x = generator(2).uniform(0.0, 10.0, 1000)
    inside = (x >= 2.0) & (x <= 4.0)
    mask = kept(np.where(inside, math.log(5.0), -math.inf), math.log(5.0), generator(3).random(1000))
    assert np.array_equal(mask, inside)


def test_a_weight_above_the_supremum_is_refused() -> None:
    """Kills: a supremum from the sample, silently too small; an infinite one."""
    with pytest.raises(ValueError, match="above the supremum"):
        kept([0.0, 0.8], 0.7, [0.5, 0.5])
    with pytest.raises(ValueError, match="finite"):
        kept([0.0], math.inf, [0.5])


def test_thinned_intervals_cover() -> None:
    """Kills: Clopper-Pearson with n in place of the kept number, v from the stream of the draws. N(0, 1) thinned to N(0.3, 0.8²),
    failure above 1.5: 2,000 repeats of 300 flights at 95 %; exact intervals miss in at most 5 %."""
    mean, sd, edge, repeats, n = 0.3, 0.8, 1.5, 2000, 300
    exact = norm.sf(edge, mean, sd)
    x, v = generator(4).standard_normal((repeats, n)), generator(5).random((repeats, n))
    log_w = norm.logpdf(x, mean, sd) - norm.logpdf(x)
    peak = mean / (1.0 - sd**2)
    sup = norm.logpdf(peak, mean, sd) - norm.logpdf(peak)
    missed = 0
    for draws, weights, numbers in zip(x, log_w, v, strict=True):
        mask = kept(weights, float(sup), numbers)
        found = clopper_pearson(int(np.count_nonzero(draws[mask] > edge)), int(mask.sum()), 0.95)
        missed += not found.low <= exact <= found.high
    assert missed <= binom.isf(1e-6, repeats, 0.05)


@pytest.mark.parametrize("estimator", [self_normalised, control_variate])
def test_weighted_estimates_are_nominal(estimator: object) -> None:
    """Kills: Σ w² lost in the error, β with the wrong sign, mean(w y) over Σ w. The same law; 600 repeats of 1,000 flights,
    coverage between 92 % and 98 %, and the error bar is the spread of the estimates within 12 %."""
    mean, sd, edge, repeats = 0.3, 0.8, 1.0, 600
    exact, source = norm.sf(edge, mean, sd), generator(6)
    found: list[Estimate] = []
    for _ in range(repeats):
        x = source.standard_normal(1000)
        w = np.exp(norm.logpdf(x, mean, sd) - norm.logpdf(x))
        found.append(estimator(w, x > edge))  # pyright: ignore[reportCallIssue]
    values = np.array([e.value for e in found])
    covered = sum(e.low <= exact <= e.high for e in found)
    assert binom.ppf(1e-3, repeats, 0.92) <= covered <= binom.isf(1e-3, repeats, 0.98)
    assert values.std() == pytest.approx(np.mean([e.high - e.low for e in found]) / 2 / 1.959964, rel=0.12)
    assert abs(values.mean() - exact) < 5 * values.std() / math.sqrt(repeats)


def test_the_control_variate_is_sharper() -> None:
    """Kills: β = 0. Failures where the weight is large: mean(w y) moves with mean(w)."""
    x = generator(7).standard_normal(2000)
    w = np.exp(0.5 * x - 0.125)
    y = x > -1.0
    plain = float(np.std(w * y)) / math.sqrt(2000)
    found = control_variate(w, y)
    assert (found.high - found.value) / 1.959964 < 0.5 * plain


def test_weights_that_cannot_be_averaged() -> None:
    """Kills: each of the three refusals by itself."""
    even = quality(np.ones(5000))
    assert (even.effective, even.largest, even.k) == (pytest.approx(5000), pytest.approx(2e-4), -math.inf)
    assert not even.complaints()
    assert quality(np.ones(50)).complaints()[0].split(",")[0] == "an effective sample size of 50.0"
    one = np.ones(5000)
    one[17] = 60.0
    assert "a weight that is 1.2 % of their sum, above 1 %" in quality(one).complaints()
    heavy = (1.0 - generator(8).random(5000)) ** -0.95
    assert any(text.startswith("a tail of the weights") for text in quality(heavy).complaints())
    assert quality(np.zeros(9)).complaints()


@pytest.mark.parametrize("shape", [0.3, 0.6, 0.9])
def test_the_shape_of_a_pareto_tail(shape: float) -> None:
    """Kills: the sign of k, quantiles from the wrong end. Median of 60 fits to 20,000 exact Pareto values within 0.1."""
    found = [tail_shape((1.0 - generator(100 + key).random(20_000)) ** -shape) for key in range(60)]
    assert np.median(found) == pytest.approx(shape, abs=0.1)


def test_what_lies_beyond_is_unknown() -> None:
    """Kills: q added at the wrong end, q not taken off below, more than 5 % accepted."""
    found = with_the_rest(Estimate(0.9, 0.8, 0.95, 100, 0.95, "x"), 0.04)
    assert (found.low, found.high) == (pytest.approx(0.768), pytest.approx(0.952))
    assert found.low <= found.value <= found.high
    with pytest.raises(ValueError, match=r"0 to 0\.05"):
        with_the_rest(found, 0.06)


def test_classes_have_bars_that_hold_together() -> None:
    """Kills: bars of one class each, equal values in two classes, a class counted twice."""
    x = np.array([1.0, 1.0, 1.0, 2.0, 3.0, 4.0, math.inf, math.inf])
    y = np.array([True, False, False, False, False, True, True, True])
    classes = shares_of_classes(x, y, 4)
    assert [(c.low, c.high, c.share.n) for c in classes] == [(1.0, 1.0, 3), (2.0, 2.0, 1), (3.0, 4.0, 2), (math.inf, math.inf, 2)]
    assert sum(c.share.value * c.share.n for c in classes) == pytest.approx(4.0)
    assert classes[0].share.confidence == pytest.approx(1 - 0.05 / 4)
    alone = clopper_pearson(1, 3, 1 - 0.05 / 4)
    assert (classes[0].share.low, classes[0].share.high) == (alone.low, alone.high)
