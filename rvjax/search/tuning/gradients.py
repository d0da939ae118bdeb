"""Gradients for a search: of a smooth function of the closed loop in the place of the objective, forward through the flight.

    J(u) = mean over samples of m,    ∂J/∂u_j = mean of dm/dε along ṅ_j,    ṅ_j = (n(u + ε e_j) − n(u − ε e_j))/2ε

The numbers n that fly at a point u are made by the campaign itself, so whatever can be tuned has a slope; m is differentiated
through every step of the flight (`rvjax.simulation.batch.Tangents`). Each lane flies a sample along a coordinate.

    metric                             m
    settling_time_s                    ∫ r²/(1 + r²) dt,  r = |ρ|/tube: the time outside of the tube, softened at its edge
    attitude_settling_time_s           the same of |σ|
    delta_v_m_s                        ∫ F/m dt,  F = Σ fᵢ of the thrusters, or Σ √(f_axis² + δ²) of the channels
    thrust_impulse_Ns                  ∫ F dt
    angular_impulse_Nms                ∫ √(|τ|² + δ²) dt
    window errors, final errors        √ of the mean of |ρ|², or |σ|², over the closing window

The gradient only says where to look: what a candidate is worth comes from its true flights.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.tuning import Tuning
from rvjax.columns import Column
from rvjax.components.metrics.interface import Metric, MetricContext
from rvjax.errors import Finding
from rvjax.physics.state import Step
from rvjax.physics.vectors import Scalar, Thrusts, Vector, each, total
from rvjax.search.tuning.candidate_flights import Flights
from rvjax.search.tuning.space import Space
from rvjax.simulation.batch import Tangents
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem

REACH = 1e-4
"""ε: of a range, over which the numbers that fly are differenced."""

NAME = "smooth"

SOFT = 1e-3
"""δ [N, N·m]: far below what actuators give."""

Values = NDArray[np.float64]


def _squared(v: Vector) -> Scalar:
    return v.x * v.x + v.y * v.y + v.z * v.z


def _outside(step: Step, context: MetricContext) -> Scalar:
    r = _squared(step.motion.rho) / (context.tube_m * context.tube_m)
    return r / (1.0 + r)


def _turned(step: Step, context: MetricContext) -> Scalar:
    r = _squared(step.motion.sigma) / (context.tube_mrp * context.tube_mrp)
    return r / (1.0 + r)


def _pushed(step: Step, context: MetricContext) -> Scalar:
    return _fired(step, context) / step.plant.mass


def _fired(step: Step, context: MetricContext) -> Scalar:
    del context
    if isinstance(step.thrusts, Thrusts):
        return total(step.thrusts)
    return total(each(lambda f: jnp.sqrt(f * f + SOFT**2), step.applied.force))


def _twisted(step: Step, context: MetricContext) -> Scalar:
    del context
    return jnp.sqrt(_squared(step.applied.torque) + SOFT**2)


def _closing(square: Callable[[Step], Scalar]) -> Callable[[Step, MetricContext], Scalar]:
    def inside(step: Step, context: MetricContext) -> Scalar:
        window = context.duration_s - context.window_start_s
        return jnp.where(step.t >= context.window_start_s, square(step) / window, 0.0)

    return inside


def _metric(rate: Callable[[Step, MetricContext], Scalar], finish: Callable[[Scalar], Scalar] = lambda total: total) -> Metric:
    """∫ rate dt, then finish."""
    return Metric(
        {NAME: Column(NAME, "1", "a smooth function in the place of an objective")},
        lambda context: context.duration_s * 0.0,
        lambda total, step, weight, context: total + weight * rate(step, context),
        lambda total, context: {NAME: finish(total)},
    )


_POSITION = _metric(_closing(lambda step: _squared(step.motion.rho)), lambda total: jnp.sqrt(total + 1e-12))
_ATTITUDE = _metric(_closing(lambda step: _squared(step.motion.sigma)), lambda total: jnp.sqrt(total + 1e-12))
SMOOTH: Mapping[str, Metric] = {
    "settling_time_s": _metric(_outside),
    "attitude_settling_time_s": _metric(_turned),
    "delta_v_m_s": _metric(_pushed),
    "thrust_impulse_Ns": _metric(_fired),
    "angular_impulse_Nms": _metric(_twisted),
    "final_position_error_m": _POSITION,
    "window_position_error_m": _POSITION,
    "final_attitude_error_deg": _ATTITUDE,
    "window_attitude_error_deg": _ATTITUDE,
}


class Slopes:
    """Gradients of the first objective, in the coordinates of the search."""

    def __init__(self, space: Space, tuning: Tuning, flights: Flights) -> None:
        self._space, self._flights = space, flights
        self._metric = SMOOTH[tuning.objective[0].metric]
        self._samples = np.arange(tuning.rounds[0], dtype=np.int64)
        self._programs: dict[str, Tangents] = {}

    @staticmethod
    def findings(problem: Problem, tuning: Tuning) -> list[Finding]:
        """The first objective, where nothing smooth is in its place."""
        metric = tuning.objective[0].metric
        if metric in SMOOTH:
            return []
        what = f"{metric} has no smooth substitute"
        return [problem.spec.source.finding(("tune", "objective"), what, did_you_mean(metric, SMOOTH))]

    def of(self, candidates: Sequence[int], points: Values) -> Values:
        """(m, d) gradients at points; 0 along levels, and where the campaign refuses the point or what is beside it."""
        gradients = np.zeros(points.shape)
        for row, (candidate, point) in enumerate(zip(candidates, points, strict=True)):
            problem = self._flights.candidates[candidate].problem
            ways = [j for j, axis in enumerate(self._space.axes) if not axis.levels]
            tangents = {} if problem is None else {j: t for j in ways if (t := self._tangent(point, j)) is not None}
            if problem is not None and tangents:
                slopes = self._fly(problem, tangents)
                gradients[row, list(tangents)] = slopes
        return gradients

    def _tangent(self, point: Values, axis: int) -> Any:
        """ṅ along a coordinate, of every sample."""
        ends = [min(point[axis] + REACH, 1.0), max(point[axis] - REACH, 0.0)]
        sides: list[Any] = []
        for end in ends:
            moved = point.copy()
            moved[axis] = end
            number = self._flights.problem_at(self._space.values(moved, exact=True))
            if number is None:
                return None
            sides.append(Draws.of(number, self._samples)[1])
        return jax.tree.map(lambda high, low: (high - low) / (ends[0] - ends[1]), *sides)

    def _fly(self, problem: Problem, tangents: Mapping[int, Any]) -> Values:
        """(axes,) the slope along each, the mean over the samples."""
        _, numbers = Draws.of(problem, self._samples)
        program = self._programs.setdefault(problem.structure, Tangents(problem.loop, self._metric, NAME))
        count = len(self._samples)
        drawn = jax.tree.map(lambda x: np.tile(x, len(tangents)), numbers)
        tangent = jax.tree.map(lambda *parts: np.concatenate(parts), *tangents.values())
        self._flights.spend(len(tangents) * count)
        slopes = program.fly(drawn, tangent, problem.spec.horizon.steps)
        each = slopes.reshape(len(tangents), count)
        return np.array([float(np.mean(x[np.isfinite(x)])) if np.isfinite(x).any() else 0.0 for x in each])
