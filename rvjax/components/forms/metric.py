"""The user's metric: a fold over the steps of a flight, on plain arrays.

acc₀ = start(numbers),   acc = update(acc, instant, numbers) at every step,   values = finish(acc, numbers)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from rvjax.campaign import Model
from rvjax.components.forms import arrays
from rvjax.components.forms.called import begun, following
from rvjax.components.forms.form import check_form
from rvjax.components.forms.signal import Signal, columns
from rvjax.components.metrics import interface
from rvjax.components.metrics.interface import MetricContext
from rvjax.components.registry import Component
from rvjax.components.user_mistakes import UserMistake, given_by
from rvjax.physics.state import Step
from rvjax.physics.vectors import Scalar


class Instant(NamedTuple):
    """All values of a flight at the start of a step, as arrays; frames as of `Measured`.

    t: time [s]. weight: of the trapezoidal rule [s], so that Σ weight f(t) ≈ ∫ f dt. duration: of the flight [s].
    rho, nu, sigma, omega: true motion. target_r, target_v, target_w: of the target. port: docking point, in T [m].
    command: before the saturation; commanded: behind it; applied: behind the faults; disturbance: (6,) each [N, N·m].
    thrusts: (n,) behind the faults [N]; () without thrusters. mass [kg].
    """

    t: Any
    weight: Any
    duration: Any
    rho: Any
    nu: Any
    sigma: Any
    omega: Any
    target_r: Any
    target_v: Any
    target_w: Any
    port: Any
    command: Any
    commanded: Any
    applied: Any
    disturbance: Any
    thrusts: Any
    mass: Any


@dataclass(frozen=True)
class Metric:
    """A metric with its columns of the samples table.

    parameters: the model of its numbers. columns: unit and meaning of each value, by name; better="lower" or "higher" where
    one side is better. start(numbers) → any tree of numbers; update(acc, instant, numbers) → the same tree;
    finish(acc, numbers) → a number for each column; None: the accumulator is the mapping of values itself. safety: the values
    stay in the table where a flight collided; without it they are then NaN, since what follows a collision is no flight.
    """

    parameters: type[Model]
    columns: Mapping[str, Signal]
    start: Callable[..., Any] | None = None
    update: Callable[..., Any] | None = None
    finish: Callable[..., Mapping[str, Any]] | None = None
    safety: bool = False

    family = "metrics"

    def __post_init__(self) -> None:
        check_form(self, functions=("start", "update"), maybe=("finish",), model=self.parameters)
        if (
            not isinstance(self.columns, Mapping)
            or not self.columns
            or not all(isinstance(c, Signal) for c in self.columns.values())
        ):
            raise TypeError(
                'Metric: found no columns; accepted: a mapping such as {"clearance_m": Signal("m", "meaning", "higher")}'
            )

    @cached_property
    def component(self) -> Component[Any]:
        """The component of the registry."""
        return Component(self.parameters, self._build)

    def _build(self, parameters: Model) -> interface.Metric:
        del parameters
        return interface.Metric(columns(self.columns), self._start, self._update, self._finish, safety=self.safety)

    def _start(self, context: MetricContext) -> Any:
        return begun(self.start, "the result", arrays.arrays(context.numbers))

    def _update(self, acc: Any, step: Step, weight: Scalar, context: MetricContext) -> Any:
        wrenches = (step.command, step.commanded, step.applied, step.disturbance, step.thrusts)
        values = (*step.motion, *step.target, step.plant.port, *wrenches)
        seen: list[Any] = [step.t, weight, context.duration_s, *map(arrays.array, values), step.plant.mass]
        return following(self.update, acc, "the result", acc, Instant(*seen), arrays.arrays(context.numbers))

    def _finish(self, acc: Any, context: MetricContext) -> Mapping[str, Any]:
        name = "the accumulator" if self.finish is None else self.finish.__name__
        with given_by(self.finish or self.start):
            values = acc if self.finish is None else self.finish(acc, arrays.arrays(context.numbers))
            if not isinstance(values, Mapping) or set(values) != set(self.columns):
                found = f"the columns {', '.join(map(str, values))}" if isinstance(values, Mapping) else arrays.kind(values)
                raise UserMistake(f"{name} gives {found}", f"accepted: a mapping with {', '.join(self.columns)}")
            return {column: arrays.number(values[column], f"{column} of {name}") for column in self.columns}
