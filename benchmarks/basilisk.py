"""Flies shipped campaigns again in Basilisk: `python -m benchmarks.basilisk [CAMPAIGN…] [--sample K] [--set path=value]…`.

Target and pursuer are two independent spacecraft of Basilisk with point-mass gravity, in inertial space. They get three things
from a flight of rvjax: its first row, the drawn mass and inertias, and the mean wrench of every step, held over the step in the
pursuer's frame. Basilisk integrates with its RK4 at the same step. Printed: the distance between both flights at the end, and the
largest on the way; then the same with the step halved. What the figures mean: docs/crosscheck.md.

    pip install 'rvjax[crosscheck]'
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks import markdown
from rvjax.columns import CHANNELS

CAMPAIGNS = Path(__file__).parents[1] / "campaigns"
FOLDERS = (".", "ci", "scenes")
"""Of shipped campaigns."""

NANO = 1e-9

Array = NDArray[np.float64]


class UnfitError(Exception):
    """Why a campaign is not repeated."""


class Flight(NamedTuple):
    """trace: every step. mass [kg], inertia and target_inertia (3, 3) [kg·m²], port: docking point in T [m], mu [m³/s²]."""

    trace: pd.DataFrame
    step_s: float
    mass: float
    inertia: Array
    target_inertia: Array
    port: Array
    mu: float


class Apart(NamedTuple):
    """How far two flights are apart. position [m], attitude [rad]: of the pursuer, relative to the docking point and the target.
    radius [m]: of the target's orbit. target [rad]: angle between the directions of the Earth's centre in T."""

    position: Array
    attitude: Array
    radius: Array
    target: Array


def flown(path: Path, sample: int = 0, overrides: Sequence[str] = ()) -> Flight:
    """A sample of a campaign with the trace of every step. Errors: UnfitError."""
    from rvjax.physics.dynamics import MU_EARTH
    from rvjax.simulation import jax_config
    from rvjax.simulation.batch import Flyer
    from rvjax.simulation.draws import Draws
    from rvjax.simulation.problem import load
    from rvjax.simulation.tables import trace_tables

    problem = load(path, overrides)
    jax_config.configure(problem.spec.precision)
    horizon, flyer = problem.spec.horizon, Flyer.of(problem)
    if abs(horizon.step_s / NANO - round(horizon.step_s / NANO)) > 1e-6:
        raise UnfitError(f"Basilisk counts time in whole nanoseconds; a step has {horizon.step_s} s")
    _, drawn = Draws.of(problem, np.full(flyer.lanes(1), sample))
    record = flyer.fly(drawn, horizon.steps, 1, trace=(0,))
    plants = [step.plant for step in record.steps]
    masses = np.array([np.broadcast_to(plant.mass, 1)[0] for plant in plants])
    if np.ptp(masses) > 0.0:
        raise UnfitError(f"the pursuer's mass changes, from {masses[0]:.6g} to {masses[-1]:.6g} kg")
    (trace,), _ = trace_tables(record.steps, {}, measured=False, means=record.means)
    if np.isfinite(record.lost_s[0]):
        raise UnfitError(f"the flight is not finite from {record.lost_s[0]:.6g} s on")
    plant = drawn.plant
    return Flight(
        trace,
        horizon.step_s,
        float(masses[0]),
        _matrix(plant.inertia),
        _matrix(plant.target_inertia),
        np.array([np.broadcast_to(part, 1)[0] for part in plant.port.parts()]),
        MU_EARTH,
    )


def repeated(flight: Flight) -> tuple[dict[str, Array], dict[str, Array]]:
    """The states of target and pursuer at the rows, flown by Basilisk: r, v (inertial), sigma (of the body), w (in the body)."""
    from Basilisk.simulation import extForceTorque, spacecraft, svIntegrators
    from Basilisk.utilities import SimulationBaseClass, simIncludeGravBody

    step = round(flight.step_s / NANO)
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("process").addTask(simulation.CreateNewTask("task", step))
    gravity = simIncludeGravBody.gravBodyFactory()
    earth = gravity.createEarth()
    earth.isCentralBody, earth.mu = True, flight.mu
    bodies: list[Any] = []
    integrators: list[Any] = []
    inertias = ((1.0, flight.target_inertia), (flight.mass, flight.inertia))
    for (mass, inertia), (r, v, sigma, w) in zip(inertias, absolute(flight), strict=True):
        body = spacecraft.Spacecraft()
        body.hub.mHub, body.hub.IHubPntBc_B = mass, inertia.tolist()
        body.hub.r_CN_NInit, body.hub.v_CN_NInit = r.tolist(), v.tolist()
        body.hub.sigma_BNInit, body.hub.omega_BN_BInit = sigma.tolist(), w.tolist()
        body.gravField.gravBodies = spacecraft.GravBodyVector(list(gravity.gravBodies.values()))
        integrators.append(svIntegrators.svIntegratorRK4(body))
        body.setIntegrator(integrators[-1])
        simulation.AddModelToTask("task", body)
        bodies.append(body)
    push = extForceTorque.ExtForceTorque()
    bodies[1].addDynamicEffector(push)
    simulation.AddModelToTask("task", push)
    records = [body.scStateOutMsg.recorder() for body in bodies]
    for record in records:
        simulation.AddModelToTask("task", record)
    simulation.InitializeSimulation()
    wrench = flight.trace[[f"mean_{channel}" for channel in CHANNELS]].to_numpy(np.float64)
    for k, row in enumerate(wrench[:-1].tolist()):
        push.extForce_B, push.extTorquePntB_B = row[:3], row[3:]
        simulation.ConfigureStopTime((k + 1) * step)
        simulation.ExecuteSimulation()
    target, pursuer = ({name: np.array(getattr(record, field)) for name, field in _STATE.items()} for record in records)
    return target, pursuer


_STATE = {"r": "r_BN_N", "v": "v_BN_N", "sigma": "sigma_BN", "w": "omega_BN_B"}


def absolute(flight: Flight) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """(r, v, σ, ω) of target and pursuer at the first row, in the inertial frame that is then the target's; ω in the body."""
    first = {name: _vectors(flight.trace.iloc[:1], form)[0] for name, form in _FORMS.items()}
    r, v, w = first["r_t"], first["v_t"], first["w_t"]
    turn = Rotation.from_mrp(first["sigma"])
    position = r + flight.port + turn.apply(first["rho"])
    velocity = v + np.cross(w, flight.port) + turn.apply(first["nu"])
    return (r, v, np.zeros(3), w), (position, velocity, first["sigma"], first["omega"] + turn.inv().apply(w))


