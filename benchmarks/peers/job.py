"""The job that every peer does, and what its script gives back. NumPy only: it is imported in the environment of each peer.

A pursuer of drawn mass, position and velocity flies to a hold point 100 m behind a target in a circular orbit, and stops there.
State e = (x, y, z, vx, vy, vz) [m, m/s]: relative to the hold point, in the target's Hill frame (x outward, y along the velocity,
z along the orbit normal). Every STEP the law commands a force [N] that is held until the next,

    f = clip(-100 kg · (KP (x, y, z) + KD (vx, vy, vz)), ±LIMIT)

Result: the distance from the hold point after 300 s, and the share of the flights that end closer than TUBE.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MU = 3.986004418e14
"""Of the Earth [m³/s²]."""

AXIS = 6878137.0
"""Radius of the target's orbit [m]."""

RATE = (MU / AXIS**3) ** 0.5
"""Of the orbit [rad/s]."""

HOLD = np.array([0.0, -100.0, 0.0])
KP, KD, GUESS, LIMIT = 0.0009, 0.05, 100.0, 0.5
STEP, STEPS = 0.5, 600
TUBE = 0.5

COLUMNS = ("mass", "x", "y", "z", "vx", "vy", "vz")
"""Of the drawn values: kg, m, m/s."""


@dataclass
class Result:
    """What a peer gives back.

    distances: of each flight from the hold point at the end [m]. version: of the peer. interval: of the share, at 95 %, where the
    peer has one. fly_s: of the flights alone, where that can be told apart. verdict: where the peer gives one.
    """

    distances: list[float]
    version: str
    interval: tuple[float, float] | None = None
    fly_s: float | None = None
    verdict: str = ""


def law(position: Array, velocity: Array) -> Array:
    """The commanded force [N]; both relative to the hold point, (…, 3)."""
    return np.clip(-GUESS * (KP * position + KD * velocity), -LIMIT, LIMIT)


def save(draws: Array, path: Path) -> None:
    """Drawn values, (samples, 7) in the order of COLUMNS, with all their digits."""
    np.savetxt(path, draws, fmt="%.17g", delimiter=",", header=",".join(COLUMNS), comments="")


def main(fly: Callable[[Array, int], Any]) -> None:
    """Of a peer's script: `python -m benchmarks.peers.with_PEER DRAWS.csv RESULT.json CORES`."""
    draws, result, cores = sys.argv[1:]
    came = fly(np.loadtxt(draws, delimiter=",", skiprows=1, ndmin=2), int(cores))
    Path(result).write_text(json.dumps(asdict(came)))
