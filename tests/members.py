"""Disturbances and navigation errors for tests, with numbers drawn as for a flight."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from rvjax.components.registry import component
from rvjax.components.samplers.monte_carlo import MonteCarlo
from rvjax.physics.dynamics import Relative, relative, target_alpha
from rvjax.physics.state import Motion, Numbers, Plant, State, TargetMotion
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Part
from tests import flights
from tests.parameters import example

Array = NDArray[np.float64]

ROWS = [[0.5, 0.1, 0, 0, 0, 0, 0.01], [1.0, 0.3, -0.2, 0, 0.02, 0, 0], [1.3, 0, 0, 0.5, 0, 0, 0], [4.0, 1, 1, 1, 0, 0.1, 0]]

FAMILIES = ("disturbances", "navigation")
"""The families whose members act from step to step."""


def built(family: str, use: str, samples: int | Sequence[int] = 4, seed: int = 1, **said: Any) -> tuple[Any, Numbers]:
    """The functions of a member and its numbers, each of shape (samples,). said: what a campaign says
    of it; else an example from its model."""
    member = component(family, use)
    parameters = member.parameters.model_validate(said or example(family, use))
    chosen = np.arange(samples) if isinstance(samples, int) else np.asarray(samples)
    part = Part(f"{family}.{use}", parameters.quantities(), member.noisy)
    return member.build(parameters), Draws(MonteCarlo(seed).at(chosen), chosen, seed).numbers(part)


def scene() -> tuple[Motion, TargetMotion, Plant]:
    """`flights.LANES` samples of the scene that flights are tested in."""
    drawn = flights.draw({}, 300.0, 0.05)
    return drawn.motion, drawn.target, drawn.plant


def known(motion: Motion, target: TargetMotion, plant: Plant) -> tuple[State, Relative]:
    """The state of one sample, and its geometry."""
    alpha_t = target_alpha(target.w, plant.target_inertia, plant.target_inertia_inverse)
    return State(motion, target, ()), relative(motion, target, alpha_t, plant.port)


def array(tree: Any) -> Array:
    """The components of a vector or of channels, the last axis."""
    return np.stack([np.asarray(part) for part in jnp.broadcast_arrays(*tree.parts())], axis=-1)
