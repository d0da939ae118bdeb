"""A table as CSV with a companion that has units and descriptions, as JSON, and as MATLAB v5: bytes, some rows at a time."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator
from itertools import chain
from typing import Any

import pandas as pd

from rvjax.columns import Column
from rvjax.errors import UsageError
from rvjax.export import matlab
from rvjax.export.exported import Exported

FORMAT = 1
"""Of the JSON document."""

ROWS = 16_384
"""Rows that are written at once."""

_FACTS = ("name", "unit", "description", "better", "kind", "law")
_KEYWORDS = frozenset(
    (
        *("break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for", "function", "global", "if"),
        *("otherwise", "parfor", "persistent", "return", "spmd", "switch", "try", "while"),
    )
)


def csv(table: Exported) -> tuple[Iterator[bytes], Iterator[bytes]]:
    """The table, numbers in the shortest digits that give the same bits; and its columns: name, unit, description."""
    rows = [{fact: getattr(_column(table, name), fact) for fact in _FACTS} for name in table.frame.columns]
    return _lines(table.frame), _lines(pd.DataFrame(rows, columns=_FACTS))


def document(table: Exported) -> Iterator[bytes]:
    """Strict JSON: facts of the run, columns, and an array for each column. Not finite numbers are the words NaN, Infinity and
    -Infinity."""
    columns = {name: {fact: getattr(_column(table, name), fact) for fact in _FACTS[1:]} for name in table.frame.columns}
    head = _dumped({"format": FORMAT, "table": table.name, "run": dict(table.facts), "columns": columns, "data": {}})
    yield head.removesuffix(b"}}")
    for place, (name, series) in enumerate(table.frame.items()):
        yield (b", " if place else b"") + _dumped(str(name)) + b": ["
        for begin in _blocks(len(series)):
            values = _dumped([_json(value) for value in series.iloc[begin : begin + ROWS].tolist()])
            yield (b", " if begin else b"") + values.removeprefix(b"[").removesuffix(b"]")
        yield b"]"
    yield b"}}\n"


def mat(table: Exported) -> Iterator[bytes]:
    """MATLAB v5: a struct of columns, and structs with the same fields: units, descriptions, names; and run, a struct of facts.

    Field names are valid in MATLAB 7 and later, up to 63 letters; `names` has the name of each column as in the run folder.
    UsageError where the table is too large for the format.
    """
    fields = field_names(table.frame.columns)
    described = {field: _column(table, name) for name, field in fields.items()}
    facts = {name: matlab.integer(fact) if isinstance(fact, int) else matlab.text(fact) for name, fact in table.facts.items()}
    variables = (
        matlab.record({field: matlab.column(pd.Series(table.frame[name])) for name, field in fields.items()}, table.name),
        matlab.record({field: matlab.text(column.unit) for field, column in described.items()}, "units"),
        matlab.record({field: matlab.text(column.description) for field, column in described.items()}, "descriptions"),
        matlab.record({field: matlab.text(name) for name, field in fields.items()}, "names"),
        matlab.record(facts, "run"),
    )
    if (largest := max(variable.size for variable in variables)) > matlab.LARGEST:
        raise UsageError(
            f"{len(table.frame):,} rows of {len(fields)} columns: {largest / 1e9:.2f} GB, and a variable of MATLAB v5 has "
            f"{matlab.LARGEST / 1e9:.2f} GB at most; accepted: csv or json"
        )
    return chain([matlab.HEADER], chain.from_iterable(variable.parts() for variable in variables))


def field_names(names: Iterable[str]) -> dict[str, str]:
    """A valid and unique MATLAB name for each name, in order: letters, digits and _, a letter first, no keyword."""
    fields: dict[str, str] = {}
    taken: set[str] = set()
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
        plain = plain if re.match(r"[A-Za-z]", plain) and plain not in _KEYWORDS else f"x_{plain}"
        field, number = plain[: matlab.LONGEST], 1
        while field in taken:
            number += 1
            field = f"{plain[: matlab.LONGEST - len(str(number)) - 1]}_{number}"
        taken.add(field)
        fields[name] = field
    return fields


def _column(table: Exported, name: str) -> Column:
    return table.columns.get(name, Column(name, "", ""))


def _lines(frame: pd.DataFrame) -> Iterator[bytes]:
    """The rows as CSV, some at a time."""
    for begin in _blocks(len(frame)):
        yield frame.iloc[begin : begin + ROWS].to_csv(index=False, header=not begin).encode()


def _blocks(rows: int) -> range:
    """The first row of each block; of an empty table, too."""
    return range(0, max(rows, 1), ROWS)


def _dumped(value: Any) -> bytes:
    return json.dumps(value, allow_nan=False, ensure_ascii=False, indent=None).encode()


def _json(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    return value
