"""Read back: each number of the flight that comes from draws, beside its value by the table.

Where a draw is a number of the flight, it is read. Where numbers of the flight are derived from draws, they are computed again,
by other formulas and from the columns of the table alone:

    J = Σ Jᵢ aᵢaᵢᵀ,  aᵢ = eᵢ turned by the tilt about the axis, or by the drawn rotation (Rodrigues' formula)
    J_C = J − m c^× (c^×)ᵀ,  c the centre of mass
    limit = nominal limit · spread,  largest thrust = nominal largest thrust · spread
    r = r(a, e, ν),  v = v(a, e, ν) in the perifocal frame, by vis-viva and the flight path angle; turned by the MRP as a matrix
    start in a frame: axes of LVLH and its rate √(μp)/|r|² from the true anomaly, axes of the port by Rodrigues' formula; position
    and velocity of the pursuer and of the docking point, both from the target's centre
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign import Model, Quantity
from rvjax.campaign.actuators import Thrusters
from rvjax.campaign.inertia import MatrixInertia, PrincipalInertia
from rvjax.campaign.quantity import COMPONENTS
from rvjax.campaign.start import FramedStart
from rvjax.campaign.thruster_layout import thruster_names
from rvjax.physics.dynamics import MU_EARTH
from rvjax.physics.propellant import Propellant
from rvjax.physics.vectors import Thrusts, Vector
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.draws import Draws
from rvjax.simulation.inertia import Body, bodies
from rvjax.simulation.problem import NEVER, Part, Problem

Values = NDArray[np.float64]

WELL = 20.0
"""Ratio of the largest to the smallest moment of inertia up to which J J⁻¹ = I must hold to the last digits."""


@dataclass(frozen=True)
class ReadBack:
    """A number of the flight in every lane: by the table, and inside the compiled program.

    columns: the draws that it comes from. exact: it is the draw itself, in the precision of the flight. size: of the vector that
    it is a component of, which rounding is relative to.
    """

    columns: tuple[str, ...]
    table: Values
    inside: Values
    exact: bool = True
    size: float = 1.0


def readings(problem: Problem, draws: Draws, numbers: Drawn) -> list[ReadBack]:
    """All numbers that come from draws. numbers: those inside the compiled program."""
    return [reading for reading in (*_direct(problem, draws, numbers), *_derived(problem, draws, numbers)) if reading.columns]


def _direct(problem: Problem, draws: Draws, numbers: Drawn) -> Iterator[ReadBack]:
    plant, motion = numbers.plant, numbers.motion
    named: dict[str, Any] = {
        "pursuer.mass_kg": plant.mass,
        "pursuer.centre_of_mass_m": plant.centre,
        "target.port_m": plant.port,
        "target.rate_rad_s": numbers.target.w,
        "start.rho_m": motion.rho,
        "start.nu_m_s": motion.nu,
        "start.sigma": motion.sigma,
        "start.omega_rad_s": motion.omega,
        "actuators.upper": numbers.upper,
        "actuators.lower": numbers.lower,
        "target.keep_out.radii_m": numbers.context.keep_out,
    }
    if isinstance(propellant := numbers.propellant, Propellant):
        names = ("mass_kg", "specific_impulse_s", "tank_m", "torque_arm_m")
        pairs = zip(names, propellant, strict=True)
        named |= {f"pursuer.propellant.{name}": value for name, value in pairs if not isinstance(value, tuple)}
    for body, hull in zip(("target.hull", "pursuer.hull"), numbers.context.hulls, strict=False):
        named |= {f"{body}.centre_m": hull.centre, f"{body}.radius_m": hull.radius}
        named |= {f"{body}.box_m": hull.half * 2.0} if isinstance(hull.half, Vector) else {}
    groups = (
        (problem.faults, numbers.faults),
        (problem.disturbances, numbers.disturbances),
        (problem.navigation, numbers.navigation),
        ((problem.guidance,), (numbers.guidance,)),
        (problem.actuation, numbers.actuation),
        (problem.effects, numbers.effects),
        (problem.chosen, numbers.context.chosen),
    )
    for parts, values in groups:
        for part, part_values in zip(parts, values, strict=True):
            named |= {f"{part.prefix}.{name}": part_values[name] for name in part.quantities}
    gains = numbers.gains
    named |= {f"{problem.controller.prefix}.{name}": gains[name.removeprefix("gains.")] for name in problem.controller.quantities}
    for name, value in named.items():
        yield from _components(draws, name, value)
    for part, values in zip(problem.faults, numbers.faults, strict=True):
        yield from _schedule(draws, part, values)


def _components(draws: Draws, name: str, value: Any) -> Iterator[ReadBack]:
    """A scalar, or the drawn components of a vector, of the channels or of the thrusters."""
    parts = value.parts() if hasattr(value, "parts") else (value,)
    known = {len(components): components for components in COMPONENTS.values() if components}
    components = ("",) if len(parts) == 1 else known.get(len(parts)) or thruster_names(len(parts))
    for component, inside in zip(components, parts, strict=True):
        if (column := f"{name}.{component}".rstrip(".")) in draws.values:
            yield ReadBack((column,), draws.values[column], inside)


def _schedule(draws: Draws, part: Part, values: Any) -> Iterator[ReadBack]:
    """The number of channels that fail."""
    if (name := f"{part.prefix}.schedule.failing") in draws.values:
        begins = [onset < NEVER.value for onset in values["onset_s"].parts()]
        yield ReadBack((name,), draws.values[name], np.sum(begins, axis=0))
    for what in ("count", "probability"):  # they decide the onsets, which are read
        if (name := f"{part.prefix}.schedule.{what}") in draws.values:
            yield ReadBack((name,), draws.values[name], draws.values[name])


def _derived(problem: Problem, draws: Draws, numbers: Drawn) -> Iterator[ReadBack]:
    spec, plant = problem.spec, numbers.plant
    actuators = spec.actuators.quantities("actuators")
    if isinstance(plant.thrust, Thrusts) and isinstance(spec.actuators, Thrusters):
        nominal = [(most,) for most in spec.actuators.geometry.most]
        limits = [(nominal, "actuators.spread", plant.thrust)]
    else:
        sides = (("upper", plant.upper), ("lower", plant.lower))
        table = {side: _by_table(draws, f"actuators.{side}", actuators[f"actuators.{side}"]) for side, _ in sides}
        limits = [(table[side], f"actuators.spread.{side}", true) for side, true in sides]
    for nominal, spread, true in limits:
        for (limit, *first), (factor, *second), inside in zip(
            nominal, _by_table(draws, spread, actuators[spread]), true.parts(), strict=True
        ):
            yield ReadBack((*first, *second), limit * factor, inside, exact=False)
    inertias = ((plant.inertia, plant.inertia_inverse), (plant.target_inertia, plant.target_inertia_inverse))
    for body, (inertia, inverse) in zip(bodies(spec), inertias, strict=True):
        yield from _body(draws, body, inertia, inverse)
    yield from _orbit(problem, draws, numbers)
    if isinstance(spec.start, FramedStart):
        yield from _start(problem, spec.start, draws, numbers)
    yield from _context(problem, draws, numbers)


def _by_table(draws: Draws, name: str, quantity: Quantity) -> list[tuple[Any, ...]]:
    """(value by the table, its column if it is drawn) of each component."""
    names = [f"{name}.{component}" for component in quantity.components] or [name]
    fixed = [part.low for part in quantity.parts] or [0.0] * len(names)
    return [
        (draws.values[column], column) if column in draws.values else (draws.same(low),)
        for column, low in zip(names, fixed, strict=True)
    ]


def _body(draws: Draws, body: Body, true: Any, inverse: Any) -> Iterator[ReadBack]:
    """The inertia about the centre of mass, and its inverse where the inertia is physical: a moved draw may not be."""
    expected, columns = _inertia(draws, body.path, body.inertia)
    if body.mass_and_centre:
        (mass, *heavy), *centre = (
            item for name, quantity in body.mass_and_centre.items() for item in _by_table(draws, name, quantity)
        )
        arm = _skew(np.stack([value for value, *_ in centre], axis=-1))
        expected = expected - mass[:, None, None] * (arm @ np.swapaxes(arm, 1, 2))
        columns += (*heavy, *(column for _, *drawn in centre for column in drawn))
    inside = _matrix(true)
    places = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
    entries = [
        _by_table(draws, f"{body.path}.{name}", quantity)
        for name, quantity in body.inertia.quantities().items()
        if quantity.shape == "vector"
    ]
    plain = isinstance(body.inertia, MatrixInertia) and not body.mass_and_centre
    sources = [tuple(column) for entry in entries for _, *column in entry] if plain else [columns] * len(places)
    for (i, j), source in zip(places, sources, strict=True):
        yield ReadBack(source, expected[:, i, j], inside[:, i, j], exact=plain)
    sizes = np.linalg.eigvalsh(inside)
    clear = sizes[:, 0] * WELL > sizes[:, 2]
    product = np.where(clear[:, None, None], inside @ _matrix(inverse), np.eye(3))
    for i, j in np.ndindex(3, 3):
        yield ReadBack(columns, draws.same(float(i == j)), product[:, i, j], exact=False)
    if (name := f"{body.path}.rejected") in draws.values:  # it counts rejected draws, which do not fly
        yield ReadBack((name,), draws.values[name], draws.values[name])


def _inertia(draws: Draws, name: str, inertia: PrincipalInertia | MatrixInertia) -> tuple[Values, tuple[str, ...]]:
    """(samples, 3, 3) J about the reference point, and the columns that it comes from."""
    moments, products = inertia.entries
    entries = [*_by_table(draws, f"{name}.{'moments' if products else 'principal'}", moments)]
    if products is not None:
        entries += _by_table(draws, f"{name}.products", products)
        xx, yy, zz, yz, xz, xy = (value for value, *_ in entries)
        whole = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(-1, 3, 3)
        return whole, tuple(column for _, *drawn in entries for column in drawn)
    assert isinstance(inertia, PrincipalInertia)
    ((tilt, *tilted),) = _by_table(draws, f"{name}.tilt_rad", inertia.tilt_rad)
    turning = "rotation" if inertia.attitude else "axis"
    turn = [draws.values.get(f"{name}.{turning}.{axis}", draws.same(float(axis == "x"))) for axis in "xyz"]
    columns = [column for _, *drawn in entries for column in drawn] + tilted
    columns += [column for axis in "xyz" if (column := f"{name}.{turning}.{axis}") in draws.values]
    turned = _from_mrp(np.stack(turn, axis=-1)) if inertia.attitude else _rodrigues(np.stack(turn, axis=-1), tilt)
    diagonal = np.stack([value for value, *_ in entries], axis=-1)
    return np.einsum("nij,nj,nkj->nik", turned, diagonal, turned), tuple(columns)


def _matrix(symmetric: Any) -> Values:
    """(n, 3, 3) from the six entries."""
    xx, yy, zz, yz, xz, xy = (np.asarray(part, dtype=np.float64) for part in symmetric.parts())
    return np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(-1, 3, 3)


def _context(problem: Problem, draws: Draws, numbers: Drawn) -> Iterator[ReadBack]:
    """The docking axis and the last onset inside the flight, as the metrics get them."""
    axis, columns = _docking_axis(problem, draws)
    for row, inside in zip(axis.T, numbers.context.axis.parts(), strict=True):
        yield ReadBack(columns, row, inside, exact=False)
    onsets = [
        onset for part in problem.faults for onset in _by_table(draws, f"{part.prefix}.onset_s", part.quantities["onset_s"])
    ]
    inside = [np.where(x <= problem.spec.horizon.duration_s, x, -np.inf) for x, *_ in onsets]
    columns = tuple(column for _, *drawn in onsets for column in drawn)
    yield ReadBack(columns, np.max([draws.same(-np.inf), *inside], axis=0), numbers.context.last_onset_s)


def _docking_axis(problem: Problem, draws: Draws) -> tuple[Values, tuple[str, ...]]:
    """(n, 3) unit vectors in T, 0 where there is no axis, and the columns that they come from."""
    target = problem.spec.target
    vector, columns = _vector(draws, "target.port_m", target.port_m)
    if target.port_axis is not None:
        vector, columns = np.full(vector.shape, target.port_axis), ()
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    return vector / np.where(length > 0.0, length, 1.0), columns


def _vector(draws: Draws, name: str, quantity: Quantity) -> tuple[Values, tuple[str, ...]]:
    """(n, 3) a vector by the table, and its columns."""
    rows = _by_table(draws, name, quantity)
    return np.stack([value for value, *_ in rows], axis=-1), tuple(column for _, *drawn in rows for column in drawn)


def _rodrigues(axis: Values, angle: Values) -> Values:
    """(n, 3, 3) matrices whose columns are the coordinate axes turned by −angle about the axis: what R(a tan(angle/4)) is."""
    skew = _skew(axis)
    sine, cosine = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) - sine * skew + (1.0 - cosine) * (skew @ skew)


def _skew(vector: Values) -> Values:
    """(n, 3, 3) a^× of (n, 3) vectors."""
    x, y, z = vector.T
    zero = x * 0.0
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)


def _from_mrp(sigma: Values) -> Values:
    """(n, 3, 3) R(σ) as the rotation by −4 arctan |σ| about σ."""
    size = np.linalg.norm(sigma, axis=-1)
    axis = np.where(size[:, None] > 0.0, sigma / np.where(size > 0.0, size, 1.0)[:, None], 0.0)
    return _rodrigues(axis, 4.0 * np.arctan(size))


class _Orbit(NamedTuple):
    """By the table: a, e, ν, R of the target's MRP, and the columns that they come from."""

    semi_major_axis: Values
    eccentricity: Values
    anomaly: Values
    turn: Values
    columns: tuple[str, ...]

    @property
    def parameter(self) -> Values:
        """p [m]."""
        return self.semi_major_axis * (1.0 - self.eccentricity**2)

    @property
    def distance(self) -> Values:
        """|r| [m]."""
        return self.parameter / (1.0 + self.eccentricity * np.cos(self.anomaly))

    def in_target(self, along: Values, across: Values, normal: Values) -> Values:
        """(n, 3) components in T of a vector in the perifocal frame."""
        return np.einsum("nij,nj->ni", self.turn, np.stack([along, across, normal], axis=-1))


