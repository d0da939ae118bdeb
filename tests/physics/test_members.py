"""What holds for every member of the families that act from step to step: disturbances and navigation errors."""

from __future__ import annotations

from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from pydantic import ValidationError

from rvjax.components.navigation.interface import Known
from rvjax.components.registry import component, members
from rvjax.physics.dynamics import target_alpha
from rvjax.physics.state import Motion, Tick
from rvjax.physics.vectors import Channels
from tests import flights
from tests.members import FAMILIES, built, known, scene
from tests.parameters import example

EVERY = [(family, use) for family in FAMILIES for use in members(family)]
H, STEPS = 0.05, 2


def told(family: str, functions: Any, numbers: Any, target: Any, plant: Any) -> Any:
    """The numbers that the functions of a member get."""
    if family == "disturbances":
        return numbers
    alpha_t = target_alpha(target.w, plant.target_inertia, plant.target_inertia_inverse)
    return functions.given(numbers, Known(target, alpha_t, plant.port))


def keep(family: str, functions: Any, k: Any, h: Any, memory: Any, numbers: Any, motion: Any, target: Any, plant: Any) -> Any:
    """The memory of step k."""
    state, _ = known(motion, target, plant)
    tick = Tick(k, k * h, h)
    numbers = told(family, functions, numbers, target, plant)
    return functions.keep(tick, state if family == "disturbances" else motion, memory, numbers)


def act(family: str, functions: Any, t: Any, memory: Any, numbers: Any, motion: Any, target: Any, plant: Any) -> Any:
    """What the member gives at a time."""
    state, geometry = known(motion, target, plant)
    if family == "disturbances":
        return functions.push(t, state, geometry, plant, memory, numbers)
    return functions.see(t, motion, memory, told(family, functions, numbers, target, plant))


def start(family: str, functions: Any, numbers: Any, motion: Any, target: Any, plant: Any) -> Any:
    """The memory before the first step, in the type of the flight, as `flight.begin` has it."""
    numbers = told(family, functions, numbers, target, plant)
    memory = functions.start(numbers) if family == "disturbances" else functions.start(motion, numbers)
    return jax.tree.map(lambda x: jnp.asarray(x, motion.rho.x.dtype), memory)


def whole(family: str, functions: Any, numbers: Any, motion: Any, target: Any, plant: Any) -> Any:
    """What one sample gets at the beginning and at two thirds of each of two steps, and the last memory."""

    def step(memory: Any, k: Any) -> Any:
        memory = keep(family, functions, k, H, memory, numbers, motion, target, plant)
        return memory, [act(family, functions, (k + part) * H, memory, numbers, motion, target, plant) for part in (0.0, 0.65)]

    memory, given = jax.lax.scan(
        step, start(family, functions, numbers, motion, target, plant), jnp.arange(STEPS, dtype=jnp.int32)
    )
    return given, memory


def program(family: str, use: str) -> Any:
    """`whole` of every lane, as a function of the numbers, traced anew."""
    functions, _ = built(family, use, flights.LANES)
    return jax.jit(jax.vmap(lambda *own: whole(family, functions, *own)))


@cache
def flown(family: str, use: str) -> tuple[Any, Any]:
    """(program, what it gives for every lane), once for all tests."""
    made = program(family, use)
    return made, made(built(family, use, flights.LANES)[1], *scene())


@pytest.mark.parametrize(("family", "use"), EVERY)
def test_what_a_member_gives(family: str, use: str) -> None:
    """Finite, of the right kind, the same again. Kills: a global state, a NaN at t = 0, a scalar in the place of a vector."""
    made, (given, memory) = flown(family, use)
    for one in given:
        assert isinstance(one, Channels if family == "disturbances" else Motion)
    for x in jax.tree.leaves(given):
        assert x.shape == (flights.LANES, STEPS)
    for x in jax.tree.leaves(memory):
        assert x.shape == (flights.LANES,)
    for x in jax.tree.leaves((given, memory)):
        assert np.isfinite(x).all()
    own = (built(family, use, flights.LANES)[1], *scene())
    jax.tree.map(np.testing.assert_array_equal, (given, memory), made(*own))
    assert made.lower(*own).as_text() == program(family, use).lower(*own).as_text(), "traced anew it is the same program"


@pytest.mark.parametrize(("family", "use"), EVERY)
@pytest.mark.parametrize("kind", [jnp.float32, jnp.float64])
def test_a_memory_is_carried_as_it_was_and_nothing_is_promoted(family: str, use: str, kind: Any) -> None:
    """A flight is a loop: what `keep` gives has the shape and type of what `start` gave. Kills: a float64 constant in float32, a
    whole number that is carried, a memory that grows."""
    functions, numbers = built(family, use, 1)
    rows = jax.tree.map(lambda x: jax.ShapeDtypeStruct((), kind), (numbers, *scene()))

    def carried(own: Any, motion: Any, target: Any, plant: Any) -> Any:
        h = motion.rho.x * 0.0 + jnp.asarray(H, kind)
        before = start(family, functions, own, motion, target, plant)
        after = keep(family, functions, jnp.int32(1), h, before, own, motion, target, plant)
        return before, after, act(family, functions, h, after, own, motion, target, plant)

    before, after, given = jax.eval_shape(carried, *rows)
    assert jax.tree.structure(before) == jax.tree.structure(after)
    assert {x.dtype for x in jax.tree.leaves((before, after, given))} == {jnp.dtype(kind)}


@pytest.mark.parametrize(("family", "use"), EVERY)
def test_lanes_know_nothing_of_each_other(family: str, use: str) -> None:
    """Sample 3 is the same beside whichever others, bit for bit. Kills: noise by place in the chunk for noise by sample."""
    _, numbers = built(family, use, flights.LANES)
    order = np.array([3, 1, 2, 0])
    _, turned = built(family, use, [int(sample) for sample in order])
    jax.tree.map(lambda x, y: np.testing.assert_array_equal(x[order], y), numbers, turned)
    made, all_of_them = flown(family, use)
    others = made(turned, *flights.lane(scene(), order))
    jax.tree.map(lambda x, y: np.testing.assert_array_equal(x[order], y), all_of_them, others)


@pytest.mark.parametrize(("family", "use"), EVERY)
def test_defaults(family: str, use: str) -> None:
    """A member without required keys is built from nothing at all; one with some says which. Kills: a default that is refused."""
    model = component(family, use).parameters
    said = example(family, use, drawn=False)
    needed = {key: said[key] for key, info in model.keys().items() if info.is_required()}
    try:
        parameters = model.model_validate(needed)
    except ValidationError:  # one of several keys is needed
        parameters = model.model_validate(said)
    assert component(family, use).build(parameters)