_FORMS = {
    "rho": "rho_{}_m",
    "nu": "nu_{}_m_s",
    "sigma": "sigma_{}",
    "omega": "omega_{}_rad_s",
    "r_t": "target_r_{}_m",
    "v_t": "target_v_{}_m_s",
    "w_t": "target_w_{}_rad_s",
}


def apart(flight: Flight, target: dict[str, Array], pursuer: dict[str, Array]) -> Apart:
    """At every row, between the trace and two absolute flights."""
    turn_t, turn_p = (Rotation.from_mrp(body["sigma"]) for body in (target, pursuer))
    rho = turn_p.inv().apply(pursuer["r"] - target["r"] - turn_t.apply(flight.port))
    between = (turn_t.inv() * turn_p).inv() * Rotation.from_mrp(_vectors(flight.trace, _FORMS["sigma"]))
    down, known = turn_t.inv().apply(target["r"]), _vectors(flight.trace, _FORMS["r_t"])
    ahead, moving = turn_t.inv().apply(target["v"]), _vectors(flight.trace, _FORMS["v_t"])
    return Apart(
        np.linalg.norm(rho - _vectors(flight.trace, _FORMS["rho"]), axis=1),
        between.magnitude(),
        np.abs(np.linalg.norm(down, axis=1) - np.linalg.norm(known, axis=1)),
        np.maximum(_angles(down, known), _angles(ahead, moving)),
    )


def _angles(a: Array, b: Array) -> Array:
    """Between the vectors of two arrays of shape (rows, 3)."""
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.sum(a * b, axis=1))


def _vectors(trace: pd.DataFrame, form: str) -> Array:
    return np.array(trace[[form.format(axis) for axis in "xyz"]], np.float64)


def _matrix(j: Any) -> Array:
    """A symmetric matrix of the first lane."""
    parts = [[j.xx, j.xy, j.xz], [j.xy, j.yy, j.yz], [j.xz, j.yz, j.zz]]
    return np.array([[np.broadcast_to(entry, 1)[0] for entry in row] for row in parts])


COLUMNS = (
    "campaign",
    "step, duration, s",
    "position, m",
    "attitude, rad",
    "position, half the step",
    "attitude, half the step",
    "target's radius, m",
    "target's attitude, rad",
)
"""Of the table; each number at the end / at most."""


def row(path: Path, sample: int, overrides: Sequence[str]) -> str:
    """A row of the table, of a campaign."""
    name = str(path.relative_to(CAMPAIGNS) if path.is_relative_to(CAMPAIGNS) else path)
    try:
        flight = flown(path, sample, overrides)
        found = apart(flight, *repeated(flight))
        halved = flown(path, sample, [*overrides, f"horizon.step_s={flight.step_s / 2.0!r}"])
        again = apart(halved, *repeated(halved))
    except UnfitError as error:
        return markdown.row([name, f"not repeated: {error}", *[""] * (len(COLUMNS) - 2)])
    series = (found.position, found.attitude, again.position, again.attitude, found.radius, found.target)
    length = f"{flight.step_s:g}, {flight.trace['t_s'].iloc[-1]:g}"
    return markdown.row([name, length, *(f"{each[-1]:.1e} / {each.max():.1e}" for each in series)])


def main() -> int:
    """Prints the table. 2 where a campaign is wrong or Basilisk is missing."""
    from rvjax.errors import RvjaxError

    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("campaigns", nargs="*", type=Path, metavar="CAMPAIGN")
    parser.add_argument("--sample", type=int, default=0)
    parser.add_argument("--set", dest="overrides", action="append", default=[])
    given = parser.parse_args()
    try:
        import Basilisk  # noqa: F401
    except ImportError:
        print("Basilisk is not installed; accepted: pip install 'rvjax[crosscheck]'", file=sys.stderr)
        return 2
    print(markdown.head(COLUMNS))
    for path in given.campaigns or [path for folder in FOLDERS for path in sorted((CAMPAIGNS / folder).glob("*.yaml"))]:
        try:
            print(row(path.resolve(), given.sample, given.overrides), flush=True)
        except RvjaxError as error:
            print(error, file=sys.stderr)
            return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
