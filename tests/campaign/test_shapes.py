"""Shapes and types where numbers change hands: streams → draws → flight; said in jaxtyping, checked by beartype."""

from __future__ import annotations

import jax
import numpy as np
import pytest
from beartype import beartype
from jaxtyping import Float64, Int64, TypeCheckError, jaxtyped

from rvjax.simulation.batch import LANES, Flown, Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load
from rvjax.stats.random_streams import uniforms
from tests.short import CAMPAIGN, SHORT


@jaxtyped(typechecker=beartype)
def a_stream(samples: Int64[np.ndarray, " n"], words: Float64[np.ndarray, "n 4"]) -> None:
    """Four words for every sample."""


@jaxtyped(typechecker=beartype)
def a_batch(
    samples: Int64[np.ndarray, " n"], columns: list[Float64[np.ndarray, " n"]], flying: list[Float64[np.ndarray, " n"]]
) -> None:
    """One number for every sample, in the table and in what flies; fixed numbers too."""


@jaxtyped(typechecker=beartype)
def a_flight(
    values: list[Float64[np.ndarray, " n"]], lost: Float64[np.ndarray, " n"], glances: list[Float64[np.ndarray, " n"]]
) -> None:
    """One number for every lane."""


def flown(draws: Draws, drawn: object) -> Flown:
    problem = load(CAMPAIGN, SHORT)
    return Flyer.of(problem).fly(drawn, problem.spec.horizon.steps, 100, with_envelope=True)


def test_shapes() -> None:
    """Kills: a fixed number that is not spread over the samples, float32 or integers that slip in, a transposed block."""
    samples = np.arange(LANES, dtype=np.int64)
    a_stream(samples, uniforms(1, "name", samples))
    draws, drawn = Draws.of(load(CAMPAIGN, SHORT), samples)
    a_batch(samples, list(draws.values.values()), jax.tree.leaves(drawn))
    done = flown(draws, drawn)
    a_flight(list(done.values.values()), done.lost_s, jax.tree.leaves(done.envelope))


def test_the_check_can_fail() -> None:
    samples = np.arange(3, dtype=np.int64)
    with pytest.raises(TypeCheckError):
        a_stream(samples, uniforms(1, "name", samples).T)
    with pytest.raises(TypeCheckError):
        a_batch(samples, [np.zeros(3, dtype=np.float32)], [])
