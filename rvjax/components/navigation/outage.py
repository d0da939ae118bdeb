"""Loss of the measurement at a known time; meanwhile the last measurement is held, or propagated without forces (`between`).

    no measurement for t_s ≤ t < t_s + d        t_s: start, d: duration

An outage begins and ends at the nearest steps. `between` and `of`: as in `update-rate`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

from rvjax.campaign import Quantity, Spec, scalar
from rvjax.campaign.plain_values import exact
from rvjax.campaign.problems import Problem
from rvjax.components.effect import zero
from rvjax.components.navigation.interface import NavigationError
from rvjax.components.navigation.last_measurement import Interrupted, Last, LastMeasurement, age
from rvjax.components.registry import Component
from rvjax.physics.state import Motion, Numbers, Tick
from rvjax.physics.vectors import Scalar


class Parameters(Interrupted):
    """Beginning and duration."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"start_s": {"uniform": [20, 60]}, "duration_s": 10},)

    start_s: Quantity = scalar("s", at_least=0.0, doc="time t_s at which the outage begins")
    duration_s: Quantity = scalar("s", above=0.0, doc="duration d")


def build(parameters: Parameters) -> NavigationError:
    """The measurement with its outage."""
    last = LastMeasurement.of(parameters)

    def start(motion: Motion, numbers: Numbers) -> Last:
        return last.first(motion, numbers)

    def keep(tick: Tick, motion: Motion, memory: Last, numbers: Numbers) -> Last:
        now = (tick.k + 0.5) * tick.h
        lost = (now >= numbers.start_s) & (now < numbers.start_s + numbers.duration_s)
        return last.renewed(~lost, tick, motion, memory, numbers)

    def see(t: Scalar, motion: Motion, memory: Last, numbers: Numbers) -> Motion:
        del numbers
        return last.seen(t, motion, memory)

    return NavigationError(see, start, keep, informed=last.propagated, age=age)


def silent(parameters: Parameters, spec: Spec) -> Iterator[Problem]:
    """An outage after the flight, or between two steps."""
    ((earliest, latest),), ((_, longest),) = parameters.start_s.supports, parameters.duration_s.supports
    step = spec.horizon.step_s
    if earliest >= spec.horizon.duration_s:
        found = f"the outage begins at {exact(earliest)} s at the earliest, not before the end of the flight"
        yield Problem(found, f"accepted: below {exact(spec.horizon.duration_s)} s", ("start_s",))
    elif earliest == latest and _instant(earliest, step) == _instant(earliest + longest, step):
        found = f"an outage of {exact(longest)} s ends at the step at which it begins"
        yield Problem(found, f"accepted: {exact(step)} s or more, or a shorter horizon.step_s", ("duration_s",))


def _instant(t: float, step: float) -> int:
    """The first step k with (k + ½) h ≥ t."""
    k = max(round(t / step) - 1, 0)
    while (k + 0.5) * step < t:
        k += 1
    return k


COMPONENT = Component(Parameters, build, neutral=(zero("duration_s"),), silent=silent)
