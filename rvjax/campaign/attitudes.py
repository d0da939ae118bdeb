"""Attitudes in three notations. Each says how the body frame is turned out of the reference frame.

    [s1, s2, s3]                                     MRP,  σ = e tan(φ/4),  for a turn by φ about the unit axis e
    {quaternion: {scalar_last: [x, y, z, w]}}        unit quaternion,  (x, y, z) = e sin(φ/2),  w = cos(φ/2)
    {quaternion: {scalar_first: [w, x, y, z]}}       the same, the scalar part first
    {yaw_pitch_roll_deg: [ψ, θ, φ]}                  Euler angles 3-2-1: ψ about z, then θ about the new y, then φ about the new x

All become MRP of the shorter turn, σ = q_v/(1 + |q_0|) with the sign of q_0, so |σ| ≤ 1. A quaternion whose norm is 1 within 1e-6
is normalised, any other is refused. These notations take plain numbers; a drawn attitude is drawn as MRP or by
`{rotation: uniform}`. (J. Diebel, "Representing attitude", 2006; H. Schaub, J. Junkins, "Analytical mechanics of space systems",
chapter 3.)
"""

from __future__ import annotations

import math
from typing import Any

from rvjax.campaign.plain_values import Place, is_list, is_mapping, is_number
from rvjax.campaign.problems import Problem, refuse, unexpected
from rvjax.elementary import cos, length, sin

QUATERNION, EULER = "quaternion", "yaw_pitch_roll_deg"
ORDERS = ("scalar_last", "scalar_first")
NEAR = 1e-6
"""How far the norm of a quaternion may be from 1."""

_INSTEAD = "{quaternion: {scalar_last: [x, y, z, w]}} or {quaternion: {scalar_first: [w, x, y, z]}}"
_ANGLES = "[yaw, pitch, roll] in deg, turned in this order about z, y, x (3-2-1)"

Mrp = tuple[float, float, float]


def read_attitude(raw: Any) -> Mrp | None:
    """The MRP of a quaternion or of Euler angles; None for any other notation. Refuses a mistake in the two, with its place."""
    if is_list(raw) and len(raw) == 4:
        refuse(unexpected(raw, f"accepted: a list of 3 (MRP), or a quaternion as {_INSTEAD}"))
    if not is_mapping(raw) or not raw.keys() & {QUATERNION, EULER}:
        return None
    if len(raw) != 1:
        refuse(unexpected(raw, f"accepted: either {QUATERNION} or {EULER}"))
    ((word, given),) = raw.items()
    return _of_angles(given) if word == EULER else _of_quaternion(given)


def _of_quaternion(given: Any) -> Mrp:
    if not is_mapping(given) or len(given) != 1 or not given.keys() <= set(ORDERS):
        refuse(unexpected(given, f"accepted: the order of the numbers, {_INSTEAD}", (QUATERNION,)))
    ((order, numbers),) = given.items()
    place = (QUATERNION, order)
    form = "[x, y, z, w]" if order == ORDERS[0] else "[w, x, y, z]"
    q = _numbers(numbers, 4, f"accepted: 4 plain numbers {form}", place)
    norm = length(*q)
    if abs(norm - 1.0) > NEAR:
        refuse(Problem(f"the norm of the quaternion is {norm:.9g}", f"accepted: 1 within {NEAR:g}", place))
    vector, scalar = (q[:3], q[3]) if order == ORDERS[0] else (q[1:], q[0])
    return _mrp(scalar, vector)


def _of_angles(given: Any) -> Mrp:
    """Product of the three half turns q = q_z(ψ) q_y(θ) q_x(φ)."""
    angles = _numbers(given, 3, f"accepted: 3 plain numbers {_ANGLES}", (EULER,))
    (cz, sz), (cy, sy), (cx, sx) = ((float(cos(half)), float(sin(half))) for half in (math.radians(a) / 2.0 for a in angles))
    vector = [cz * cy * sx - sz * sy * cx, cz * sy * cx + sz * cy * sx, sz * cy * cx - cz * sy * sx]
    return _mrp(cz * cy * cx + sz * sy * sx, vector)


def _numbers(given: Any, count: int, accepted: str, place: Place) -> list[float]:
    if not is_list(given) or len(given) != count:
        refuse(unexpected(given, accepted, place))
    wrong = [unexpected(item, accepted, (*place, index)) for index, item in enumerate(given) if not is_number(item)]
    return [float(item) for item in given] if not wrong else refuse(*wrong)


def _mrp(scalar: float, vector: list[float]) -> Mrp:
    """σ of the shorter turn, |σ| ≤ 1."""
    norm = length(scalar, *vector)
    x, y, z = (math.copysign(1.0, scalar) * part / (norm + abs(scalar)) for part in vector)
    shrink = 1.0 - 2.0**-51 if length(x, y, z) > 1.0 else 1.0  # half a turn, after rounding
    return x * shrink, y * shrink, z * shrink


def attitude_forms() -> list[dict[str, Any]]:
    """The two notations as JSON Schema."""

    def only(word: str, given: dict[str, Any]) -> dict[str, Any]:
        return {"type": "object", "properties": {word: given}, "required": [word], "additionalProperties": False}

    def numbers(count: int, words: str) -> dict[str, Any]:
        return {"type": "array", "items": {"type": "number"}, "minItems": count, "maxItems": count, "description": words}

    orders = [only(order, numbers(4, form)) for order, form in zip(ORDERS, ("x, y, z, w", "w, x, y, z"), strict=True)]
    return [
        {"description": "a unit quaternion", **only(QUATERNION, {"oneOf": orders})},
        {"description": "Euler angles 3-2-1", **only(EULER, numbers(3, "yaw, pitch, roll [deg]"))},
    ]
