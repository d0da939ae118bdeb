"""Augmented system: an integrator with a leak before the saturation, whose output h(v) follows a virtual wrench α₂.

    v̇ = −κv + N(χ) w̄,   z₃ = h(v) − α₂,   w̄ = −K₃z₃ + κ h'(v) v + α̂̇₂
    χ̇ = γ_χ (z₃/u)(w̄/u) − λ_χ χ;  λ_χ = 0 in the textbook form, χ̇ = 0 without a Nussbaum gain

per channel. With N(χ) h'(v) = 1 and α̂̇₂ = α̇₂ it is ż₃ = −K₃z₃. N: `rvjax.physics.nussbaum`; u: mean of the nominal limits; α̂̇₂: of
a differentiator (`rvjax.physics.differentiators`). The augmented system is from K. Xia, W. Huo, ISA Transactions, 2018; its form
here is a reconstruction. The leak λ_χ is the σ-modification of P. Ioannou, J. Sun, "Robust adaptive control", 1996, ch. 8.
"""

from __future__ import annotations

from typing import NamedTuple

from rvjax.campaign import Model, Quantity, scalar
from rvjax.physics.nussbaum import GAINS
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels, each


class AugmentedGains(Model):
    """Gains of the augmented system."""

    k3: Quantity = scalar("1/s", default=8.0, above=0.0, doc="wrench gain K₃")
    kappa: Quantity = scalar("1/s", default=0.5, above=0.0, doc="leak κ of the augmented state")
    gamma_chi: Quantity = scalar("1", default=0.02, at_least=0.0, doc="rate γ_χ of the Nussbaum arguments")
    leak_chi: Quantity = scalar("1/s", default=0.3, at_least=0.0, doc="leak λ_χ of the Nussbaum arguments, with leakage")


class Wanted(NamedTuple):
    """alpha2: α₂, rate: α̂̇₂; limit: u."""

    alpha2: Channels
    rate: Channels
    limit: Channels


def rates(
    nussbaum: str, leaks: bool, v: Channels, chi: Channels, h: Channels, slope: Channels, wanted: Wanted, gains: Numbers
) -> tuple[Channels, Channels]:
    """(v̇, χ̇). h, slope: h(v) and h'(v). leaks: whether χ has its leak. Gains used: k3, kappa, gamma_chi, leak_chi."""
    z3 = h - wanted.alpha2
    w = slope * v * gains.kappa + wanted.rate - z3 * gains.k3
    v_rate = each(GAINS[nussbaum], chi) * w - v * gains.kappa
    if nussbaum == "none":
        return v_rate, chi * 0.0
    inverse = each(lambda u: 1.0 / u, wanted.limit)
    drive = z3 * inverse * (w * inverse) * gains.gamma_chi
    return v_rate, drive - chi * gains.leak_chi if leaks else drive
