"""Section: the gains of the controller, and every fixed value of the campaign."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from rvjax.campaign.fixed_values import fixed_values
from rvjax.report.blocks import Cell, Code, Section, Table
from rvjax.report.number_format import capital, count
from rvjax.report.run_view import Run

_HEAD = ("name", "value", "unit")


def section(run: Run) -> Section | None:
    """A table of the controller's gains and choices, and one of all other fixed values, defaults included."""
    recorded = run.provenance.get("fixed")
    known = recorded if isinstance(recorded, Mapping) else fixed_values(run.spec, {})
    gains = {name: value for name, value in known.items() if name.split(".")[0] == "controller"}
    others = {name: value for name, value in known.items() if name not in gains}
    if not known:
        return None
    left_out = "" if isinstance(recorded, Mapping) else " Defaults of components are not recorded in this folder."
    tables = (
        Table(f"The controller {run.spec.controller.use}: gains and choices that are the same in every sample, in SI.{left_out}",
              _HEAD, tuple(_row(name, *value) for name, value in gains.items())),
        Table(f"All other values that are the same in every sample, in SI, defaults included.{left_out}",
              _HEAD, tuple(_row(name, *value) for name, value in others.items())),
    )  # fmt: skip
    numbers = count(len(gains) - 1)
    lead = f"The controller has {numbers} fixed gains and choices, everything else {count(len(others))} fixed values."
    return Section("fixed-values", "Gains and fixed values", lead, tuple(table for table in tables if table.rows))


def _row(name: str, value: Any, unit: str) -> tuple[Cell, ...]:
    return Code(name), _words(value), "" if unit == "1" else unit


def _words(value: Any) -> str:
    """Numbers in plain notation; a list with commas."""
    if isinstance(value, (list, tuple)):
        return ", ".join(map(_words, value))
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (int, float)):
        return f"{value:.12g}".replace("-", "−") if math.isfinite(value) else str(value)
    return value if isinstance(value, str) else capital(json.dumps(value))
