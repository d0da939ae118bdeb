"""Plan: the values of some draws from a CSV file, one row for each sample; all other draws by their own streams.

    {use: plan, csv: plan.csv}

Columns have the names of draws, with or without `draw.`, and values in SI, as in the samples table. Every value is inside what
its variable may draw; of a law of a whole vector there are all three components. Nobody knows where the rows come from: the plan
is for exploration, and no verdict is issued on it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rvjax.campaign import Model, Series, series
from rvjax.campaign.problems import Problem
from rvjax.campaign.variables import Variable
from rvjax.columns import DRAW
from rvjax.components.samplers.interface import PLACE, Samples, Sampling, Scheme, Setting, Streams, Values
from rvjax.stats.sampling_design import Exploration

NORM = 1e-9
"""How far the norm of a vector may be above its radius, relative: digits that a table leaves out."""

CSV = (*PLACE, "csv")


class Parameters(Model):
    """The plan."""

    table: Series = series(others=True, doc="CSV file, a column for each draw that it gives, a row for each sample")


@dataclass(frozen=True)
class Plan:
    """values: of each draw that is given, row by row."""

    seed: int
    values: Mapping[str, Values] = field(repr=False)

    def at(self, samples: Samples) -> Streams:
        """The points of some samples."""
        return Streams(self.seed, samples, {name: values[samples % len(values)] for name, values in self.values.items()})


def scheme(parameters: Parameters) -> Scheme:
    """What the table makes."""
    table = parameters.table
    columns = {name.removeprefix(DRAW): np.array(values) for name, values in zip(table.names, table.values, strict=True)}

    def wrong(setting: Setting) -> Iterable[Problem]:
        known = {name: setting.names.draw(name) for name in columns}
        if len(columns) < len(table.names):
            yield Problem("a draw that stands twice, with and without draw.", "accepted: each draw once", CSV, at_key=True)
        yield from (Problem(*found, CSV, at_key=True) for found in known.values() if found)
        for variable in sorted({setting.names.variable[name].name for name, found in known.items() if not found}):
            yield from _outside(setting.names.drawn[variable], columns, table.lines)
        if table.rows != setting.samples:
            accepted = f"accepted: {table.rows:,}, a sample for each row of the plan"
            yield Problem(f"{setting.samples:,} samples of a plan", accepted, ("samples",))

    return Scheme(lambda setting: Plan(setting.seed, columns), wrong, tuple(columns), extends=False)


def _outside(variable: Variable, columns: Mapping[str, Values], lines: tuple[int, ...]) -> Iterable[Problem]:
    """The first row that is outside what a variable may draw."""
    law: Any = variable.law  # of a scalar or joint, as the number of its draws says
    if missing := [name for name in variable.draws if name not in columns]:
        found = f"{', '.join(missing)} is missing"
        yield Problem(found, f"accepted: all of {', '.join(variable.draws)}, which are drawn together", CSV, at_key=True)
        return
    values = np.stack([columns[name] for name in variable.draws])
    if len(variable.draws) == 1:
        low, high = law.low, law.high
        inside, words = (values[0] >= low) & (values[0] <= high), f"{low:g} to {high:g}"
    else:
        radius = law.radius
        inside, words = np.linalg.norm(values, axis=0) <= radius * (1.0 + NORM), f"a norm of at most {radius:g}"
    for row in np.flatnonzero(~inside)[:1]:
        told = ", ".join(f"{value:g}" for value in values[:, row])
        found = f"line {lines[row]}, {variable.name}: {told} is outside what is drawn"
        yield Problem(found, f"accepted: {words}, in the unit of the draw", CSV, at_key=True)


COMPONENT = Sampling(Parameters, scheme, basis=Exploration())
