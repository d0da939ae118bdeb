"""What holds for every metric: its columns, the state that a flight carries, lanes that know nothing of each other."""

from __future__ import annotations

from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rvjax.components.registry import component, members
from rvjax.physics.state import Step, Tick
from rvjax.simulation import closed_loop
from tests import flights

H = 0.05


@cache
def scene() -> tuple[Step, Any]:
    """A step of `flights.LANES` samples, and the context that their metrics measure against."""
    loop = flights.loop("pd-plus")
    drawn = flights.draw(flights.gains("pd-plus"), 300.0, H)

    def begun(numbers: closed_loop.Drawn) -> Step:
        y, held = closed_loop.start(loop, numbers)
        return closed_loop.evaluate(loop, numbers, 1.0, y, held, Tick(20, 1.0, H))[1]

    step = jax.vmap(begun)(drawn)
    return step._replace(t=jnp.broadcast_to(jnp.asarray(step.t), drawn.plant.mass.shape)), drawn.context


def folded(name: str, step: Step, context: Any) -> dict[str, Any]:
    """The values of a metric after two equal steps of one sample."""
    metric = component("metrics", name)
    acc = metric.start(context)
    for _ in range(2):
        acc = metric.update(acc, step, context.step_s, context)
    return dict(metric.finish(acc, context))


@pytest.mark.parametrize("name", members("metrics"))
def test_a_metric_gives_its_columns(name: str) -> None:
    """Kills: a column without a value, a value without a column, a unit or a meaning left out, NaN of a flight that is finite."""
    metric = component("metrics", name)
    values = jax.vmap(lambda *own: folded(name, *own))(*scene())
    assert values.keys() == metric.columns.keys()
    for key, column in metric.columns.items():
        assert (column.name, bool(column.unit), bool(column.description)) == (key, True, True)
        assert np.shape(values[key]) == (flights.LANES,)
        assert not np.isnan(values[key]).any()


@pytest.mark.parametrize("name", members("metrics"))
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


@pytest.mark.parametrize("name", members("metrics"))
def test_lanes_know_nothing_of_each_other(name: str) -> None:
    """The same samples in another order have the same values, bit for bit. Kills: a mean or a maximum over the lanes."""
    order = np.array([3, 1, 2, 0])
    values = jax.vmap(lambda *own: folded(name, *own))(*scene())
    turned = jax.vmap(lambda *own: folded(name, *own))(*flights.lane(scene(), order))
    for key, x in values.items():
        np.testing.assert_array_equal(np.asarray(x)[order], turned[key], err_msg=key)
