"""Draws: the numbers of some samples, from the quantities of a problem.

    Problem, samples ─draw→ columns `draw.<path>` (in the table) and `Drawn` (in the flight)

A component of a quantity is drawn from the stream of its name, a joint distribution from the stream of the quantity.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from rvjax import elementary
from rvjax.campaign import Quantity, Spec
from rvjax.campaign import hulls as campaign_hulls
from rvjax.campaign.actuators import Thrusters
from rvjax.campaign.model import Corridor
from rvjax.campaign.schedule import Schedule
from rvjax.campaign.start import FramedStart
from rvjax.columns import Column, draw_column
from rvjax.components.metrics.interface import Funnel, MetricContext
from rvjax.components.samplers.interface import Points
from rvjax.physics.dynamics import MU_EARTH
from rvjax.physics.hulls import Hull
from rvjax.physics.propellant import Propellant
from rvjax.physics.state import Motion, Numbers, Plant, TargetMotion
from rvjax.physics.vectors import Channels, Thrusts, Vector, inverse, rotate, rotation
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.inertia import bodies
from rvjax.simulation.problem import NEVER, Part, Problem
from rvjax.simulation.start_frames import Given, docking_axis, start_motion
from rvjax.stats.random_streams import uniforms

Values = NDArray[np.float64]

FAR = 2.0**-40
"""A moved uniform number is this far from the end that is farther from the original: another value of every distribution."""


@dataclass
class Draws:
    """Draws quantities for some samples and keeps the drawn values, by name. Fixed numbers are not kept.

    points: of the samples. seed: of the noise in flight. meanings: of every draw with a distribution, by name. moved: for some
    streams, by name, (samples,) whether a sample gets other numbers than usual from it. streams: the columns that each stream
    determines, in the order of the draws. noise: of a stream, (samples,) samples whose noise they have; None: the same samples.
    """

    points: Points
    samples: NDArray[np.int64]
    seed: int
    meanings: Mapping[str, Column] = field(default_factory=dict[str, Column])
    moved: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict[str, NDArray[np.bool_]])
    values: dict[str, NDArray[Any]] = field(default_factory=dict[str, NDArray[Any]])
    columns: dict[str, Column] = field(default_factory=dict[str, Column])
    streams: dict[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]])
    noise: Callable[[str], NDArray[np.int64]] | None = None

    def block(self, name: str, count: int, *columns: str) -> Values:
        """(samples, count) uniform numbers of the stream `name`, which determines these columns."""
        return self._moved(name, self.points.uniforms(name, count), columns)

    def _moved(self, name: str, numbers: Values, columns: tuple[str, ...]) -> Values:
        self.streams[name] = columns
        if name not in self.moved:
            return numbers
        return np.where(self.moved[name][:, None], np.where(numbers < 0.5, 1.0 - FAR, FAR), numbers)

    def parts(self, name: str, quantity: Quantity) -> tuple[Values, ...]:
        """The components of a quantity, each of shape (samples,), in SI."""
        names = quantity.names(name)

        def numbers(stream: str, count: int) -> Values:
            return self.block(stream, count, *(names if quantity.joint is not None else (stream,)))

        drawn = quantity.draw(name, numbers, len(self.samples))
        drawn = tuple(
            self.assigned(part, name if quantity.joint is not None else part, values)
            for part, values in zip(names, drawn, strict=True)
        )
        varies = [part.uniforms > 0 for part in quantity.parts] or [True] * len(drawn)
        for part, random, values in zip(names, varies, drawn, strict=True):
            if random:
                self.keep(part, values, quantity.unit, quantity.doc)
        return drawn

    def assigned(self, name: str, stream: str, values: Values) -> Values:
        """The values that the sampler sets for a draw, except of moved samples; without such values, the drawn ones."""
        fixed = self.points.prescribed(name)
        if fixed is None:
            return values
        return np.where(self.moved[stream], values, fixed) if stream in self.moved else fixed

    def take(self, name: str, quantity: Quantity) -> Any:
        """A quantity as a number, Vector, Channels or Thrusts."""
        drawn = self.parts(name, quantity)
        if quantity.shape == "scalar":
            return drawn[0]
        if quantity.shape == "thrusters":
            return Thrusts(drawn)
        return Vector(*drawn) if quantity.shape == "vector" else Channels.of(drawn)

    def same(self, value: float) -> Values:
        """The same number for every sample."""
        return np.full(len(self.samples), value, dtype=np.float64)

    def numbers(self, part: Part, below: str = "") -> Numbers:
        """The numbers of a component. below: only those under this name (`gains`), if it is not empty."""
        prefix = f"{below}." if below else ""
        quantities = part.quantities.items()
        values = {name.removeprefix(prefix): self.take(f"{part.prefix}.{name}", quantity) for name, quantity in quantities}
        if part.schedule is not None:
            values["onset_s"] = self.scheduled(part, part.schedule, values["onset_s"])
        return Numbers(values | ({"noise": self.key(f"{part.prefix}.noise")} if part.noisy else {}))

    def uniform(self, name: str) -> Values:
        """(samples,) uniform numbers of the stream `name`."""
        return self.block(name, 1)[:, 0]

    def key(self, name: str) -> tuple[Values, ...]:
        """A random key for every sample: four whole numbers of 16 bits, which are exact in float32 too."""
        numbers = uniforms(self.seed, name, self.samples if self.noise is None else self.noise(name))
        return tuple(np.floor(self._moved(name, numbers, ()) * 65536.0).T)

    def scheduled(self, part: Part, schedule: Schedule, onset: Channels | Thrusts) -> Channels | Thrusts:
        """The onsets of the failing channels or thrusters of each sample, +∞ for all others. They are kept as columns."""
        quantity, name = part.quantities["onset_s"], f"{part.prefix}.onset_s"
        rows = list(zip(quantity.components, onset.parts(), quantity.parts, strict=True))
        able = {channel: values for channel, values, law in rows if law != NEVER}
        prefix = f"{part.prefix}.schedule"
        starts = schedule.arrange(
            able, lambda what, count: self.take(f"{prefix}.{what}", count), lambda what: self.uniform(f"{prefix}.{what}")
        )
        for channel, values in starts.items():
            self.keep(f"{name}.{channel}", values, quantity.unit, f"{quantity.doc}; inf: never")
        self.keep(
            f"{prefix}.failing", np.sum([np.isfinite(x) for x in starts.values()], axis=0, dtype=float), "1", "channels that fail"
        )
        return onset.like(tuple(starts.get(channel, values) for channel, values, _ in rows))

    def keep(self, name: str, values: Values, unit: str, doc: str) -> None:
        """Keeps values as a column of the table."""
        self.values[name] = values
        known = self.meanings.get(name, Column(name, unit, doc))
        self.columns[name] = Column(draw_column(name), unit, doc, kind=known.kind, law=known.law)

    @classmethod
    def of(
        cls, problem: Problem, samples: NDArray[np.int64], moved: Mapping[str, NDArray[np.bool_]] | None = None
    ) -> tuple[Self, Drawn]:
        """The draws of these samples by name, and the numbers of their flights."""
        points, rejected = problem.dispersions.at(samples)
        noise = partial(problem.dispersions.noise, samples)
        draws = cls(points, samples, problem.spec.seed, problem.dispersions.columns, moved or {}, noise=noise)
        drawn = _drawn(problem, draws)
        for name, counts in rejected.items():
            draws.values[name] = counts
            draws.columns[name] = problem.dispersions.columns[name]
        return draws, drawn


def _drawn(problem: Problem, draws: Draws) -> Drawn:
    spec = problem.spec
    upper = draws.take("actuators.upper", spec.actuators.upper)
    lower = draws.take("actuators.lower", spec.actuators.lower)
    port = draws.take("target.port_m", spec.target.port_m)
    inertia, target_inertia = (body.drawn(draws.parts) for body in bodies(spec))
    faults = tuple(draws.numbers(part) for part in problem.faults)
    plant = Plant(
        mass=draws.take("pursuer.mass_kg", spec.pursuer.mass_kg),
        inertia=inertia,
        inertia_inverse=inverse(inertia),
        **_true_limits(problem, draws, upper, lower),
        target_inertia=target_inertia,
        target_inertia_inverse=inverse(target_inertia),
        port=port,
        centre=draws.take("pursuer.centre_of_mass_m", spec.pursuer.centre_of_mass_m),
    )
    motion, target = _motions(problem, draws, port)
    return Drawn(
        plant=plant,
        motion=motion,
        target=target,
        upper=upper,
        lower=lower,
        faults=faults,
        disturbances=tuple(draws.numbers(part) for part in problem.disturbances),
        navigation=tuple(draws.numbers(part) for part in problem.navigation),
        actuation=tuple(draws.numbers(part) for part in problem.actuation),
        effects=tuple(draws.numbers(part) for part in problem.effects),
        gains=draws.numbers(problem.controller, below="gains"),
        guidance=draws.numbers(problem.guidance),
        context=_context(problem, draws, port, faults),
        propellant=_propellant(spec, draws),
    )


def _propellant(spec: Spec, draws: Draws) -> Propellant | tuple[()]:
    """What the actuators burn; empty in a campaign without propellant."""
    if (given := spec.pursuer.propellant) is None:
        return ()
    values = {name: draws.take(f"pursuer.propellant.{name}", quantity) for name, quantity in given.quantities().items()}
    return Propellant(values["mass_kg"], values["specific_impulse_s"], values["tank_m"], values.get("torque_arm_m", ()))


def _motions(problem: Problem, draws: Draws, port: Vector) -> tuple[Motion, TargetMotion]:
    """The relative motion and the target at t = 0."""
    start = problem.spec.start
    if isinstance(start, FramedStart):
        given = Given(
            draws.take("start.position_m", start.position_m),
            draws.take("start.velocity_m_s", start.velocity_m_s),
            draws.take("start.attitude_mrp", start.attitude_mrp),
            draws.take("start.rate_rad_s", start.rate_rad_s),
        )
        target = _target(problem, draws)
        axis = docking_axis(problem.spec.target.port_axis, port)
        return start_motion(start.frame, start.rest, given, target, port, axis), target
    motion = Motion(
        draws.take("start.rho_m", start.rho_m),
        draws.take("start.nu_m_s", start.nu_m_s),
        draws.take("start.sigma", start.sigma),
        draws.take("start.omega_rad_s", start.omega_rad_s),
    )
    return motion, _target(problem, draws)


def _true_limits(problem: Problem, draws: Draws, upper: Channels, lower: Channels) -> dict[str, Any]:
    """The limits with their spread. With thrusters their largest thrusts are spread, not the limits."""
    actuators = problem.spec.actuators
    spread = {
        name: draws.take(name, quantity) for name, quantity in actuators.quantities("actuators").items() if "spread" in name
    }
    if isinstance(actuators, Thrusters):
        nominal = Thrusts(tuple(map(draws.same, actuators.geometry.most)))
        return {"upper": upper, "lower": lower, "thrust": nominal * spread["actuators.spread"]}
    return {"upper": upper * spread["actuators.spread.upper"], "lower": lower * spread["actuators.spread.lower"]}


def _target(problem: Problem, draws: Draws) -> TargetMotion:
    """The target at t = 0, resolved in T, from Kepler elements in the perifocal frame.

    r = p/(1 + e cos θ) (cos θ, sin θ, 0),   v = √(μ/p) (−sin θ, e + cos θ, 0),   p = a(1 − e²)
    """
    target = problem.spec.target
    eccentricity = draws.take("target.orbit.eccentricity", target.orbit.eccentricity)
    axis = draws.take("target.orbit.semi_major_axis_m", target.orbit.semi_major_axis_m)
    anomaly = draws.take("target.orbit.true_anomaly_rad", target.orbit.true_anomaly_rad)
    turn = rotation(draws.take("target.attitude_mrp", target.attitude_mrp))
    parameter = axis * (1.0 - eccentricity * eccentricity)
    cos, sin, zero = elementary.cos(anomaly), elementary.sin(anomaly), draws.same(0.0)
    distance, speed = parameter / (1.0 + eccentricity * cos), np.sqrt(MU_EARTH / parameter)
    return TargetMotion(
        r=rotate(turn, Vector(distance * cos, distance * sin, zero)),
        v=rotate(turn, Vector(-speed * sin, speed * (eccentricity + cos), zero)),
        w=draws.take("target.rate_rad_s", target.rate_rad_s),
    )


def _hulls(problem: Problem, draws: Draws) -> tuple[Hull, Hull] | tuple[()]:
    """The hulls of the target and the pursuer; empty where either is missing."""
    target, pursuer = problem.spec.target.hull, problem.spec.pursuer.hull
    if target is None or pursuer is None:
        return ()
    return _hull("target.hull", target, draws), _hull("pursuer.hull", pursuer, draws)


def _hull(name: str, hull: campaign_hulls.Hull, draws: Draws) -> Hull:
    centre = draws.take(f"{name}.centre_m", hull.centre_m)
    if hull.radius_m is not None:
        return Hull(centre, draws.take(f"{name}.radius_m", hull.radius_m))
    assert hull.box_m is not None
    return Hull(centre, draws.same(0.0), draws.take(f"{name}.box_m", hull.box_m) * 0.5)


def _funnel(corridor: Corridor, draws: Draws) -> Funnel | tuple[()]:
    """The form of the approach cone; empty where its apex is the docking point and it never ends."""
    if not corridor.is_funnel:
        return ()
    apex = corridor.radius_m / float(elementary.tan(corridor.half_angle_rad))
    return Funnel(draws.same(apex), draws.same(math.inf if corridor.length_m is None else corridor.length_m))


def _context(problem: Problem, draws: Draws, port: Vector, faults: tuple[Numbers, ...]) -> MetricContext:
    """The context of the metrics. Without a docking axis (`docking_axis`) no position is outside the approach cone."""
    spec = problem.spec
    duration = spec.horizon.duration_s
    last = draws.same(-np.inf)
    for fault in faults:
        for onset in fault.onset_s.parts():
            last = np.where(onset <= duration, np.maximum(last, onset), last)
    axis, known = docking_axis(spec.target.port_axis, port)
    return MetricContext(
        tube_m=draws.same(spec.capture.position_m),
        tube_mrp=draws.same(spec.capture.attitude_mrp),
        window_start_s=draws.same(duration - spec.capture.window_s),
        duration_s=draws.same(duration),
        last_onset_s=last,
        cone=np.where(known, elementary.cos(spec.corridor.half_angle_rad), -2.0),
        funnel=_funnel(spec.corridor, draws),
        hulls=_hulls(problem, draws),
        keep_out=() if spec.target.keep_out is None else draws.take("target.keep_out.radii_m", spec.target.keep_out.radii_m),
        axis=axis,
        step_s=draws.same(spec.horizon.step_s),
        margins=tuple(map(draws.same, problem.margins)),
        chosen=tuple(draws.numbers(part) for part in problem.chosen),
    )
