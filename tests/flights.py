"""Flights for tests, built from the flying half alone: a loop, its drawn numbers, the trace of a flight.

The scene is hard on purpose: an eccentric orbit, a tumbling target with three different moments of inertia, a port off every
axis, a pursuer with products of inertia, disturbances with a phase on every channel, faults on every channel.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.columns import AXES, CHANNELS
from rvjax.components.disturbances import constant, sinusoid
from rvjax.components.disturbances.interface import Disturbance
from rvjax.components.faults import bias, effectiveness
from rvjax.components.faults.interface import fault
from rvjax.components.metrics.interface import MetricContext
from rvjax.components.registry import choosable, component, standard_metrics
from rvjax.physics.dynamics import MU_EARTH
from rvjax.physics.state import Motion, Numbers, Plant, Step, TargetMotion
from rvjax.physics.vectors import Channels, Symmetric, Vector
from rvjax.simulation import closed_loop, flight
from rvjax.simulation.closed_loop import Drawn, Loop

Array = NDArray[np.float64]

METRICS = standard_metrics()
SATURATIONS = {name: member.build(member.parameters()) for name, member in choosable("saturations").items()}
FAULTS = tuple(fault(member.failed) for member in (effectiveness, bias))
DISTURBANCES = tuple(Disturbance(member.push) for member in (constant, sinusoid))

UPPER = (4.0, 4.0, 4.0, 0.8, 0.8, 0.8)
LOWER = (3.0, 3.0, 3.0, 0.6, 0.6, 0.6)
PERIGEE_M, ECCENTRICITY = 6.8e6, 0.1


def loop(controller: str, saturation: str = "smooth-tanh", **options: Any) -> Loop:
    """A closed loop with every fault and every disturbance. options: of the controller, as in a campaign."""
    member = component("controllers", controller)
    return Loop(member.build(member.parameters(**options)), SATURATIONS[saturation], FAULTS, DISTURBANCES)


def gains(controller: str) -> dict[str, float]:
    """The default gains of a controller."""
    defaults = component("controllers", controller).parameters().gains
    return {name: getattr(defaults, name).parts[0].value for name in type(defaults).model_fields}


LANES = 4
"""Samples of a flight: one number for all tests, because another one compiles again."""


def draw(
    numbers: Mapping[str, float],
    duration_s: float,
    step_s: float,
    onset_s: float = np.inf,
    window_s: float = 60.0,
    lanes: int = LANES,
) -> Drawn:
    """Numbers of samples, each of shape (lanes,). numbers: gains; onset_s: of every fault."""
    generator = np.random.default_rng(20181)

    def same(x: float) -> Array:
        return np.full(lanes, float(x))

    def near(*centres: float, by: float) -> tuple[Array, ...]:
        return tuple(generator.uniform(c - by, c + by, lanes) for c in centres)

    def vector(*centres: float, by: float = 0.0) -> Vector:
        return Vector(*near(*centres, by=by))

    def channels(values: tuple[float, ...]) -> Channels:
        return Channels.of(tuple(map(same, values)))

    inertia = Symmetric(*near(22.0, 20.0, 23.0, by=3.0), *near(0.6, -0.4, 0.5, by=0.2))
    target_inertia = Symmetric(*near(400.0, 550.0, 650.0, by=40.0), *near(20.0, -30.0, 25.0, by=5.0))
    upper, lower = channels(UPPER), channels(LOWER)
    spread = Channels.of(near(*(1.0,) * 6, by=0.1))
    speed = float(np.sqrt(MU_EARTH * (1.0 + ECCENTRICITY) / PERIGEE_M))
    onset = channels((onset_s,) * 6)
    return Drawn(
        plant=Plant(
            mass=near(100.0, by=15.0)[0],
            inertia=inertia,
            inertia_inverse=inverse(inertia),
            upper=upper * spread,
            lower=lower * spread,
            target_inertia=target_inertia,
            target_inertia_inverse=inverse(target_inertia),
            port=vector(4.0, -2.0, 1.5, by=0.5),
            centre=Vector(same(0.0), same(0.0), same(0.0)),
        ),
        motion=Motion(
            rho=vector(12.0, -9.0, 7.0, by=4.0),
            nu=vector(0.05, -0.08, 0.06, by=0.03),
            sigma=vector(0.2, -0.15, 0.25, by=0.05),
            omega=vector(0.01, -0.008, 0.006, by=0.004),
        ),
        target=TargetMotion(r=vector(PERIGEE_M, 0.0, 0.0), v=vector(0.0, speed, 0.0), w=vector(0.004, -0.006, 0.003, by=0.002)),
        upper=upper,
        lower=lower,
        faults=(
            Numbers({"onset_s": onset, "remaining": Channels.of(near(*(0.75,) * 6, by=0.2))}),
            Numbers({"onset_s": onset, "share": Channels.of(near(*(0.03, -0.04, 0.05) * 2, by=0.01))}),
        ),
        disturbances=(
            Numbers({"force_N": vector(0.004, -0.006, 0.005), "torque_Nm": vector(-4e-4, 6e-4, 5e-4)}),
            Numbers(
                {
                    "force_N": vector(0.015, 0.01, -0.012),
                    "torque_Nm": vector(0.002, -0.003, 0.0025),
                    "rate_rad_s": Channels.of(near(*(0.06,) * 6, by=0.04)),
                    "phase_rad": Channels.of(near(*(3.0,) * 6, by=3.0)),
                }
            ),
        ),
        gains=Numbers({name: same(x) for name, x in numbers.items()}),
        context=MetricContext(
            tube_m=same(0.01),
            tube_mrp=same(2e-3),
            window_start_s=same(duration_s - window_s),
            duration_s=same(duration_s),
            last_onset_s=same(onset_s if onset_s <= duration_s else -np.inf),
            cone=same(np.cos(np.radians(10.0))),
            axis=vector(*np.array([4.0, -2.0, 1.5]) / np.linalg.norm([4.0, -2.0, 1.5])),
            step_s=same(step_s),
        ),
    )


def silenced(drawn: Drawn) -> Drawn:
    """The same samples without any wrench from the onset of their faults on: every actuator lost, no bias, no disturbance."""
    loss, push = drawn.faults
    faults = (changed(loss, remaining=loss["remaining"] * 0.0), changed(push, share=push["share"] * 0.0))
    return drawn._replace(faults=faults, disturbances=jax.tree.map(np.zeros_like, drawn.disturbances))


def changed(numbers: Numbers, **changes: Any) -> Numbers:
    """The same numbers but for some."""
    return Numbers({**numbers, **changes})


def inverse(j: Symmetric) -> Symmetric:
    """J⁻¹ by LAPACK, entry by entry."""
    full = np.linalg.inv(np.moveaxis(np.array(matrix(j)), -1, 0))
    return Symmetric(*(full[:, i, k] for i, k in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))))


def matrix(j: Symmetric) -> list[list[Any]]:
    """The nine entries of a symmetric matrix."""
    return [[j.xx, j.xy, j.xz], [j.xy, j.yy, j.yz], [j.xz, j.yz, j.zz]]


def lane(tree: Any, index: int) -> Any:
    """The numbers of one sample out of numbers of shape (lanes,)."""
    return jax.tree.map(lambda x: x[index], tree)


VECTORS: Mapping[str, Callable[[Step], Vector]] = {
    "rho_*_m": lambda step: step.motion.rho,
    "nu_*_m_s": lambda step: step.motion.nu,
    "sigma_*": lambda step: step.motion.sigma,
    "omega_*_rad_s": lambda step: step.motion.omega,
    "target_r_*_m": lambda step: step.target.r,
    "target_v_*_m_s": lambda step: step.target.v,
    "target_w_*_rad_s": lambda step: step.target.w,
}
WRENCHES: Mapping[str, Callable[[Step], Channels]] = {
    "cmd_*": lambda step: step.commanded,
    "applied_*": lambda step: step.applied,
    "dist_*": lambda step: step.disturbance,
    "ctl.v_*": lambda step: step.command,
    "ctl.chi_*": lambda step: step.report.chi,
}
NAMES = (
    "t_s",
    "ctl.drift",
    *(pattern.replace("*", axis) for pattern in VECTORS for axis in AXES),
    *(pattern.replace("*", channel) for pattern in WRENCHES for channel in CHANNELS),
)
"""Columns of a trace table; signals of the controller by `ctl.<name>`."""


def row(step: Step) -> jax.Array:
    """One instant in the order of `NAMES`."""
    parts = [part for get in (*VECTORS.values(), *WRENCHES.values()) for part in get(step).parts()]
    return jnp.stack([step.t, step.report.drift, *parts])


class Record(NamedTuple):
    """values: metric → (lanes,); lost_s: (lanes,); traces: one table for each lane."""

    values: Mapping[str, Array]
    lost_s: Array
    traces: list[pd.DataFrame]


Recorder = Callable[[Drawn, int], Record]


def recorder(closed: Loop, rows: int) -> Recorder:
    """record(drawn, every) flies `rows` times `every` steps and keeps every `every`-th of them and the last.

    One compiled program for any numbers and any `every`. The stages of a flight (`simulation.flight`) are the product's own.
    """
    evaluate = jax.jit(partial(closed_loop.evaluate, closed))  # traced once for all stages

    def recorded(drawn: Drawn, every: Any) -> tuple[Mapping[str, Any], Any, Any]:
        def stretch(carry: flight.Carry, k: Any) -> tuple[flight.Carry, Any]:
            seen = row(flight.observe(evaluate, drawn, carry, k))
            return flight.advance(evaluate, METRICS, drawn, carry, k, k + every), seen

        carry, seen = jax.lax.scan(stretch, flight.begin(closed, METRICS, drawn), jnp.arange(rows) * every)
        last = row(flight.observe(evaluate, drawn, carry, rows * every))
        values, lost = flight.finish(evaluate, METRICS, drawn, carry, rows * every)
        return values, lost, jnp.concatenate([seen, last[None]])

    compiled = jax.jit(jax.vmap(recorded, in_axes=(0, None)))

    def record(drawn: Drawn, every: int) -> Record:
        values, lost, tables = compiled(drawn, every)
        traces = [pd.DataFrame(table, columns=list(NAMES)) for table in np.asarray(tables)]
        return Record({name: np.asarray(x) for name, x in values.items()}, np.asarray(lost), traces)

    return record


SLOW_PD = {"k_sigma": 0.04, "k_omega": 0.2}
"""Changes to the default gains of pd-plus for a slow attitude loop, which RK4 follows to 1e-10 rad."""

GENTLE = {
    "epsilon_force": 0.1,
    "epsilon_torque": 0.05,
    "k2_force": 3.0,
    "k2_torque": 3.0,
    "gamma_bound": 0.5,
    "v_max_m_s": 0.25,
    "k3": 0.8,
    "kappa": 0.25,
    "filter_rad_s": 1.5,
}
"""Changes to the default gains of saturated-adaptive with which nothing is clipped or projected in the scene."""
