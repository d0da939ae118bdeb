"""Temporal margins: by how much a flight satisfies a formula of signal temporal logic, folded while it flies.

    signal below x         ρ = x − s(t)                       signal above x         ρ = s(t) − x
    scale c                ρ/c, a pure number
    all of φ₁, φ₂, …       min ρᵢ                             any of φ₁, φ₂, …       max ρᵢ               not φ      −ρ
    always φ               min ρ(φ, t) over t ∈ [a, b]        eventually φ           max ρ(φ, t) over t ∈ [a, b]
    until settled φ        min ρ(φ, t) over t < T             hold φ until ψ         max over t ∈ [a, b] of
                                                                                     min(ρ(ψ, t), min ρ(φ, s) over s < t)
    time share φ           no margin: the share of t ∈ [a, b] with ρ(φ, t) > 0, for the temporal and mixed interpretation of a
                           requirement (ECSS-E-ST-60-10C); by itself, not inside another formula

A margin above 0 says that the formula is true of the flight, below 0 that it is not; its size is how much all signals together
may be off, each by so much (in the unit of the signal, or in its scale), before that changes. t, s: the steps of the flight,
k h; [a, b]: `from_s` to `to_s`, both ends included, the whole flight where nothing is said. T: the first step from which both
capture tubes hold to the end; where they never do, φ is to hold all along (require `captured` beside it), and a flight that
begins settled has the margin ∞. hold until: before the step at which ψ is reached, not at it.

Where formulas of different units are put together, each predicate says its `scale`: the amount of its signal that counts as 1.
What stands inside always, eventually, until_settled and until has no temporal operator itself: nested in time, a margin would
need the whole trace, and these are folded in fixed memory, of one number or two for each temporal operator. The margins of a
flight that ends not finite are NaN, which is a failure of every requirement.

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

Signals: `rvjax explain signals`. Thresholds, scales and windows are numbers of a sample, so another one needs no new program.

Source: A. Donzé, O. Maler, "Robust satisfaction of temporal logic over real-valued signals", FORMATS 2010, LNCS 6246 (space
robustness); G. Fainekos, G. Pappas, "Robustness of temporal logic specifications for continuous-time signals", Theoretical
Computer Science 410, 2009. Until settled is ours.
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
"""ρ(φ) of a flight, from what all watches have kept."""


class Watch(NamedTuple):
    """One temporal operator as a fold: start(context) → acc; update(acc, step, context) → acc."""

    start: Callable[[MetricContext], tuple[Scalar, ...]]
    update: Callable[[tuple[Scalar, ...], Step, MetricContext], tuple[Scalar, ...]]


class Folded(NamedTuple):
    """metric: of all margins. numbers: thresholds, scales and windows, which `MetricContext.margins` has for every sample."""

    metric: Metric
    numbers: tuple[float, ...]


def folded(formulas: Mapping[str, Formula], signals: Mapping[str, Signal], step_s: float) -> Folded:
    """The margins as one metric. signals: every one that the formulas name; step_s: of the integration."""
    made = _Maker(signals, step_s)
    values = {f"{MARGIN}{name}": made.formula(formula) for name, formula in formulas.items()}
    units = {name: signal.column.unit for name, signal in signals.items()}
    columns = {
        f"{MARGIN}{name}": Column(
            f"{MARGIN}{name}", unit(formula, signals), f"{_kind(formula)}{in_words(formula, units)}", "higher"
        )
        for name, formula in formulas.items()
    }
    watches = tuple(made.watches)

    def start(context: MetricContext) -> tuple[Any, ...]:
        return tuple(watch.start(context) for watch in watches)

    def update(acc: tuple[Any, ...], step: Step, weight: Scalar, context: MetricContext) -> tuple[Any, ...]:
        del weight
        return tuple(watch.update(own, step, context) for watch, own in zip(watches, acc, strict=True))

    def finish(acc: tuple[Any, ...], context: MetricContext) -> Mapping[str, Scalar]:
        return {name: value(acc, context) for name, value in values.items()}

    return Folded(Metric(columns, start, update, finish), tuple(made.numbers))


def _kind(formula: Formula) -> str:
    return "" if isinstance(formula, TimeShare) else "margin, above 0: satisfied; "


def unit(formula: Formula, signals: Mapping[str, Signal]) -> str:
    """Of the margin of a formula whose parts have the same one."""
    if isinstance(formula, TimeShare):
        return "1"
    if isinstance(formula, Predicate):
        return signals[formula.signal].column.unit if formula.scale is None else "1"
    return unit(parts_of(formula)[0], signals)


class _Maker:
    """Makes functions of formulas, and collects their numbers and their folds on the way."""

    def __init__(self, signals: Mapping[str, Signal], step_s: float) -> None:
        self.numbers: list[float] = []
        self.watches: list[Watch] = []
        self._signals = signals
        self._step_s = step_s

    def formula(self, formula: Formula) -> Finished:
        """Of a formula with temporal operators."""
        if isinstance(formula, Junction):
            parts = [self.formula(part) for part in formula.parts]
            join = jnp.minimum if formula.word == "all" else jnp.maximum
            return lambda acc, context: reduce(join, [part(acc, context) for part in parts])
        if isinstance(formula, Negation):
            part = self.formula(formula.part)
            return lambda acc, context: -part(acc, context)
        place, last = len(self.watches), 0
        if isinstance(formula, UntilSettled):
            watch, last = until_settled(self.state(formula.part)), 1
        elif isinstance(formula, Until):
            watch, last = until(self.state(formula.hold), self.state(formula.reach), self._inside(formula.window)), 1
        elif isinstance(formula, (Always, Eventually)):
            make = always if isinstance(formula, Always) else eventually
            watch = make(self.state(formula.part), self._inside(formula.window))
        elif isinstance(formula, TimeShare):
            self.watches.append(time_share(self.state(formula.part), self._inside(formula.window)))
            return lambda acc, context: acc[place][0] / acc[place][1]
        else:
            raise TypeError(f"{formula} is no formula of a whole flight")
        self.watches.append(watch)
        return lambda acc, context: acc[place][last]

    def state(self, formula: Formula) -> State:
        """Of a formula without temporal operators."""
        if isinstance(formula, Junction):
            parts = [self.state(part) for part in formula.parts]
            join = jnp.minimum if formula.word == "all" else jnp.maximum
            return lambda step, context: reduce(join, [part(step, context) for part in parts])
        if isinstance(formula, Negation):
            part = self.state(formula.part)
            return lambda step, context: -part(step, context)
        if not isinstance(formula, Predicate):
            raise TypeError(f"{formula} is no formula of one instant")
        get, value, above = self._signals[formula.signal].get, self._number(formula.value), formula.above
        scale = None if formula.scale is None else self._number(formula.scale)

        def margin(step: Step, context: MetricContext) -> Scalar:
            room = get(step) - value(context) if above else value(context) - get(step)
            return room if scale is None else room / scale(context)

        return margin

    def _inside(self, window: Window) -> State:
        """Whether an instant is in a window, whose ends are put half-way between two steps so that no rounding decides."""
        first, behind = window.steps(self._step_s)
        start, end = self._number((first - 0.5) * self._step_s), self._number((behind + 0.5) * self._step_s)
        return lambda step, context: (step.t > start(context)) & (step.t < end(context))

    def _number(self, value: float) -> Callable[[MetricContext], Scalar]:
        place = len(self.numbers)
        self.numbers.append(value)
        return lambda context: context.margins[place]


def always(state: State, inside: State) -> Watch:
    """min ρ over the window."""

    def update(acc: tuple[Scalar, ...], step: Step, context: MetricContext) -> tuple[Scalar, ...]:
        return (jnp.where(inside(step, context), jnp.minimum(acc[0], state(step, context)), acc[0]),)

    return Watch(lambda context: (_full(context, jnp.inf),), update)


def eventually(state: State, inside: State) -> Watch:
    """max ρ over the window."""

    def update(acc: tuple[Scalar, ...], step: Step, context: MetricContext) -> tuple[Scalar, ...]:
        return (jnp.where(inside(step, context), jnp.maximum(acc[0], state(step, context)), acc[0]),)

    return Watch(lambda context: (_full(context, -jnp.inf),), update)


def time_share(state: State, inside: State) -> Watch:
    """(steps of the window at which ρ > 0, steps of the window)."""

    def update(acc: tuple[Scalar, ...], step: Step, context: MetricContext) -> tuple[Scalar, ...]:
        within = inside(step, context)
        true = within & (state(step, context) > 0.0)
        return acc[0] + jnp.where(true, 1.0, 0.0), acc[1] + jnp.where(within, 1.0, 0.0)

    return Watch(lambda context: (_full(context, 0.0), _full(context, 0.0)), update)


def until_settled(state: State) -> Watch:
    """(min ρ so far, the same up to the last step outside the tubes): the second one is min ρ over t < T."""

    def update(acc: tuple[Scalar, ...], step: Step, context: MetricContext) -> tuple[Scalar, ...]:
        lowest = jnp.minimum(acc[0], state(step, context))
        settled = (norm(step.motion.rho) <= context.tube_m) & (norm(step.motion.sigma) <= context.tube_mrp)
        return lowest, jnp.where(settled, acc[1], lowest)

    return Watch(lambda context: (_full(context, jnp.inf), _full(context, jnp.inf)), update)


def until(hold: State, reach: State, inside: State) -> Watch:
    """(min ρ(φ) before this step, the best of min(ρ(ψ), that) in the window so far)."""

    def update(acc: tuple[Scalar, ...], step: Step, context: MetricContext) -> tuple[Scalar, ...]:
        held, best = acc
        reached = jnp.minimum(reach(step, context), held)
        best = jnp.where(inside(step, context), jnp.maximum(best, reached), best)
        return jnp.minimum(held, hold(step, context)), best

    return Watch(lambda context: (_full(context, jnp.inf), _full(context, -jnp.inf)), update)


def _full(context: MetricContext, value: float) -> Scalar:
    return jnp.full_like(context.duration_s, value)
