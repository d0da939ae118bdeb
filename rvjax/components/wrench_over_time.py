"""What the steps of the integration see of a table, of a pulse and of a sinusoid, decided from their numbers without a flight.

    table   ½ W(t_k) + ½ W(t_{k+1}), the weights of RK4 on a line from step to step
    pulse   A(s) = e [P(s/e) − P((s − w)/e)],   P(x) = x⁴(5/2 − 3x + x²) for 0 ≤ x ≤ 1,   0 before, x − ½ after

A: integral of a pulse of height 1 from its beginning to the time s after it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign import Quantity, Spec
from rvjax.campaign.plain_values import exact, shortest
from rvjax.campaign.problems import Problem
from rvjax.columns import CHANNELS
from rvjax.components.effect import LOST, impulse_of_steps, rounding_s, seen, typical

Values = NDArray[np.float64]

MOST_PULSES = 1_000_000
"""Pulses of a flight whose impulse is summed."""


def table_problem(parameters: Any, spec: Spec) -> Iterator[Problem]:
    """A problem if the wrench of a table is 0 at every step of every sample. parameters: of the disturbance."""
    table, key = parameters.table, _key(parameters)
    ((low, high),) = parameters.shift_s.supports
    if not np.any(table[:, 1:]):
        yield Problem("every row of the table is 0", "accepted: a table with a wrench", (key,))
    elif not (_nonzero_at_steps(table, low, spec) if low == high else _nonzero_between(table, low, high, spec)):
        place, accepted = (key,), f"accepted: times with a wrench inside the flight, or shift_s; {_flight(spec)}"
        times = _times(table, low, high)
        between = low == high and _nonzero_between(table, low, high, spec)
        why = f"between two steps of {exact(spec.horizon.step_s)} s" if between else f"outside the flight; {times}"
        yield Problem(f"the wrench of the table is 0 at every step: the rest lies {why}", accepted, place)


def _key(parameters: Any) -> str:
    """The key of the table in the campaign."""
    return "csv" if parameters.rows is None else "rows"


def table_warnings(parameters: Any, spec: Spec) -> Iterator[Problem]:
    """What the steps lose of a table, for a fixed shift or else its median: all of it, or details shorter than a step."""
    table, key = parameters.table, _key(parameters)
    ((low, high),) = parameters.shift_s.supports
    if table[-1, 0] + high <= 0.0 or table[0, 0] + low >= spec.horizon.duration_s:
        row = "first" if table[0, 0] + low > 0.0 else "last"
        message = f"the flight sees only the {row} row of the table, a constant wrench: {_times(table, low, high)}"
        yield Problem(message, f"accepted: times inside the flight, or shift_s; {_flight(spec)}", (key,))
        return
    delay, factor = typical(parameters.shift_s), typical(parameters.scale)
    h, steps = spec.horizon.step_s, spec.horizon.steps
    grid = np.arange(steps + 1) * h
    rows = table[:, 0] + delay
    inside = rows[(rows > 0.0) & (rows < spec.horizon.duration_s)]
    close = np.diff(rows)[(rows[:-1] < spec.horizon.duration_s) & (rows[1:] > 0.0)]
    if not len(close) or close.min() >= h * (1.0 - 1e-9):
        return
    for place, channel in enumerate(CHANNELS, start=1):
        column = table[:, place]
        at_steps = np.interp(grid, rows, column)
        off = np.abs(np.interp(inside, rows, column) - np.interp(inside, grid, at_steps))
        if off.max(initial=0.0) <= LOST * np.abs(column).max():
            continue
        times = np.unique(np.concatenate([[0.0], inside, [spec.horizon.duration_s]]))
        whole = factor * float(np.trapezoid(np.interp(times, rows, column), times))
        steps_see = factor * float(np.trapezoid(at_steps, grid))
        yield Problem(_impulses(f"rows {close.min():g} s apart", channel, steps_see, whole, h), _SHORTER, (key,))


_SHORTER = "accepted: details of a step or longer, or a shorter horizon.step_s"


def _impulses(what: str, channel: str, steps_see: float, whole: float, h: float) -> str:
    unit = "N s" if channel.startswith("f") else "N m s"
    return (
        f"{what} are shorter than the step of {exact(h)} s: on {channel} the steps see an impulse of {steps_see:.4g} {unit}, "
        f"the campaign has {whole:.4g} {unit}"
    )


def _flight(spec: Spec) -> str:
    return f"the flight is from 0 s to {exact(spec.horizon.duration_s)} s"


def _times(table: Values, low: float, high: float) -> str:
    shift = "" if low == high == 0.0 else f" before a shift of {exact(low)} s" + ("" if low == high else f" to {exact(high)} s")
    return f"its times are {table[0, 0]:.15g} s to {table[-1, 0]:.15g} s{shift}"


def _nonzero_at_steps(table: Values, shift: float, spec: Spec) -> bool:
    """Whether the wrench can differ from 0 at a step. Rounding is in favour of yes."""
    grid, room = np.arange(spec.horizon.steps + 1) * spec.horizon.step_s, rounding_s(spec)
    columns = [column for column in table[:, 1:].T if np.any(column)]
    return any(np.any(np.interp(grid + off, table[:, 0] + shift, column)) for column in columns for off in (0.0, -room, room))


def _nonzero_between(table: Values, low: float, high: float, spec: Spec) -> bool:
    """Whether the wrench differs from 0 at some time of the flight, for some shift."""
    first, last = -high, spec.horizon.duration_s - low
    rows = table[(table[:, 0] >= first) & (table[:, 0] <= last), 1:]
    return bool(np.any(rows)) or any(np.any(np.interp([first, last], table[:, 0], column)) for column in table[:, 1:].T)


def pulse_problem(pulse: Any, spec: Spec) -> Iterator[Problem]:
    """A problem if no pulse of a plume can be seen. pulse: the parameters of the plume."""
    ((earliest, latest),) = pulse.first_s.supports
    if earliest >= spec.horizon.duration_s:
        message = f"the first pulse begins at {earliest:.15g} s, not before the end of the flight"
        yield Problem(message, f"accepted: below {exact(spec.horizon.duration_s)} s", ("first_s",))
        return
    length = pulse.width_s.supports[0][1] + pulse.edge_s.supports[0][1]
    if pulse.period_s is not None and not pulse.period_s.is_fixed:
        return
    if not seen(spec, earliest, latest - earliest + length, None if pulse.period_s is None else typical(pulse.period_s)):
        half = 0.5 * spec.horizon.step_s
        message = f"every pulse of {length:g} s, edge included, lies between two instants of the integration"
        yield Problem(message, f"accepted: a pulse of {exact(half)} s (half a step) or longer, or a shorter step_s", ("width_s",))


def pulse_warnings(pulse: Any, spec: Spec) -> Iterator[Problem]:
    """A problem if the steps see another impulse than that of the pulses, for fixed times or else their medians."""
    width, edge = typical(pulse.width_s), typical(pulse.edge_s)
    first, end = typical(pulse.first_s), spec.horizon.duration_s
    period = None if pulse.period_s is None else typical(pulse.period_s)
    pulses = 1 if period is None else math.floor(max(end - first, 0.0) / period) + 1
    if edge >= spec.horizon.step_s or first >= end or pulses > MOST_PULSES:
        return

    def height(t: Values) -> Values:
        since = t - first
        if period is not None:
            since = since - np.maximum(np.floor(since / period), 0.0) * period
        return _risen(since / edge) - _risen((since - width) / edge)

    rest = end - first - np.arange(pulses, dtype=np.float64) * (period or 0.0)
    whole = edge * float(np.sum(_area(rest / edge) - _area((rest - width) / edge)))
    steps_see = impulse_of_steps(spec, height)
    if abs(steps_see - whole) > LOST * whole:
        message = (
            f"edges of {exact(edge)} s are shorter than the step of {exact(spec.horizon.step_s)} s: "
            f"of the impulse of the pulses the steps see {steps_see / whole:.4g} times"
        )
        yield Problem(message, "accepted: edge_s of several steps, or a shorter horizon.step_s", ("edge_s",))


def _risen(x: Values) -> Values:
    """S(x)."""
    inside = np.clip(x, 0.0, 1.0)
    return inside**3 * (10.0 + inside * (6.0 * inside - 15.0))


def _area(x: Values) -> Values:
    """P(x), the integral of S."""
    inside = np.clip(x, 0.0, 1.0)
    return inside**4 * (2.5 - 3.0 * inside + inside**2) + np.maximum(x - 1.0, 0.0)


def fast_sinusoid(force: Quantity, torque: Quantity, rate: Quantity, spec: Spec) -> Iterable[Problem]:
    """A problem if a channel of a sinusoid turns by more than half a period in every step: the steps see a slower one."""
    sizes = (*force.supports, *torque.supports)
    channels = [
        channel
        for channel, (low, high), (least, most) in zip(CHANNELS, sizes, rate.supports, strict=True)
        if (low, high) != (0.0, 0.0) and min(abs(least), abs(most)) * spec.horizon.step_s > math.pi and least * most > 0.0
    ]
    if channels:
        h = spec.horizon.step_s
        most = shortest(math.pi / h, lambda rate: rate * h <= math.pi)
        message = f"on {', '.join(channels)} the period is shorter than two steps of {exact(h)} s"
        yield Problem(message, f"accepted: at most {most} rad/s, or a shorter step_s", ("rate_rad_s",))
