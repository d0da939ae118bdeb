"""Margins whose probability of failure is known exactly, for `benchmarks.rare_coverage` and the tests of `rvjax.stats.rare`.

A margin is a function of points z (n, d) of standard normal space and keys (n,) of noise; the flight fails where it is ≤ 0.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import special

Values = NDArray[np.float64]
Keys = NDArray[np.int64]

LINEAR = {1e-5: 4.264890793922825, 1e-6: 4.753424308822899, 1e-7: 5.1993375821928165, 1e-9: 5.9978070150076865}
"""β of p = Φ(−β)."""


class Case(NamedTuple):
    """margin(z, keys); dimension d; probability p, exact; noisy: whether the keys matter."""

    margin: Callable[[Values, Keys], Values]
    dimension: int
    probability: float
    noisy: bool = False


def linear(p: float, dimension: int = 200) -> Case:
    """β − z₁"""
    return Case(lambda z, keys: LINEAR[p] - z[:, 0], dimension, p)


def two_sided(dimension: int = 200) -> Case:
    """β − |z₁|, p = 2 Φ(−β)"""
    return Case(lambda z, keys: 4.891638475698591 - np.abs(z[:, 0]), dimension, 1e-6)


def half_spaces(count: int, dimension: int = 200) -> Case:
    """β − max(z₁ … z_K), p = 1 − Φ(β)^K"""
    beta, p = {4: (5.0, 1.1466057945e-6), 10: (4.5, 3.39762117638e-5)}[count]
    return Case(lambda z, keys: beta - z[:, :count].max(axis=1), dimension, p)


def far_out(dimension: int = 100) -> Case:
    """c − |z|², p = P(χ²_d > c)"""
    limit = {100: 182.1267771, 300: 431.1413577}[dimension]
    return Case(lambda z, keys: limit - np.sum(z * z, axis=1), dimension, 1e-6)


def bent(inwards: bool, dimension: int = 200) -> Case:
    """β − z₁ ± (κ/2) χ²_9 of z₂ … z₁₀: the failing side is convex with +, concave with −."""
    beta, bend, p = (5.0, -0.05, 1.04948506759e-6) if inwards else (4.0, 0.2, 1.76515410774e-6)
    return Case(lambda z, keys: beta - z[:, 0] + 0.5 * bend * np.sum(z[:, 1:10] ** 2, axis=1), dimension, p)


def waiting(dimension: int = 100) -> Case:
    """150 − Σ of 100 exponentials, x_i = −ln Φ(−z_i)"""
    return Case(lambda z, keys: 150.0 + np.sum(special.log_ndtr(-z), axis=1), dimension, 5.92454033548e-6)


def rounded(dimension: int = 50) -> Case:
    """The linear margin rounded up to quarters and capped at 3, where 93 % of the flights are."""
    beta = LINEAR[1e-5]
    return Case(lambda z, keys: np.minimum(np.ceil(4.0 * (beta - z[:, 0])) / 4.0, 3.0), dimension, 1e-5)


def hidden(dimension: int = 50) -> Case:
    """A pocket z₂ > 3.54 (p = 2e-4) without any slope, beside a decoy z₁ > 4.75 (p = 1e-6) that slopes."""
    p = 1.0 - (1.0 - 1e-6) * special.ndtr(3.54)
    return Case(lambda z, keys: np.where(z[:, 1] > 3.54, -1.0, LINEAR[1e-6] - z[:, 0]), dimension, float(p))


STEPS = 16


def end_value(dimension: int = 20) -> Case:
    """β − (0.8 z₁ + 0.6 x_T), x the Ornstein-Uhlenbeck process x' = a x + √(1 − a²) ξ, a = 0.9, that a key drives.

    A move draws the whole noise again or none of it: the more the noise decides, the larger the variance.
    """

    def margin(z: Values, keys: Keys) -> Values:
        x = _normal(keys, 0)
        for step in range(1, STEPS + 1):
            x = 0.9 * x + np.sqrt(1.0 - 0.81) * _normal(keys, step)
        return LINEAR[1e-5] - (0.8 * z[:, 0] + 0.6 * x)

    return Case(margin, dimension, 1e-5, noisy=True)


def _normal(keys: Keys, step: int) -> Values:
    """(n,) normal numbers of a step, by the mixing function of splitmix64."""
    x = keys.astype(np.uint64) * np.uint64(2 * STEPS) + np.uint64(step)
    with np.errstate(over="ignore"):
        for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
            x += np.uint64(0x9E3779B97F4A7C15)
            x = (x ^ (x >> np.uint64(shift))) * np.uint64(factor)
        x ^= x >> np.uint64(31)
    return special.ndtri(((x >> np.uint64(11)).astype(float) + 0.5) * 2.0**-53)


CASES: dict[str, Callable[[], Case]] = {
    "linear 1e-5": lambda: linear(1e-5),
    "linear 1e-6": lambda: linear(1e-6),
    "linear 1e-7": lambda: linear(1e-7),
    "linear 1e-9": lambda: linear(1e-9),
    "two-sided 1e-6": two_sided,
    "4 half-spaces": lambda: half_spaces(4),
    "10 half-spaces": lambda: half_spaces(10),
    "χ² of 100": lambda: far_out(100),
    "χ² of 300": lambda: far_out(300),
    "convex": lambda: bent(False),
    "concave": lambda: bent(True),
    "100 exponentials": waiting,
    "rounded and capped": rounded,
    "noise in flight": end_value,
}
"""Every case that splitting is expected to estimate well."""
