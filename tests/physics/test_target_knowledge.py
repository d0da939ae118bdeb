"""What the controller knows of the target: constant errors and noise, and where they take the flight."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from rvjax.physics.noise import normals
from rvjax.physics.state import Tick
from rvjax.physics.vectors import Vector
from rvjax.simulation import closed_loop
from tests import flights
from tests.members import array, built
from tests.physics.test_navigation import QUANTITIES
from tests.physics.test_sensors import FALSE_ALARM, TRUTH, Array, H, W, loop_of, recorded, still


def test_a_perfect_controller_flies_to_the_point_that_it_believes() -> None:
    """PD+ with the exact plant ends at ρ = e within 0.5 mm, seen from where it believes to be at 0.

    Kills: δ − e, the motion without its change, ν without ω_t×e, e in P, a controller that knows the true point.
    """
    pairs = built("navigation", "target-knowledge", flights.LANES, port_m={"ball": 0.5})
    closed = flights.loop("pd-plus")._replace(faults=(), disturbances=(), navigation=(pairs[0],))
    drawn = flights.draw(flights.gains("pd-plus"), 300.0, 0.1)._replace(faults=(), disturbances=(), navigation=(pairs[1],))
    same = {
        name: np.full(flights.LANES, x) for name, x in (("mass", 100.0), ("j", flights.gains("pd-plus")["inertia_guess_kgm2"]))
    }
    zero = same["j"] * 0.0
    j = flights.Symmetric(same["j"], same["j"], same["j"], zero, zero, zero)
    big = flights.Channels.of((zero + 1e6,) * 6)
    plant = drawn.plant._replace(mass=same["mass"], inertia=j, inertia_inverse=flights.inverse(j), upper=big, lower=big)
    last = flights.recorder(closed, 1)(drawn._replace(plant=plant, upper=big, lower=big), 4000).traces
    for lane, table in enumerate(last):
        error = array(pairs[1]["port_m"])[lane]
        end = table.iloc[-1]
        assert np.linalg.norm(error) > 0.05
        np.testing.assert_allclose([end[f"rho_{axis}_m"] for axis in "xyz"], error, rtol=0.0, atol=5e-4)


def feed_forward(motion: dict[str, Array], r: Array, w: Array, alpha: Array, port: Array, gains: Any) -> Array:
    """PD+ in NumPy: the force, from what is known of the target; gravity in long double as a plain difference."""
    turn = Rotation.from_mrp(motion["sigma"]).inv()
    mu = np.longdouble(3.986004418e14)

    def gravity(x: Any) -> Any:
        return -mu * x / np.sqrt(x @ x) ** 3

    centre = turn.as_matrix().astype(np.longdouble) @ r.astype(np.longdouble)
    place = centre + motion["rho"] + turn.apply(port)
    swing = np.cross(alpha, port) + np.cross(w, np.cross(w, port))
    n = np.asarray(gravity(place) - gravity(centre), dtype=float) - turn.apply(swing)
    return gains.mass_guess_kg * (-n - gains.k_rho * motion["rho"] - gains.k_nu * motion["nu"])


@pytest.mark.parametrize("sampling", [0, 4])
def test_the_controller_starts_on_what_it_knows(sampling: int) -> None:
    """Its state at t = 0 comes from the target's data with their errors. Kills: a start on the true rate or docking point."""
    closed, drawn = loop_of(("target-knowledge", {"rate_deg_s": {"box": 0.5}, "port_m": {"ball": 0.5}}))
    started = closed_loop.Controller(lambda view, gains: (view.target.w, view.port), closed.controller.respond)  # pyright: ignore
    y, _ = closed_loop.start(closed._replace(controller=started, sampling=sampling), drawn)
    off = array(y.control[0]) - array(drawn.target.w), array(y.control[1]) - array(drawn.plant.port)
    (own,) = drawn.navigation
    np.testing.assert_allclose(off, (array(own["rate_rad_s"]), array(own["port_m"])), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("sampling", [0, 4])
def test_errors_about_the_target_enter_the_feed_forward(sampling: int) -> None:
    """The commanded force of PD+ at ten steps is that of an oracle with wrong rate, attitude and port, continuous and sampled.

    Kills: a rate error of T in P, b turned as well, a target's attitude that is turned the other way, ω̇_t of the wrong rate, a
    sampled controller that is told the truth, ω̇_t or δ that is not held.
    """
    said = {"rate_deg_s": {"box": 0.5}, "attitude_deg": {"box": 3.0}, "port_m": {"ball": 0.5}}
    closed, drawn = loop_of(("target-knowledge", said), ("target-noise", {"rate_deg_s": 0.2}))
    closed = closed._replace(sampling=sampling)
    seen, (own, _) = recorded(closed, drawn, 10), drawn.navigation
    truth, motion, measured_motion = seen.target, seen.motion, seen.measured
    inertia = np.array(flights.matrix(drawn.plant.target_inertia), dtype=float)
    phi = array(own["attitude_rad"])
    wrong = Rotation.from_rotvec(-phi * (4.0 * np.arctan(np.linalg.norm(phi) / 4.0) / np.linalg.norm(phi)))
    error, port = array(own["port_m"]), array(drawn.plant.port)
    xi = [array(Vector(*normals(drawn.navigation[1].noise, k, 3))) for k in range(10)]
    gains = drawn.gains
    for k in range(10):
        at = k - k % sampling if sampling else k
        w = array(truth.w)[at]
        alpha = -np.linalg.solve(inertia, np.cross(w, inertia @ w))
        told = wrong.apply(w) + array(own["rate_rad_s"]) + np.radians(0.2) * xi[at]
        true = {name: array(getattr(motion, name))[at] for name in QUANTITIES}
        turn = Rotation.from_mrp(true["sigma"]).inv()
        believed = true | {"rho": true["rho"] - turn.apply(error), "nu": true["nu"] - turn.apply(np.cross(w, error))}
        shown = array(measured_motion.rho)[at], array(measured_motion.nu)[at]
        np.testing.assert_allclose(shown, (believed["rho"], believed["nu"]), rtol=0.0, atol=1e-12)
        force = feed_forward(believed, wrong.apply(array(truth.r)[at]), told, wrong.apply(alpha), port + error, gains)
        np.testing.assert_allclose(array(seen.command.force)[k], force, rtol=1e-9, atol=1e-10)


def test_noise_about_the_target_is_white_and_of_its_size() -> None:
    """χ² of each axis, and no step correlated with the next; false alarm 1e-6. Kills: degrees for radians, noise that stands."""
    error, numbers = built("navigation", "target-noise", 2_000, rate_deg_s=[0.1, 0.2, 0.05])
    steps = 10

    def one(own: Any) -> Any:
        def told(k: Any) -> Any:
            return error.knows(k * H, TRUTH, error.keep(Tick(k, k * H, H), still(0.0), error.start(still(0.0), own), own), own)

        return jax.vmap(told)(jnp.arange(steps))

    known = jax.jit(jax.vmap(one))(numbers)
    off = (array(known.target.w) - np.array(W)) / np.radians([0.1, 0.2, 0.05])
    low, high = stats.chi2.ppf([0.5 * FALSE_ALARM / 6, 1.0 - 0.5 * FALSE_ALARM / 6], 2_000 * steps)
    energy = (off**2).sum(axis=(0, 1))
    assert ((low <= energy) & (energy <= high)).all()
    both = (off[:, :-1] * off[:, 1:]).sum(axis=(0, 1)) / np.sqrt((off[:, :-1] ** 2).sum(axis=(0, 1)))
    assert (np.abs(both) <= stats.norm.isf(0.5 * FALSE_ALARM / 6)).all()
