"""The keys of a campaign file, read from the models: path, unit, default, range or choices, meaning.

A trail leads from a section down to a key: `pursuer`, `inertia_kgm2`, `principal`. Its steps may pass through lists (`require`)
and through mappings with free names (`where`), which leave no part in the path: `require.where.below`.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple, get_args

from pydantic.fields import FieldInfo

from rvjax.campaign import units
from rvjax.campaign.csv_columns import DeclaredSeries
from rvjax.campaign.declarations import Declared, DeclaredQuantity, declared
from rvjax.campaign.fields import Model
from rvjax.campaign.plain_values import is_list, is_mapping
from rvjax.campaign.quantity import COMPONENTS

LARGE = 2**53
"""A bound of a whole number from here on is not worth telling."""

REQUIRED = "required"

_PLURAL = {"number": "numbers", "whole number": "whole numbers", "text": "texts"}


@dataclass(frozen=True)
class Key:
    """unit: its symbol, "1" for a pure number, "" for what is no number; default: as a campaign says it, or REQUIRED; accepted:
    range, choices or form."""

    path: str
    unit: str
    default: str
    accepted: str
    meaning: str


class Step(NamedTuple):
    """A key of a model."""

    model: type[Model]
    key: str
    info: FieldInfo


Trail = tuple[Step, ...]


def trails(model: type[Model], before: Trail = ()) -> Iterator[Trail]:
    """The trail of every key of a model, each before those of the keys below it."""
    for key, info in model.keys().items():
        trail = (*before, Step(model, key, info))
        yield trail
        for inner in models_in(info.annotation):
            yield from trails(inner, trail)


def models_in(annotation: Any) -> list[type[Model]]:
    """The models that a field may hold, in lists and mappings too; of a model and a variant of it only the model."""
    if inspect.isclass(annotation) and issubclass(annotation, Model):
        return [annotation]
    known = list(dict.fromkeys(model for part in get_args(annotation) for model in models_in(part)))
    return [model for model in known if not any(other is not model and issubclass(model, other) for other in known)]


def path_of(trail: Trail) -> str:
    """`pursuer.mass_kg`."""
    return ".".join(step.key for step in trail)


def names_of(trail: Trail) -> set[str]:
    """Every name that the key has: the end of its path from any step on; in the unit of the draws, or without a unit, too."""
    keys = [step.key for step in trail]
    fields = [next(name for name, info in step.model.model_fields.items() if info is step.info) for step in trail]
    stemmed = [*keys[:-1], units.split(keys[-1])[0]]
    others = [[*keys[:-1], other] for other, field in trail[-1].model.OTHER_UNITS.items() if field in (keys[-1], fields[-1])]
    return {".".join(names[first:]) for names in (keys, fields, stemmed, *others) for first in range(len(names))}


def key_of(trail: Trail, path: str = "") -> Key:
    """What there is to say of a key. path: of the key, where it is not that of the trail."""
    model, key, info = trail[-1]
    return Key(path or path_of(trail), unit_of(key, info), default_of(info), accepted(model, key, info), meaning(info))


def flat(model: type[Model], prefix: str = "") -> Iterator[Key]:
    """The keys of a model, and those of a model inside it in its place."""
    for key, info in model.keys().items():
        inner = info.annotation
        if inspect.isclass(inner) and issubclass(inner, Model):
            yield from flat(inner, f"{prefix}{key}.")
        else:
            yield key_of((Step(model, key, info),), prefix + key)


def unit_of(key: str, info: FieldInfo) -> str:
    """The symbol of the unit in which a campaign writes the key."""
    declaration, unit = declared(info), units.split(key)[1]
    if declaration:
        return declaration.symbol
    if unit is not units.NONE:
        return unit.symbol
    numbers = (part for part in (info.annotation, *get_args(info.annotation)) if part is int)
    return "1" if any(numbers) else ""


def meaning(info: FieldInfo) -> str:
    """The meaning without its unit."""
    declaration = declared(info)
    return declaration.doc if declaration else info.description or ""


def default_of(info: FieldInfo) -> str:
    """The default as a campaign writes it."""
    return REQUIRED if info.is_required() else flow(info.default)


def flow(value: Any) -> str:
    """A plain value in one line of YAML."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return f"{value:.15g}"
    if is_mapping(value):
        return f"{{{', '.join(f'{key}: {flow(item)}' for key, item in value.items())}}}"
    if is_list(value) or isinstance(value, tuple):
        return f"[{', '.join(map(flow, value))}]"
    return str(value) if value != "" else '""'


def accepted(model: type[Model], key: str, info: FieldInfo) -> str:
    """Range, choices or form of a key in words."""
    if inner := models_in(info.annotation):
        return " or ".join(f"{', '.join(form.keys())}" for form in inner)
    declaration = declared(info)
    if declaration is not None:
        return _range(declaration)
    if any(isinstance(item, DeclaredSeries) for item in info.metadata):
        return "name of a CSV file"
    return _words(json_schemas(model)[key])


@cache
def json_schemas(model: type[Model]) -> Mapping[str, Any]:
    """What each key of a model accepts, as JSON Schema."""
    return model.model_json_schema()["properties"]


def _range(declaration: Declared) -> str:
    """`above 0, or drawn`, `x, y, z, each at least 0, or drawn`."""
    limits = declaration.range.words("1")
    if not isinstance(declaration, DeclaredQuantity):
        return limits or "any number"
    several = {"scalar": "", "vector": "x, y, z", "channels": f"{', '.join(COMPONENTS['channels'])}, or one per thruster"}
    words = [several.get(declaration.shape, ""), f"each {limits}" if limits and declaration.shape != "scalar" else limits]
    words.append(f"norm at most {declaration.largest_norm:g}" if declaration.largest_norm is not None else "")
    return ", ".join(filter(None, (*words, "or drawn"))) if any(words) else "any number, or drawn"


def _words(schema: Mapping[str, Any]) -> str:
    """A JSON Schema in words."""
    if "anyOf" in schema or "oneOf" in schema:
        forms = [_words(form) for form in schema.get("anyOf", schema.get("oneOf", ()))]
        return " or ".join(dict.fromkeys(form for form in forms if form and form != "null"))
    if "const" in schema or "enum" in schema:
        return ", ".join(map(str, schema.get("enum", [schema.get("const")])))
    kind = schema.get("type")
    if kind in ("integer", "number"):
        return _bounded("whole number" if kind == "integer" else "number", schema)
    if kind == "array":
        items = _words(schema.get("items", {}))
        return f"list of {_PLURAL.get(items, items) or 'entries'}"
    if kind == "object":
        return f"mapping: {', '.join(schema['properties'])}" if "properties" in schema else "mapping"
    return {"boolean": "true, false", "string": "text", "null": "null"}.get(str(kind), "")


def _bounded(words: str, schema: Mapping[str, Any]) -> str:
    low, high = schema.get("minimum"), schema.get("maximum", LARGE)
    ends = [f"at least {low:,}" if low is not None else "", f"at most {high:,}" if abs(high) < LARGE else ""]
    return ", ".join((words, " and ".join(filter(None, ends)))) if any(ends) else words
