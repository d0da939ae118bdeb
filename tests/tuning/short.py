"""A tuning that takes seconds: the controller that compiles soonest, flights of 20 s, a dozen candidates."""

from __future__ import annotations

from pathlib import Path

TEXT = """rvjax: 1
name: short-tuning
samples: 416
seed: 5
horizon: {duration_s: 20, step_s: 0.1}
target: {rate_deg_s: [0.23, -0.34, 0.17], port_m: [5, 0, 0]}
pursuer: {mass_kg: {uniform: [80, 120]}, inertia_kgm2: {principal: [22, 20, 23]}}
start: {rho_m: {box: 1}, sigma: {box: 0.1}}
actuators: {upper: {force: 4, torque: 0.8}, lower: {force: 3, torque: 0.6}}
faults: [{use: effectiveness, onset_s: {uniform: [2, 8]}, remaining: {uniform: [0.5, 1]}}]
controller: {use: pd-plus}
capture: {position_m: 0.5, attitude_mrp: 0.05, window_s: 2}
require:
  - {metric: captured, at_least: 0.5}
tune:
  parameters:
    controller.gains.k_rho: {log: [0.02, 0.5]}
    controller.gains.k_nu: {log: [0.1, 3]}
    x: {linear: [0.5, 2]}
    controller.gains.k_sigma: {product: [x, 0.2]}
  objective: {metric: settling_time_s, quantile: 0.8}
  method: {use: cma-es, population: 6}
  budget: {candidates: 18}
  samples: 64
  race: {first: 16, hard: 4}
  confirm: {samples: 208}
"""


def write(folder: Path, *changes: tuple[str, str]) -> Path:
    """The campaign in a folder, with some of its text replaced."""
    text = TEXT
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = folder / "tuning.yaml"
    path.write_text(text)
    return path
