"""The data types of a flight: state, plant, measurement, report. All of a single sample at a single instant.

Frames: I inertial, T fixed in the target, P fixed in the pursuer. Units: SI.

    symbol      name        meaning                                                          unit
    ρ           rho         pursuer minus docking point, in P                                m
    ν           nu          difference of the inertial velocities, in P                      m/s
    σ           sigma       modified Rodrigues parameters of P with respect to T             1
    ω           omega       angular velocity of P relative to T, in P                        rad/s
    r_t, v_t    r, v        target's inertial position and velocity, resolved in T           m, m/s
    ω_t         w           target's inertial angular velocity, in T                         rad/s
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import jax

from rvjax.physics.vectors import Channels, Scalar, Symmetric, Thrusts, Vector


class Motion(NamedTuple):
    """Relative motion of the pursuer (or, of the same shape, its rate)."""

    rho: Vector
    nu: Vector
    sigma: Vector
    omega: Vector


class TargetMotion(NamedTuple):
    """Motion of the target (or its rate), resolved in T."""

    r: Vector
    v: Vector
    w: Vector


class Plant(NamedTuple):
    """The true, drawn plant. A controller never gets it.

    inertia: about the centre of mass, in P. centre: of mass, from the reference point of the actuators' torques, in P [m].
    thrust: the largest of each thruster [N]; with thrusters, upper and lower are nominal.
    """

    mass: Scalar
    inertia: Symmetric
    inertia_inverse: Symmetric
    upper: Channels
    lower: Channels
    target_inertia: Symmetric
    target_inertia_inverse: Symmetric
    port: Vector
    centre: Vector
    thrust: Thrusts | tuple[()] = ()


class PointMotion(NamedTuple):
    """How a reference point moves in T: ṗ [m/s] and p̈ [m/s²], the derivatives of its components."""

    velocity: Vector
    accel: Vector


class Path(NamedTuple):
    """A reference point since t [s]: p(t) from the docking point [m], ṗ [m/s], p̈ [m/s²], in T."""

    t: Scalar
    point: Vector
    velocity: Vector
    accel: Vector

    def at(self, t: Scalar) -> Path:
        """p + ṗτ + ½p̈τ² and ṗ + p̈τ, τ: the time since."""
        since = t - self.t
        velocity = self.velocity + self.accel * since
        return Path(t, self.point + (self.velocity + velocity) * (0.5 * since), velocity, self.accel)


class Measurement(NamedTuple):
    """The input of a controller: the measured motion, the data that a cooperative target sends, and nominal limits.

    motion: ρ and ν are relative to the reference point of the guidance. alpha_t: angular acceleration of the target, in T
    [rad/s²]; port: the reference point, in T [m], with the guidance `direct` the docking point δ; upper, lower: nominal
    magnitudes of the limits [N, N·m]; moving: how the reference point moves in T, empty where it is fixed.
    """

    t: Scalar
    motion: Motion
    target: TargetMotion
    alpha_t: Vector
    port: Vector
    upper: Channels
    lower: Channels
    moving: PointMotion | tuple[()] = ()


class Tick(NamedTuple):
    """The start of a step: its number k, its time t = k h, its length h [s]."""

    k: Scalar
    t: Scalar
    h: Scalar


class Report(NamedTuple):
    """Signals of a controller for metrics and traces; they do not act on the flight.

    chi: Nussbaum arguments (0 without Nussbaum gains). drift: change of the parameter estimates from their start, relative
    to it (0 without estimates). signals: further signals for the trace, by name.
    """

    chi: Channels
    drift: Scalar
    signals: Mapping[str, Any]


class Tank(NamedTuple):
    """Propellant used since t = 0, and left [kg]."""

    used: Scalar
    left: Scalar


class Step(NamedTuple):
    """All values of a flight at an instant, for metrics and traces.

    measured: the motion with the navigation errors. command: v before the saturation; commanded: h(v); applied: after the faults;
    disturbance: added to it [N, N·m]. thrusts: after the faults [N], empty without thrusters. effects: of each effect its state
    and its signals. total: applied wrench, disturbances and effects, about the centre of mass, in P [N, N·m]. tank: empty in a
    campaign without propellant; with it, plant has the mass, inertia and centre of the instant. ages: time since the last
    measurement [s], of each navigation error that interrupts it. path: of the reference point of the guidance, empty without.
    """

    t: Scalar
    motion: Motion
    measured: Motion
    target: TargetMotion
    plant: Plant
    command: Channels
    commanded: Channels
    applied: Channels
    disturbance: Channels
    report: Report
    thrusts: Thrusts | tuple[()] = ()
    effects: tuple[tuple[Any, Mapping[str, Any]], ...] = ()
    total: Channels | tuple[()] = ()
    tank: Tank | tuple[()] = ()
    ages: tuple[Scalar, ...] = ()
    path: Path | tuple[()] = ()


class State(NamedTuple):
    """All integrated values: relative motion, target, state of the controller, states of the effects in the campaign's order,
    consumed propellant [kg] (empty in a campaign without propellant)."""

    motion: Motion
    target: TargetMotion
    control: Any
    effects: tuple[Any, ...] = ()
    consumed: Scalar | tuple[()] = ()


@jax.tree_util.register_pytree_node_class
class Numbers(Mapping[str, Any]):
    """Named numbers of a component (drawn or fixed); also readable as attributes: `gains.k1`."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        self._values = dict(sorted(values.items()))

    def __getitem__(self, name: str) -> Any:
        return self._values[name]

    def __iter__(self):
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self._values[name]
        except KeyError:
            raise AttributeError(name) from None

    def tree_flatten(self) -> tuple[tuple[Any, ...], tuple[str, ...]]:
        return tuple(self._values.values()), tuple(self._values)

    @classmethod
    def tree_unflatten(cls, names: tuple[str, ...], values: tuple[Any, ...]) -> Numbers:
        return cls(dict(zip(names, values, strict=True)))
