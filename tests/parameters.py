"""Parameters for any member of a family, built from what its model declares: no test lists the members by hand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import count
from typing import Any

from pydantic import ValidationError, WithJsonSchema
from pydantic.fields import FieldInfo

from rvjax.campaign import Model
from rvjax.campaign.declarations import Declared, DeclaredNumber, declared
from rvjax.components.registry import component

Said = dict[str, Any]


def example(family: str, use: str, *, drawn: bool = True, apart: type[Model] = Model) -> Said:
    """What a campaign may say of a member: the fullest of three mappings that its model accepts.

    Every number that the model declares; those that are not null by default; the required ones alone. drawn: uniform in a range
    instead of fixed. apart: a model whose keys are left out, such as the one that all members of the family share.
    """
    model = component(family, use).parameters
    shared = apart.keys()
    keys = {key: info for key, info in model.keys().items() if key not in shared}
    refused: ValidationError | None = None
    for chosen in _choices(keys):
        said = {key: value for key, info in chosen.items() if (value := _value(info, drawn)) is not None}
        try:
            model.model_validate(said | {key: 1.0 for key, info in shared.items() if info.is_required()})
        except ValidationError as error:
            refused = error
        else:
            return said
    raise AssertionError(f"{family}, {use}: no example fits its model: {refused}")


def _choices(keys: Mapping[str, FieldInfo]) -> Iterator[dict[str, FieldInfo]]:
    yield dict(keys)
    yield {key: info for key, info in keys.items() if info.is_required() or info.default is not None}
    yield {key: info for key, info in keys.items() if info.is_required()}


def _value(info: FieldInfo, drawn: bool) -> Any:
    """A value for a key; None: leave it at its default."""
    declaration = declared(info)
    if declaration is not None:
        low, high = _inside(declaration)
        return {"uniform": [low, high]} if drawn and not isinstance(declaration, DeclaredNumber) else low
    for item in info.metadata:
        if isinstance(item, WithJsonSchema) and "array" in str(item.json_schema.get("type", "")):
            return _of_schema(item.json_schema, count())
    if info.annotation is int and info.is_required():
        return max([getattr(item, "ge", 0) or 0 for item in info.metadata], default=0) + 1
    return None


def _inside(declaration: Declared) -> tuple[float, float]:
    """Two numbers inside the declared range, neither of them 0."""
    limits = declaration.range
    low = limits.at_least if limits.above is None else limits.above
    high = limits.at_most if limits.below is None else limits.below
    if low is not None and high is not None:
        return low + 0.25 * (high - low), low + 0.4 * (high - low)
    if low is not None:
        return low + 0.5, low + 1.0
    if high is not None:
        return high - 1.0, high - 0.5
    most = getattr(declaration, "largest_norm", None) or 1.0
    return 0.1 * most, 0.2 * most


def _of_schema(schema: Mapping[str, Any], numbers: Iterator[int]) -> Any:
    """The shortest array that a JSON Schema accepts; its numbers rise."""
    if schema.get("type") == "array":
        return [_of_schema(schema["items"], numbers) for _ in range(schema.get("minItems", 1))]
    return 0.5 * next(numbers)
