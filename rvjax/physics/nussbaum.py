"""Nussbaum gains: even, smooth functions N(χ) whose mean over [0, χ] swings between −∞ and +∞.

    exp-cos         N(χ) = e^{χ²} cos(πχ/2)          N(0) = 1
    quadratic-cos   N(χ) = χ² cos χ                  N(0) = 0
    none            N(χ) = 1                         no Nussbaum gain, for comparison

R. Nussbaum, "Some remarks on a conjecture in parameter adaptive control", Systems & Control Letters, 1983. An even gain per
channel compensates the unknown slope of the saturation: Xia, Huo, 2018.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import jax.numpy as jnp

from rvjax.physics.elementary import cos, exp
from rvjax.physics.vectors import Scalar


def exp_cos(chi: Scalar) -> Scalar:
    """N(χ) = e^{χ²} cos(πχ/2)."""
    return exp(chi * chi) * cos((0.5 * math.pi) * chi)


def quadratic_cos(chi: Scalar) -> Scalar:
    """N(χ) = χ² cos χ."""
    return chi * chi * cos(chi)


def none(chi: Scalar) -> Scalar:
    """N(χ) = 1."""
    return jnp.ones_like(chi)


GAINS: Mapping[str, Callable[[Scalar], Scalar]] = {"exp-cos": exp_cos, "quadratic-cos": quadratic_cos, "none": none}
