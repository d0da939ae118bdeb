"""Plan: values of some draws from a CSV file with a row for each sample; all other draws are random.

    {use: plan, csv: plan.csv}

Columns have the names of draws, with or without the prefix `draw.`, and values in SI, as in the samples table. Every value must
be inside the support of its distribution. The draws of a joint distribution must all be there. The rows need not be independent,
so this design is for exploration and gives no verdict.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rvjax.campaign import Model, Series, series
from rvjax.campaign.plain_values import exact
from rvjax.campaign.problems import Problem
from rvjax.campaign.variables import Variable
from rvjax.columns import DRAW
from rvjax.components.samplers.interface import Samples, Sampling, Scheme, Setting, Streams, Values
from rvjax.components.samplers.sample_table import SampleTable, rows_of
from rvjax.stats.sampling_design import Exploration

NORM = 1e-9
"""Relative excess of a vector's norm over its radius that is accepted: rounding in the table."""


class Parameters(Model):
    """The file with the values."""

    table: Series = series(others=True, doc="CSV file with a column for each prescribed draw and a row for each sample")


@dataclass(frozen=True)
class Plan:
    """values: (rows,) of each prescribed draw."""

    seed: int
    values: Mapping[str, Values] = field(repr=False)

    def at(self, samples: Samples) -> Streams:
        """The points of some samples."""
        return Streams(self.seed, samples, rows_of(self.values, samples))


def scheme(parameters: Parameters) -> Scheme:
    """The plan in a file."""
    table = SampleTable.of(parameters.table, DRAW)

    def problems(setting: Setting) -> Iterable[Problem]:
        wrong = {name: setting.names.draw(name) for name in table.columns}
        if len(table.columns) < len(parameters.table.names):
            found = "a draw has two columns, with and without the prefix draw."
            yield table.name_problem(found, "accepted: a column for each draw")
        yield from (table.name_problem(*words) for words in wrong.values() if words)
        for variable in sorted({setting.names.variable[name].name for name, words in wrong.items() if not words}):
            yield from _variable_problems(setting.names.drawn[variable], table)
        yield from table.length_problems(setting)

    return Scheme(lambda setting: Plan(setting.seed, table.columns), problems, tuple(table.columns), extends=False)


def _variable_problems(variable: Variable, table: SampleTable) -> Iterable[Problem]:
    """Missing columns of a variable, or the first row outside the support of its distribution."""
    if missing := list(table.missing_problems(variable.draws, ", which are drawn together")):
        yield from missing
        return
    law: Any = variable.law  # scalar for a single draw, else joint
    values = np.stack([table.columns[name] for name in variable.draws])
    if len(variable.draws) == 1:
        low, high = law.low, law.high
        inside, words = (values[0] >= low) & (values[0] <= high), f"{exact(low)} to {exact(high)}"
    else:
        radius = law.radius
        inside, words = np.linalg.norm(values, axis=0) <= radius * (1.0 + NORM), f"a norm of at most {exact(radius)}"
    accepted = f"{words}, the support of the distribution in the unit of the draw"
    yield from table.value_problems(variable.name, variable.draws, inside, accepted)


COMPONENT = Sampling(Parameters, scheme, design=Exploration())
