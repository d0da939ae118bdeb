"""Sensitivity from given data, against indices that are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats as scipy_stats

from rvjax.stats import explained

ISHIGAMI = (0.31390519, 0.44241114, 0.0)
"""First-order indices at a = 7, b = 0.1 (T. Ishigami, T. Homma, 1990)."""


def test_the_indices_of_ishigamis_function() -> None:
    """From 4,000 points, to 0.03. Kills: a variance that is divided by the wrong count, classes of unequal size."""
    rng = np.random.default_rng(0)
    x = rng.uniform(-np.pi, np.pi, size=(4000, 3))
    y = np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    for column, expected in zip(x.T, ISHIGAMI, strict=True):
        found = explained(column, y, rng=rng)
        assert found.share.value == pytest.approx(expected, abs=0.03)
        assert found.share.low <= found.share.value <= found.share.high
        assert (found.p < 0.01) == (expected > 0)


def test_nothing_is_explained_by_chance(full: bool) -> None:
    """60 points that do not depend on x: the share is 0 in the mean of 30 repeats, 60 with `--long`, within 4.5 standard errors,
    and p is below 5 % in no more of them than chance allows in 9,999 of 10,000. Kills: no correction for the classes, the wrong
    side of p."""
    rng, repeats = np.random.default_rng(1), 60 if full else 30
    found = [explained(rng.normal(size=60), rng.normal(size=60), rng=rng) for _ in range(repeats)]
    shares = [one.share.value for one in found]
    assert abs(np.mean(shares)) < 4.5 * np.std(shares) / np.sqrt(repeats)
    assert sum(one.p <= 0.05 for one in found) <= scipy_stats.binom.isf(1e-4, repeats, 0.05)


def test_odd_data() -> None:
    """Kills: a division by a variance of 0; values that are alike in two classes; sizes that are no pairs."""
    rng = np.random.default_rng(2)
    assert explained(np.arange(10), np.ones(10), rng=rng).share.value == 0.0
    assert explained(np.ones(10), np.arange(10), rng=rng).share.value == 0.0
    levels = np.repeat([0.0, 1.0], 20)
    assert explained(levels, levels, rng=rng).share.value == 1.0
    for x, y in ((np.arange(3), np.arange(3)), (np.arange(5), np.arange(6))):
        with pytest.raises(ValueError, match="pairs"):
            explained(x, y, rng=rng)
