"""Verdicts that may be looked at after every sample: e-processes and the sequential probability ratio test.

Failures are counted as samples come. An e-process is a likelihood ratio whose expected value under the hypothesis is <= 1 at
every time, so it ever reaches 1/alpha with probability <= alpha (Ville), whatever the rule for stopping. All values are
logarithms, so no number of samples is too large.

Sources: J. Ville, Étude critique de la notion de collectif (1939); H. Robbins, Ann. Math. Stat. 41 (1970) 1397 (mixtures);
A. Wald, Ann. Math. Stat. 16 (1945) 117 (ratio test).
"""

from __future__ import annotations

import numpy as np
import scipy  # pyright: ignore[reportMissingTypeStubs]  # imports `special` when it is first used: a fifth of a second
from numpy.typing import ArrayLike, NDArray

from rvjax.stats._binomial import check_share, invalid, largest, whole
from rvjax.stats.boundary_crossing import Boundary

SMALL = 1e-250
"""Below this the tail of the Beta distribution is computed from its continued fraction, which cannot underflow."""

TERMS = 100
"""Most terms of that fraction; for such small tails it needs less than ten."""


def log_e_pass(n: ArrayLike, failures: ArrayLike, p0: float) -> NDArray[np.float64]:
    """ln of the mean over p of p^s (1-p)^f / (p0^s (1-p0)^f), p ~ Beta(1/2, 1/2) restricted to (p0, 1].

    s = n - failures, f = failures. An e-process against H0: P(success) <= p0, so PASS once it is >= ln(1/alpha): for every
    p <= p0 that ever happens with probability <= alpha. Broadcasts n and failures, falls with the failures.
    ValueError unless 0 <= failures <= n and 0 < p0 < 1. Source: Robbins (1970).
    """
    check_share("p0", p0)
    size, f = np.broadcast_arrays(whole("n", n), whole("failures", failures))
    if np.any(f > size):
        raise invalid("failures must be between 0 and n", f"{failures} of {n}")
    return _log_e(size, f, p0)


def log_e_fail(n: ArrayLike, failures: ArrayLike, p0: float) -> NDArray[np.float64]:
    """ln of the mean over p of p^s (1-p)^f / (p0^s (1-p0)^f), p ~ Beta(1/2, 1/2) restricted to [0, p0).

    The mirror image of `log_e_pass`: an e-process against H0: P(success) >= p0, so FAIL once it is >= ln(1/alpha). Rises
    with the failures.
    """
    size, f = np.broadcast_arrays(whole("n", n), whole("failures", failures))
    return log_e_pass(size, np.asarray(size - f), 1 - p0)


def e_boundary(looks: ArrayLike, p0: float, alpha: float) -> Boundary:
    """The most failures with log_e_pass >= ln(1/alpha) and the least with log_e_fail >= ln(1/alpha), at every look.

    PASS with P(success) <= p0, and FAIL with P(success) >= p0, have probability <= alpha, for any number of looks.
    `looks`: numbers of samples; all of 1..10^6 take seconds at most. ValueError unless p0 and alpha are between 0 and 1.
    """
    check_share("p0", p0)
    check_share("alpha", alpha)
    n, enough = whole("looks", looks), -np.log(alpha)
    passes = largest(lambda f, size: _log_e(size, f, p0) >= enough, n)
    successes = largest(lambda s, size: _log_e(size, s, 1 - p0) >= enough, n)
    return Boundary(n, passes, n - successes)


def log_ratio(n: ArrayLike, failures: ArrayLike, p0: float, p1: float) -> NDArray[np.float64]:
    """(n - f) ln(p1 / p0) + f ln((1 - p1) / (1 - p0)): the log-likelihood ratio of a share p1 of successes against p0 < p1.

    Broadcasts. ValueError unless 0 < p0 < p1 < 1 and 0 <= failures <= n. Source: Wald (1945).
    """
    gain, loss = _steps(p0, p1)
    size, f = np.broadcast_arrays(whole("n", n), whole("failures", failures))
    if np.any(f > size):
        raise invalid("failures must be between 0 and n", f"{failures} of {n}")
    return (size - f) * gain - f * loss


