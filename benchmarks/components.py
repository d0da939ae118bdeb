"""What a component costs: `python -m benchmarks.components [--rounds N]`.

The step of `benchmarks/docking.yaml` with one component more, and without it, on one core: chunks of 416 lanes fly 100
steps in turn in one process. A row's cost is the best time of all rounds over that of the campaign as it is; the quartiles of the
ratios within a round say how quiet the machine was. What came out: docs/performance.md.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

CAMPAIGN = Path(__file__).with_name("docking.yaml")
STEPS = 100
NAVIGATION = "position_m: 0.005, velocity_m_s: 0.002, attitude_deg: 0.05, rate_deg_s: 0.01"


def _pushed(said: str) -> Sequence[str]:
    sinusoid = (
        "{use: sinusoid, force_N: {uniform: [0, 0.02]}, torque_Nm: {uniform: [0, 0.005]}, rate_rad_s: {uniform: [0.01, 0.1]}}"
    )
    return (f"disturbances=[{sinusoid}, {said}]",)


def _of(family: str) -> Sequence[str]:
    """All of a family, as in the campaign that shows it."""
    from ruamel.yaml import YAML

    return (f"{family}={json.dumps(YAML(typ='safe').load(CAMPAIGN.parents[1] / 'campaigns' / f'{family}.yaml')[family])}",)


def _thrusters(allocation: str) -> Sequence[str]:
    return (f"actuators={{use: thrusters, layout: cube-24, size_m: 1, max_N: 1.2, allocation: {allocation}}}",)


OU = _pushed("{use: ornstein-uhlenbeck, force_N: 0.01, torque_Nm: 0.002, time_constant_s: 20}")
SEEN = (f"navigation=[{{use: noise, {NAVIGATION}}}]",)
WAVE = ", ".join(f"[{10 * row}, {np.sin(row):.3f}, 0, 0, 0, 0, 0]" for row in range(32))

ROWS: Mapping[str, tuple[Sequence[str], str]] = {
    "the campaign as it is": ((), ""),
    "disturbance ornstein-uhlenbeck": (OU, ""),
    "navigation bias": ((f"navigation=[{{use: bias, {NAVIGATION}}}]",), ""),
    "navigation noise": (SEEN, ""),
    "both": ((*OU, *SEEN), ""),
    "disturbance ornstein-uhlenbeck, jax.random.normal": (OU, "jax.random"),
    "navigation noise, jax.random.normal": (SEEN, "jax.random"),
    "disturbance j2-difference": (_pushed("{use: j2-difference, inclination_deg: 51.6}"), ""),
    "disturbance differential-drag": (
        _pushed("{use: differential-drag, density_kg_m3: 1.0e-12, pursuer_m2_kg: 0.02, target_m2_kg: 0.01}"),
        "",
    ),
    "disturbance plume-pulse": (_pushed("{use: plume-pulse, force_N: 0.1, first_s: 10, width_s: 1, period_s: 20}"), ""),
    "disturbance table of 32 rows": (_pushed(f"{{use: table, rows: [{WAVE}]}}"), ""),
    "navigation gyro-drift": (("navigation=[{use: gyro-drift, walk_deg_s: 0.001}]",), ""),
    "navigation delay of 8 steps": (("navigation=[{use: delay, steps: 8}]",), ""),
    "sampled controller": (("horizon.control_period_s=0.2",), ""),
    "all eight faults, scheduled": (_of("faults"), ""),
    "six disturbances": (_of("disturbances"), ""),
    "all four navigation errors": (_of("navigation"), ""),
    "one of each: fault with a schedule, ornstein-uhlenbeck, noise, sampled": (
        (
            "faults=[{use: effectiveness, onset_s: {uniform: [30, 150]}, remaining: 0.5, schedule: {count: 2}}]",
            *OU,
            *SEEN,
            "horizon.control_period_s=0.2",
        ),
        "",
    ),
    "24 thrusters, pseudo-inverse": (_thrusters("pseudo-inverse"), ""),
    "24 thrusters, bounded least squares": (_thrusters("bounded-least-squares"), ""),
    "everything but thrusters": ((*_of("faults"), *_of("disturbances"), *_of("navigation"), "horizon.control_period_s=0.2"), ""),
}
"""Overrides of the campaign, and which noise it flies with."""


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=60)
    rounds = parser.parse_args().rounds
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    from rvjax.simulation import jax_config

    jax_config.configure("float64", threads=1)
    from rvjax.simulation.batch import LANES, Flyer
    from rvjax.simulation.draws import Draws
    from rvjax.simulation.problem import load

    flights = []
    for overrides, noise in ROWS.values():
        _fly_with(noise)
        problem = load(CAMPAIGN, overrides)
        flyer = Flyer.of(problem)
        _, drawn = Draws.of(problem, np.arange(LANES, dtype=np.int64))
        flyer.fly(drawn, 1, 1)
        flights.append((flyer, drawn))
    seconds = np.zeros((rounds, len(flights)))
    for row in seconds:
        for place, (flyer, drawn) in enumerate(flights):
            started = time.perf_counter()
            flyer.fly(drawn, STEPS, STEPS)
            row[place] = time.perf_counter() - started
    best, ratios = seconds.min(axis=0), seconds / seconds[:, :1]
    low, high = np.quantile(ratios, [0.25, 0.75], axis=0)
    print("| step with | time | of the campaign's | quartiles within a round |\n|---|---|---|---|")
    for place, name in enumerate(ROWS):
        time_us = best[place] / STEPS * 1e6
        print(f"| {name} | {time_us:.0f} µs | {best[place] / best[0]:.2f} | {low[place]:.2f} … {high[place]:.2f} |")


def _fly_with(noise: str) -> None:
    """Which normal numbers the members are built with from here on."""
    import jax
    import jax.numpy as jnp

    from rvjax.components.disturbances import ornstein_uhlenbeck
    from rvjax.components.navigation import noise as measured
    from rvjax.physics import noise as own

    def normals(key, k, count):
        a, b, c, d = (part.astype(jnp.uint32) for part in key)
        stream = jax.random.wrap_key_data(jnp.stack([(a << 16) | b, (c << 16) | d]), impl="threefry2x32")
        drawn = jax.random.normal(jax.random.fold_in(stream, k), (count,), key[0].dtype)
        return tuple(drawn[index] for index in range(count))

    ornstein_uhlenbeck.normals = measured.normals = normals if noise else own.normals


if __name__ == "__main__":
    main()
