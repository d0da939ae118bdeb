"""The mean wrench of traces with the engines: `llvm` has the bits of an interpreter in NumPy, `xla` agrees."""

from __future__ import annotations

from functools import partial

import jax
import numpy as np
import pytest

from rvjax.simulation import closed_loop, mean_wrench
from rvjax.simulation.batch import Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.engines.llvm.engine import LlvmEngine
from rvjax.simulation.problem import load
from tests.engines.test_flights import FOLDER, FUNCTIONS, SAMPLES, problem, same_all
from tests.oracles.interpreter import Interpreted

FIRST, LAST = 2, 7


@pytest.mark.parametrize("name", ["quickstart.yaml", "navigation.yaml"])
def test_it_is_that_of_the_interpreter(name: str) -> None:
    """Over some steps, of more samples than a group has lanes. The chunk stays where it is. Kills: a carry that moves, a sum that
    does not begin at 0, numbers of another lane."""
    found = problem(name)
    _, drawn = Draws.of(found, np.arange(SAMPLES))
    chunk = LlvmEngine(found.loop, found.metrics).begin(drawn)
    chunk.advance(0, FIRST)
    carry = chunk.numbers_and_carry()[1]
    ours = chunk.mean_wrench(FIRST, LAST)
    assert same_all(*(jax.tree.leaves(x) for x in (carry, chunk.numbers_and_carry()[1])))

    summed = mean_wrench.Summed(carry, jax.tree.map(np.zeros_like, drawn.upper))
    step = Interpreted(partial(mean_wrench.step, partial(closed_loop.evaluate, found.loop)), FUNCTIONS, drawn, summed, 0)
    for k in range(FIRST, LAST):
        summed = step(drawn, summed, k)
    theirs = jax.tree.map(lambda x: x / (LAST - FIRST), summed.means)
    assert same_all(jax.tree.leaves(ours), jax.tree.leaves(theirs))


def test_xla_agrees() -> None:
    """Of every traced sample and row. Kills: means of other samples, a mean that begins at another step."""
    records = []
    for engine, traced in (("llvm", range(5)), ("llvm", (0, 3, 4)), ("xla", (0, 3, 4))):
        found = load(FOLDER / "quickstart.yaml", [f"engine={engine}", "controller={use: pd-plus}"])
        flyer = Flyer.of(found)
        _, drawn = Draws.of(found, np.resize(np.arange(5), flyer.lanes(5)))
        records.append(flyer.fly(drawn, 50, 12, trace=traced))
    whole, ours, theirs = (np.array([mean.parts() for mean in record.means]) for record in records)
    assert ours.shape == theirs.shape == (5, 6, 3)
    np.testing.assert_array_equal(ours, whole[..., [0, 3, 4]])
    np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-12)
    assert np.ptp(ours, axis=2).min() > 0.0
