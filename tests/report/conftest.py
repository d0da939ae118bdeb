"""Run folders with made-up flights: the columns of real ones, plausible numbers, nothing flown."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from rvjax.analysis.run_totals import worst_first
from rvjax.report import build, figures
from rvjax.run_folder import Column, RunDescription, RunFolder
from tests.once import made_once

CHANNELS = ("fx", "fy", "fz", "tx", "ty", "tz")
DURATION = 300.0
REQUIRE = """
  - {metric: captured, at_least: 0.98, confidence: 0.95}
  - {metric: settling_time_s, quantile: 0.95, below: 150, confidence: 0.95}
  - {metric: saturation_duty, channel: any, quantile: 0.99, below: 0.2, confidence: 0.9}
"""
CAMPAIGN = """rvjax: 1
name: {name}
description: {description}
samples: {samples}
seed: 20181
horizon: {{duration_s: 300, step_s: 0.05}}
target: {{orbit: {{semi_major_axis_km: 6878}}, rate_deg_s: [0.23, -0.34, 0.17], port_m: [5, 0, 0]}}
pursuer: {{mass_kg: {{uniform: [80, 120]}}, inertia_kgm2: {{principal: [22, 20, 23]}}}}
start: {{rho_m: {{box: 20}}, sigma: {{box: 0.25}}, nu_m_s: {{box: 0.1}}, omega_rad_s: {{box: 0.01}}}}
actuators: {{upper: [4, 4, 4, 0.8, 0.8, 0.8], lower: [3, 3, 3, 0.6, 0.6, 0.6], spread: {{uniform: [0.9, 1.1]}}}}
faults: [{{use: effectiveness, channels: all, onset_s: {{uniform: [30, 150]}}, remaining: {{uniform: [0.5, 1.0]}}}}]
controller: {{use: saturated-adaptive}}
capture: {{position_m: 0.01, attitude_mrp: 0.002, window_s: 60}}
require: {require}
"""
_ERRORS = {
    "position_error_m": ("m", 5e-4, 0.5),
    "attitude_error_deg": ("deg", 0.02, 0.4),
    "velocity_error_m_s": ("m/s", 3e-5, 0.5),
    "rate_error_deg_s": ("deg/s", 1e-3, 0.4),
}


@contextmanager
def _svg_only() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(figures.FigureCanvasAgg, "print_png", lambda *given, **more: None)
        yield


@contextmanager
def _undrawn() -> Iterator[None]:
    empty = figures.Picture("<svg></svg>", "<svg></svg>", b"")
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(figures, "draw", lambda drawing, png=False: empty)
        yield


Within = Callable[[], AbstractContextManager[None]]


@pytest.fixture(scope="session")
def svg_only() -> Within:
    """`with svg_only():` figures as SVG alone, in half of the time: no PNG, and no layout, which comes with the PNG."""
    return _svg_only


@pytest.fixture(scope="session")
def undrawn() -> Within:
    """`with undrawn():` all sections, but their figures are not drawn, for tests of texts and numbers."""
    return _undrawn


@pytest.fixture(scope="session")
def made() -> Callable[..., Path]:
    """make(path, ...) → the path of a run folder."""
    return make


@pytest.fixture(scope="session")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A built report of 300 made-up samples, 9 not settled, 3 not finite, for all workers; nobody changes it."""
    return made_once(tmp_path_factory, "report", lambda path: build(make(path, 300, missing=12)))