def sprt_boundary(looks: ArrayLike, p0: float, p1: float, alpha: float, beta: float) -> Boundary:
    """PASS where log_ratio >= ln(1/alpha), FAIL where it is <= ln(beta): straight lines of failures over samples.

    P(PASS) <= alpha for every p <= p0 and P(FAIL) <= beta for every p >= p1, for any number of looks (Ville). The bounds of
    Wald, ln((1 - beta)/alpha) and ln(beta/(1 - alpha)), are a little narrower and may exceed alpha and beta.
    `looks`: numbers of samples. ValueError unless 0 < p0 < p1 < 1 and alpha, beta are between 0 and 1.
    """
    check_share("alpha", alpha)
    check_share("beta", beta)
    gain, loss = _steps(p0, p1)
    n = whole("looks", looks)
    reach = n * gain
    passes = np.floor((reach + np.log(alpha)) / (gain + loss)).astype(np.int64)
    fails = np.ceil((reach - np.log(beta)) / (gain + loss)).astype(np.int64)
    return Boundary(n, np.maximum(passes, -1), np.minimum(fails, n + 1))


def _steps(p0: float, p1: float) -> tuple[float, float]:
    """What a success adds to the log-likelihood ratio and what a failure subtracts, both > 0."""
    check_share("p0", p0)
    check_share("p1", p1)
    if not p0 < p1:
        raise invalid("p1 must be larger than p0", f"{p1} and {p0}")
    return float(np.log(p1 / p0)), float(np.log1p(-p0) - np.log1p(-p1))


def _log_e(n: NDArray[np.int64], failures: NDArray[np.int64], p0: float) -> NDArray[np.float64]:
    """log_e_pass without its checks: B(a, b) I_q(a, b) / (B(1/2, 1/2) I_q(1/2, 1/2) q^f p0^s), q = 1 - p0, a = f + 1/2."""
    q = 1 - p0
    a, b = np.asarray(failures + 0.5, dtype=float), np.asarray(n - failures + 0.5, dtype=float)
    prior = np.log(scipy.special.betainc(0.5, 0.5, q)) + np.log(np.pi)
    tail = scipy.special.betainc(a, b, q)
    likelihood = failures * np.log(q) + (n - failures) * np.log(p0)
    with np.errstate(divide="ignore"):
        result = scipy.special.betaln(a, b) + np.log(tail) - likelihood - prior
    small = tail < SMALL
    if np.any(small):
        # here q^f p0^s cancels against the head of the tail, q^a p0^b / (a B(a, b)) x fraction
        result = np.asarray(result)
        result[small] = 0.5 * np.log(q * p0) - np.log(a[small]) + _log_fraction(a[small], b[small], q) - prior
    return np.asarray(result)


def _log_fraction(a: NDArray[np.float64], b: NDArray[np.float64], x: float) -> NDArray[np.float64]:
    """ln of the continued fraction I_x(a, b) a B(a, b) / (x^a (1 - x)^b) = 1/(1+ d1/(1+ d2/(1+ ...))), x below a/(a + b).

    Evaluated by Lentz's method. Source: M. Abramowitz & I. A. Stegun (1964), 26.5.8.
    """
    c, d = np.ones(a.shape), 1 / (1 - (a + b) * x / (a + 1))
    value = d
    for m in range(1, TERMS):
        even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))
        d, c = 1 / (1 + even * d), 1 + even / c
        value = value * (d * c)
        odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))
        d, c = 1 / (1 + odd * d), 1 + odd / c
        value = value * (d * c)
        if np.all(np.abs(d * c - 1) < 1e-15):
            break
    return np.log(value)
