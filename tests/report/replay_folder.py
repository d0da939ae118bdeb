"""A run folder with made-up flights that move, turn past the shadow set, orbit, and have faults, for the replay."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from rvjax.run_folder import Column, RunFolder

CHANNELS = ("fx", "fy", "fz", "tx", "ty", "tz")
PORT = np.array([5.0, 0.0, 0.0])


def trace(sample: int, rows: int = 301, duration: float = 300.0) -> pd.DataFrame:
    """A pursuer on a spiral to the port that turns by more than half a turn, so that its MRP switch to the shadow set."""
    rng = np.random.default_rng(sample)
    t = np.linspace(0.0, duration, rows)
    away = np.exp(-t / 80)[:, None] * (rng.uniform(-1, 1, 3) * 3 + np.array([15.0, 0, 0]))
    away = Rotation.from_rotvec(np.outer(0.01 * t, [1.0, 0.0, 0.0])).apply(away)
    attitude = Rotation.from_rotvec(np.outer(0.9 + 0.03 * t, [0.6, 0.0, 0.8]))
    mrp = attitude.as_mrp()  # P → T; |σ| ≤ 1, so it jumps at half a turn
    rho, nu = attitude.inv().apply(away), attitude.inv().apply(np.gradient(away, t, axis=0))
    anomaly, tumble = 0.0011 * t, Rotation.from_rotvec(np.outer(t, [0.004, -0.006, 0.003]))
    zero = np.zeros_like(t)
    r = tumble.inv().apply(6.878e6 * np.stack([np.cos(anomaly), np.sin(anomaly), zero], axis=1))
    v = tumble.inv().apply(7612.7 * np.stack([-np.sin(anomaly), np.cos(anomaly), zero], axis=1))
    frame = {"t_s": t}
    vectors = {"rho_{}_m": rho, "nu_{}_m_s": nu, "sigma_{}": mrp, "omega_{}_rad_s": mrp * 0 + 0.03}
    vectors |= {"target_r_{}_m": r, "target_v_{}_m_s": v, "target_w_{}_rad_s": r * 0 + 0.004}
    for form, values in vectors.items():
        frame |= {form.format(axis): values[:, i] for i, axis in enumerate("xyz")}
    for i, name in enumerate(CHANNELS):
        limit = 3.6 if i < 3 else 0.7
        frame[f"cmd_{name}"] = limit * np.tanh(2.5 * np.cos(t / 20 + i) * np.exp(-t / 100))
        frame[f"applied_{name}"] = 0.7 * frame[f"cmd_{name}"]
    return pd.DataFrame(frame)


def add_traces(path: Path, samples: list[int]) -> dict[int, pd.DataFrame]:
    """Replaces the kept flights of a folder."""
    made = {sample: trace(sample) for sample in samples}
    with RunFolder.open(path) as folder:
        folder.drop_traces(folder.trace_samples())
        folder.write_traces({k: (frame, {name: Column(name, "", "made up") for name in frame}) for k, frame in made.items()})
    return made
