"""The job by hand: all flights as arrays of NumPy, two-body motion in the Hill frame, RK4."""

from __future__ import annotations

import time

import numpy as np

from benchmarks.peers import job


def motion(state: job.Array, acceleration: job.Array) -> job.Array:
    """d/dt of the state (…, 6) relative to the target."""
    x, y, z, vx, vy, _ = np.moveaxis(state, -1, 0)
    out = job.AXIS + x
    pull = job.MU / (out**2 + y**2 + z**2) ** 1.5
    turning = job.RATE**2 - pull
    gravity = np.stack([turning * out + 2 * job.RATE * vy, turning * y - 2 * job.RATE * vx, -pull * z])
    return np.concatenate([state[..., 3:], np.moveaxis(gravity, 0, -1) + acceleration], axis=-1)


def distances(draws: job.Array) -> job.Array:
    """From the hold point after 300 s [m]."""
    mass, state = draws[:, :1], draws[:, 1:] + np.concatenate([job.HOLD, np.zeros(3)])
    h = job.STEP
    for _ in range(job.STEPS):
        held = job.law(state[:, :3] - job.HOLD, state[:, 3:]) / mass
        k1 = motion(state, held)
        k2 = motion(state + h / 2 * k1, held)
        k3 = motion(state + h / 2 * k2, held)
        k4 = motion(state + h * k3, held)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return np.linalg.norm(state[:, :3] - job.HOLD, axis=1)


def fly(draws: job.Array, cores: int) -> job.Result:
    """One process; NumPy uses one core for arrays of this size."""
    began = time.perf_counter()
    ends = distances(draws)
    return job.Result(ends.tolist(), np.__version__, fly_s=time.perf_counter() - began)


if __name__ == "__main__":
    job.main(fly)
