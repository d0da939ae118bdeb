"""The scene of a sample: what the replay draws beside the motion, as numbers in the target's frame T and the pursuer's frame P.

A drawn number is read from the row of the sample, a fixed one from the campaign. Units: SI.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rvjax.analysis.sample_values import Row, docking_axis, numbers, port
from rvjax.campaign import Spec
from rvjax.campaign.actuators import Thrusters
from rvjax.campaign.hulls import Hull
from rvjax.columns import CHANNELS, draw_column


def scene(spec: Spec, row: Row) -> dict[str, Any]:
    """Port, corridor, keep-out zone, hulls and actuators of a sample."""
    corridor, keep_out = spec.corridor, spec.target.keep_out
    return {
        "port": port(spec, row),
        "axis": docking_axis(spec, row),
        "corridor": {"angle": corridor.half_angle_rad, "radius": corridor.radius_m, "length": corridor.length_m},
        "keepOut": None if keep_out is None else numbers(keep_out.radii_m, "target.keep_out.radii_m", row),
        "target": _hull(spec.target.hull, "target.hull", row),
        "pursuer": _hull(spec.pursuer.hull, "pursuer.hull", row),
        "limits": limits(spec, row),
        "thrusters": _thrusters(spec, row),
    }


def _hull(hull: Hull | None, path: str, row: Row) -> dict[str, Any] | None:
    if hull is None:
        return None
    parts = {"radius": ("radius_m", hull.radius_m), "box": ("box_m", hull.box_m), "centre": ("centre_m", hull.centre_m)}
    given = {key: numbers(quantity, f"{path}.{name}", row) for key, (name, quantity) in parts.items() if quantity is not None}
    return {key: values[0] if key == "radius" else values for key, values in given.items()}


def limits(spec: Spec, row: Row) -> dict[str, list[float]]:
    """The limits of the six channels [N, N·m]: nominal ones times their drawn spread; with thrusters nominal."""
    found: dict[str, list[float]] = {}
    for side in ("upper", "lower"):
        values = numbers(getattr(spec.actuators, side), f"actuators.{side}", row)
        if not isinstance(spec.actuators, Thrusters):
            middle = spec.actuators.spread.medians[0]
            spread = [float(row.get(draw_column(f"actuators.spread.{side}.{name}"), middle)) for name in CHANNELS]
            values = [value * factor for value, factor in zip(values, spread, strict=True)]
        found[side] = values
    return found


def _thrusters(spec: Spec, row: Row) -> list[dict[str, Any]]:
    """Place, direction of the force and largest thrust of each thruster, in P; empty without thrusters."""
    if not isinstance(spec.actuators, Thrusters):
        return []
    layout, middle = spec.actuators.geometry, spec.actuators.spread.medians[0]
    spread = [float(row.get(draw_column(f"actuators.spread.{name}"), middle)) for name in layout.names]
    parts = zip(layout.names, layout.at, layout.along, layout.most, spread, strict=True)
    return [{"name": n, "at": list(at), "along": list(d), "most": most * s} for n, at, d, most, s in parts]


def outside_corridor(place: NDArray[np.float64], spec: Spec, row: Row) -> NDArray[np.bool_]:
    """aᵀq < |q| cos(half angle), q = p − δ + a r/tan(half angle): from the apex. place: p (n, 3), in T [m]."""
    axis, corridor = np.array(docking_axis(spec, row)), spec.corridor
    q = place - np.array(port(spec, row)) + axis * (corridor.radius_m / math.tan(corridor.half_angle_rad))
    return q @ axis < np.linalg.norm(q, axis=1) * math.cos(corridor.half_angle_rad)
