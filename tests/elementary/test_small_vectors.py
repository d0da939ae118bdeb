"""Lengths and pseudo-inverses, which are exact up to one rounding."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from rvjax.elementary import length
from rvjax.elementary.pseudo_inverse import pseudo_inverse


def test_lengths_are_rounded_once() -> None:
    """The number nearest to the exact length. Kills: squares that are rounded, an overflow, a lost subnormal number."""
    generator = np.random.default_rng(1)
    with mpmath.workdps(60):
        for parts in (generator.normal(size=(500, 3)) * 10.0 ** generator.uniform(-150, 150, (500, 1))).tolist():
            assert length(*parts) == float(mpmath.sqrt(mpmath.fsum(mpmath.mpf(x) ** 2 for x in parts)))
    assert [length(3.0, 4.0), length(-2.5), length(0.0, 0.0), length()] == [5.0, 2.5, 0.0, 0.0]
    assert length(1e300, 1e300) == pytest.approx(math.sqrt(2.0) * 1e300, rel=1e-15)
    assert [length(1.7e308, 1.7e308), length(math.inf, math.nan)] == [math.inf, math.inf]
    assert math.isnan(length(1.0, math.nan))
    assert length(1e-320, 1e-320) == 1.414e-320


def test_pseudo_inverses_are_rounded_once() -> None:
    """A A⁺ = 1, A⁺ A is symmetric, to the last digit of what is rounded; LAPACK's differs in its last digits. Kills: a sign, a
    row in the wrong place."""
    generator = np.random.default_rng(2)
    for rows, columns in ((1, 1), (3, 5), (6, 12), (6, 24)):
        a = generator.normal(size=(rows, columns)) * (generator.uniform(size=(rows, columns)) < 0.7) + np.eye(rows, columns)
        found = pseudo_inverse(a)
        np.testing.assert_allclose(found, np.linalg.pinv(a), rtol=1e-9, atol=1e-12)
        with mpmath.workdps(40):
            exact = mpmath.matrix(a.tolist())
            wanted = exact.T * (exact * exact.T) ** -1
            assert found.tolist() == [[float(wanted[i, j]) for j in range(rows)] for i in range(columns)]
    with pytest.raises(ValueError, match="dependent rows"):
        pseudo_inverse(np.ones((2, 3)))
