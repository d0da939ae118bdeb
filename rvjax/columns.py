"""What a column of a table means."""

from __future__ import annotations

from dataclasses import dataclass

AXES = ("x", "y", "z")
CHANNELS = ("fx", "fy", "fz", "tx", "ty", "tz")
"""Suffixes of the columns of a vector, and of the six actuator channels."""


ALEATORY, EPISTEMIC = "aleatory", "epistemic"
"""Kinds of draws: chance, which differs from flight to flight; one number in reality that is not known."""


@dataclass(frozen=True)
class Column:
    """unit: SI, "1" for a pure number, "" for a label. better: "lower", "higher", or "" where neither is. kind, law: of a
    draw, else "".

    Written into the metadata of the table.
    """

    name: str
    unit: str
    description: str
    better: str = ""
    kind: str = ""
    law: str = ""
