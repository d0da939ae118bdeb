"""The JSON Schema (draft 2020-12) of a campaign file, for editors that complete and check while a person types."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from typing import Any

from rvjax.campaign.fields import Model
from rvjax.campaign.json_forms import distribution, formulas, joint_distribution
from rvjax.campaign.model import Spec
from rvjax.campaign.plain_values import is_list, is_mapping

PYTHON_FILE = r"\.py(:[A-Za-z_][A-Za-z0-9_]*)?$"
"""Pattern of a `use` that names a file."""

DRAFT = "https://json-schema.org/draft/2020-12/schema"


def schema(families: Mapping[str, Mapping[str, type[Model]]] | None = None) -> dict[str, Any]:
    """What a campaign file may say.

    families: for a field of a campaign that uses components (`faults`, `actuators.allocation`, …), the parameters of each
    by name; a field that is not named here accepts any component with any parameters.
    """
    whole = Spec.model_json_schema()
    definitions: dict[str, Any] = whole.pop("$defs")
    for field, members in (families or {}).items():
        declared = _declared(field.split("."), whole, definitions)
        entry = declared.get("items", declared)
        if "anyOf" in declared:  # the name of the component may stand alone
            entry = declared["anyOf"][-1]
            names = ({"enum": [*members]}, {"pattern": PYTHON_FILE})
            declared["anyOf"] = [*({"type": "string", **name} for name in names), entry]
        common = entry.pop("properties")
        entry["oneOf"] = [_component(name, model, common, definitions) for name, model in members.items()]
        entry["oneOf"].append(_file(common))
    whole["properties"]["margins"]["additionalProperties"] = {"$ref": "#/$defs/Margin"}
    shared = {"Distribution": distribution(), "JointDistribution": joint_distribution()}
    compact = _refer({**whole, "$defs": definitions}, shared)
    return {"$schema": DRAFT, **compact, "title": "rvjax campaign", "$defs": compact["$defs"] | shared | formulas()}


def _declared(path: list[str], whole: dict[str, Any], definitions: dict[str, Any]) -> dict[str, Any]:
    """The schema of a field, by its path from the top."""
    first, *deeper = path
    declared: dict[str, Any] = whole["properties"][first]
    for key in deeper:
        forms = (definitions[form["$ref"].rpartition("/")[2]] for form in declared["anyOf"])
        declared = next(form["properties"][key] for form in forms if key in form["properties"])
    return declared


def _file(common: dict[str, Any]) -> dict[str, Any]:
    """A component from a Python file of the user, with any parameters."""
    use = {
        "type": "string",
        "pattern": PYTHON_FILE,
        "description": "a Python file beside the campaign: ./FILE.py or ./FILE.py:NAME",
    }
    return {"type": "object", "properties": deepcopy(common) | {"use": use}, "required": ["use"]}


def _component(name: str, model: type[Model], common: dict[str, Any], definitions: dict[str, Any]) -> dict[str, Any]:
    """The keys of a component with the common keys; the names of its definitions begin with its name."""
    declared = model.model_json_schema(ref_template=f"#/$defs/{name}.{{model}}")
    definitions |= {f"{name}.{inner}": item for inner, item in declared.pop("$defs", {}).items()}
    declared["properties"] = deepcopy(common) | {"use": {"const": name}} | declared.get("properties", {})
    declared["required"] = ["use", *declared.get("required", [])]
    return declared


def _refer(value: Any, shared: Mapping[str, Any]) -> Any:
    """The same schema with a reference wherever a shared one stands."""
    for name, known in shared.items():
        if value == known:
            return {"$ref": f"#/$defs/{name}"}
    if is_mapping(value):
        return {key: _refer(item, shared) for key, item in value.items()}
    return [_refer(item, shared) for item in value] if is_list(value) else value
