"""The pursuer at t = 0 in inertial space, from a start in a frame: positions, velocities, attitudes and rates are absolute.

    target      r, v from Kepler elements in the perifocal frame, which is the inertial frame here; C_t: T → inertial
    LVLH        z toward the Earth's centre, y against the orbit normal, x = y×z; turns with θ̇ = √(μ/p³) (1 + e cos θ)²
    port        origin δ, x axis along the docking axis, by a turn of T about e_x × n; turns with the target
    pursuer     origin δ, axes of the pursuer

Attitudes are `scipy.spatial.transform.Rotation`. NumPy and SciPy only. SI units.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

MU = 3.986004418e14


class Target(NamedTuple):
    """a [m], e, θ [rad]: numbers; attitude: C_t; rate: in T [rad/s]; port: δ in T [m]; axis: of the port in T, of any length."""

    semi_major_axis: float
    eccentricity: float
    anomaly: float
    attitude: Rotation
    rate: Array
    port: Array
    axis: Array


class Start(NamedTuple):
    """As a campaign says it: position, velocity, attitude (a rotation out of its reference), rate."""

    position: Array
    velocity: Array
    attitude: Rotation
    rate: Array


class Pursuer(NamedTuple):
    """Position and velocity minus those of the target's centre of mass, inertial; C_p: P → inertial; inertial rate, in P."""

    position: Array
    velocity: Array
    attitude: Rotation
    rate: Array


def kepler(target: Target) -> tuple[Array, Array]:
    """r, v: from the eccentric anomaly E, r = (a(cos E − e), b sin E), v = ṙ with Ė = n/(1 − e cos E)."""
    a, e, theta = target.semi_major_axis, target.eccentricity, target.anomaly
    eccentric = 2.0 * np.arctan2(np.sqrt(1.0 - e) * np.sin(theta / 2.0), np.sqrt(1.0 + e) * np.cos(theta / 2.0))
    b, rate = a * np.sqrt(1.0 - e * e), np.sqrt(MU / a**3) / (1.0 - e * np.cos(eccentric))
    r = np.array([a * (np.cos(eccentric) - e), b * np.sin(eccentric), 0.0])
    return r, rate * np.array([-a * np.sin(eccentric), b * np.cos(eccentric), 0.0])


def lvlh(target: Target) -> tuple[Rotation, Array]:
    """LVLH → inertial, and its inertial rate in the inertial frame."""
    r, v = kepler(target)
    z, y = -r / np.linalg.norm(r), -np.cross(r, v) / np.linalg.norm(np.cross(r, v))
    p = target.semi_major_axis * (1.0 - target.eccentricity**2)
    rate = np.sqrt(MU / p**3) * (1.0 + target.eccentricity * np.cos(target.anomaly)) ** 2
    return Rotation.from_matrix(np.stack([np.cross(y, z), y, z], axis=-1)), np.array([0.0, 0.0, rate])


def port_axes(axis: Array) -> Rotation:
    """Axes of the port → T: the shortest turn that takes x to the docking axis, for −x half a turn about z."""
    n = np.asarray(axis, np.float64) / np.linalg.norm(axis)
    sine = np.hypot(n[1], n[2])
    about = np.array([0.0, -n[2], n[1]]) / sine if sine > 0.0 else np.array([0.0, 0.0, 1.0])
    return Rotation.from_rotvec(about * np.arctan2(sine, n[0]))


def pursuer(frame: str, relative_to: str, start: Start, target: Target) -> Pursuer:
    """The pursuer in inertial space."""
    turning, orbital = lvlh(target)
    spin, port = target.attitude.apply(target.rate), target.attitude.apply(target.port)
    attitude = (turning if frame == "lvlh" else target.attitude) * start.attitude
    axes = {"lvlh": turning, "port": target.attitude * port_axes(target.axis), "pursuer": attitude}[frame]
    position = axes.apply(start.position) + (0.0 if frame == "lvlh" else port)
    rest = {"port": spin, "lvlh": orbital, "inertial": np.zeros(3)}[relative_to]
    velocity = axes.apply(start.velocity) + np.cross(rest, position)
    return Pursuer(position, velocity, attitude, start.rate + attitude.apply(rest, inverse=True))


def flown(rho: Array, nu: Array, sigma: Array, omega: Array, target: Target) -> Pursuer:
    """The same from the relative motion of the flight, by its definition."""
    attitude = target.attitude * Rotation.from_mrp(sigma)
    swing = target.attitude.apply(np.cross(target.rate, target.port))
    spin = attitude.apply(target.attitude.apply(target.rate), inverse=True)
    return Pursuer(target.attitude.apply(target.port) + attitude.apply(rho), swing + attitude.apply(nu), attitude, omega + spin)
