"""Units in keys: `rate_deg_s` is a stem, `rate`, and a unit, `deg_s`; SI value = number in the key's unit * factor."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Unit:
    """A unit that a key may end in. symbol: of this unit; si: symbol of the unit after loading; name: in words, plural."""

    symbol: str
    si: str
    factor: float
    name: str


NONE = Unit("1", "1", 1.0, "no unit")

UNITS: dict[str, Unit] = {
    "rad_s_per_m": Unit("(rad/s)/m", "(rad/s)/m", 1.0, "radians per second per metre"),
    "deg_s_per_m": Unit("(deg/s)/m", "(rad/s)/m", math.pi / 180, "degrees per second per metre"),
    "m_s_per_m": Unit("(m/s)/m", "(m/s)/m", 1.0, "metres per second per metre"),
    "rad_per_m": Unit("rad/m", "rad/m", 1.0, "radians per metre"),
    "deg_per_m": Unit("deg/m", "rad/m", math.pi / 180, "degrees per metre"),
    "m_per_m": Unit("m/m", "m/m", 1.0, "metres per metre"),
    "kg_m3": Unit("kg/m³", "kg/m³", 1.0, "kilograms per cubic metre"),
    "m2_kg": Unit("m²/kg", "m²/kg", 1.0, "square metres per kilogram"),
    "kgm2": Unit("kg·m²", "kg·m²", 1.0, "kilogram square metres"),
    "rad_s": Unit("rad/s", "rad/s", 1.0, "radians per second"),
    "deg_s": Unit("deg/s", "rad/s", math.pi / 180, "degrees per second"),
    "m_s": Unit("m/s", "m/s", 1.0, "metres per second"),
    "Hz": Unit("Hz", "rad/s", 2.0 * math.pi, "hertz"),
    "Nm": Unit("N·m", "N·m", 1.0, "newton metres"),
    "km": Unit("km", "m", 1e3, "kilometres"),
    "kg": Unit("kg", "kg", 1.0, "kilograms"),
    "deg": Unit("deg", "rad", math.pi / 180, "degrees"),
    "rad": Unit("rad", "rad", 1.0, "radians"),
    "N": Unit("N", "N", 1.0, "newtons"),
    "m": Unit("m", "m", 1.0, "metres"),
    "s": Unit("s", "s", 1.0, "seconds"),
}
"""By key suffix. A suffix comes before the suffixes that it ends in."""


def split(key: str) -> tuple[str, Unit]:
    """`rate_deg_s` → ("rate", deg/s); a key without a known suffix has no unit."""
    for suffix, unit in UNITS.items():
        if key.endswith(f"_{suffix}"):
            return key.removesuffix(f"_{suffix}"), unit
    return key, NONE
