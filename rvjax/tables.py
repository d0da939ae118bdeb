"""Flights as tables: the samples table, the envelope table and the trace table of a run folder.

Flights ─columns→ Table
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.batch import Flown
from rvjax.campaign import Problem
from rvjax.columns import CHANNELS, Column
from rvjax.draw import Draws
from rvjax.signals import recorded, thrusts, unit_of
from rvjax.state import Step

OUTCOME_TIME = Column("outcome_time_s", "s", "when the outcome was decided: last settling time, loss, or end of the flight")
ENVELOPE = {
    column.name: column
    for column in (
        Column("t_s", "s", "time"),
        Column("rho_m", "m", "position error |rho|"),
        Column("nu_m_s", "m/s", "velocity error |nu|"),
        Column("sigma", "1", "attitude error |sigma|, modified Rodrigues parameters"),
        Column("omega_rad_s", "rad/s", "angular rate relative to the target |omega|"),
        *(Column(f"cmd_{name}", unit_of(name), f"commanded wrench, channel {name}") for name in CHANNELS),
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
    first = steps[0]
    shape = first.motion.rho.x.shape  # the time is that of all samples
    found = recorded(signals, first.report.signals, measured, len(thrusts(first)))
    data = {
        name: np.array([np.broadcast_to(signal.get(step), shape)[position] for step in steps]) for name, signal in found.items()
    }
    return pd.DataFrame(data), {name: signal.column for name, signal in found.items()}
