"""The fixed values of a campaign: every number and choice that is the same in all samples, defaults included."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rvjax.campaign.choice import Choice
from rvjax.campaign.declarations import declared
from rvjax.campaign.distributions import Fixed
from rvjax.campaign.fields import Model
from rvjax.campaign.plain_values import Place, is_list, is_mapping
from rvjax.campaign.quantity import Quantity

Value = tuple[Any, str]
"""A number, a word, true or false, or a list of these; and its unit, SI, empty for what is no number."""

_ELSEWHERE = frozenset(
    ("rvjax", "name", "description", "samples", "seed", "precision", "engine", "require", "keep", "audit", "tune", "baselines")
)
"""Sections that decide no flight of the controller under test, or that the report says elsewhere."""


def fixed_values(spec: Model, parameters: Mapping[Place, Model]) -> dict[str, Value]:
    """The fixed values by name, `controller.gains.k1`, in SI and in the order of the campaign's sections. parameters: of the
    components by `Choice.path`, as their models read them; of the others the values that the campaign says."""
    sections = [name for name in type(spec).model_fields if name not in _ELSEWHERE]
    return dict(pair for name in sections for pair in _of(name, getattr(spec, name), "", parameters))


def _of(name: str, value: Any, unit: str, parameters: Mapping[Place, Model]) -> Iterator[tuple[str, Value]]:
    """A value and what it holds."""
    if isinstance(value, Quantity):
        yield from _quantity(name, value)
    elif isinstance(value, Choice):
        yield value.prefix, (str(value.use), "")
        model = parameters.get(value.path)
        yield from _of(value.prefix, value.parameters if model is None else model, "", parameters)
    elif isinstance(value, Model):
        for field, info in type(value).model_fields.items():
            known = declared(info)
            yield from _of(f"{name}.{field}", getattr(value, field), known.unit if known else "", parameters)
    elif is_mapping(value):
        for key, part in value.items():
            yield from _of(f"{name}.{key}", part, "", parameters)
    elif is_list(value) or isinstance(value, tuple):
        yield from _list(name, value, unit, parameters)
    elif isinstance(value, (bool, int, float, str)):
        yield name, (value, unit)


def _list(name: str, value: Any, unit: str, parameters: Mapping[Place, Model]) -> Iterator[tuple[str, Value]]:
    """A list of plain values is one value; of anything else, each has its number from 1."""
    if value and all(isinstance(part, (bool, int, float, str)) for part in value):
        yield name, (list(value), unit)
        return
    for number, part in enumerate(value, 1):
        yield from _of(name if isinstance(part, Choice) else f"{name}.{number}", part, unit, parameters)


def _quantity(name: str, quantity: Quantity) -> Iterator[tuple[str, Value]]:
    """The components that are fixed, together if all are."""
    fixed = {path: part.low for path, part in zip(quantity.names(name), quantity.parts, strict=False) if isinstance(part, Fixed)}
    if fixed and len(fixed) == len(quantity.names(name)):
        values = list(fixed.values())
        yield name, (values[0] if len(values) == 1 or len(set(values)) == 1 else values, quantity.unit)
    else:
        for path, value in fixed.items():
            yield path, (value, quantity.unit)