def make(
    path: Path,
    samples: int = 60,
    shares: Sequence[float] = (0.96, 0.03, 0.01),
    *,
    require: str = REQUIRE,
    name: str = "made-up",
    description: str = "numbers that nobody has flown",
    kept: int = 20,
    missing: int = 0,
) -> Path:
    """Writes the folder. shares: captured, not settled, not finite; kept: in the envelopes; missing: not flown."""
    generator = np.random.Generator(np.random.Philox(key=5))
    draws, metrics, columns = _numbers(generator, samples)
    edges = np.floor(np.cumsum(shares) * samples + 1e-9)
    place = generator.permutation(samples)
    captured, lost = place < edges[0], place >= edges[1]
    failed = ~captured & ~lost
    metrics["metric.captured"] = captured.astype(float)
    metrics["metric.settling_time_s"] = np.where(failed, math.inf, metrics["metric.settling_time_s"])
    for error in ("metric.final_position_error_m", "metric.window_position_error_m"):
        metrics[error] = np.where(failed, 40 * metrics[error] ** 0.2, metrics[error])
    metrics["metric.peak_chi"] = np.where(failed, 1e3 * metrics["metric.peak_chi"], metrics["metric.peak_chi"])
    metrics = {key: np.where(lost, math.nan, values) for key, values in metrics.items()}
    frame = pd.DataFrame(
        {
            "sample": np.arange(samples),
            "outcome": np.select([captured, failed], ["captured", "not_settled"], "not_finite"),
            "outcome_time_s": np.where(lost, generator.uniform(20, 200, samples), DURATION),
            **draws,
            **metrics,
        }
    )
    text = CAMPAIGN.format(name=name, description=description, samples=samples + missing, require=require or "[]")
    identity = {"campaign": "0" * 64, "seed": 20181, "precision": "float64", "rvjax": "0.1.0", "device": "cpu"}
    provenance = {"started": "2026-11-22T18:00:00Z", "host": "made up"}
    requested = samples + missing
    description = RunDescription(identity=identity, provenance=provenance, campaign_text=text, samples=requested, name=name)
    with RunFolder.create(path, description) as folder:
        for chunk, first in enumerate(range(0, samples, 256)):
            folder.commit(chunk, frame.iloc[first : first + 256].reset_index(drop=True), columns)
        if kept:
            folder.write_envelope(0, *_histories(generator, frame.iloc[:kept]))
            for sample in worst_first(frame, columns)[:3]:
                folder.write_traces({sample: _trace(generator, frame.iloc[sample])})
    return path


def _numbers(
    generator: np.random.Generator, n: int
) -> tuple[dict[str, NDArray[np.float64]], dict[str, NDArray[np.float64]], dict[str, Column]]:
    """Draws, metrics, and the columns of both."""
    draws: dict[str, NDArray[np.float64]] = {}
    metrics: dict[str, NDArray[np.float64]] = {}
    columns = {"outcome_time_s": Column("outcome_time_s", "s", "when the outcome was decided")}

    def draw(path: str, unit: str, low: float, high: float) -> NDArray[np.float64]:
        draws[f"draw.{path}"] = generator.uniform(low, high, n)
        columns[f"draw.{path}"] = Column(f"draw.{path}", unit, "drawn")
        return draws[f"draw.{path}"]

    def metric(name: str, unit: str, values: NDArray[np.float64], better: str = "lower") -> None:
        metrics[f"metric.{name}"] = values
        columns[f"metric.{name}"] = Column(f"metric.{name}", unit, f"made-up {name.replace('_', ' ')}", better)

    draw("pursuer.mass_kg", "kg", 80, 120)
    rho = np.array([draw(f"start.rho_m.{axis}", "m", -20, 20) for axis in "xyz"])
    for axis in "xyz":
        draw(f"start.sigma.{axis}", "1", -0.25, 0.25)
    onset = np.array([draw(f"faults.effectiveness.onset_s.{c}", "s", 30, 150) for c in CHANNELS])
    left = np.array([draw(f"faults.effectiveness.remaining.{c}", "1", 0.5, 1.0) for c in CHANNELS])
    distance = np.linalg.norm(rho, axis=0)
    settling = 55 + 2.2 * distance + 20 * (1 - left[0]) + generator.gamma(2.0, 6.0, n)
    metric("captured", "1", np.ones(n), "higher")
    metric("settling_time_s", "s", settling)
    metric("attitude_settling_time_s", "s", 25 + generator.gamma(6.0, 3.0, n))
    metric("fault_recovery_s", "s", np.maximum(settling - onset.max(axis=0), 0))
    for prefix, factor in (("final", 1.0), ("window", 1.8)):
        for error, (unit, scale, spread) in _ERRORS.items():
            metric(f"{prefix}_{error}", unit, factor * scale * generator.lognormal(0, spread, n))
    saturation = (("saturation_duty", "1", 0.03), ("longest_saturated_s", "s", 6.0), ("saturation_depth", "1", 1.2))
    for name, unit, scale in saturation:
        base = generator.gamma(2.0, scale / 2, (6, n)) * np.where(np.arange(6)[:, None] < 3, 1.0, 0.4) * (2 - left)
        channels = np.where(base < 0.2 * scale, 0.0, base)
        for channel, values in zip(CHANNELS, channels, strict=True):
            metric(f"{name}.{channel}", unit, values)
        metric(f"{name}.any", unit, channels.max(axis=0))
    metric("delta_v_m_s", "m/s", generator.gamma(30, 0.08, n))
    metric("angular_impulse_Nms", "N·m·s", generator.gamma(20, 0.1, n))
    metric("peak_chi", "1", 0.2 + generator.gamma(3.0, 0.1, n))
    metric("peak_estimate_drift", "1", generator.gamma(3.0, 0.05, n))
    metric("closest_approach_m", "m", 4.9 + generator.normal(0, 0.02, n), "higher")
    metric("corridor_violation_s", "s", np.maximum(generator.normal(10, 15, n), 0))
    return draws, metrics, columns


