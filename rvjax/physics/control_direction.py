"""Nussbaum gain for channels whose direction is unknown: the sign with which a channel answers its command.

    α₂ = N(η) α₂⁰,      N(η) = (1 + η²/20) cos(πη/2)
    η̇ = γ_η [s − s_f]₊ q − (λ_η/π) sin πη,      ṡ_f = (s − s_f)/T
    s = |z₂|/z̄,      q = −sgn(z₂) α₂⁰/u, clipped to [0, 1]

per channel. α₂⁰: the demand of the law for a known direction; u: mean limit; z̄: v_max or k_σ (the largest virtual speed, and the
virtual rate at |σ| = 1). N is even, N(0) = 1, and its mean swings between −∞ and +∞, as that of a Nussbaum gain does; it grows
slowly, because in the even numbers it multiplies the loop gain. η moves on only while |z₂| grows although the demand opposes it:
[s − s_f]₊ is T times the growth of |z₂|, smoothed over T. The last term pulls η to the nearest even number, where |N| has its
maxima, so noise does not wear the gain away.

The drive of the published proof is γ_η z₂α₂⁰ (R. Nussbaum, Systems & Control Letters, 1983; X. Ye, J. Jiang, "Adaptive nonlinear
design without a priori knowledge of control directions", IEEE Transactions on Automatic Control, 1998). It counts work: what it
takes to brake a channel after its direction was found counts like what was lost before, and drives η past the right sign.
Here η stands while |z₂| falls. What is lost by this: docs/model.md.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, scalar
from rvjax.columns import Column
from rvjax.physics.elementary import cos, sin
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels, Scalar, each

SIGNALS = {"eta": Column("eta", "1", "argument of the Nussbaum gain for an unknown direction")}


class DirectionGains(Model):
    """Gains of the search for the direction; without effect where it is known."""

    gamma_eta: Quantity = scalar("1/s", default=3.0, at_least=0.0, doc="rate γ_η of η, with `direction: unknown`")
    leak_eta: Quantity = scalar("1/s", default=0.3, at_least=0.0, doc="pull λ_η of η to the nearest even number")
    growth_time_s: Quantity = scalar("s", default=3.0, above=0.0, doc="time T over which the growth of |z₂| is smoothed")


class Direction(NamedTuple):
    """eta: η; smooth: s_f [1]."""

    eta: Channels
    smooth: Channels


def start(z2: Channels, gains: Numbers) -> Direction:
    """η = 0 and s_f = s. Gains used: v_max_m_s, k_sigma."""
    size = _size(z2, gains)
    return Direction(size * 0.0, size)


def gain(eta: Scalar) -> Scalar:
    """N(η) = (1 + η²/20) cos(πη/2)."""
    return (1.0 + 0.05 * (eta * eta)) * cos((0.5 * math.pi) * eta)


def rate(state: Direction, z2: Channels, demand: Channels, limit: Channels, gains: Numbers) -> Direction:
    """(η̇, ṡ_f). Gains used: gamma_eta, leak_eta, growth_time_s, v_max_m_s, k_sigma."""
    growth = _size(z2, gains) - state.smooth

    def eta_rate(eta: Scalar, grown: Scalar, z: Scalar, wanted: Scalar, most: Scalar) -> Scalar:
        against = jnp.clip(-jnp.sign(z) * (wanted / most), 0.0, 1.0)
        drive = gains.gamma_eta * (jnp.maximum(grown, 0.0) * against)
        return drive - gains.leak_eta * ((1.0 / math.pi) * sin(math.pi * eta))

    return Direction(each(eta_rate, state.eta, growth, z2, demand, limit), growth * (1.0 / gains.growth_time_s))


def _size(z2: Channels, gains: Numbers) -> Channels:
    """s = |z₂|/z̄."""
    return each(jnp.abs, z2) * Channels.pair(1.0 / gains.v_max_m_s, 1.0 / gains.k_sigma)
