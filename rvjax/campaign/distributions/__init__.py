"""Distributions of drawn numbers, each through its inverse: x = F⁻¹(u) with u uniform in (0, 1).

Inverses follow L. Devroye, "Non-Uniform Random Variate Generation", Springer, 1986, chapters II and V.
"""

from __future__ import annotations

from rvjax.campaign.distributions.bounded import Beta, LogUniform, Triangular, Uniform
from rvjax.campaign.distributions.discrete import Fixed, Pick, Poisson
from rvjax.campaign.distributions.interface import Distribution, JointDistribution
from rvjax.campaign.distributions.joint import Attitude, Ball, Direction, VonMisesFisher
from rvjax.campaign.distributions.normal import HalfNormal, LogNormal, Normal, TruncatedNormal
from rvjax.campaign.distributions.table import Empirical
from rvjax.campaign.distributions.waiting import Exponential, Weibull

__all__ = [
    "Attitude",
    "Ball",
    "Beta",
    "Direction",
    "Distribution",
    "Empirical",
    "Exponential",
    "Fixed",
    "HalfNormal",
    "JointDistribution",
    "LogNormal",
    "LogUniform",
    "Normal",
    "Pick",
    "Poisson",
    "Triangular",
    "TruncatedNormal",
    "Uniform",
    "VonMisesFisher",
    "Weibull",
]
