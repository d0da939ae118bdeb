"""A run folder whose flight was made by SciPy in an inertial frame and then resolved as a trace is. Nothing of rvjax flies."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from rvjax.run_folder import Column, RunDescription, RunFolder
from tests.once import made_once

MU = 3.986004418e14
PORT = np.array([5.0, 0.5, -0.3])
ATTITUDE = np.array([0.2, -0.1, 0.3])  # of the target at t = 0, MRP
SPIN = np.array([0.06, -0.09, 0.045])
TURN = np.array([0.3, 0.2, -0.4])  # of the pursuer, relative to the target
PLANE = (30.0, 51.6, 40.0)
LOST = 3
"""Rows of NaN at the end of sample 2."""

CAMPAIGN = """rvjax: 1
name: made-elsewhere
samples: 3
horizon: {duration_s: 60, step_s: 0.1}
target:
  orbit: {semi_major_axis_km: 8000, eccentricity: 0.1, true_anomaly_deg: 30}
  attitude_mrp: {box: 0.4}
  port_m: [5, 0.5, -0.3]
  MORE
pursuer: {mass_kg: 100, inertia_kgm2: {principal: [22, 20, 23]}}
start: {rho_m: {box: 20}, sigma: {box: 0.25}, nu_m_s: 0, omega_rad_s: 0}
actuators: {upper: [4, 4, 4, 0.8, 0.8, 0.8], lower: [3, 3, 3, 0.6, 0.6, 0.6]}
controller: {use: pd-plus}
capture: {window_s: 10}
"""


@dataclass(frozen=True)
class Truth:
    """The inertial motion, in the perifocal frame. Rotations take components in the body to inertial ones."""

    t: NDArray[np.float64]
    r: NDArray[np.float64]
    v: NDArray[np.float64]
    target: Rotation
    p: NDArray[np.float64]
    w: NDArray[np.float64]
    pursuer: Rotation

    @classmethod
    def flown(cls) -> Truth:
        """A target on an ellipse that spins, and a pursuer on a smooth way about it that turns against it."""
        t = np.linspace(0.0, 60.0, 121)
        axis, e, anomaly = 8.0e6, 0.1, np.radians(30.0)
        p = axis * (1 - e * e)
        r0 = p / (1 + e * np.cos(anomaly)) * np.array([np.cos(anomaly), np.sin(anomaly), 0.0])
        v0 = np.sqrt(MU / p) * np.array([-np.sin(anomaly), e + np.cos(anomaly), 0.0])

        def pull(_: float, y: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.concatenate([y[3:], -MU * y[:3] / np.linalg.norm(y[:3]) ** 3])

        orbit = solve_ivp(pull, (0.0, 60.0), [*r0, *v0], method="DOP853", t_eval=t, rtol=3e-14, atol=1e-9).y.T
        target = Rotation.from_mrp(ATTITUDE) * Rotation.from_rotvec(np.outer(t, SPIN))
        pursuer = target * Rotation.from_rotvec(np.outer(np.cos(t / 20.0), TURN))
        way = np.stack([12.0 * np.cos(t / 30.0), 3.0 * np.sin(t / 10.0), 0.1 * t], axis=1)
        speed = np.stack([-0.4 * np.sin(t / 30.0), 0.3 * np.cos(t / 10.0), np.full_like(t, 0.1)], axis=1)
        return cls(t, orbit[:, :3], orbit[:, 3:], target, orbit[:, :3] + way, orbit[:, 3:] + speed, pursuer)

    @property
    def relative_rate(self) -> NDArray[np.float64]:
        """ω: of the pursuer relative to the target, in the pursuer's frame; the axis of the turn is the same in both."""
        return np.outer(-np.sin(self.t / 20.0) / 20.0, TURN)

    @property
    def rate(self) -> NDArray[np.float64]:
        """The inertial rate of the pursuer, in its frame."""
        return self.relative_rate + (self.pursuer.inv() * self.target).apply(SPIN)

    def trace(self) -> pd.DataFrame:
        """As `rvjax.physics.state` says it."""
        port, swing = self.target.apply(PORT), self.target.apply(np.cross(SPIN, PORT))
        vectors = {
            "rho_{}_m": self.pursuer.inv().apply(self.p - self.r - port),
            "nu_{}_m_s": self.pursuer.inv().apply(self.w - self.v - swing),
            "sigma_{}": (self.target.inv() * self.pursuer).as_mrp(),
            "omega_{}_rad_s": self.relative_rate,
            "target_r_{}_m": self.target.inv().apply(self.r),
            "target_v_{}_m_s": self.target.inv().apply(self.v),
            "target_w_{}_rad_s": np.tile(SPIN, (len(self.t), 1)),
        }
        columns = {form.format(axis): values[:, i] for form, values in vectors.items() for i, axis in enumerate("xyz")}
        return pd.DataFrame({"t_s": self.t, **columns, "cmd_fx": np.sin(self.t)})


@pytest.fixture(scope="session")
def truth() -> Truth:
    """Flown once."""
    return Truth.flown()


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory, truth: Truth) -> Path:
    """The run folder with kept traces of samples 1 and 2; sample 2 diverges at its end."""
    return made_once(tmp_path_factory, "exported", lambda path: made_folder(path, truth))


def made_folder(path: Path, truth: Truth, more: str = "") -> Path:
    """Writes the folder. more: of the target in the campaign, in braces."""
    drawn = {f"draw.target.attitude_mrp.{axis}": np.full(3, ATTITUDE[i]) for i, axis in enumerate("xyz")}
    frame = pd.DataFrame(
        {
            "sample": np.arange(3),
            "outcome": ["captured", "captured", "not_finite"],
            "outcome_time_s": [20.0, 0.1 + 0.2, 59.0],
            **drawn,
            "draw.faults.effectiveness-of-the-thrusters-on-the-far-side.onset_s.fx": [np.inf, 30.0, 1 / 3],
            "metric.settling_time_s": [12.5, np.inf, np.nan],
        }
    )
    columns = {name: Column(name, "m·s", f"what {name} means", "lower") for name in frame.columns[2:]}
    text = CAMPAIGN.replace("  MORE\n", "".join(f"  {part}\n" for part in more.split("; ") if part))
    identity = {"campaign": "0" * 64, "seed": 5, "precision": "float64", "rvjax": "0.1.0", "device": "cpu"}
    run = RunDescription(identity=identity, provenance={}, campaign_text=text, samples=3, name="made-elsewhere")
    trace = truth.trace()
    lost = trace.copy()
    lost.iloc[-LOST:, 1:] = np.nan
    described = {name: Column(name, "N·m", f"what {name} is") for name in trace.columns}
    with RunFolder.create(path, run) as made:
        made.commit(0, frame, columns)
        made.write_traces({1: (trace, described), 2: (lost, described)})
    return path