def _orbit_by_table(problem: Problem, draws: Draws) -> _Orbit:
    target = problem.spec.target
    elements = {
        "semi_major_axis_m": target.orbit.semi_major_axis_m,
        "eccentricity": target.orbit.eccentricity,
        "true_anomaly_rad": target.orbit.true_anomaly_rad,
    }
    rows = [_by_table(draws, f"target.orbit.{name}", quantity)[0] for name, quantity in elements.items()]
    sigma, columns = _vector(draws, "target.attitude_mrp", target.attitude_mrp)
    a, e, anomaly = (value for value, *_ in rows)
    return _Orbit(a, e, anomaly, _from_mrp(sigma), (*(column for _, *drawn in rows for column in drawn), *columns))


def _orbit(problem: Problem, draws: Draws, numbers: Drawn) -> Iterator[ReadBack]:
    orbit = _orbit_by_table(problem, draws)
    distance, anomaly, e = orbit.distance, orbit.anomaly, orbit.eccentricity
    speed = np.sqrt(MU_EARTH * (2.0 / distance - 1.0 / orbit.semi_major_axis))
    climb = np.arctan2(e * np.sin(anomaly), 1.0 + e * np.cos(anomaly))
    ahead = anomaly + 0.5 * np.pi - climb
    flat = draws.same(0.0)
    where = orbit.in_target(distance * np.cos(anomaly), distance * np.sin(anomaly), flat)
    motion = orbit.in_target(speed * np.cos(ahead), speed * np.sin(ahead), flat)
    for expected, inside in ((where, numbers.target.r), (motion, numbers.target.v)):
        for row, values in zip(expected.T, inside.parts(), strict=True):
            yield ReadBack(orbit.columns, row, values, exact=False)


