"""Importance sampling that is learned once: its law, its weights, what it refuses; Pareto k and mixtures beside oracles."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from benchmarks import rare_margins
from benchmarks.rare_coverage import repeats_of
from benchmarks.rare_margins import Case
from rvjax.stats.rare import gaussian_mixture, importance
from rvjax.stats.rare.points import Points
from rvjax.stats.rare.tail_index import pareto_shape, tail_index

CASES: dict[str, Case] = {
    "linear": rare_margins.linear(1e-6, 60),
    "two-sided": rare_margins.two_sided(60),
    "4 half-spaces": rare_margins.half_spaces(4, 60),
    "concave": rare_margins.bent(True, 60),
}


@pytest.mark.parametrize("name", CASES)
def test_the_probability_is_met(name: str, full: bool) -> None:
    """200 repeats with `--long`, 1 of some without: those that are not refused have the mean p within chance of 1 in 10,000 (with
    `--long`), the proved bound errs no more often than it says, and at least half of all repeats are not refused.
    Kills: weights of another law than that which was drawn; a mixture in all coordinates, whose weights collapse."""
    if not (full or name in ("two-sided", "concave")):
        pytest.skip("200 repeats: --long")
    case = CASES[name]
    came = [repeat for repeat in repeats_of(case, 200 if full else 1, "importance", 5) if not repeat.refused]
    assert len(came) >= (100 if full else 1)
    ratios = np.array([repeat.estimate for repeat in came]) / case.probability
    assert np.all(np.abs(ratios - 1.0) < 0.5)
    if full:
        error = ratios.std(ddof=1) / math.sqrt(len(ratios))
        assert abs(ratios.mean() - 1.0) <= stats.t.isf(5e-5, len(ratios) - 1) * error
    assert sum(repeat.proved > case.probability for repeat in came) <= stats.binom.isf(1e-4, len(came), 0.05)
    assert sum(not r.low <= case.probability <= r.high for r in came) <= stats.binom.isf(1e-4, len(came), 0.12)


def proposal() -> importance.Proposal:
    """Two parts in coordinates 1 and 3 of 5."""
    mixture = gaussian_mixture.Mixture(np.array([0.3, 0.7]), np.array([[2.0, 0.0], [-1.0, 1.5]]), np.array([0.5, 1.2]))
    return importance.Proposal(5, np.array([1, 3]), mixture)


def test_weights_are_the_ratio_of_the_densities() -> None:
    """φ/q by SciPy, point by point, at most 10. Kills: a missing defensive part, a norm of another dimension."""
    q, rng = proposal(), np.random.default_rng(2)
    z = rng.standard_normal((50, 5)) * 2.0
    x = z[:, q.selected]
    phi = stats.multivariate_normal(np.zeros(2)).pdf(x)
    parts = [
        share * stats.multivariate_normal(mean, variance * np.eye(2)).pdf(x)
        for share, mean, variance in zip(q.mixture.shares, q.mixture.means, q.mixture.variances, strict=True)
    ]
    assert q.weights(z) == pytest.approx(phi / (0.1 * phi + 0.9 * sum(parts)), rel=1e-12)
    assert np.all(q.weights(z) <= 10.0)


def test_points_are_drawn_from_the_law_that_weighs_them() -> None:
    """The mean of φ/q over points of q is 1, and φ/q · z₁² has the mean 1, each within chance of 1 in 10,000. Kills: points
    without the defensive part, variances for deviations."""
    q, rng = proposal(), np.random.default_rng(3)
    points = q.draw(rng, 40_000)
    w = q.weights(points.z)
    for values in (w, w * points.z[:, 1] ** 2, w * points.z[:, 3], points.z[:, 0]):
        expected = 0.0 if values is points.z[:, 0] or abs(values.mean()) < 0.5 else 1.0
        assert abs(values.mean() - expected) < stats.norm.isf(5e-5) * values.std() / math.sqrt(len(values))


def test_the_coordinates_that_matter_are_selected() -> None:
    """A shifted mean, a smaller and a larger variance are selected among 300; nothing else, with a chance of at most 1 % of being
    wrong by construction. Kills: no correction for 300 coordinates, a test of the mean alone."""
    rng = np.random.default_rng(4)
    z = rng.standard_normal((400, 300))
    z[:, 7] += 2.0
    z[:, 100] *= 0.3
    z[:, 200] *= 2.0
    assert importance.select(z, 400).tolist() == [7, 100, 200]


def test_without_a_coordinate_that_matters_the_law_is_the_usual_one() -> None:
    """Failing points that are N(0, I): no coordinate is selected and every weight is 1. Kills: an empty mixture that fails."""
    rng = np.random.default_rng(6)
    q = importance.learn(rng.standard_normal((200, 4)), 20, 1)
    assert len(q.selected) == 0
    assert q.weights(q.draw(rng, 10).z) == pytest.approx(np.ones(10), rel=1e-12)


def weighed(**changed: float) -> importance.Weighed:
    """Weights that nothing speaks against, but for what is changed."""
    sound = importance.Weighed(blocks=(1e-6,) * 20, flights=8000, failing=900, effective=500.0, largest=0.01, shape=0.2)
    return replace(sound, **changed)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"effective": 99.0}, "effective sample size"),
        ({"largest": 0.06}, "one weight is 6 %"),
        ({"shape": 0.71}, "k = 0.71"),
    ],
)
def test_weights_that_cannot_be_trusted_are_refused(changed: dict[str, float], words: str) -> None:
    """Each rule for itself, with its number. Kills: a rule that is missing, a limit of another size."""
    assert weighed().refusals() == []
    assert [words in text for text in weighed(**changed).refusals()] == [True]


def test_splitting_may_refute_it() -> None:
    """Blocks near 1e-6 against replicates near 3e-6 disagree; against replicates near 1.05e-6 they do not. Kills: no
    comparison, one that compares the estimates without their errors."""
    rng = np.random.default_rng(7)
    blocks = tuple(1e-6 * (1 + 0.2 * rng.standard_normal(20)))
    ours = importance.Weighed(blocks, 8000, 900, 500.0, 0.01, 0.2)
    far, near = (tuple(p * (1 + 0.3 * rng.standard_normal(20))) for p in (3e-6, 1.05e-6))
    assert importance.disagreement(ours, far) is not None
    assert importance.disagreement(ours, near) is None


def test_failing_weights_make_the_estimate() -> None:
    """By hand: the mean over all flights of the weights of the failing ones, in blocks. Kills: a mean over the failing alone."""
    q, rng = proposal(), np.random.default_rng(9)
    points = q.draw(rng, 40)
    margins = np.where(np.arange(40) % 3 == 0, -1.0, 1.0)
    margins[1] = np.nan
    came = importance.weigh(q, points, margins, 20)
    w = np.where(margins > 0, 0.0, q.weights(points.z))
    assert np.mean(came.blocks) == pytest.approx(w.mean(), rel=1e-12)
    assert came.failing == 15
    assert came.effective == pytest.approx(w.sum() ** 2 / (w**2).sum(), rel=1e-12)
    assert came.largest == pytest.approx(w.max() / w.sum(), rel=1e-12)


@pytest.mark.parametrize("shape", [-0.3, 0.2, 0.9])
def test_the_shape_of_a_pareto_law_is_recovered(shape: float) -> None:
    """4,000 values of SciPy's generalized Pareto law: k̂ within five asymptotic errors (1 + k)/√n of k, less the prior's pull of
    10/n. Kills: another sign of k, a prior of the wrong weight."""
    x = stats.genpareto(shape).rvs(4000, random_state=np.random.default_rng(1))
    error = max(1.0 + shape, 0.5) / math.sqrt(4000)
    assert pareto_shape(x) == pytest.approx((4000 * shape + 5) / 4010, abs=5 * error)


def test_the_tail_of_few_or_equal_weights() -> None:
    """Fewer than 25 weights have no tail; equal ones the lightest. Kills: a division by 0."""
    assert math.isnan(tail_index(np.ones(24)))
    assert tail_index(np.ones(100)) == -math.inf


def test_the_number_of_parts_is_found() -> None:
    """Three clouds far from each other are three parts with their centres; one cloud is one part. Kills: no price of a part."""
    rng = np.random.default_rng(5)
    centres = np.array([[5.0, 0.0], [-5.0, 0.0], [0.0, 6.0]])
    x = np.concatenate([centre + rng.standard_normal((150, 2)) for centre in centres])
    mixture = gaussian_mixture.fit(x, 6, rng)
    assert len(mixture.shares) == 3
    nearest = np.min(np.linalg.norm(mixture.means[:, None] - centres, axis=2), axis=1)
    assert np.all(nearest < 0.5)
    assert len(gaussian_mixture.fit(rng.standard_normal((300, 2)), 6, rng).shares) == 1


def test_a_fit_is_no_worse_than_the_law_it_came_from() -> None:
    """The likelihood after the iterations is at least that of the true mixture. Kills: variances without the dimension."""
    rng = np.random.default_rng(6)
    true = gaussian_mixture.Mixture(np.array([0.5, 0.5]), np.array([[2.0] * 4, [-2.0] * 4]), np.array([0.7, 1.3]))
    x = true.draw(rng, 500)
    fitted = gaussian_mixture._fit(x, 2, rng)
    assert fitted.log_density(x).mean() >= true.log_density(x).mean()
    assert np.all(np.isfinite(importance.learn(np.hstack([x, rng.standard_normal((500, 2))]), 500, 1).weights(np.zeros((1, 6)))))
    assert isinstance(proposal().draw(rng, 3), Points)
