"""The body that the defaults of the controllers were tuned for, and how a default follows the nominal body of a campaign.

    default = number · (m₀ / 100 kg)   or   number · (J₀ / 21.67 kg·m²)

m₀, J₀: mass and mean moment of inertia of the campaign's nominal pursuer (`rvjax.campaign.nominal_body`). A pursuer with c times
the mass and the inertia, c times the actuators and c times the disturbances then makes the same motion.
"""

from __future__ import annotations

from typing import Literal

Follows = Literal["mass", "inertia"]

REFERENCE = {"mass": 100.0, "inertia": 65.0 / 3.0}
"""Mass [kg] and mean moment of inertia [kg·m²]: the nominal pursuer of most campaigns in campaigns/."""

UNITS = {"mass": "kg", "inertia": "kg·m²"}

DIGITS = 12
"""Significant digits of a default that follows the nominal body: the last bits of a median differ between machines."""


def rounded(value: float) -> float:
    """The value to DIGITS digits."""
    return float(f"{value:.{DIGITS}g}")


def words(default: float, follows: Follows) -> str:
    """`0.7 × the nominal mass of the pursuer`."""
    share = f"{default / REFERENCE[follows]:.3g}"
    if default == 0.0:
        return "0"
    return f"{'' if share == '1' else f'{share} × '}the nominal {follows} of the pursuer"
