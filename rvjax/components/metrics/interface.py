"""What a metric is: a fold over the steps of a flight, so that memory does not grow with the duration."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rvjax.columns import Column
from rvjax.physics.hulls import Hull
from rvjax.physics.state import Numbers, Step
from rvjax.physics.vectors import Scalar, Vector


class Funnel(NamedTuple):
    """apex_m: how far the cone's apex lies behind the docking point; length_m: distance from the docking point up to which the
    cone counts."""

    apex_m: Scalar
    length_m: Scalar


class MetricContext(NamedTuple):
    """What the metrics measure against. Times in s, lengths in m.

    tube_m, tube_mrp: radius of the position and attitude tubes; window_start_s: start of the closing window; duration_s: horizon;
    last_onset_s: onset of the last fault inside the horizon (−∞ without); cone: cosine of the approach cone's half-angle;
    axis: unit vector of the docking axis, in T; step_s: integration step; margins: thresholds, scales and windows of the temporal
    margins, in the order of `rvjax.simulation.temporal_margins`. chosen: the numbers of each metric that the campaign chooses, in
    its order; numbers: of the metric that is called, where it has parameters. funnel: form of the approach cone, empty
    where its apex is the docking point and it never ends. hulls: of the target and the pursuer, the latter from its reference
    point; empty without. keep_out: semi-axes of the keep-out zone, in T; empty without.
    """

    tube_m: Scalar
    tube_mrp: Scalar
    window_start_s: Scalar
    duration_s: Scalar
    last_onset_s: Scalar
    cone: Scalar
    axis: Vector
    step_s: Scalar
    margins: tuple[Scalar, ...] = ()
    chosen: tuple[Numbers, ...] = ()
    numbers: Numbers = Numbers({})
    funnel: Funnel | tuple[()] = ()
    hulls: tuple[Hull, Hull] | tuple[()] = ()
    keep_out: Vector | tuple[()] = ()


class Metric(NamedTuple):
    """columns: of the samples table.

    start(context) → acc; update(acc, step, weight, context) → acc; finish(acc, context) → values.

    weight [s]: quadrature weight of the step (trapezoidal rule), so that Σ weight f(t) ≈ ∫ f dt.
    needs: places of a campaign, such as `target.hull`, without which the metric is off.

    safety: its values stay in the table where a flight collided. Those of all other metrics are then NaN, since what follows a
    collision is no flight. A metric of safety says how bad a flight was, and what follows a collision can only make its values
    worse: a smallest distance, a time inside a zone, the free drift from any instant. What looks at the end of a flight, at a
    single event (`contact`: it may come after the collision, through the target) or at what was spent is none.

    every_s: a metric that is updated only at the instants 0, every_s, 2 every_s, …, a whole number of steps apart; None: at every
    step. The weights are of the steps all the same. every: the same in steps, which the campaign's step gives.
    """

    family = "metrics"

    columns: Mapping[str, Column]
    start: Callable[[MetricContext], Any]
    update: Callable[[Any, Step, Scalar, MetricContext], Any]
    finish: Callable[[Any, MetricContext], Mapping[str, Any]]
    needs: tuple[str, ...] = ()
    safety: bool = False
    every_s: float | None = None
    every: int = 1
