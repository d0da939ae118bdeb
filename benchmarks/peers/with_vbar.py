"""The job in V-BAR: its approach to a hold point, all flights as copies of its vectorized environment.

The copies share one mass, so commands are accelerations: the law's force over the drawn mass. Its motion is that of Clohessy and
Wiltshire, exact for a held acceleration. The keep-out ball, which it always watches, ends no flight.
"""

from __future__ import annotations

import time
from importlib.metadata import version
from typing import Any

import numpy as np
from vbar.dynamics.bodies import EARTH
from vbar.metrics.summary import clopper_pearson
from vbar.scenarios.approach import ApproachConfig
from vbar.scenarios.vector import ApproachVectorEnv

from benchmarks.peers import job


def fly(draws: job.Array, cores: int) -> job.Result:
    """One process. No flight ends at the goal before its 300 s, and none loses mass."""
    mass, starts = draws[:, :1], draws[:, 1:] + np.concatenate([job.HOLD, np.zeros(3)])
    config = ApproachConfig(
        dt=job.STEP,
        max_steps=job.STEPS,
        altitude_m=job.AXIS - EARTH.radius,
        action_mode="accel",
        max_accel=job.LIMIT / mass.min(),
        isp=1e12,
        hold_point=tuple(job.HOLD),
        capture_radius=1e-12,
        violation_samples=2,
        training=True,  # it accepts given starts
    )
    flights = ApproachVectorEnv(config, num_envs=len(draws))
    began = time.perf_counter()
    seen, _ = flights.reset(seed=0)
    for k, start in enumerate(starts):  # `reset` of all takes one start for all
        seen[k], _ = flights.envs[k].reset(seed=0, options={"start_state": start})
        flights._load(k)
    info: dict[str, Any] = {}
    for _ in range(job.STEPS):
        seen, _, _, _, info = flights.step(job.law(seen[:, :3] - job.HOLD, seen[:, 3:6]) / mass)
    ends = np.asarray(info["final_info"]["dist_to_hold_m"])
    fly_s = time.perf_counter() - began
    interval = clopper_pearson(int(np.sum(ends < job.TUBE)), len(ends))
    return job.Result(ends.tolist(), version("vbar"), interval, fly_s)


if __name__ == "__main__":
    job.main(fly)
