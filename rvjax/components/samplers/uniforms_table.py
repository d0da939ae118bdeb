"""Points: the uniform numbers that decide the draws, from a CSV file, one row for each sample; other draws by their streams.

    {use: points, csv: worst.csv}

A column has the name of a variable, `pursuer.mass_kg`, and numbers in (0, 1): the law turns 0.5 into its median. A law that takes
several numbers has a column for each, `start.rho_m.0`, `start.rho_m.1`, … With the values that a plan says, draws that are
correlated or drawn again could not be told; with these numbers every draw of a flight comes back to the last bit, as long as the
seed is the same. `rvjax worst` writes such files. Nobody knows where the rows come from: no verdict is issued on them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rvjax.campaign import Model, Series, series
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.problems import Problem
from rvjax.components.samplers.interface import PLACE, Samples, Sampling, Scheme, Setting, Values
from rvjax.stats.random_streams import uniforms
from rvjax.stats.sampling_design import Exploration

CSV = (*PLACE, "csv")


class Parameters(Model):
    """The numbers."""

    table: Series = series(others=True, doc="CSV file, a column for each number of a variable, a row for each sample")


def columns_of(name: str, count: int) -> tuple[str, ...]:
    """The columns of a variable whose law takes so many numbers."""
    return (name,) if count == 1 else tuple(f"{name}.{k}" for k in range(count))


@dataclass(frozen=True)
class Block:
    """The points of some samples; numbers: (samples, count) of each variable that is given."""

    seed: int
    samples: Samples
    numbers: Mapping[str, Values] = field(repr=False)

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1)."""
        if name in self.numbers:
            return self.numbers[name]
        return uniforms(self.seed, name, self.samples)[:, :count]

    def given(self, name: str) -> None:
        """No draw is given."""


@dataclass(frozen=True)
class Table:
    """numbers: (rows, count) of each variable."""

    seed: int
    numbers: Mapping[str, Values] = field(repr=False)

    def at(self, samples: Samples) -> Block:
        """The points of some samples."""
        return Block(self.seed, samples, {name: rows[samples % len(rows)] for name, rows in self.numbers.items()})


def scheme(parameters: Parameters) -> Scheme:
    """What the table makes."""
    table = parameters.table
    columns = {name: np.array(values) for name, values in zip(table.names, table.values, strict=True)}

    def wanted(setting: Setting) -> dict[str, tuple[str, ...]]:
        drawn: Mapping[str, Any] = setting.names.drawn
        return {name: columns_of(name, variable.law.uniforms) for name, variable in drawn.items()}

    def wrong(setting: Setting) -> Iterable[Problem]:
        known = wanted(setting)
        all_of_them = [column for own in known.values() for column in own]
        for name in columns:
            if name not in all_of_them:
                yield Problem(f"{name} is no number of a variable", did_you_mean(name, all_of_them), CSV, at_key=True)
        for own in known.values():
            missing = [column for column in own if column not in columns]
            if missing and len(missing) < len(own):
                yield Problem(f"{', '.join(missing)} is missing", f"accepted: all of {', '.join(own)}", CSV, at_key=True)
        for name, values in columns.items():
            for row in np.flatnonzero(~((values > 0.0) & (values < 1.0)))[:1]:
                found = f"line {table.lines[row]}, {name}: {values[row]:g}"
                yield Problem(found, "accepted: a number above 0 and below 1", CSV, at_key=True)
        if table.rows != setting.samples:
            accepted = f"accepted: {table.rows:,}, a sample for each row"
            yield Problem(f"{setting.samples:,} samples of {table.rows:,} points", accepted, ("samples",))

    def make(setting: Setting) -> Table:
        given = {name: own for name, own in wanted(setting).items() if own[0] in columns}
        return Table(setting.seed, {name: np.column_stack([columns[column] for column in own]) for name, own in given.items()})

    return Scheme(make, wrong, extends=False)


COMPONENT = Sampling(Parameters, scheme, basis=Exploration())
