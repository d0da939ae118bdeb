"""What a column of a table means."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

AXES = ("x", "y", "z")
CHANNELS = ("fx", "fy", "fz", "tx", "ty", "tz")
"""Suffixes of the columns of a vector, and of the six actuator channels."""

DRAW, METRIC, SIGNAL, EFFECT, NAVIGATION = "draw.", "metric.", "ctl.", "effects.", "navigation."
"""Prefixes of the column names of draws, metrics, signals of the controller, of effects with their states, and of navigation."""


def draw_column(name: str) -> str:
    """`pursuer.mass_kg` → `draw.pursuer.mass_kg`."""
    return DRAW + name


def metric_column(name: str) -> str:
    """`settling_time_s` → `metric.settling_time_s`."""
    return METRIC + name


def drawn_columns(columns: Iterable[str]) -> list[str]:
    """The columns of draws, without the controller's: runs of different controllers have these in common."""
    return [name for name in columns if name.startswith(DRAW) and not name.startswith(draw_column("controller."))]


OUTCOMES = ("captured", "not_settled", "collided", "not_finite")
"""The possible outcomes of a sample; each sample has exactly one."""

FAILED = ("collided", "not_finite")
"""Outcomes that fail every requirement."""


MARGIN = "margin."
"""Prefix of the name of a temporal margin: the metric of a formula in the campaign's `margins`."""


def metric_and_channel(name: str) -> tuple[str, str]:
    """`saturation_duty.fx` → ("saturation_duty", "fx"); a metric without channels, or a margin, is itself: ("margin.any", "")."""
    if name.startswith(MARGIN):
        return name, ""
    metric, _, channel = name.partition(".")
    return metric, channel


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
