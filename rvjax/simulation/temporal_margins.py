"""Temporal margins: by how much a flight satisfies a formula of signal temporal logic, computed while it flies.

    signal below x         ρ = x − s(t)                       signal above x         ρ = s(t) − x
    scale c                ρ/c, a pure number
    all of φ₁, φ₂, …       min ρᵢ                             any of φ₁, φ₂, …       max ρᵢ               not φ      −ρ
    always φ               min ρ(φ, t) over t ∈ [a, b]        eventually φ           max ρ(φ, t) over t ∈ [a, b]
    until settled φ        min ρ(φ, t) over t < T             hold φ until ψ         max over t ∈ [a, b] of
                                                                                     min(ρ(ψ, t), min ρ(φ, s) over s < t)
    time share φ           the share of t ∈ [a, b] with ρ(φ, t) > 0: no margin, but a value for the temporal and mixed
                           interpretation of a requirement (ECSS-E-ST-60-10C); not inside another formula

Above 0 the flight satisfies the formula, below 0 it does not. The size of a margin is the change of all signals (each in its
unit, or in its scale) that may reverse this. t, s: the steps k h of the flight. [a, b]: `from_s` to `to_s`, both ends included,
by default the whole flight. T: the first step from which both capture tubes hold to the end. If they never do, φ has to hold
during the whole flight (also require `captured`); a flight that begins settled has the margin ∞. hold until: φ has to hold
before the step at which ψ is reached, not at it.

If formulas of different units are combined, each predicate needs a `scale`: the amount of its signal that counts as 1. No
temporal operator may be inside always, eventually, until_settled and until: that would need the whole trace, while each
operator here needs only one or two numbers of memory. The margins of a flight that ends not finite are NaN, a failure of every
requirement.

    margins:
      docks-gently:                      # the metric margin.docks-gently
        all:
          - always: {signal: closing_speed_m_s, below: 0.5, scale: 0.1, from_s: 60}
          - eventually: {signal: position_error_m, below: 0.01, scale: 0.01, to_s: 200}
          - until_settled: {signal: attitude_error_deg, below: 20, scale: 5}
      calm-before-near:
        until:
          hold: {signal: position_error_m, above: 1, scale: 1}
          reach: {all: [{signal: rate_deg_s, below: 0.1, scale: 0.1}, {signal: speed_m_s, below: 0.1, scale: 0.1}]}
          to_s: 200

Signals: `rvjax explain signals`. Thresholds, scales and windows are numbers of a sample, so changing them needs no new program.

Source: A. Donzé, O. Maler, "Robust satisfaction of temporal logic over real-valued signals", FORMATS 2010, LNCS 6246 (space
robustness); G. Fainekos, G. Pappas, "Robustness of temporal logic specifications for continuous-time signals", Theoretical
Computer Science 410, 2009. Until settled is defined here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import reduce
from typing import Any, NamedTuple

import jax.numpy as jnp

from rvjax.campaign.formula import (
    Always,
    Eventually,
    Formula,
    Junction,
    Negation,
    Predicate,
    TimeShare,
    Until,
    UntilSettled,
    Window,
    in_words,
    parts_of,
)
from rvjax.columns import MARGIN, Column
from rvjax.components.metrics.interface import Metric, MetricContext
from rvjax.physics.state import Step
from rvjax.physics.vectors import Scalar, norm
from rvjax.simulation.signals import Signal

State = Callable[[Step, MetricContext], Scalar]
"""ρ(φ, t) of a formula without temporal operators."""

Finished = Callable[[tuple[Any, ...], MetricContext], Scalar]
"""ρ(φ) of a flight, from the accumulators of all operators."""


class Operator(NamedTuple):
    """A temporal operator with an accumulator: start(context) → acc; update(acc, step, context) → acc."""

    start: Callable[[MetricContext], tuple[Scalar, ...]]
    update: Callable[[tuple[Scalar, ...], Step, MetricContext], tuple[Scalar, ...]]


class MarginsMetric(NamedTuple):
    """metric: with a column per margin. numbers: thresholds, scales and windows, passed in `MetricContext.margins`."""

    metric: Metric
    numbers: tuple[float, ...]


def margins_metric(formulas: Mapping[str, Formula], signals: Mapping[str, Signal], step_s: float) -> MarginsMetric:
    """The margins as a single metric. signals: all that the formulas name; step_s: of the integration."""
    compiler = _Compiler(signals, step_s)
    values = {f"{MARGIN}{name}": compiler.formula(formula) for name, formula in formulas.items()}
    units = {name: signal.column.unit for name, signal in signals.items()}
    columns = {
        f"{MARGIN}{name}": Column(
            f"{MARGIN}{name}", unit(formula, signals), f"{_kind(formula)}{in_words(formula, units)}", "higher"
        )
        for name, formula in formulas.items()
    }
    operators = tuple(compiler.operators)

    def start(context: MetricContext) -> tuple[Any, ...]:
        return tuple(operator.start(context) for operator in operators)

    def update(acc: tuple[Any, ...], step: Step, weight: Scalar, context: MetricContext) -> tuple[Any, ...]:
        del weight
        return tuple(operator.update(kept, step, context) for operator, kept in zip(operators, acc, strict=True))

    def finish(acc: tuple[Any, ...], context: MetricContext) -> Mapping[str, Scalar]:
        return {name: value(acc, context) for name, value in values.items()}

    return MarginsMetric(Metric(columns, start, update, finish), tuple(compiler.numbers))


def _kind(formula: Formula) -> str:
    return "" if isinstance(formula, TimeShare) else "margin, above 0: satisfied; "


def unit(formula: Formula, signals: Mapping[str, Signal]) -> str:
    """The unit of the margin of a formula whose parts have the same unit."""
    if isinstance(formula, TimeShare):
        return "1"
    if isinstance(formula, Predicate):
        return signals[formula.signal].column.unit if formula.scale is None else "1"
    return unit(parts_of(formula)[0], signals)


class _Compiler:
    """Turns formulas into functions, and collects their numbers and operators."""

    def __init__(self, signals: Mapping[str, Signal], step_s: float) -> None:
        self.numbers: list[float] = []
        self.operators: list[Operator] = []
        self._signals = signals
        self._step_s = step_s

    def formula(self, formula: Formula) -> Finished:
        """The function of a formula with temporal operators."""
        if isinstance(formula, Junction):
            parts = [self.formula(part) for part in formula.parts]
            join = jnp.minimum if formula.word == "all" else jnp.maximum
            return lambda acc, context: reduce(join, [part(acc, context) for part in parts])
        if isinstance(formula, Negation):
            part = self.formula(formula.part)
            return lambda acc, context: -part(acc, context)
        place, last = len(self.operators), 0
        if isinstance(formula, UntilSettled):
            operator, last = until_settled(self.state(formula.part)), 1
        elif isinstance(formula, Until):
            operator, last = until(self.state(formula.hold), self.state(formula.reach), self._inside(formula.window)), 1
        elif isinstance(formula, (Always, Eventually)):
            make = always if isinstance(formula, Always) else eventually
            operator = make(self.state(formula.part), self._inside(formula.window))
        elif isinstance(formula, TimeShare):
            self.operators.append(time_share(self.state(formula.part), self._inside(formula.window)))
            return lambda acc, context: acc[place][0] / acc[place][1]
        else:
            raise TypeError(f"{formula} is no formula of a whole flight")
        self.operators.append(operator)
        return lambda acc, context: acc[place][last]

    def state(self, formula: Formula) -> State:
        """The function of a formula without temporal operators."""
        if isinstance(formula, Junction):
            parts = [self.state(part) for part in formula.parts]
            join = jnp.minimum if formula.word == "all" else jnp.maximum
            return lambda step, context: reduce(join, [part(step, context) for part in parts])
        if isinstance(formula, Negation):
            part = self.state(formula.part)
            return lambda step, context: -part(step, context)
        if not isinstance(formula, Predicate):
            raise TypeError(f"{formula} is no formula of an instant")
        get, value, above = self._signals[formula.signal].get, self._number(formula.value), formula.above
        scale = None if formula.scale is None else self._number(formula.scale)

        def margin(step: Step, context: MetricContext) -> Scalar:
            room = get(step) - value(context) if above else value(context) - get(step)
            return room if scale is None else room / scale(context)

        return margin

    def _inside(self, window: Window) -> State:
        """Whether an instant is in a window. Its ends are half-way between two steps, so rounding does not matter."""
        first, behind = window.steps(self._step_s)
        start, end = self._number((first - 0.5) * self._step_s), self._number((behind + 0.5) * self._step_s)
        return lambda step, context: (step.t > start(context)) & (step.t < end(context))

    def _number(self, value: float) -> Callable[[MetricContext], Scalar]:
        place = len(self.numbers)
        self.numbers.append(value)
        return lambda context: context.margins[place]


def always(state: State, inside: State) -> Operator:
    """min ρ over the window."""

    def update(acc: tuple[Scalar, ...], step: Step, context: MetricContext) -> tuple[Scalar, ...]:
        return (jnp.where(inside(step, context), jnp.minimum(acc[0], state(step, context)), acc[0]),)

    return Operator(lambda context: (_full(context, jnp.inf),), update)


def eventually(state: State, inside: State) -> Operator:
    """max ρ over the window."""

    def update(acc: tuple[Scalar, ...], step: Step, context: MetricContext) -> tuple[Scalar, ...]:
        return (jnp.where(inside(step, context), jnp.maximum(acc[0], state(step, context)), acc[0]),)

    return Operator(lambda context: (_full(context, -jnp.inf),), update)


def time_share(state: State, inside: State) -> Operator:
    """(steps of the window at which ρ > 0, steps of the window)."""

    def update(acc: tuple[Scalar, ...], step: Step, context: MetricContext) -> tuple[Scalar, ...]:
        within = inside(step, context)
        true = within & (state(step, context) > 0.0)
        return acc[0] + jnp.where(true, 1.0, 0.0), acc[1] + jnp.where(within, 1.0, 0.0)

    return Operator(lambda context: (_full(context, 0.0), _full(context, 0.0)), update)


def until_settled(state: State) -> Operator:
    """(min ρ so far, the same up to the last step outside the tubes): the second is min ρ over t < T."""

    def update(acc: tuple[Scalar, ...], step: Step, context: MetricContext) -> tuple[Scalar, ...]:
        lowest = jnp.minimum(acc[0], state(step, context))
        settled = (norm(step.motion.rho) <= context.tube_m) & (norm(step.motion.sigma) <= context.tube_mrp)
        return lowest, jnp.where(settled, acc[1], lowest)

    return Operator(lambda context: (_full(context, jnp.inf), _full(context, jnp.inf)), update)


def until(hold: State, reach: State, inside: State) -> Operator:
    """(min ρ(φ) before this step, the largest min(ρ(ψ), that) in the window so far)."""

    def update(acc: tuple[Scalar, ...], step: Step, context: MetricContext) -> tuple[Scalar, ...]:
        held, best = acc
        reached = jnp.minimum(reach(step, context), held)
        best = jnp.where(inside(step, context), jnp.maximum(best, reached), best)
        return jnp.minimum(held, hold(step, context)), best

    return Operator(lambda context: (_full(context, jnp.inf), _full(context, -jnp.inf)), update)


def _full(context: MetricContext, value: float) -> Scalar:
    return jnp.full_like(context.duration_s, value)
