"""Examples of a campaign's keys, made from the models: each is a section that `rvjax validate` accepts.

A model that couples its keys gives whole examples, `Model.EXAMPLES`; a field may give values, `example=`. All other values come
from the declared default or range. An example is what its model accepts, so no example can be wrong unnoticed.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, get_args, get_origin

from pydantic import ValidationError
from pydantic.fields import FieldInfo
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap

from rvjax.campaign.csv_columns import DeclaredSeries
from rvjax.campaign.csv_files import CsvFile
from rvjax.campaign.declarations import Declared, declared
from rvjax.campaign.fields import Model
from rvjax.campaign.plain_values import is_list, is_mapping
from rvjax.components.manual_keys import json_schemas, models_in

WIDTH = 100
ROWS = 2
"""Rows of a CSV file in an example."""

DRAW = "pursuer.mass_kg"
"""Name of a draw, where a mapping has names of draws as keys."""


@dataclass(frozen=True)
class Example:
    """yaml: sections of a campaign, which replace those of the same name; files: content of the CSV files that it names."""

    yaml: str
    files: Mapping[str, str] = field(default_factory=dict[str, str])


def example(sections: Mapping[str, Any]) -> Example:
    """The example of some sections."""
    files: dict[str, str] = {}
    writer: Any = YAML()
    writer.default_flow_style = None
    writer.width = WIDTH
    text = io.StringIO()
    whole = CommentedMap(_plain(sections, files))
    whole.fa.set_block_style()
    writer.dump(whole, text)
    return Example(text.getvalue(), files)


def mappings(model: type[Model], trail: Sequence[str] = ()) -> Iterator[dict[str, Any]]:
    """What a campaign may say of a model, with the key at the end of the trail; every mapping is one that the model accepts."""
    starts = _starts(model)
    if not trail:
        yield starts[0]
        return
    key, *deeper = trail
    if not deeper:
        yield from (start for start, given in zip(starts, model.EXAMPLES, strict=False) if key in given)
    for value in values(model, key, deeper):
        for start in starts:
            said = {**start, key: value}
            with suppress(ValidationError):
                model.model_validate(said)
                yield said
    yield from (start for start in starts if _has(start, trail))


def _has(said: Any, trail: Sequence[str]) -> bool:
    """Whether there is a key at the end of a trail, in any entry of the lists on the way."""
    if is_list(said):
        return any(_has(item, trail) for item in said)
    return not trail or (is_mapping(said) and trail[0] in said and _has(said[trail[0]], trail[1:]))


def _starts(model: type[Model]) -> list[dict[str, Any]]:
    """The required keys with each of the model's examples."""
    required = [key for key, info in model.keys().items() if info.is_required()]
    return [
        {key: given[key] if key in given else next(values(model, key)) for key in dict.fromkeys((*required, *given))}
        for given in model.EXAMPLES or ({},)
    ]


def values(model: type[Model], key: str, deeper: Sequence[str] = ()) -> Iterator[Any]:
    """Values of a key that show the key at the end of a trail below it; the best first."""
    info = model.keys()[key]
    if not deeper:
        yield from info.examples or ()
    for inner in models_in(info.annotation):
        known = inner.keys()
        if not deeper or deeper[0] in known:
            yield from (_around(info.annotation, said) for said in mappings(inner, deeper))
    if not deeper:
        yield from _plain_values(model, key, info)


def _plain_values(model: type[Model], key: str, info: FieldInfo) -> Iterator[Any]:
    """Values of a key, from its range, its choices and its default."""
    declaration, default = declared(info), None if info.is_required() else info.default
    if declaration is not None:
        yield from (value for value in (default, _inside(declaration)) if value not in (None, 0.0))
        yield 0.0
        return
    for item in info.metadata:
        if isinstance(item, DeclaredSeries):
            yield _file(item)
    if default not in (None, "", [], (), {}, False):
        yield default
    yield from _of_schema(json_schemas(model)[key])
    yield default


def _around(annotation: Any, inner: Any) -> Any:
    """The value of a field that holds a model: alone, in a list, or in a mapping with a free name."""
    origins = {get_origin(annotation), *(get_origin(part) for part in get_args(annotation))}
    if tuple in origins:
        return [inner]
    return inner if not any(isinstance(origin, type) and issubclass(origin, Mapping) for origin in origins) else {DRAW: inner}


def _inside(declaration: Declared) -> float:
    """A number inside the declared range, none of its ends, and not 0."""
    limits = declaration.range
    low = limits.at_least if limits.above is None else limits.above
    high = limits.at_most if limits.below is None else limits.below
    if low is not None and high is not None:
        return low + 0.25 * (high - low)
    if low is not None:
        return low + 0.5
    if high is not None:
        return high - 0.5
    return 0.1 * (getattr(declaration, "largest_norm", None) or 1.0)


def _file(item: DeclaredSeries) -> CsvFile:
    """A CSV file with the required columns and the first of the others."""
    names = (*item.columns, *item.optional[:1]) or (DRAW,)
    rows = tuple((row + 2, tuple(f"{100.0 + row if name == DRAW else row:g}" for name in names)) for row in range(ROWS))
    return CsvFile("table.csv", names, rows)


def _of_schema(schema: Mapping[str, Any]) -> Iterator[Any]:
    """Values that a JSON Schema accepts."""
    for form in (schema, *schema.get("anyOf", ())):
        kind = form.get("type")
        if "enum" in form or "const" in form:
            yield from form.get("enum", [form.get("const")])
        elif kind == "boolean":
            yield True
        elif kind in ("integer", "number"):
            yield max(1, form.get("minimum", 1))
        elif kind == "string":
            yield "text"
        elif kind == "array":
            yield [next(_of_schema(form.get("items", {})), "text")] * form.get("minItems", 1)


def _plain(value: Any, files: dict[str, str]) -> Any:
    """The value with the names of its CSV files instead of the files, whole numbers as such."""
    if isinstance(value, CsvFile):
        lines = [value.names, *(cells for _, cells in value.rows)]
        files[value.name] = "".join(f"{','.join(line)}\n" for line in lines)
        return value.name
    if is_mapping(value):
        return {str(key): _plain(item, files) for key, item in value.items()}
    if is_list(value) or isinstance(value, tuple):
        return [_plain(item, files) for item in value]
    return int(value) if isinstance(value, float) and value.is_integer() and abs(value) < 1e9 else value
