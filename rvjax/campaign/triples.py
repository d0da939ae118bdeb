"""Three plain numbers, the same in every sample: a place, or a direction of any length but 0."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

from rvjax.campaign.plain_values import exact, is_list, is_number
from rvjax.campaign.problems import Problem, refuse, unexpected
from rvjax.elementary import length

Three = tuple[float, float, float]

_SCHEMA: dict[str, Any] = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}


def _triple(raw: Any) -> Three:
    if not is_list(raw) or len(raw) != 3 or not all(is_number(item) for item in raw):
        refuse(unexpected(raw, "accepted: a list of 3 numbers"))
    x, y, z = map(float, raw)
    return x, y, z


def _direction(raw: Any) -> Three:
    along = _triple(raw)
    if not 1e-100 < length(*along) < 1e100:
        refuse(Problem(f"the length is {exact(length(*along))}", "accepted: a direction of any other length"))
    return along


def _maybe_direction(raw: Any) -> Three | None:
    return None if raw is None else _direction(raw)


Triple = Annotated[Three, BeforeValidator(_triple), WithJsonSchema(_SCHEMA)]
Direction = Annotated[Three, BeforeValidator(_direction), WithJsonSchema(_SCHEMA)]
MaybeDirection = Annotated[
    Three | None, BeforeValidator(_maybe_direction), WithJsonSchema({"anyOf": [_SCHEMA, {"type": "null"}]})
]
"""A direction that may be left out."""


def unit(direction: Three) -> Three:
    """The direction with length 1."""
    size = length(*direction)
    x, y, z = (float(part / size) for part in direction)
    return x, y, z
