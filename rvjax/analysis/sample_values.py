"""What a sample has for the quantities of its campaign: drawn numbers from its row, fixed ones from the campaign. SI."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rvjax.campaign import Quantity, Spec
from rvjax.columns import draw_column

Row = Mapping[str, Any]
"""A row of the samples table, by the names of its columns."""


def numbers(quantity: Quantity, path: str, row: Row) -> list[float]:
    """The components of a quantity in a sample. path: in the campaign, as in the names of draws."""
    columns = [draw_column(name) for name in quantity.names(path)]
    middle = quantity.medians if any(column not in row for column in columns) else ()
    return [float(row[column]) if column in row else float(middle[place]) for place, column in enumerate(columns)]


def port(spec: Spec, row: Row) -> list[float]:
    """δ: the docking point in T [m]."""
    return numbers(spec.target.port_m, "target.port_m", row)


def docking_axis(spec: Spec, row: Row) -> list[float]:
    """The docking axis in T, outward, a unit vector; without any, the x axis."""
    given = [float(part) for part in spec.target.port_axis] if spec.target.port_axis is not None else port(spec, row)
    length = math.hypot(*given)
    return [part / length for part in given] if length > 0.0 else [1.0, 0.0, 0.0]
