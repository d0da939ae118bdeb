"""The job in cbfkit: its `jit(vmap(scan))` over all flights, RK4, two-body motion in the Hill frame; the mass is a state.

Its sampler gets a key of JAX and not the number of a flight, so given draws are looked up by the key.
"""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from cbfkit.integration import runge_kutta_4
from cbfkit.simulation import monte_carlo_gpu, status
from cbfkit.utils.user_types import ControllerData

from benchmarks.peers import job

SEED = 0
jax.config.update("jax_enable_x64", True)


def dynamics(state: Any) -> Any:
    """f and g of d/dt state = f + g u; state: position, velocity, mass."""
    x, y, z, vx, vy, vz, mass = state
    out = job.AXIS + x
    pull = job.MU / (out**2 + y**2 + z**2) ** 1.5
    turning = job.RATE**2 - pull
    gravity = [turning * out + 2 * job.RATE * vy, turning * y - 2 * job.RATE * vx, -pull * z]
    return jnp.stack([vx, vy, vz, *gravity, jnp.zeros(())]), jnp.zeros((7, 3)).at[3:6].set(jnp.eye(3) / mass)


def law(t: Any, state: Any, key: Any, reference: Any) -> Any:
    """PD, as its nominal controller."""
    force = -job.GUESS * (job.KP * (state[:3] - jnp.asarray(job.HOLD)) + job.KD * state[3:6])
    return jnp.clip(force, -job.LIMIT, job.LIMIT), None


def fly(draws: job.Array, cores: int) -> job.Result:
    """It flies everything twice, first to compile; its clock is that of the second time."""
    keys = jax.random.split(jax.random.fold_in(jax.random.PRNGKey(SEED), 1), len(draws))
    starts = jnp.asarray(np.concatenate([draws[:, 1:4] + job.HOLD, draws[:, 4:], draws[:, :1]], axis=1))
    setup = monte_carlo_gpu.MonteCarloSetup(
        dt=job.STEP,
        num_steps=job.STEPS + 1,  # the last state that it keeps is that before the last step
        dynamics=dynamics,
        integrator=runge_kutta_4,
        initial_state_sampler=lambda key: starts[jnp.argmax(jnp.all(keys == key, axis=1))],
        nominal_controller=law,
        controller=None,
        sensor=status._default_sensor,
        estimator=status._default_estimator,
        perturbation=status._default_perturbation,
        sigma=jnp.zeros(()),
        controller_data=ControllerData(error=jnp.asarray(False), complete=jnp.asarray(False)),
    )
    flown = monte_carlo_gpu.conduct_monte_carlo_gpu(setup, len(draws), SEED)
    ends = np.linalg.norm(np.asarray(flown.states)[:, -1, :3] - job.HOLD, axis=1)
    return job.Result(ends.tolist(), version("cbfkit"), fly_s=flown.wall_time_s)


if __name__ == "__main__":
    job.main(fly)