def _flight(generator: np.random.Generator, row: pd.Series, t: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Norms and commanded wrench of one made-up flight; NaN after the outcome time of a flight that was lost."""
    rho0 = math.hypot(*(row[f"draw.start.rho_m.{axis}"] for axis in "xyz"))
    decay = np.exp(-t / 14) if row["outcome"] != "not_settled" else 0.5 + 0.5 * np.cos(t / 40) ** 2
    noise = generator.lognormal(0, 0.3, (4, t.size))
    values = {
        "rho_m": rho0 * decay + 5e-4 * noise[0],
        "sigma": 0.3 * np.exp(-t / 6) + 2e-5 * noise[1],
        "nu_m_s": 0.6 * decay + 3e-5 * noise[2],
        "omega_rad_s": 0.1 * np.exp(-t / 6) + 2e-5 * noise[3],
    }
    for index, channel in enumerate(CHANNELS):
        size = 4.0 if index < 3 else 0.8
        wave = decay * np.cos(t / 25 + generator.uniform(0, 6)) * 2 + 0.02 * generator.normal(0, 1, t.size)
        values[f"cmd_{channel}"] = size * np.where(wave > 0, np.tanh(wave), 0.75 * np.tanh(wave))
    lost = (row["outcome"] == "not_finite") & (t > row["outcome_time_s"])
    return {name: np.where(lost, math.nan, series) for name, series in values.items()}


def _histories(generator: np.random.Generator, rows: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, Column]]:
    t = np.linspace(0, DURATION, 121)
    flights = [(int(row["sample"]), _flight(generator, row, t)) for _, row in rows.iterrows()]
    parts = [pd.DataFrame({"sample": sample, "t_s": t} | values) for sample, values in flights]
    return _described(pd.concat(parts, ignore_index=True))


def _trace(generator: np.random.Generator, row: pd.Series) -> tuple[pd.DataFrame, dict[str, Column]]:
    """A kept flight, every vector along (0.6, 0, 0.8)."""
    t = np.linspace(0, DURATION, 601)
    values = _flight(generator, row, t)
    frame = {"t_s": t} | {name: series for name, series in values.items() if name.startswith("cmd_")}
    for stem, unit in (("rho", "_m"), ("sigma", ""), ("nu", "_m_s"), ("omega", "_rad_s")):
        for axis, part in (("x", 0.6), ("y", 0.0), ("z", 0.8)):
            frame[f"{stem}_{axis}{unit}"] = part * values[stem + unit]
    return _described(pd.DataFrame(frame))


def _described(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, Column]]:
    return frame, {name: Column(name, "", "made up") for name in frame.columns}
