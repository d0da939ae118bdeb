"""Wrench over time from a table, fixed in P.

    d(t) = a W(t − t₀)         at the beginning of a step, linear during the step
    W: linear interpolation of the rows; the wrench of the first row before it, that of the last row after it

The table is a file, or rows in the campaign. It is interpolated once per step, so there is no kink within a step and RK4 keeps
its order. Details shorter than a step are lost. All samples use the same table; scale and shift are drawn for each sample.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any, ClassVar, NamedTuple, Self

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, WithJsonSchema, model_validator

from rvjax.campaign import Model, Quantity, Series, option, scalar, series
from rvjax.campaign.plain_values import describe, exact, is_list, is_number
from rvjax.campaign.problems import Problem, refuse
from rvjax.components.disturbances.interface import Disturbance
from rvjax.components.effect import zero
from rvjax.components.registry import Component
from rvjax.components.wrench_over_time import table_problem, table_warnings
from rvjax.physics.dynamics import Relative
from rvjax.physics.state import Numbers, Plant, State, Tick
from rvjax.physics.vectors import Channels, Scalar

WRENCH = ("fx_N", "fy_N", "fz_N", "tx_Nm", "ty_Nm", "tz_Nm")
COLUMNS = ("t_s", *WRENCH)
MOST_ROWS = 10_000
MOST_NAMED = 20
"""Largest number of invalid rows in a message."""

Rows = tuple[tuple[float, ...], ...]
ROWS = {
    "type": "array",
    "items": {"type": "array", "items": {"type": "number"}, "minItems": len(COLUMNS), "maxItems": len(COLUMNS)},
    "minItems": 2,
    "maxItems": MOST_ROWS,
}
"""JSON Schema of the rows."""


def read_rows(raw: Any) -> Rows | None:
    """The rows of a table in a campaign. Reports every problem at once."""
    if raw is None:
        return None
    if not is_list(raw):
        refuse(Problem(f"found {describe(raw)}", f"accepted: a list of rows [{', '.join(COLUMNS)}]"))
    wrong = [(row, (index,)) for index, row in enumerate(raw) if not is_list(row) or len(row) != len(COLUMNS)] or [
        (value, (index, place)) for index, row in enumerate(raw) for place, value in enumerate(row) if not is_number(value)
    ]
    if wrong:
        accepted = f"accepted: {len(COLUMNS)} numbers, {', '.join(COLUMNS)}"
        refuse(*(Problem(f"found {describe(value)}", accepted, place) for value, place in wrong[:MOST_NAMED]))
    return tuple(tuple(map(float, row)) for row in raw)


class Parameters(Model):
    """The table, in a file or in the campaign, and its scale and shift."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"rows": [[0, 0, 0, 0, 0, 0, 0], [100, 0.01, 0, 0, 0, 0, 0.001]]},
        {},
    )

    file: Series | None = series(
        "t_s",
        optional=WRENCH,
        default=None,
        doc=f"file with the columns t_s and some of {', '.join(WRENCH)}; others are 0",
    )
    rows: Annotated[Rows | None, BeforeValidator(read_rows), WithJsonSchema(ROWS)] = option(
        default=None, doc=f"rows [{', '.join(COLUMNS)}] instead of a file"
    )
    scale: Quantity = scalar("1", default=1.0, doc="factor a on the wrench")
    shift_s: Quantity = scalar("s", default=0.0, doc="delay t₀ of the table")

    @model_validator(mode="after")
    def _one_table(self) -> Self:
        if (self.file is None) == (self.rows is None):
            keys = "neither csv nor rows" if self.rows is None else "both csv and rows"
            refuse(Problem(keys, "accepted: either csv or rows", ("csv",), at_key=True))
        place = ("csv",) if self.rows is None else ("rows",)
        count = len(self.table)
        if not 2 <= count <= MOST_ROWS:
            refuse(Problem(f"{self._place(count - 1)}: rows in the table: {count:,}", f"accepted: 2 to {MOST_ROWS:,}", place))
        for row in np.flatnonzero(np.diff(self.table[:, 0]) <= 0.0)[:1] + 1:
            words = f"{self._place(row)} has the time {exact(float(self.table[row, 0]))} s"
            refuse(Problem(words, "accepted: a time after that of the row before", place))
        return self

    def _place(self, row: int) -> str:
        """Where a row stands: line of the file, or number of the row in the campaign."""
        return f"row {row + 1}" if self.file is None else f"{self.file.file} line {self.file.lines[row]}"

    @property
    def table(self) -> NDArray[np.float64]:
        """(rows, 7) in the order of `COLUMNS`."""
        if self.rows is not None:
            return np.array(self.rows, dtype=np.float64).reshape(-1, len(COLUMNS))
        assert self.file is not None
        nothing = (0.0,) * self.file.rows
        return np.array([self.file[name] if name in self.file.names else nothing for name in COLUMNS]).T


class Segment(NamedTuple):
    """The wrench [N, N·m] at the beginning t [s] of a step of length h [s], and at its end."""

    t: Scalar
    h: Scalar
    first: Channels
    last: Channels


def start(table: NDArray[np.float64], numbers: Numbers) -> Segment:
    """The wrench at t = 0."""
    zero = numbers.scale * 0.0
    now = interpolated(table, zero, numbers)
    return Segment(zero, zero + 1.0, now, now)


def keep(table: NDArray[np.float64], tick: Tick, y: State, memory: Segment, numbers: Numbers) -> Segment:
    """The segment of this step, which begins at the end of the previous segment."""
    del y
    return Segment(tick.t, tick.h, memory.last, interpolated(table, tick.t + tick.h, numbers))


def interpolated(table: NDArray[np.float64], t: Scalar, numbers: Numbers) -> Channels:
    """a W(t − t₀) [N, N·m]."""
    kind = jnp.result_type(numbers.scale)
    times = jnp.asarray(table[:, 0], kind)
    at = jnp.clip(t - numbers.shift_s, times[0], times[-1])
    index = jnp.clip(jnp.searchsorted(times, at, side="right", method="scan_unrolled") - 1, 0, len(table) - 2)
    slopes = np.diff(table, axis=0)[:, 1:] / np.diff(table[:, :1], axis=0)
    row = jnp.asarray(np.concatenate([table[:-1], slopes], axis=1), kind)[index]
    since = at - row[0]
    return Channels.of(tuple(numbers.scale * (row[1 + i] + row[7 + i] * since) for i in range(6)))


def push(t: Scalar, y: State, known: Relative, plant: Plant, memory: Segment, numbers: Numbers) -> Channels:
    """Linear interpolation over the step."""
    del y, known, plant, numbers
    return memory.first + (memory.last - memory.first) * ((t - memory.t) / memory.h)


def build(parameters: Parameters) -> Disturbance:
    """A disturbance from this table."""
    table = parameters.table
    return Disturbance(push, partial(start, table), partial(keep, table))


COMPONENT = Component(Parameters, build, neutral=(zero("scale"),), silent=table_problem, coarse=table_warnings)
