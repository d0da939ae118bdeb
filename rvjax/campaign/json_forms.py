"""What a drawn number and a drawn vector look like in a campaign, as JSON Schema."""

from __future__ import annotations

from typing import Any

from rvjax.campaign.distribution_notation import ABOUT, LAWS, RADIAL
from rvjax.campaign.formula import WINDOW


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


def formulas() -> dict[str, Any]:
    """A formula of a temporal margin, and a state of one instant, which it is made of; they refer to each other."""

    def either(name: str, *more: dict[str, Any]) -> dict[str, Any]:
        itself = {"$ref": f"#/$defs/{name}"}
        several = {"type": "array", "items": itself, "minItems": 1}
        return {"oneOf": [*more, _only("all", several), _only("any", several), _only("not", itself)]}

    seconds = {"type": "number", "minimum": 0, "description": "s"}
    window = dict.fromkeys(WINDOW, seconds)
    number = {"type": "number", "description": "in the unit of the signal"}
    sides = {"signal": {"type": "string"}, "below": number, "above": number, "scale": number | {"exclusiveMinimum": 0}}
    predicate = {
        "type": "object",
        "properties": sides,
        "required": ["signal"],
        "oneOf": [{"required": ["below"]}, {"required": ["above"]}],
    }
    state = either("State", predicate | {"additionalProperties": False})
    timed = either("State", {**predicate, "properties": sides | window, "additionalProperties": False})
    timed["oneOf"][1:] = [{**form, "properties": form["properties"] | window} for form in timed["oneOf"][1:]]
    until = {"hold": {"$ref": "#/$defs/State"}, "reach": {"$ref": "#/$defs/State"}, **window}
    pair = {"type": "object", "properties": until, "required": ["hold", "reach"], "additionalProperties": False}
    temporal = [_only("always", timed), _only("eventually", timed), _only("until_settled", {"$ref": "#/$defs/State"})]
    formula = either("Formula", *temporal, _only("until", pair))
    return {"Formula": formula, "State": state, "Margin": {"oneOf": [*formula["oneOf"], _only("time_share", timed)]}}
