"""Disturbances and navigation errors for tests: each with what a campaign says of it, numbers drawn as for a flight."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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

Array = NDArray[np.float64]

ROWS = [[0.5, 0.1, 0, 0, 0, 0, 0.01], [1.0, 0.3, -0.2, 0, 0.02, 0, 0], [1.3, 0, 0, 0.5, 0, 0, 0], [4.0, 1, 1, 1, 0, 0.1, 0]]

OWN: Mapping[str, Mapping[str, Mapping[str, Any]]] = {
    "disturbances": {
        "constant": {"force_N": {"box": 0.02}, "torque_Nm": 0.001},
        "sinusoid": {"force_N": 0.02, "rate_rad_s": {"uniform": [0.01, 0.1]}},
        "gravity-gradient": {},
        "ornstein-uhlenbeck": {"force_N": 0.01, "torque_Nm": 0.002, "time_constant_s": {"uniform": [5, 50]}},
        "differential-drag": {"density_kg_m3": 1e-12, "pursuer_m2_kg": 0.02, "target_m2_kg": 0.01},
        "j2-difference": {"inclination_deg": 51.6},
        "plume-pulse": {"force_N": {"direction": 0.5}, "first_s": 0.2, "width_s": 0.5, "period_s": 2.0},
        "table": {"rows": ROWS, "scale": {"uniform": [0.8, 1.2]}, "shift_s": {"uniform": [-0.5, 0.5]}},
    },
    "navigation": {
        "noise": {"position_m": 0.01, "velocity_m_s": 0.002, "attitude_deg": 0.1, "rate_deg_s": 0.01},
        "bias": {"position_m": {"ball": 0.05}, "velocity_m_s": 0.01, "attitude_deg": {"ball": 2.0}, "rate_deg_s": 0.01},
        "gyro-drift": {"bias_deg_s": {"ball": 0.05}, "walk_deg_s": 0.01},
        "delay": {"steps": 3},
    },
}
"""What a campaign says of each member, by family."""


def built(family: str, use: str, samples: int | Sequence[int] = 4, seed: int = 1, **said: Any) -> tuple[Any, Numbers]:
    """The functions of a member and its numbers, each of shape (samples,). said: instead of `OWN`."""
    member = component(family, use)
    parameters = member.parameters.model_validate(said or dict(OWN[family][use]))
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
