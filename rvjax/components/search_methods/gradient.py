"""Gradient: x' = x + s,   s along argmin gᵀs + ½ sᵀB s for 0 ≤ x + s ≤ 1,   |s_i| ≤ r,   g the gradient at x.

A projected quasi-Newton descent, from the start of the campaign and from points of a Sobol sequence, all at once: each batch is
the next step of every descent that goes on. B is the BFGS matrix of all steps so far, B' = B − B s sᵀB/(sᵀB s) + y yᵀ/(yᵀs), y
the change of g (J. Nocedal, S. Wright, "Numerical optimization", Springer, 2006, ch. 6, 18). The reach r doubles where a step was
as long as that. A step that arrives where it goes up nearly as steeply as it went down was too long: it teaches B, and another
one, shorter, is taken from where it began. Gradients alone decide, so they may be of a smooth function in the place of an
objective; constraints count where that function holds them. A descent ends where its step is below 10⁻⁶ of the range, or where
there is no gradient; the search ends with the last of them. An axis of levels stays where its descent began.
"""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign import Model
from rvjax.campaign.fields import count
from rvjax.components.search_methods.interface import Evaluate, Method, Task, Values, snapped
from rvjax.components.search_methods.point_sets import number, spread

FIRST, MOST, SMALL = 0.1, 0.5, 1e-6
"""Reach at first, at most, and where a descent ends: shares of the range."""

UP = 0.9
"""A step is too long if it arrives going up by this share of how it went down."""

LARGE, FLAT = 1e100, 1e-10
"""A gradient that is larger says nothing, its square would overflow; the least cosine of s and y that teaches a curvature."""

Descent = Generator[Values, Values, None]
"""Yields a point, is sent the gradient there."""


class Parameters(Model):
    """Where it begins."""

    starts: int = count(default=4, at_least=1, at_most=10_000, doc="descents at once, the first from the start of the campaign")


def descent(x: Values, free: NDArray[np.bool_]) -> Descent:
    """From one point down. free: (d,) the axes that move."""
    g = np.where(free, (yield x), 0.0)
    reach, model = FIRST, None
    while says(g) and g.any():
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
        if not says(new):
            reach = length / 4.0
            continue
        before, after, y = g @ s, new @ s, new - g
        if y @ s <= FLAT * float(np.linalg.norm(y) * np.linalg.norm(s)):
            model = curvature / 2.0  # it bends down: a longer step
        else:
            model = taught(np.eye(len(x)) * ((y @ y) / (y @ s)) if model is None else model, s, y)
        if after > -UP * before:
            reach = length * float(np.clip(before / (before - after), 0.1, 0.5))
            continue
        reach = min(2.0 * reach, MOST) if length == reach else reach
        x, g = there, new


def says(g: Values) -> bool:
    """Whether it is a gradient to calculate with."""
    return bool((np.abs(g) < LARGE).all())  # not where it is NaN


def step(curvature: Values, g: Values, low: Values, high: Values) -> Values:
    """argmin gᵀs + ½ sᵀB s for low ≤ s ≤ high: what is farthest outside stays at its side while the others are solved again."""
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


def taught(curvature: Values, s: Values, y: Values) -> Values:
    """The BFGS matrix after a step."""
    ahead = curvature @ s
    return curvature - np.outer(ahead, ahead) / (s @ ahead) + np.outer(y, y) / (y @ s)


def search(parameters: Parameters, task: Task, evaluate: Evaluate) -> None:
    """All descents side by side."""
    given = np.empty((0, len(task.axes))) if task.start is None else task.start[None]
    others = spread(len(task.axes), number(task.seed, "search:gradient"))(parameters.starts - len(given))
    free = np.array([not axis.levels for axis in task.axes])
    descents = [descent(point, free) for point in snapped(task.axes, np.concatenate([given, others]))]
    ahead = [(one, next(one)) for one in descents]
    while ahead:
        told = evaluate(snapped(task.axes, np.stack([point for _, point in ahead])))
        if told.gradient is None:
            raise ValueError("the method gradient was told no gradient")
        following: list[tuple[Descent, Values]] = []
        for (one, _), gradient in zip(ahead, told.gradient, strict=True):
            try:
                following.append((one, one.send(gradient)))
            except StopIteration:
                continue
        ahead = following


COMPONENT = Method(Parameters, lambda parameters: lambda task, evaluate: search(parameters, task, evaluate), gradient=True)
