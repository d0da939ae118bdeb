"""Points: uniform numbers that decide some draws, from a CSV file with a row for each sample; all other draws are random.

    {use: points, csv: worst.csv}

A column has the name of a variable, `pursuer.mass_kg`, and numbers in (0, 1); 0.5 gives the median. A distribution of several
uniform numbers has a column for each, `start.rho_m.0`, `start.rho_m.1`, … Unlike the values of a plan, these numbers also
reproduce draws that are correlated or redrawn after rejection: with the same seed, every draw of a flight is bit-equal. A column
`noise` has the number of the sample whose noise in flight a row has; without it, a sample has its usual noise. `rvjax worst` and
`rvjax rare` write such files. The rows need not be independent, so this design is for exploration and gives no verdict.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from rvjax.campaign import Model, Series, series
from rvjax.campaign.csv_files import CsvFile
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.problems import Problem
from rvjax.components.samplers.interface import Samples, Sampling, Scheme, Setting, Values
from rvjax.components.samplers.sample_table import SampleTable, rows_of
from rvjax.stats.random_streams import uniforms
from rvjax.stats.sampling_design import Exploration

NOISE = "noise"
"""The column with the samples whose noise the rows have."""

MOST_SAMPLES = 2.0**53
"""Below it every whole number is exact in the file."""


class Parameters(Model):
    """The file with the uniform numbers."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"csv": CsvFile("table.csv", ("pursuer.mass_kg",), ((2, ("0.25",)), (3, ("0.75",))))},
    )

    table: Series = series(others=True, doc="CSV file with a column for each uniform number and a row for each sample")


def columns_of(name: str, count: int) -> tuple[str, ...]:
    """The columns of a variable whose distribution takes `count` uniform numbers."""
    return (name,) if count == 1 else tuple(f"{name}.{k}" for k in range(count))


@dataclass(frozen=True)
class Block:
    """The points of some samples. numbers: (samples, count) of each variable in the table."""

    seed: int
    samples: Samples
    numbers: Mapping[str, Values] = field(repr=False)

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1)."""
        if name in self.numbers:
            return self.numbers[name]
        return uniforms(self.seed, name, self.samples)[:, :count]

    def prescribed(self, name: str) -> None:
        """No draw is prescribed."""


@dataclass(frozen=True)
class UniformsTable:
    """numbers: (rows, count) of each variable. keys: (rows,) samples whose noise the rows have; None: their own."""

    seed: int
    numbers: Mapping[str, Values] = field(repr=False)
    keys: Samples | None = None

    def at(self, samples: Samples) -> Block:
        """The points of some samples."""
        return Block(self.seed, self.noise(samples, ""), rows_of(self.numbers, samples))

    def noise(self, samples: Samples, stream: str) -> Samples:
        """(samples,) the samples whose noise in flight these samples have, the same for every stream."""
        return samples if self.keys is None else self.keys[samples % len(self.keys)]


def scheme(parameters: Parameters) -> Scheme:
    """The points in a file."""
    table = SampleTable.of(parameters.table)

    def problems(setting: Setting) -> Iterable[Problem]:
        variables = _columns(setting)
        known = [NOISE, *(column for columns in variables.values() for column in columns)]
        for name in table.columns:
            if name not in known:
                yield table.name_problem(f"{name} is not a column of any variable", did_you_mean(name, known))
        for columns in variables.values():
            yield from table.missing_problems(columns)
        for name, values in table.columns.items():
            if name == NOISE:
                valid = (values >= 0.0) & (values < MOST_SAMPLES) & (values == np.floor(values))
                yield from table.value_problems(name, (name,), valid, "the number of a sample, from 0 and below 2^53")
            else:
                yield from table.value_problems(name, (name,), (values > 0.0) & (values < 1.0), "a number above 0 and below 1")
        yield from table.length_problems(setting)

    def make(setting: Setting) -> UniformsTable:
        present = {name: columns for name, columns in _columns(setting).items() if columns[0] in table.columns}
        numbers = {name: np.column_stack([table.columns[column] for column in columns]) for name, columns in present.items()}
        keys = table.columns.get(NOISE)
        return UniformsTable(setting.seed, numbers, None if keys is None else keys.astype(np.int64))

    return Scheme(make, problems, extends=False)


def _columns(setting: Setting) -> dict[str, tuple[str, ...]]:
    drawn: Mapping[str, Any] = setting.names.drawn
    return {name: columns_of(name, variable.law.uniforms) for name, variable in drawn.items()}


COMPONENT = Sampling(Parameters, scheme, design=Exploration())
