"""What a column of a table means."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Column:
    """unit: SI, "1" without dimension. better: "lower", "higher", or "" where neither is. Written into the table's metadata."""

    name: str
    unit: str
    description: str
    better: str = ""
