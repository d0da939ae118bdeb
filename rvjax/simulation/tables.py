"""Flights as tables: the samples table, the envelope table and the trace table of a run folder.

Flights ─columns→ Table
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import jax
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.columns import CHANNELS, Column, draw_column, metric_column
from rvjax.components.effects.interface import Effect
from rvjax.components.metrics.collision import COLLISION_TIME
from rvjax.components.metrics.interface import Metric
from rvjax.physics.state import Path, Step, Tank
from rvjax.physics.vectors import Channels
from rvjax.simulation.batch import Flown
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem
from rvjax.simulation.signals import MEAN_WRENCH, recorded, thrusts, unit_of

OUTCOME_TIME = Column(
    "outcome_time_s", "s", "when the outcome was decided: last settling time, collision, loss, or end of the flight"
)
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
    """A row per sample: outcome, draws and metrics. rows: which of the flown samples.

    Outcomes. captured: both tubes hold over the closing window. collided: the distance of the hulls was not certainly positive at
    some time; the metrics are NaN (captured: 0), except those of safety. not_finite: the state stopped being finite before; the
    metrics are NaN (captured: 0). not_settled: all other flights.
    """
    results = outcomes(flown, problem.spec.horizon.duration_s, problem.metrics)
    frame = pd.DataFrame(
        {"sample": draws.samples[rows], **{name: results[name][rows] for name in ("outcome", OUTCOME_TIME.name)}}
        | {draw_column(name): array[rows] for name, array in draws.values.items()}
        | {metric_column(name): results[metric_column(name)][rows] for name in problem.metric_columns}
    )
    columns = {OUTCOME_TIME.name: OUTCOME_TIME} | {draw_column(name): column for name, column in draws.columns.items()}
    return frame, columns | {metric_column(name): column for name, column in problem.metric_columns.items()}


def outcomes(flown: Flown, duration_s: float | NDArray[np.float64], metrics: Sequence[Metric]) -> dict[str, NDArray[Any]]:
    """The outcomes and metrics of `samples_table`, of every lane."""
    values, finite = flown.values, np.isinf(flown.lost_s)
    collision = values.get(COLLISION_TIME.name, np.full_like(flown.lost_s, np.inf))
    collided = collision <= np.minimum(flown.lost_s, np.finfo(float).max)
    captured = values["captured"] > 0.5
    settled = np.maximum(values["settling_time_s"], values["attitude_settling_time_s"])
    ends = {  # the first that holds
        "collided": (collided, collision),
        "not_finite": (~finite, flown.lost_s),
        "captured": (captured, settled),
        "not_settled": (np.full_like(finite, True), np.zeros_like(collision) + duration_s),
    }
    holds, times = zip(*ends.values(), strict=True)
    stays = {name for metric in metrics if metric.safety for name in metric.columns}
    lost = {name: 0.0 if name == "captured" else np.nan for name in values}
    flies = {name: np.where(collided, name in stays, finite) for name in values}
    outcome = np.array([*ends])[np.argmax(holds, axis=0)]
    return {"outcome": outcome, OUTCOME_TIME.name: np.select(holds, times)} | {
        metric_column(name): np.where(flies[name], array, lost[name]) for name, array in values.items()
    }


def envelope_table(flown: Flown, times: NDArray[np.float64], samples: NDArray[np.int64], rows: slice) -> pd.DataFrame:
    """A row per sample and instant, sample by sample; columns: `ENVELOPE`."""
    stacked = {
        "rho_m": [point.rho for point in flown.envelope],
        "nu_m_s": [point.nu for point in flown.envelope],
        "sigma": [point.sigma for point in flown.envelope],
        "omega_rad_s": [point.omega for point in flown.envelope],
    } | {f"cmd_{name}": [point.commanded.parts()[i] for point in flown.envelope] for i, name in enumerate(CHANNELS)}
    kept = samples[rows]
    columns = {name: np.stack(series)[:, rows].T.ravel() for name, series in stacked.items()}
    return pd.DataFrame({"sample": np.repeat(kept, len(times)), "t_s": np.tile(times, len(kept))} | columns)


def trace_tables(
    steps: Sequence[Step],
    signals: Mapping[str, Column],
    measured: bool,
    effects: Mapping[str, Effect] | None = None,
    means: Sequence[Channels] = (),
    interrupted: Sequence[str] = (),
) -> tuple[list[pd.DataFrame], dict[str, Column]]:
    """For every traced sample a row per observed step, in SI; frames as in `rvjax.physics.state`.

    signals: of the controller. measured: include the measured motion. effects: of the campaign, by name. means: the mean
    wrench from each row to the next. interrupted: as in `signals.recorded`.
    """
    (samples,) = steps[0].motion.rho.x.shape
    flat: Step = jax.tree.map(lambda *each: np.concatenate(each), *steps)
    moving = {name: (effect, flat.effects[index]) for index, (name, effect) in enumerate((effects or {}).items())}
    burning, guided = isinstance(flat.tank, Tank), isinstance(flat.path, Path)
    columns = recorded(signals, flat.report.signals, measured, len(thrusts(flat)), moving, burning, interrupted, guided)
    rows = len(steps) * samples
    data = {name: np.broadcast_to(signal.get(flat), rows).reshape(len(steps), samples) for name, signal in columns.items()}
    none = Channels.of((np.full(samples, np.nan),) * len(CHANNELS))
    wrench = jax.tree.map(lambda *each: np.stack(each), *means, none)
    data |= dict(zip(MEAN_WRENCH, wrench.parts(), strict=True))
    frames = [pd.DataFrame({name: values[:, place] for name, values in data.items()}) for place in range(samples)]
    return frames, {name: signal.column for name, signal in columns.items()} | dict(MEAN_WRENCH)
