"""Functions whose optimum is known, and who tells a search about them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from rvjax.components.registry import component
from rvjax.components.search_methods.interface import Axis, Results, Spent, Task, Values

CENTRE = np.array([0.42, 0.61, 0.55, 0.38])


class Outcome(NamedTuple):
    """What a function says of m points; gradient: of the first objective."""

    objectives: Values
    violation: Values | None = None
    gradient: Values | None = None


Function = Callable[[Values], Outcome]


def ranks(violation: Values, objectives: Values) -> Values:
    """(m,) by violation, then by the first objective, then by the next."""
    rows = [tuple(row) for row in np.column_stack([violation, objectives]).tolist()]
    order = {row: place for place, row in enumerate(sorted(set(rows)))}
    return np.array([float(order[row]) for row in rows])


@dataclass
class Answers:
    """Tells what comes of points, so many batches or points of them; proposed: what was asked, batch by batch."""

    function: Function
    points: int | None = None
    batches: int | None = None
    proposed: list[Values] = field(default_factory=list)
    objectives: list[Values] = field(default_factory=list)

    def __call__(self, points: Values) -> Results:
        """As `Evaluate`."""
        spent = self.points is not None and sum(map(len, self.proposed)) + len(points) > self.points
        if spent or len(self.proposed) == self.batches:
            raise Spent
        self.proposed.append(points.copy())
        objectives, violation, gradient = self.function(points)
        self.objectives.append(objectives)
        violation = np.zeros(len(points)) if violation is None else violation
        return Results(violation, objectives, ranks(violation, objectives), gradient)

    @property
    def all(self) -> Values:
        """(n, d) everything proposed."""
        return np.concatenate(self.proposed)

    @property
    def best(self) -> float:
        """The least first objective."""
        return float(np.concatenate(self.objectives)[:, 0].min())


def searched(name: str, function: Function, task: Task, budget: int | None = None, **said: object) -> Answers:
    """A search until it ends, or until a budget of points is spent; `batches` among said: of batches instead."""
    batches = said.pop("batches", None)
    assert batches is None or isinstance(batches, int)
    answers = Answers(function, budget, batches)
    method = component("searches", name)
    with suppress(Spent):
        method.build(method.parameters.model_validate(said))(task, answers)
    return answers


def cube(dimensions: int, seed: int, **more: object) -> Task:
    """Axes without levels."""
    return replace(Task((Axis(),) * dimensions, seed), **more)  # pyright: ignore[reportArgumentType]


def sphere(x: Values) -> Outcome:
    """Σ (x_i − c_i)², 0 at c."""
    away = x - CENTRE[: x.shape[1]]
    return Outcome((away**2).sum(axis=1)[:, None], None, 2.0 * away)


BRANIN = 0.397887


def branin(x: Values) -> Outcome:
    """Three optima of 0.397887 over [−5, 10] × [0, 15]."""
    u, v = 15.0 * x[:, 0] - 5.0, 15.0 * x[:, 1]
    inner = v - 5.1 / (4 * np.pi**2) * u**2 + 5 / np.pi * u - 6.0
    slope = 2 * inner * (5 / np.pi - 5.1 / (2 * np.pi**2) * u) - 10 * (1 - 1 / (8 * np.pi)) * np.sin(u)
    value = inner**2 + 10 * (1 - 1 / (8 * np.pi)) * np.cos(u) + 10
    return Outcome(value[:, None], None, 15.0 * np.stack([slope, 2 * inner], axis=1))


def rosenbrock(x: Values) -> Outcome:
    """Σ 100 (u_{i+1} − u_i²)² + (1 − u_i)², 0 at u = 1, over [−2, 2]^d."""
    u = 4.0 * x - 2.0
    bend, rest = u[:, 1:] - u[:, :-1] ** 2, 1.0 - u[:, :-1]
    gradient = np.zeros_like(u)
    gradient[:, :-1] -= 400 * bend * u[:, :-1] + 2 * rest
    gradient[:, 1:] += 200 * bend
    return Outcome((100 * bend**2 + rest**2).sum(axis=1)[:, None], None, 4.0 * gradient)


MIXED = (Axis(), Axis(levels=8), Axis(levels=3, ordered=False))
PRICES = np.array([0.6, 0.0, 0.9])


def mixed(x: Values) -> Outcome:
    """A number, a whole number and a choice: 0 at 0.3, the level 5 of 8 and the choice 1 of 3. The gradients of
    levels mislead."""
    level, choice = np.floor(8 * x[:, 1]), np.floor(3 * x[:, 2]).astype(int)
    away = x[:, 0] - 0.3
    value = away**2 + 0.02 * (level - 5) ** 2 + PRICES[choice]
    return Outcome(value[:, None], None, np.stack([2 * away, np.ones_like(away), -np.ones_like(away)], axis=1))


def constrained(x: Values) -> Outcome:
    """x + y where x y ≥ 0.16: 0.8 at (0.4, 0.4), on the boundary; the objective alone is least at (0, 0)."""
    missed = np.maximum(0.0, 0.16 - x[:, 0] * x[:, 1])
    return Outcome(x.sum(axis=1)[:, None], missed)


def zdt1(x: Values) -> Outcome:
    """Two objectives; the front is f2 = 1 − √f1 with all x but the first 0 (E. Zitzler, K. Deb, L. Thiele 2000)."""
    g = 1.0 + 9.0 * x[:, 1:].mean(axis=1)
    return Outcome(np.stack([x[:, 0], g * (1.0 - np.sqrt(x[:, 0] / g))], axis=1))
