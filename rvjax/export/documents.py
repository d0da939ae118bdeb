"""A table as CSV with a companion that has units and descriptions, as JSON, and as MATLAB v5."""

from __future__ import annotations

import io
import json
import math
import re
from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd

from rvjax.columns import Column
from rvjax.errors import UsageError
from rvjax.export.exported import Exported

FORMAT = 1
"""Of the JSON document."""

LONGEST = 63
"""Letters of a name in MATLAB 7 and later."""

_FACTS = ("name", "unit", "description", "better", "kind", "law")
_KEYWORDS = frozenset(
    (
        *("break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for", "function", "global", "if"),
        *("otherwise", "parfor", "persistent", "return", "spmd", "switch", "try", "while"),
    )
)


def csv(table: Exported) -> tuple[bytes, bytes]:
    """The table, numbers in the shortest digits that give the same bits; and its columns: name, unit, description."""
    rows = [{fact: getattr(_column(table, name), fact) for fact in _FACTS} for name in table.frame.columns]
    return table.frame.to_csv(index=False).encode(), pd.DataFrame(rows, columns=_FACTS).to_csv(index=False).encode()


def document(table: Exported) -> bytes:
    """Strict JSON: facts of the run, columns, and an array for each column. Not finite numbers are the words NaN, Infinity and
    -Infinity."""
    columns = {name: {fact: getattr(_column(table, name), fact) for fact in _FACTS[1:]} for name in table.frame.columns}
    data = {str(name): [_json(value) for value in series.tolist()] for name, series in table.frame.items()}
    document = {"format": FORMAT, "table": table.name, "run": dict(table.facts), "columns": columns, "data": data}
    return json.dumps(document, allow_nan=False, ensure_ascii=False, indent=None).encode() + b"\n"


def matlab(table: Exported) -> bytes:
    """MATLAB v5: a struct of columns, and structs with the same fields: units, descriptions, names; and run, a struct of facts.

    Field names are valid in MATLAB 7 and later, up to 63 letters; `names` has the name of each column as in the run folder.
    UsageError where the table is too large for the format.
    """
    from scipy.io import savemat

    fields = field_names(table.frame.columns)
    described = {field: _column(table, name) for name, field in fields.items()}
    variables: dict[str, Any] = {
        table.name: {field: _array(table, name) for name, field in fields.items()},
        "units": {field: column.unit for field, column in described.items()},
        "descriptions": {field: column.description for field, column in described.items()},
        "names": {field: name for name, field in fields.items()},
        "run": dict(table.facts),
    }
    sink = io.BytesIO()
    try:
        savemat(sink, variables, format="5", long_field_names=True, do_compression=True, oned_as="column")
    except Exception as error:
        if type(error).__name__ != "MatWriteError":
            raise
        raise UsageError(f"{len(table.frame):,} rows: too large for MATLAB v5 ({error}); accepted: csv or json") from error
    return sink.getvalue()


def field_names(names: Iterable[str]) -> dict[str, str]:
    """A valid and unique MATLAB name for each name, in order: letters, digits and _, a letter first, no keyword."""
    fields: dict[str, str] = {}
    taken: set[str] = set()
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
        plain = plain if re.match(r"[A-Za-z]", plain) and plain not in _KEYWORDS else f"x_{plain}"
        field, number = plain[:LONGEST], 1
        while field in taken:
            number += 1
            field = f"{plain[: LONGEST - len(str(number)) - 1]}_{number}"
        taken.add(field)
        fields[name] = field
    return fields


def _column(table: Exported, name: str) -> Column:
    return table.columns.get(name, Column(name, "", ""))


def _array(table: Exported, name: str) -> Any:
    """A column: numbers as float64, texts as a cell array."""
    series = pd.Series(table.frame[name])
    if pd.api.types.is_numeric_dtype(series) or pd.api.types.is_bool_dtype(series):
        return series.to_numpy(dtype=np.float64)
    return np.array([[str(value)] for value in series], dtype=object)


def _json(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    return value
