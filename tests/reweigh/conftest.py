"""A run to be reweighed."""

from __future__ import annotations

from pathlib import Path

import pytest

from rvjax.execution.run import run
from tests.once import made_once

CAMPAIGN = """rvjax: 1
name: reweighed
samples: 1248
seed: 5
horizon: {duration_s: 20, step_s: 0.1}
target: {port_m: [5, 0, 0]}
pursuer:
  mass_kg: {truncated_normal: [100, 5, 70, 130]}
  inertia_kgm2: {principal: [22, 20, {uniform: [19, 24]}]}
start: {rho_m: [2, 0, 0], nu_m_s: {ball: 0.2}, sigma: {uniform: [-0.05, 0.05]}}
actuators: {upper: {force: 4, torque: 0.8}, lower: {force: 3, torque: 0.6}, spread: {uniform: [0.9, 1.1]}}
faults:
  - {use: effectiveness, channels: [fx], onset_s: {uniform: [2, 8]}, remaining: {uniform: [0, 1]}}
  - {use: bias, name: some, channels: all, onset_s: {uniform: [2, 8]}, share: 0.001, schedule: {count: 1}}
navigation: [{use: noise, position_m: 0.001}]
correlate:
  - {variables: [pursuer.mass_kg, pursuer.inertia_kgm2.principal.z], rank: [[1, 0.5], [0.5, 1]]}
controller: {use: pd-plus, gains: {k_rho: 0.05, k_nu: 0.5}}
capture: {position_m: 4.6, attitude_mrp: 0.5, window_s: 2}
require:
  - {metric: delta_v_m_s, below: 0.5, at_least: 0.5}
  - {metric: delta_v_m_s, below: 0.5, at_least: 0.5, where: {"faults.effectiveness.remaining.fx": {below: 0.5}}}
"""


def flown(factory: pytest.TempPathFactory, name: str, campaign: str) -> Path:
    """The run folder of a campaign, flown once for all workers."""

    def make(path: Path) -> None:
        path.mkdir()
        (path / f"{name}.yaml").write_text(campaign)
        run(path / f"{name}.yaml", path / "run", progress=False)

    return made_once(factory, name, make) / "run"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return flown(tmp_path_factory, "reweighed", CAMPAIGN)
