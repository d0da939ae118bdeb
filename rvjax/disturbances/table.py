"""Wrench over time out of a table, fixed in P.

    d(t) = a W(t − t₀)         where a step begins, a straight line in between
    W: the rows, with straight lines between them; before the first row its wrench, behind the last row the last one's

The table is looked up once a step and no kink lies within one, so RK4 keeps its order; rows closer to each other than the step
are passed over, a kink within a step is cut off by it. All samples fly the same table; scale and shift are drawn for each.
"""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, WithJsonSchema

from rvjax.algebra import Channels, Scalar
from rvjax.disturbances.interface import Disturbance
from rvjax.dynamics import Relative
from rvjax.family import Component
from rvjax.spec import Model, Quantity, option, scalar
from rvjax.spec.problem import Problem, refuse
from rvjax.spec.values import describe, is_list, is_number
from rvjax.state import Numbers, Plant, State, Tick

COLUMNS = ("t_s", "fx_N", "fy_N", "fz_N", "tx_Nm", "ty_Nm", "tz_Nm")
MOST_ROWS = 2000
MOST_NAMED = 20
"""Wrong rows that are named."""

ROWS = {
    "type": "array",
    "items": {"type": "array", "items": {"type": "number"}, "minItems": len(COLUMNS), "maxItems": len(COLUMNS)},
    "minItems": 2,
    "maxItems": MOST_ROWS,
}


def written(given: Any) -> tuple[tuple[float, ...], ...]:
    """The rows of a table as they are written, times rising."""
    if not is_list(given) or not 2 <= len(given) <= MOST_ROWS:
        found = f"{len(given)} rows" if is_list(given) else describe(given)
        refuse(Problem(f"found {found}", f"accepted: a list of 2 to {MOST_ROWS:,} rows [{', '.join(COLUMNS)}]"))
    wrong = [
        (index, row)
        for index, row in enumerate(given)
        if not is_list(row) or len(row) != len(COLUMNS) or not all(map(is_number, row))
    ]
    if wrong:
        accepted = f"accepted: {len(COLUMNS)} numbers, {', '.join(COLUMNS)}"
        refuse(*(Problem(f"found {describe(row)}", accepted, (index,)) for index, row in wrong[:MOST_NAMED]))
    times = [row[0] for row in given]
    early = [index for index in range(1, len(times)) if times[index] <= times[index - 1]]
    if early:
        accepted = "accepted: a time after that of the row before"
        refuse(*(Problem(f"found {times[index]:g} s", accepted, (index, 0)) for index in early[:MOST_NAMED]))
    return tuple(tuple(map(float, row)) for row in given)


class Parameters(Model):
    """The table, and how each sample departs from it."""

    rows: Annotated[tuple[tuple[float, ...], ...], BeforeValidator(written), WithJsonSchema(ROWS)] = option(
        doc=f"rows [{', '.join(COLUMNS)}], times rising"
    )
    scale: Quantity = scalar("1", default=1.0, doc="factor a on the wrench")
    shift_s: Quantity = scalar("s", default=0.0, doc="delay t₀ of the table")


class Stretch(NamedTuple):
    """The wrench [N, N·m] at the beginning t [s] of a step of length h [s], and at its end."""

    t: Scalar
    h: Scalar
    first: Channels
    last: Channels


def start(table: NDArray[np.float64], numbers: Numbers) -> Stretch:
    """The end of no step, at t = 0."""
    zero = numbers.scale * 0.0
    now = looked_up(table, zero, numbers)
    return Stretch(zero, zero + 1.0, now, now)


def keep(table: NDArray[np.float64], tick: Tick, y: State, memory: Stretch, numbers: Numbers) -> Stretch:
    """It begins with what the step before ended with."""
    del y
    return Stretch(tick.t, tick.h, memory.last, looked_up(table, tick.t + tick.h, numbers))


def looked_up(table: NDArray[np.float64], t: Scalar, numbers: Numbers) -> Channels:
    """a W(t − t₀) [N, N·m]."""
    kind = jnp.result_type(numbers.scale)
    times = jnp.asarray(table[:, 0], kind)
    at = jnp.clip(t - numbers.shift_s, times[0], times[-1])
    index = jnp.clip(jnp.searchsorted(times, at, side="right", method="scan_unrolled") - 1, 0, len(table) - 2)
    slopes = np.diff(table, axis=0)[:, 1:] / np.diff(table[:, :1], axis=0)
    row = jnp.asarray(np.concatenate([table[:-1], slopes], axis=1), kind)[index]
    since = at - row[0]
    return Channels.of(tuple(numbers.scale * (row[1 + i] + row[7 + i] * since) for i in range(6)))


def push(t: Scalar, y: State, known: Relative, plant: Plant, memory: Stretch, numbers: Numbers) -> Channels:
    """The straight line over the step."""
    del y, known, plant, numbers
    return memory.first + (memory.last - memory.first) * ((t - memory.t) / memory.h)


def build(parameters: Parameters) -> Disturbance:
    """With this table."""
    table = np.array(parameters.rows)
    return Disturbance(push, partial(start, table), partial(keep, table))


COMPONENT = Component(Parameters, build)