def _start(problem: Problem, start: FramedStart, draws: Draws, numbers: Drawn) -> Iterator[ReadBack]:
    """R(σ), ρ, ν and ω of a start in a frame."""
    orbit, motion = _orbit_by_table(problem, draws), numbers.motion
    (position, velocity, attitude, rate), given = _vectors(draws, "start", start)
    (spin, port), known = _vectors(draws, "target", problem.spec.target, "rate_rad_s", "port_m")
    turn, axes = _start_axes(problem, start, draws, orbit, _from_mrp(attitude))
    flat = draws.same(0.0)
    orbital = orbit.in_target(flat, flat, np.sqrt(MU_EARTH * orbit.parameter) / orbit.distance**2)
    rest = {"port": spin, "lvlh": orbital, "inertial": spin * 0.0}[start.rest]
    place = np.einsum("nij,nj->ni", axes, position) + (0.0 if start.frame == "lvlh" else port)
    speed = np.einsum("nij,nj->ni", axes, velocity) + np.cross(rest, place) - np.cross(spin, port)
    about = (*known["port_m"], *orbit.columns, *given["attitude_mrp"])
    placed, spun = (*about, *given["position_m"]), (*about, *known["rate_rad_s"])
    seen = _from_mrp(np.stack(motion.sigma.parts(), axis=-1)).reshape(-1, 9)
    for columns, expected, inside in (
        (about, turn.reshape(-1, 9), tuple(seen.T)),
        (placed, np.einsum("nij,nj->ni", turn, place - port), motion.rho.parts()),
        ((*placed, *spun, *given["velocity_m_s"]), np.einsum("nij,nj->ni", turn, speed), motion.nu.parts()),
        ((*spun, *given["rate_rad_s"]), rate + np.einsum("nij,nj->ni", turn, rest - spin), motion.omega.parts()),
    ):
        for row, values in zip(expected.T, inside, strict=True):
            yield ReadBack(tuple(dict.fromkeys(columns)), row, values, exact=False, size=float(np.max(np.abs(expected))))


