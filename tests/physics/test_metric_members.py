"""What holds for every metric: its columns, the state that a flight carries, lanes that know nothing of each other."""

from __future__ import annotations

from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rvjax.components.registry import choosable, component, members
from rvjax.physics.hulls import Hull
from rvjax.physics.state import Step, Tick
from rvjax.physics.vectors import Vector
from rvjax.simulation import closed_loop
from tests import flights

H = 0.05
STANDARD = [name for name in members("metrics") if name not in choosable("metrics")]
"""The metrics of every campaign."""


@cache
def scene() -> tuple[Step, Any]:
    """A step of `flights.LANES` samples, and the context that their metrics measure against."""
    loop = flights.loop("pd-plus")
    drawn = flights.draw(flights.gains("pd-plus"), 300.0, H)

    def begun(numbers: closed_loop.Drawn) -> Step:
        y, held = closed_loop.start(loop, numbers)
        return closed_loop.evaluate(loop, numbers, 1.0, y, held, Tick(20, 1.0, H))[1]

    step = jax.vmap(begun)(drawn)
    size = drawn.plant.mass * 0.0 + 1.0
    sizes = Vector(size, size * 0.5, size * 2.0)
    context = drawn.context._replace(hulls=(Hull(sizes * 0.1, size * 0.0, sizes), Hull(sizes * 0.2, size)), keep_out=sizes * 9.0)
    return step._replace(t=jnp.broadcast_to(jnp.asarray(step.t), drawn.plant.mass.shape)), context


def folded(name: str, step: Step, context: Any) -> dict[str, Any]:
    """The values of a metric after two equal steps of one sample."""
    metric = component("metrics", name)
    acc = metric.start(context)
    for _ in range(2):
        acc = metric.update(acc, step, context.step_s, context)
    return dict(metric.finish(acc, context))


@pytest.mark.parametrize("name", STANDARD)
def test_a_metric_gives_its_columns(name: str) -> None:
    """Kills: a column without a value, a value without a column, a unit or a meaning left out, NaN of a flight that is finite."""
    metric = component("metrics", name)
    values = jax.vmap(lambda *own: folded(name, *own))(*scene())
    assert values.keys() == metric.columns.keys()
    for key, column in metric.columns.items():
        assert (column.name, bool(column.unit), bool(column.description)) == (key, True, True)
        assert np.shape(values[key]) == (flights.LANES,)
        assert not np.isnan(values[key]).any()


@pytest.mark.parametrize("name", STANDARD)
@pytest.mark.parametrize("kind", [jnp.float32, jnp.float64])
def test_an_accumulator_keeps_its_form_and_nothing_is_promoted(name: str, kind: Any) -> None:
    """A flight is a loop: what `update` gives has the shapes and types of what `start` gave. Kills: a float64 constant,
    a history where an accumulator belongs."""
    metric = component("metrics", name)

    def one_step(step: Step, context: Any) -> Any:
        before = metric.start(context)
        after = metric.update(before, step, context.step_s, context)
        return before, after

    def typed(x: Any) -> Any:
        floats = jnp.issubdtype(jnp.asarray(x).dtype, jnp.floating)
        return jax.ShapeDtypeStruct((), kind if floats else jnp.asarray(x).dtype)

    before, after = jax.eval_shape(one_step, *jax.tree.map(typed, scene()))
    assert jax.tree.map(lambda x: (x.shape, x.dtype), before) == jax.tree.map(lambda x: (x.shape, x.dtype), after)
    floats = {x.dtype for x in jax.tree.leaves(after) if jnp.issubdtype(x.dtype, jnp.floating)}
    assert floats <= {jnp.dtype(kind)}


@pytest.mark.parametrize("name", STANDARD)
def test_lanes_know_nothing_of_each_other(name: str) -> None:
    """The same samples in another order have the same values, bit for bit. Kills: a mean or a maximum over the lanes."""
    order = np.array([3, 1, 2, 0])
    values = jax.vmap(lambda *own: folded(name, *own))(*scene())
    turned = jax.vmap(lambda *own: folded(name, *own))(*flights.lane(scene(), order))
    for key, x in values.items():
        np.testing.assert_array_equal(np.asarray(x)[order], turned[key], err_msg=key)


@pytest.mark.parametrize("kind", [jnp.float32, jnp.float64])
@pytest.mark.parametrize(("duration", "h"), [(300.0, 0.05), (300.0, 0.1), (20.0, 0.05), (7.7, 0.1)])
def test_no_time_is_longer_than_the_flight(kind: Any, duration: float, h: float) -> None:
    """A flight that is outside the cone and saturated all the time, and that settles with its last step.

    Kills: a sum of weights that exceeds the duration by its rounding error: 300.00000000003394 s of 300 s, a share above 1.
    """
    step, context = jax.tree.map(lambda x: jnp.asarray(x, kind)[0], scene())
    steps = round(duration / h)
    step = step._replace(
        commanded=step.plant.upper, motion=step.motion._replace(rho=step.motion.rho + step.plant.port * (1e3 + 0 * step.t))
    )
    numbers = {"duration_s": duration, "step_s": h, "cone": 2.0}
    context = context._replace(**{key: jnp.asarray(value, kind) for key, value in numbers.items()})

    def values(name: str) -> dict[str, float]:
        metric = component("metrics", name)

        def update(k: Any, acc: Any) -> Any:
            weight = context.step_s * jnp.where((k == 0) | (k == steps), 0.5, 1.0).astype(kind)
            settled = jnp.where(k == steps, 0.0, 1.0).astype(kind)
            motion = step.motion if name != "tubes" else step.motion._replace(rho=step.motion.rho * settled)
            motion = motion if name != "tubes" else motion._replace(sigma=step.motion.sigma * settled)
            return metric.update(acc, step._replace(t=k.astype(kind) * context.step_s, motion=motion), weight, context)

        acc = jax.lax.fori_loop(0, steps + 1, update, metric.start(context))
        return {key: float(value) for key, value in metric.finish(acc, context).items()}

    most = float(jnp.asarray(duration, kind))
    near = pytest.approx(most, rel=1e-4 if kind is jnp.float32 else 1e-12)
    times = {**values("approach"), **values("saturation"), **values("tubes")}
    for name in ("corridor_violation_s", "longest_saturated_s.any", "longest_saturated_s.tz", "settling_time_s"):
        assert times[name] == near
        assert times[name] <= most
    assert times["attitude_settling_time_s"] <= most
    for name in ("saturation_duty.any", "saturation_duty.fx"):
        assert times[name] == pytest.approx(1.0, rel=1e-4)
        assert times[name] <= 1.0
