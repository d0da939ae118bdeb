"""Flights as tables: the samples table, the envelope table and the trace table of a run folder.

Flights ─columns→ Table
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from operator import attrgetter
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.algebra import Channels, Symmetric, Thrusts, Vector
from rvjax.batch import Flown
from rvjax.campaign import Problem
from rvjax.columns import AXES, CHANNELS, Column
from rvjax.controllers.interface import WRENCH
from rvjax.draw import Draws
from rvjax.state import Step


def _channel_unit(channel: str) -> str:
    return "N" if channel[0] == "f" else "N·m"


OUTCOME_TIME = Column("outcome_time_s", "s", "when the outcome was decided: last settling time, loss, or end of the flight")
ENVELOPE = {
    column.name: column
    for column in (
        Column("t_s", "s", "time"),
        Column("rho_m", "m", "position error |rho|"),
        Column("nu_m_s", "m/s", "velocity error |nu|"),
        Column("sigma", "1", "attitude error |sigma|, modified Rodrigues parameters"),
        Column("omega_rad_s", "rad/s", "angular rate relative to the target |omega|"),
        *(Column(f"cmd_{name}", _channel_unit(name), f"commanded wrench, channel {name}") for name in CHANNELS),
    )
}


def samples_table(problem: Problem, draws: Draws, flown: Flown, rows: slice) -> tuple[pd.DataFrame, dict[str, Column]]:
    """One row per sample: outcome, draws and metrics; rows: which samples of the flown ones.

    captured: both tubes held over the closing window. not_finite: a number of the state stopped being finite; its metrics are
    NaN (captured: 0). not_settled: everything else.
    """
    values = {name: array[rows] for name, array in flown.values.items()}
    lost = flown.lost_s[rows]
    finite, captured = np.isinf(lost), values["captured"] > 0.5
    outcome = np.where(finite, np.where(captured, "captured", "not_settled"), "not_finite")
    settled = np.maximum(values["settling_time_s"], values["attitude_settling_time_s"])
    time = np.where(finite, np.where(captured, settled, problem.spec.horizon.duration_s), lost)
    metrics = {name: np.where(finite, array, 0.0 if name == "captured" else np.nan) for name, array in values.items()}
    frame = pd.DataFrame(
        {"sample": draws.samples[rows], "outcome": outcome, OUTCOME_TIME.name: time}
        | {f"draw.{name}": array[rows] for name, array in draws.values.items()}
        | {f"metric.{name}": metrics[name] for name in problem.metric_columns}
    )
    columns = {OUTCOME_TIME.name: OUTCOME_TIME} | {f"draw.{name}": column for name, column in draws.columns.items()}
    return frame, columns | {f"metric.{name}": column for name, column in problem.metric_columns.items()}


def envelope_table(flown: Flown, times: NDArray[np.float64], samples: NDArray[np.int64], rows: slice) -> pd.DataFrame:
    """One row per sample and instant, sample by sample; columns: `ENVELOPE`."""
    stacked = {
        "rho_m": [g.rho for g in flown.glances],
        "nu_m_s": [g.nu for g in flown.glances],
        "sigma": [g.sigma for g in flown.glances],
        "omega_rad_s": [g.omega for g in flown.glances],
    } | {f"cmd_{name}": [g.commanded.parts()[i] for g in flown.glances] for i, name in enumerate(CHANNELS)}
    kept = samples[rows]
    columns = {name: np.stack(series)[:, rows].T.ravel() for name, series in stacked.items()}
    return pd.DataFrame({"sample": np.repeat(kept, len(times)), "t_s": np.tile(times, len(kept))} | columns)


def trace_table(
    steps: list[Step], position: int, signals: Mapping[str, Column], measured: bool
) -> tuple[pd.DataFrame, dict[str, Column]]:
    """One row per observed step of one traced sample, everything in SI; frames as in `rvjax.state`.

    signals: the controller's. measured: with the motion as it is measured beside the true one.
    """
    columns: dict[str, Column] = {}
    data: dict[str, NDArray[np.float64]] = {}
    for column, series in _series(steps, signals, measured):
        columns[column.name] = column
        data[column.name] = np.array([values[position] for values in series])
    return pd.DataFrame(data), columns


def _series(steps: list[Step], signals: Mapping[str, Column], measured: bool) -> Iterator[tuple[Column, list[Any]]]:
    first = steps[0]
    yield Column("t_s", "s", "time"), [np.broadcast_to(step.t, step.motion.rho.x.shape) for step in steps]
    vectors = {
        "rho_{}_m": ("m", "pursuer minus docking point, in P", "rho", "motion.rho"),
        "nu_{}_m_s": ("m/s", "difference of inertial velocities, in P", "nu", "motion.nu"),
        "sigma_{}": ("1", "modified Rodrigues parameters of P with respect to T", "sigma", "motion.sigma"),
        "omega_{}_rad_s": ("rad/s", "angular velocity of P relative to T, in P", "omega", "motion.omega"),
        "target_r_{}_m": ("m", "inertial position of the target, resolved in T", "r_t", "target.r"),
        "target_v_{}_m_s": ("m/s", "inertial velocity of the target, resolved in T", "v_t", "target.v"),
        "target_w_{}_rad_s": ("rad/s", "inertial angular velocity of the target, in T", "w_t", "target.w"),
    }
    if measured:
        vectors |= {
            f"seen_{form}": (unit, f"as measured, {text}", symbol, place.replace("motion", "seen"))
            for form, (unit, text, symbol, place) in vectors.items()
            if place.startswith("motion")
        }
    for form, (unit, text, symbol, place) in vectors.items():
        for i, axis in enumerate(AXES):
            yield Column(form.format(axis), unit, f"{symbol}: {text}"), [attrgetter(place)(step).parts()[i] for step in steps]
    wrenches: Mapping[str, tuple[str, Any]] = {
        "cmd": ("commanded wrench h(v), in P", lambda s: s.commanded),
        "applied": ("wrench behind the faults, before the disturbance, in P", lambda s: s.applied),
        "dist": ("disturbance wrench, in P", lambda s: s.disturbance),
        "ctl.v": ("command v before the saturation", lambda s: s.command),
        "ctl.chi": ("Nussbaum argument", lambda s: s.report.chi),
    }
    for form, (text, get) in wrenches.items():
        for i, channel in enumerate(CHANNELS):
            unit = "1" if form == "ctl.chi" else _channel_unit(channel)
            yield Column(f"{form}_{channel}", unit, text), [get(step).parts()[i] for step in steps]
    for i in range(len(_thrusts(first))):
        yield Column(f"thrust_t{i + 1}_N", "N", f"thrust of t{i + 1} behind the faults"), [_thrusts(s)[i] for s in steps]
    for name, meaning in signals.items():
        for suffix in _named_parts(first.report.signals[name]):
            unit = _channel_unit(suffix[1:]) if meaning.unit == WRENCH else meaning.unit
            column = Column(f"ctl.{name}{suffix}", unit, f"{meaning.description}, a signal of the controller")
            yield column, [_named_parts(step.report.signals[name])[suffix] for step in steps]


def _thrusts(step: Step) -> tuple[Any, ...]:
    return step.thrusts.parts() if isinstance(step.thrusts, Thrusts) else ()


def _named_parts(value: Any) -> dict[str, Any]:
    names = {Vector: AXES, Channels: CHANNELS, Symmetric: ("xx", "yy", "zz", "yz", "xz", "xy")}.get(type(value))
    return {"": value} if names is None else {f"_{name}": part for name, part in zip(names, value.parts(), strict=True)}
