"""Quantiles of the beta law, and the logarithm of the gamma function under them, against 45-digit arithmetic."""

from __future__ import annotations

import time
from decimal import Decimal
from typing import Any

import mpmath
import numpy as np
import pytest
import scipy.special

from rvjax.elementary.incomplete_beta import beta_quantile
from rvjax.elementary.log_gamma import log_beta, log_gamma

LEAST, MOST = 2.0**-54, 1.0 - 2.0**-53
"""Smallest and largest number of a stream."""


@pytest.fixture(autouse=True)
def digits() -> Any:
    """45 digits."""
    with mpmath.workdps(45):
        yield


def below(a: Any, b: Any, x: Any) -> Any:
    """I_x(a, b) by its power series (DLMF 8.17.8)."""
    term = total = mpmath.mpf(1)
    n = 0
    while term > total * mpmath.mpf(10) ** -42:
        term *= (a + b + n) / (a + 1 + n) * x
        total += term
        n += 1
    return total * mpmath.exp(a * mpmath.log(x) + b * mpmath.log1p(-x) - ln_beta(a, b)) / a


def ln_beta(a: Any, b: Any) -> Any:
    return mpmath.loggamma(a) + mpmath.loggamma(b) - mpmath.loggamma(a + b)


def error(a: float, b: float, u: Any, x: float) -> float:
    """Relative error of x ≤ ½ with I_x(a, b) = u: what I_x is off, by x dI/dx."""
    p, q, z = mpmath.mpf(a), mpmath.mpf(b), mpmath.mpf(x)
    slope = mpmath.exp(p * mpmath.log(z) + (q - 1) * mpmath.log1p(-z) - ln_beta(p, q))
    return abs(float((below(p, q, z) - u) / slope))


def worst(a: float, b: float, u: Any) -> float:
    """The largest relative error of the smaller one of x and 1 − x."""
    x, rest = beta_quantile(a, b, u)
    assert np.isfinite([x, rest]).all()
    found = zip(u, x, rest, strict=True)
    return max(
        error(a, b, mpmath.mpf(given), x) if x <= 0.5 else error(b, a, 1 - mpmath.mpf(given), rest) for given, x, rest in found
    )


def uniforms(generator: np.random.Generator, count: int) -> Any:
    """Even ones, and some near both ends."""
    sides = 2.0 ** -generator.uniform(1, 53, (2, count))
    return np.concatenate([generator.uniform(0, 1, count), sides[0], 1.0 - sides[1], [LEAST, MOST, 0.5]])


SHAPES = (
    *((0.1, 0.1), (0.1, 300.0), (300.0, 0.1), (0.5, 0.5), (1.0, 1.0)),
    *((1.0, 7.0), (2.0, 5.0), (40.0, 30.0), (0.3, 2.0), (900.0, 3.0)),
)


@pytest.mark.parametrize(("a", "b"), SHAPES)
def test_both_tails_keep_their_digits(a: float, b: float) -> None:
    """Relative error 2e-13, also of 1 − x near 1. Kills: a wrong term of the fraction, the wrong tail, a step too few."""
    assert worst(a, b, uniforms(np.random.default_rng(3), 12)) <= 2e-13


def test_shapes_of_every_size() -> None:
    """Random shapes. Kills: a start from which the search does not arrive."""
    generator = np.random.default_rng(4)
    for _ in range(30):
        a, b = 10.0 ** generator.uniform(-1, 2.5, 2)
        assert worst(a, b, uniforms(generator, 2)) <= 2e-13, (a, b)


def test_large_shapes() -> None:
    """Up to 1e6, against SciPy where it keeps its digits, in the tail of the smaller probability. Kills: a sum that overflows."""
    u = np.concatenate([np.linspace(0.001, 0.5, 60), [LEAST, 1e-9]])
    for a, b in ((1e6, 1e6), (1e6, 1e5), (50.0, 1e5), (0.1, 1e6), (1e4, 1e6)):
        x, _ = beta_quantile(a, b, u)
        np.testing.assert_allclose(x, scipy.special.betaincinv(a, b, u), rtol=1e-12, err_msg=f"{a} {b}")
        _, rest = beta_quantile(b, a, 1.0 - u)
        upper = u > 0.001  # 1 − u has lost digits of a smaller u
        np.testing.assert_allclose(rest[upper], x[upper], rtol=1e-12, err_msg=f"{b} {a}")


def test_a_number_does_not_depend_on_its_neighbours() -> None:
    """Alone and among others, in any shape. Kills: steps that are counted for all together."""
    u = uniforms(np.random.default_rng(6), 40)
    for a, b in ((0.1, 3.0), (2.0, 5.0), (700.0, 20.0)):
        x, rest = beta_quantile(a, b, u)
        for i in (0, 7, len(u) - 1):
            assert (x[i], rest[i]) == tuple(float(v[0]) for v in beta_quantile(a, b, u[i : i + 1]))
        np.testing.assert_array_equal(beta_quantile(a, b, u[:6].reshape(2, 3))[0], x[:6].reshape(2, 3))


def test_ends() -> None:
    """u = 0 and u = 1. Kills: NaN there."""
    x, rest = beta_quantile(2.0, 5.0, np.array([0.0, 1.0]))
    assert (x.tolist(), rest.tolist()) == ([0.0, 1.0], [1.0, 0.0])


def test_a_chunk_is_fast() -> None:
    """416 numbers of ordinary shapes within 50 ms; they take about 6. Kills: a search that creeps."""
    u = uniforms(np.random.default_rng(7), 138)[:416]
    beta_quantile(2.0, 5.0, u)
    begun = time.perf_counter()
    beta_quantile(2.0, 5.0, u)
    assert time.perf_counter() - begun < 0.25  # five times of that on a busy machine


@pytest.mark.parametrize("x", [1e-6, 0.1, 0.5, 1.0, 2.0, 7.3, 39.9, 40.0, 1234.5, 1e6, 2e6])
def test_log_gamma_has_forty_digits(x: float) -> None:
    """Kills: a wrong Bernoulli number, a series that ends too early."""
    with mpmath.workdps(60):
        wanted = mpmath.loggamma(mpmath.mpf(x))
        found = mpmath.mpf(str(log_gamma(Decimal(x))))
        assert abs(found - wanted) <= mpmath.mpf(10) ** -40 * max(abs(wanted), 1)
        both = mpmath.mpf(str(log_beta(Decimal(x), Decimal("2.5"))))
        assert abs(both - ln_beta(mpmath.mpf(x), mpmath.mpf("2.5"))) <= mpmath.mpf(10) ** -40 * max(abs(wanted), 1)
