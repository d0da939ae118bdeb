"""Kept flights for the replay: their motion in the target's frame T as columns for `data_blocks`, and their events.

    px py pz          p = Rᵀρ + δ: pursuer from the target's centre of mass, in T                          m
    q0 … q3           attitude of P in T: (cos(φ/2), e sin(φ/2)); components in P → in T by v + 2 q × (q × v + q0 v)
    l0 … l3           attitude of LVLH in T, likewise
    turn              angle by which LVLH has turned since t = 0: ∫ |h|/|r|² dt                            rad
    speed, rate       |ν|, |ω|                                                                            m/s, rad/s
    cmd_…, applied_…  wrench h(v), and behind the faults                                                   N, N·m
    thrust_t…_N       of each thruster                                                                     N

Quaternions keep their sign from row to row, also where the modified Rodrigues parameters jump to their shadow set, so that
between two rows the attitude is on the arc between their quaternions.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.analysis.sample_values import Row, numbers, port
from rvjax.analysis.trace_frames import Values, lvlh, quaternions, quaternions_of_mrp, turned, vectors
from rvjax.campaign import Spec
from rvjax.columns import CHANNELS, metric_column
from rvjax.report.fault_severity import times
from rvjax.report.interactive.scene import outside_corridor

ZONES = {"corridor": "outside the corridor", "keep_out": "in the keep-out zone"}


def motion(trace: pd.DataFrame, spec: Spec, row: Row) -> dict[str, Values]:
    """The columns of a flight, without the time."""
    attitude = quaternions_of_mrp(vectors(trace, "sigma_{}"))
    place = turned(attitude, vectors(trace, "rho_{}_m")) + np.array(port(spec, row))
    columns = dict(zip(("px", "py", "pz"), place.T, strict=True))
    columns |= _named("q", attitude)
    if "target_r_x_m" in trace:
        columns |= _orbit(trace)
    columns["speed"] = np.linalg.norm(vectors(trace, "nu_{}_m_s"), axis=1)
    columns["rate"] = np.linalg.norm(vectors(trace, "omega_{}_rad_s"), axis=1)
    kept = [f"{kind}_{name}" for kind in ("cmd", "applied") for name in CHANNELS]
    kept += [str(name) for name in trace.columns if str(name).startswith("thrust_t")]
    return columns | {name: trace[name].to_numpy(dtype=float) for name in kept if name in trace}


def _orbit(trace: pd.DataFrame) -> dict[str, Values]:
    """The attitude of LVLH in T, and how far it has turned."""
    r, v, t = vectors(trace, "target_r_{}_m"), vectors(trace, "target_v_{}_m_s"), trace["t_s"].to_numpy(dtype=float)
    rate = np.linalg.norm(np.cross(r, v), axis=1) / np.sum(r * r, axis=1)
    turn = np.concatenate([[0.0], np.cumsum(np.diff(t) * (rate[1:] + rate[:-1]) / 2)])
    return _named("l", quaternions(np.swapaxes(lvlh(r, v), 1, 2))) | {"turn": turn}


def _named(letter: str, q: Values) -> dict[str, Values]:
    """The columns of quaternions, which have their scalar first in the page."""
    return {f"{letter}{i}": q[:, (i + 3) % 4] for i in range(4)}


def faults(spec: Spec, row: Row) -> list[dict[str, Any]]:
    """Every fault of the sample that begins before the end of the flight: its actuator, its begin and its end [s]."""
    end = spec.horizon.duration_s
    found = [
        {"fault": fault.name, "actuator": actuator, "from": onset, "to": min(onset + duration, end)}
        for fault in spec.faults
        for actuator, onset, duration in times(fault, row, spec.actuators)
        if onset < end
    ]
    return sorted(found, key=lambda item: (item["from"], item["fault"], item["actuator"]))


def events(trace: pd.DataFrame, spec: Spec, row: Row) -> list[dict[str, Any]]:
    """Capture, collision and loss at their instants, and the times in which a zone is violated at the kept instants; by time."""
    outcome, t = str(row.get("outcome", "")), trace["t_s"].to_numpy(dtype=float)
    found: list[dict[str, Any]] = []
    settled = max(float(row.get(metric_column(name), math.nan)) for name in ("settling_time_s", "attitude_settling_time_s"))
    if outcome == "captured" and math.isfinite(settled):
        found.append({"kind": "captured", "text": "captured: inside both tubes until the end", "t": settled})
    collision = float(row.get(metric_column("collision_time_s"), math.inf))
    if outcome == "collided" and math.isfinite(collision):
        found.append({"kind": "collided", "text": "collision: the hulls touch", "t": collision})
    if outcome == "not_finite":
        found.append({"kind": "not_finite", "text": "the state is not finite any more", "t": float(row["outcome_time_s"])})
    for kind, inside in _violations(trace, spec, row).items():
        found += [{"kind": kind, "text": ZONES[kind], "t": t[i], "to": t[j]} for i, j in _runs(inside)]
    return sorted(found, key=lambda item: (item["t"], item["kind"]))


def _violations(trace: pd.DataFrame, spec: Spec, row: Row) -> dict[str, NDArray[np.bool_]]:
    """Which of the kept instants violate the corridor and the keep-out zone, as their metrics define it."""
    offset = vectors(trace, "rho_{}_m")
    distance = np.linalg.norm(offset, axis=1)
    place = turned(quaternions_of_mrp(vectors(trace, "sigma_{}")), offset) + np.array(port(spec, row))
    outside = outside_corridor(place, spec, row) & (distance > spec.capture.position_m)
    length, keep_out = spec.corridor.length_m, spec.target.keep_out
    found = {"corridor": outside & (distance <= (math.inf if length is None else length))}
    if keep_out is not None:
        radii = np.array(numbers(keep_out.radii_m, "target.keep_out.radii_m", row))
        found["keep_out"] = outside & (np.sum((place / radii) ** 2, axis=1) < 1.0)
    return found


def _runs(holds: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of every run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], holds, [False]]).astype(np.int8)))
    return [(int(first), int(behind) - 1) for first, behind in edges.reshape(-1, 2)]
