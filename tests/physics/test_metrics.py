"""Every metric, folded inside the flight, against a plain NumPy computation from the full trace of the same flight."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy.integrate import trapezoid
from scipy.spatial.transform import Rotation

from rvjax.columns import CHANNELS
from rvjax.simulation.closed_loop import Drawn
from tests import flights
from tests.flights import Recorder
from tests.oracles.absolute import columns

STEP_S, DURATION_S, ONSET_S, WINDOW_S = 0.05, 150.0, 50.0, 30.0

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def flown(levant: Recorder) -> tuple[Drawn, flights.Record]:
    """Four lanes that differ in what they meet: tubes held, left, never reached; actuators that saturate or do not."""
    numbers = flights.gains("saturated-adaptive")
    drawn = flights.draw(numbers, DURATION_S, STEP_S, ONSET_S, WINDOW_S)
    context = drawn.context._replace(tube_m=np.array([0.1, 1e-6, 0.5, 30.0]), tube_mrp=np.array([1e-2, 2e-3, 1e-9, 0.9]))
    weak = np.array([1.0, 1.0, 0.3, 0.3])
    plant = drawn.plant._replace(upper=drawn.plant.upper * weak, lower=drawn.plant.lower * weak)
    drawn = drawn._replace(context=context, plant=plant)
    return drawn, levant(drawn, 1)


def settling(t: Array, outside: Array) -> float:
    """The first instant from which nothing is outside; infinite if the last instant is."""
    if not outside.any():
        return 0.0
    last = int(np.flatnonzero(outside)[-1])
    return np.inf if last == len(t) - 1 else float(t[last + 1])


def longest_time(on: Array, weights: Array) -> float:
    """The longest stretch of instants in which `on` holds, by their weights."""
    best = now = 0.0
    for held, weight in zip(on, weights, strict=True):
        now = now + weight if held else 0.0
        best = max(best, now)
    return best


def brute_force(trace: pd.DataFrame, drawn: Drawn, lane: int) -> dict[str, float]:
    """Every metric from the rows of one trace, by its definition."""
    context, plant = flights.lane(drawn.context, lane), flights.lane(drawn.plant, lane)
    t = trace["t_s"].to_numpy()
    weights = np.full(len(t), STEP_S)
    weights[[0, -1]] *= 0.5
    rho, nu, sigma, omega = (columns(trace, name) for name in ("rho_*_m", "nu_*_m_s", "sigma_*", "omega_*_rad_s"))
    attitude = Rotation.from_mrp(sigma)
    position, turned = np.linalg.norm(rho, axis=1), np.degrees(attitude.magnitude())
    outside = position > context.tube_m, np.linalg.norm(sigma, axis=1) > context.tube_mrp
    settled = [settling(t, out) for out in outside]
    closing = t >= DURATION_S - WINDOW_S - 1e-9
    found = {
        "captured": float(not (outside[0] | outside[1])[closing].any()),
        "settling_time_s": settled[0],
        "attitude_settling_time_s": settled[1],
        "fault_recovery_s": max(max(settled) - ONSET_S, 0.0),
        "peak_chi": float(np.abs(columns(trace, "ctl.chi_*", CHANNELS)).max()),
        "peak_estimate_drift": float(trace["ctl.drift"].max()),
    }
    errors = {
        "position_error_m": position,
        "attitude_error_deg": turned,
        "velocity_error_m_s": np.linalg.norm(nu, axis=1),
        "rate_error_deg_s": np.degrees(np.linalg.norm(omega, axis=1)),
    }
    for name, error in errors.items():
        found[f"final_{name}"], found[f"window_{name}"] = float(error[-1]), float(error[closing].max())

    commanded, v = columns(trace, "cmd_*", CHANNELS), columns(trace, "ctl.v_*", CHANNELS)
    limits = np.where(commanded >= 0, np.array(plant.upper.parts()), np.array(plant.lower.parts()))
    on = np.abs(commanded) >= 0.99 * limits
    per_channel = {
        "saturation_duty": weights @ on / DURATION_S,
        "longest_saturated_s": np.array([longest_time(on[:, i], weights) for i in range(6)]),
        "saturation_depth": (np.abs(v) / limits).max(axis=0),
    }
    for name, values in per_channel.items():
        found |= {f"{name}.{channel}": float(x) for channel, x in zip(CHANNELS, values, strict=True)}
        found[f"{name}.any"] = float(values.max())

    applied = columns(trace, "applied_*", CHANNELS)
    found["thrust_impulse_Ns"] = float(trapezoid(np.abs(applied[:, :3]).sum(axis=1), t))
    found["delta_v_m_s"] = found["thrust_impulse_Ns"] / float(plant.mass)
    found["angular_impulse_Nms"] = float(trapezoid(np.linalg.norm(applied[:, 3:], axis=1), t))
    from_port = attitude.apply(rho)
    found["closest_approach_m"] = float(np.linalg.norm(from_port + np.array(plant.port.parts()), axis=1).min())
    angle = np.arccos(np.clip(from_port @ np.array(context.axis.parts()) / position, -1.0, 1.0))
    found["corridor_violation_s"] = float(weights @ ((angle > np.radians(10.0)) & (position > context.tube_m)))
    return found


@pytest.mark.parametrize("lane", range(flights.LANES))
def test_folds_agree_with_the_trace(flown: tuple[Drawn, flights.Record], lane: int) -> None:
    """Kills: a wrong quadrature weight, a tube or window off by a step, a limit of the wrong side, Rᵀρ for Rρ in the corridor."""
    drawn, record = flown
    expected = brute_force(record.traces[lane], drawn, lane)
    assert set(record.values) == set(expected), "every metric has its definition here"
    for name, value in expected.items():
        assert float(record.values[name][lane]) == pytest.approx(value, rel=1e-9, abs=1e-9), name


def test_the_lanes_meet_everything(flown: tuple[Drawn, flights.Record]) -> None:
    """What the comparison rests on: captured and not, settled at once and never, saturated and not."""
    values = flown[1].values
    assert values["captured"].tolist() == [1.0, 0.0, 0.0, 1.0]
    assert np.isinf(values["settling_time_s"][1])
    assert values["settling_time_s"][3] == 0.0
    assert values["saturation_duty.any"][:2].max() == 0.0
    assert values["saturation_duty.any"][2:].min() > 0.0
    assert values["corridor_violation_s"].max() > 10.0


def test_every_metric_has_a_column() -> None:
    """Names, units and meanings for the table: what a metric gives is what it declares."""
    declared = [name for metric in flights.METRICS for name in metric.columns]
    assert len(declared) == len(set(declared))
    assert all(column.unit and column.description for metric in flights.METRICS for column in metric.columns.values())
