"""Unit and meaning of a value that a user's component puts into the trace or the table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from rvjax.columns import Column


class Signal(NamedTuple):
    """What a value means. unit: SI, "1" for a pure number; meaning: a few words; better: "lower" or "higher", of a metric."""

    unit: str
    meaning: str
    better: str = ""


def columns(signals: Mapping[str, Signal] | None) -> Mapping[str, Column]:
    """The columns of the declared signals of a component, by name."""
    return {name: Column(name, signal.unit, signal.meaning, signal.better) for name, signal in (signals or {}).items()}
