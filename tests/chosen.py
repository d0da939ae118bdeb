"""Metrics that a campaign chooses, folded over steps that a test writes, or flown with the trace of the same flights."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np
from numpy.typing import NDArray

from rvjax.components.registry import component
from rvjax.physics.state import Motion, Numbers, Plant, Report, Step, TargetMotion
from rvjax.physics.vectors import Channels, Symmetric, Vector
from rvjax.simulation import problem
from rvjax.simulation.batch import Flyer
from rvjax.simulation.draws import Draws
from tests import flights

Array = NDArray[np.float64]

PORT = (5.0, 0.0, 0.0)


def vector(values: Any) -> Vector:
    """Three numbers as a vector."""
    x, y, z = np.asarray(values, float)
    return Vector(x, y, z)


def step(
    t: float,
    rho: Any,
    nu: Any = (0, 0, 0),
    sigma: Any = (0, 0, 0),
    omega: Any = (0, 0, 0),
    r: Any = (7e6, 0, 0),
    v: Any = (0, 7.5e3, 0),
    w: Any = (0, 0, 0),
    port: Any = PORT,
    force: Any = (0, 0, 0),
) -> Step:
    """A step of a body of 100 kg."""
    no, one = Channels.of((0.0,) * 6), Symmetric.of(1.0, 0.0)
    motion = Motion(*map(vector, (rho, nu, sigma, omega)))
    plant = Plant(100.0, one, one, no, no, one, one, vector(port), vector((0, 0, 0)))
    applied = Channels(vector(force), vector((0, 0, 0)))
    return Step(t, motion, motion, TargetMotion(vector(r), vector(v), vector(w)), plant, no, no, applied, no, Report(no, 0.0, {}))


def folded(use: str, steps: Sequence[Step], onset_s: float = -np.inf, h: float = 1.0, **said: Any) -> dict[str, float]:
    """The values of a metric after these steps, h apart. said: what a campaign says of it."""
    member = component("metrics", use)
    parameters = member.parameters.model_validate(said)
    metric = member.build(parameters)
    numbers = {name: np.array(quantity.medians) for name, quantity in parameters.quantities().items()}
    plain = Numbers({name: vector(x) if x.size == 3 else x[0] for name, x in numbers.items()})
    scene = flights.lane(flights.draw({}, 300.0, 0.05).context, 0)
    port = np.array(steps[0].plant.port.parts())
    context = scene._replace(
        duration_s=np.float64(steps[-1].t),
        step_s=np.float64(h),
        last_onset_s=np.float64(onset_s),
        axis=vector(port / np.linalg.norm(port)),
        numbers=plain,
    )

    @jax.jit
    def after(acc: Any, now: Step, weight: float) -> Any:
        return metric.update(acc, now, weight, context)

    acc = metric.start(context)
    for now in steps:
        acc = after(acc, now, h * (0.5 if now.t in (0.0, steps[-1].t) else 1.0))
    return {name: float(x) for name, x in jax.jit(lambda acc: metric.finish(acc, context))(acc).items()}


class Flight(NamedTuple):
    """values: metric → (samples,). t: (rows,). Of every sample and row: (samples, rows, 3) motion, target and applied force.
    drawn: the numbers of the samples."""

    values: dict[str, Array]
    t: Array
    rho: Array
    nu: Array
    sigma: Array
    omega: Array
    r: Array
    v: Array
    w: Array
    force: Array
    drawn: Any


def flown(file: Path, text: str, samples: int) -> Flight:
    """The flights of a campaign, with every step."""
    file.write_text(text)
    campaign = problem.load(file)
    _, drawn = Draws.of(campaign, np.arange(samples))
    flyer = Flyer.of(campaign, threads=1)
    lanes = flyer.lanes(samples)
    padded = jax.tree.map(lambda x: np.resize(x, lanes), drawn)
    result = flyer.fly(padded, campaign.spec.horizon.steps, 1, trace=range(samples))

    def rows(part: Any) -> Array:
        return np.array([np.stack(part(now).parts(), axis=-1) for now in result.steps]).swapaxes(0, 1)

    return Flight(
        {name: np.asarray(x)[:samples] for name, x in result.values.items()},
        np.array([now.t[0] for now in result.steps]),
        *(rows(lambda now, i=i: now.motion[i]) for i in range(4)),
        *(rows(lambda now, i=i: now.target[i]) for i in range(3)),
        rows(lambda now: now.applied.force),
        drawn,
    )
