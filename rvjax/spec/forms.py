"""What a drawn number and a drawn vector look like in a campaign, as JSON Schema."""

from __future__ import annotations

from typing import Any

from rvjax.spec.notation import ABOUT, LAWS, RADIAL


def _only(word: str, given: dict[str, Any]) -> dict[str, Any]:
    return {"type": "object", "properties": {word: given}, "required": [word], "additionalProperties": False}


def _numbers(names: tuple[str, ...]) -> dict[str, Any]:
    number = {"type": "number"}
    if len(names) == 1:
        return number | {"description": names[0]}
    return {
        "type": "array",
        "items": number,
        "minItems": len(names),
        "maxItems": len(names),
        "description": ", ".join(names),
    }


def distribution() -> dict[str, Any]:
    """One of the laws of a scalar."""
    values = {"type": "array", "items": {"type": "number"}, "minItems": 1}
    weighted = {
        "type": "object",
        "properties": {"values": values, "weights": values},
        "required": ["values", "weights"],
    }
    laws = [_only(word, _numbers(names)) for word, (names, _) in LAWS.items()]
    choice = _only("choice", {"anyOf": [values, weighted | {"additionalProperties": False}]})
    column = {"csv": {"type": "string"}, "column": {"type": "string"}, "interpolate": {"type": "boolean"}}
    table = {"type": "object", "properties": column, "required": ["csv", "column"], "additionalProperties": False}
    return {"description": "a drawn number", "oneOf": [*laws, choice, _only("table", table)]}


def joint_distribution() -> dict[str, Any]:
    """One of the laws of a whole vector."""
    halves = {"anyOf": [_numbers(("half side",)), _numbers(("x", "y", "z"))]}
    laws = [_only(word, _numbers(("radius",))) for word in RADIAL]
    about = {"mean": _numbers(("x", "y", "z")), "kappa": {"type": "number"}, "radius": {"type": "number"}}
    whole = {"type": "object", "properties": about, "required": list(ABOUT), "additionalProperties": False}
    return {"description": "a drawn vector", "oneOf": [_only("box", halves), *laws, _only("von_mises_fisher", whole)]}


def drawn_attitude() -> dict[str, Any]:
    """A rotation that is uniform over all rotations, as modified Rodrigues parameters."""
    return {"description": "a drawn attitude", **_only("rotation", {"const": "uniform"})}
