"""Gradient: x' = x + s,   s along argmin gᵀs + ½ sᵀB s for 0 ≤ x + s ≤ 1,   |s_i| ≤ r,   g the gradient at x.

Projected quasi-Newton descents from the original campaign and from points of a Sobol sequence, in parallel: a batch holds the
next step of every active descent. B is the BFGS matrix of all steps so far, B' = B − B s sᵀB/(sᵀB s) + y yᵀ/(yᵀs), y the change
of g (J. Nocedal, S. Wright, "Numerical optimization", Springer, 2006, ch. 6, 18). The trust radius r doubles after a step of that
length. A step is too long if the slope at its end is nearly as steep upwards as it was downwards: it updates B, and a shorter
step from the same point replaces it. Only gradients are used, so a smooth function may replace the objective; constraints count
if that function contains them. A descent ends when its step is below 10⁻⁶ of the range, or when there is no gradient; the search
ends with the last descent. An axis with levels keeps its initial value.
"""

from __future__ import annotations

from collections.abc import Generator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign import Model
from rvjax.campaign.fields import count
from rvjax.components.search_methods.interface import Evaluate, Method, Task, Values, snapped
from rvjax.components.search_methods.point_sets import number, spread

FIRST, MOST, SMALL = 0.1, 0.5, 1e-6
"""First trust radius, largest trust radius, and step at which a descent ends: shares of the range."""

UP = 0.9
"""A step is too long if the slope upwards at its end exceeds this share of the slope downwards at its start."""

LARGE, FLAT = 1e100, 1e-10
"""Larger gradients are invalid, because their squares overflow; smallest cosine of s and y that updates B."""

Descent = Generator[Values, Values, None]
"""Yields a point and receives the gradient there."""


class Parameters(Model):
    """Starting points."""

    starts: int = count(default=4, at_least=1, at_most=10_000, doc="parallel descents, the first from the original campaign")


def descent(x: Values, free: NDArray[np.bool_]) -> Descent:
    """A descent from a point. free: (d,) the axes that move."""
    g = np.where(free, (yield x), 0.0)
    reach, model = FIRST, None
    while usable(g) and g.any():
        curvature = np.eye(len(x)) * (np.abs(g).max() / FIRST) if model is None else model
        s = step(curvature, g, -x, 1.0 - x)
        length = np.abs(s).max()
        if length < SMALL or reach < SMALL:
            return
        if g @ s >= 0.0:
            if model is None:
                return
            model = None
            continue
        s, length = s * min(1.0, reach / length), min(length, reach)
        there = np.clip(x + s, 0.0, 1.0)
        new = np.where(free, (yield there), 0.0)
        if not usable(new):
            reach = length / 4.0
            continue
        before, after, y = g @ s, new @ s, new - g
        if y @ s <= FLAT * float(np.linalg.norm(y) * np.linalg.norm(s)):
            model = curvature / 2.0  # negative curvature: a longer step
        else:
            model = updated(np.eye(len(x)) * ((y @ y) / (y @ s)) if model is None else model, s, y)
        if after > -UP * before:
            reach = length * float(np.clip(before / (before - after), 0.1, 0.5))
            continue
        reach = min(2.0 * reach, MOST) if length == reach else reach
        x, g = there, new


def usable(g: Values) -> bool:
    """Whether a gradient is finite and not too large."""
    return bool((np.abs(g) < LARGE).all())  # false for NaN


def step(curvature: Values, g: Values, low: Values, high: Values) -> Values:
    """argmin gᵀs + ½ sᵀB s for low ≤ s ≤ high: fixes the coordinate farthest outside at its bound, solves again."""
    s, inside = np.zeros(len(g)), np.ones(len(g), dtype=bool)
    while inside.any():
        pull = g[inside] + curvature[np.ix_(inside, ~inside)] @ s[~inside]
        s[inside] = np.linalg.solve(curvature[np.ix_(inside, inside)], -pull)
        beyond = np.maximum(low - s, s - high)
        farthest = int(beyond.argmax())
        if beyond[farthest] <= 0.0:
            break
        inside[farthest] = False
        s = np.clip(s, low, high)
    return s


def updated(curvature: Values, s: Values, y: Values) -> Values:
    """The BFGS matrix after a step s that changed the gradient by y."""
    ahead = curvature @ s
    return curvature - np.outer(ahead, ahead) / (s @ ahead) + np.outer(y, y) / (y @ s)


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """All descents in parallel."""
    first = np.empty((0, len(task.axes))) if task.start is None else task.start[None]
    others = spread(len(task.axes), number(task.seed, "search:gradient"))(parameters.starts - len(first))
    free = np.array([not axis.levels for axis in task.axes])
    descents = [descent(point, free) for point in snapped(task.axes, np.concatenate([first, others]))]
    active = [(path, next(path)) for path in descents]
    while active:
        results = evaluate(snapped(task.axes, np.stack([point for _, point in active])))
        if results.gradient is None:
            raise ValueError("the method gradient got no gradient")
        following: list[tuple[Descent, Values]] = []
        for (path, _), gradient in zip(active, results.gradient, strict=True):
            try:
                following.append((path, path.send(gradient)))
            except StopIteration:
                continue
        active = following


COMPONENT = Method(Parameters, lambda parameters: partial(search, parameters), gradient=True)