def _start_axes(problem: Problem, start: FramedStart, draws: Draws, orbit: _Orbit, turn: Values) -> tuple[Values, Values]:
    """(n, 3, 3) R(σ), and the axes of the frame in T as columns. turn: R of the given attitude."""
    if start.frame == "pursuer":
        return turn, np.swapaxes(turn, 1, 2)
    flat, cosine, sine = draws.same(0.0), np.cos(orbit.anomaly), np.sin(orbit.anomaly)
    if start.frame == "lvlh":
        rows = ((-sine, cosine, flat), (flat, flat, flat - 1.0), (-cosine, -sine, flat))
        axes = np.stack([orbit.in_target(*row) for row in rows], axis=-1)
        return turn @ np.swapaxes(axes, 1, 2), axes
    axis, _ = _docking_axis(problem, draws)
    beside = np.hypot(axis[:, 1], axis[:, 2])
    about = np.stack([flat, -axis[:, 2], axis[:, 1]], axis=-1) / np.where(beside > 0.0, beside, 1.0)[:, None]
    return turn, _rodrigues(np.where(beside[:, None] > 0.0, about, (0.0, 0.0, 1.0)), -np.arctan2(beside, axis[:, 0]))


def _vectors(draws: Draws, section: str, model: Model, *names: str) -> tuple[list[Values], dict[str, tuple[str, ...]]]:
    """Vectors by the table, and the columns of each by its name. names: of the section's quantities; by default all of them."""
    chosen = {name: quantity for name, quantity in model.quantities().items() if not names or name in names}
    read = {name: _vector(draws, f"{section}.{name}", quantity) for name, quantity in chosen.items()}
    return [vector for vector, _ in read.values()], {name: columns for name, (_, columns) in read.items()}
