"""Contact conditions: against the trace of the same flights in plain NumPy, and against flights that are known by hand."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rvjax.analysis.verdicts.compliance import RequirementEvaluator
from rvjax.campaign import Requirement
from rvjax.columns import METRIC
from rvjax.simulation import problem
from rvjax.simulation.effect import refused
from tests.chosen import Array, Flight, flown, folded, step

CAMPAIGN = """
rvjax: 1
name: contact
samples: 4
seed: 7
horizon: {duration_s: 40, step_s: 0.05}
target: {orbit: {semi_major_axis_km: 7600, eccentricity: 0.1}, rate_deg_s: [0.8, -1.2, 0.9], port_m: [4, -2, 1.5]}
pursuer: {mass_kg: 100, inertia_kgm2: {moments: [22, 20, 23], products: [1, -2, 1.5]}}
start:
  rho_m: [{uniform: [3, 4]}, {uniform: [-1.5, -1]}, {uniform: [0.5, 1]}]
  nu_m_s: [-0.15, 0.05, 0.02]
  sigma: {box: 0.15}
  omega_rad_s: {box: 0.02}
actuators: {upper: 4, lower: 3}
controller: {use: pd-plus}
capture: {window_s: 5}
metrics:
  - {use: contact, distance_m: {uniform: [1, 2]}, radius_m: 5, interface_m: [-0.8, 0.4, -0.3]}
"""
INTERFACE = np.array([-0.8, 0.4, -0.3])
STEP_S = 0.05


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> Flight:
    """Four flights that come to the port fast enough to turn and slide at contact."""
    return flown(tmp_path_factory.mktemp("contact") / "campaign.yaml", CAMPAIGN, 4)


def of_the_trace(flight: Flight, lane: int) -> dict[str, float]:
    """The columns from the places and attitudes alone: speeds and rates are differences between neighbouring rows."""
    port = np.array([float(part[lane]) for part in flight.drawn.plant.port.parts()])
    axis = port / np.linalg.norm(port)
    distance = float(flight.drawn.context.chosen[0]["distance_m"][lane])
    turned = Rotation.from_mrp(flight.sigma[lane])  # P to T
    p = turned.apply(flight.rho[lane] + INTERFACE) - INTERFACE
    axial, across = p @ axis, np.linalg.norm(p - np.outer(p @ axis, axis), axis=1)
    last = int(np.flatnonzero((axial[:-1] > distance) & (axial[1:] <= distance))[0])
    share = (axial[last] - distance) / (axial[last] - axial[last + 1])

    def at(values: Array) -> float:
        return float(values[last] + share * (values[last + 1] - values[last]))

    speed = np.gradient(p, STEP_S, axis=0)
    rates = np.zeros_like(p)
    rates[1:-1] = (turned[2:] * turned[:-2].inv()).as_rotvec() / (2.0 * STEP_S)
    theirs = turned.apply(axis)
    swing = np.arccos(np.clip(theirs @ axis, -1.0, 1.0))
    hinge = np.cross(axis, theirs)
    back = Rotation.from_rotvec(-swing[:, None] * hinge / np.linalg.norm(hinge, axis=1)[:, None])
    return {
        "contact_time_s": float(flight.t[last] + share * STEP_S),
        "contact_lateral_m": at(across),
        "contact_closing_speed_m_s": at(-speed @ axis),
        "contact_lateral_speed_m_s": at(np.linalg.norm(speed - np.outer(speed @ axis, axis), axis=1)),
        "contact_pitch_yaw_deg": at(np.degrees(swing)),
        "contact_roll_deg": at(np.degrees((back * turned).magnitude())),
        "contact_pitch_yaw_rate_deg_s": at(np.degrees(np.linalg.norm(np.cross(axis, rates), axis=1))),
        "contact_roll_rate_deg_s": at(np.degrees(np.abs(rates @ axis))),
    }


@pytest.mark.parametrize("lane", range(4))
def test_contact_against_the_trace(flight: Flight, lane: int) -> None:
    """Kills: ω_t×ρ or ω×s left out, the interface turned the wrong way, speeds of the inertial frame, roll and pitch swapped,
    rates in the wrong frame, the step after the contact instead of the instant between."""
    expected = of_the_trace(flight, lane)
    for name, value in expected.items():
        assert float(flight.values[name][lane]) == pytest.approx(value, rel=2e-5, abs=1e-6), name
    assert expected["contact_pitch_yaw_deg"] > 0.5
    assert expected["contact_roll_deg"] > 1e-3
    assert expected["contact_lateral_speed_m_s"] > 1e-3


@cache
def line(points: tuple[tuple[float, float], ...], **said: Any) -> dict[str, float]:
    """The values on a way through these places (axial, lateral), a second apart, straight between them."""
    places = np.array(points)
    speeds = np.gradient(places, axis=0)
    steps = [step(float(t), (x, y, 0.0), nu=(u, v, 0.0)) for t, ((x, y), (u, v)) in enumerate(zip(places, speeds, strict=True))]
    return folded("contact", steps, **said)


def test_the_first_contact_from_outside_counts() -> None:
    """From behind the plane out, back too far from the axis, out, back near the axis at 7.25 s, out and back once more.

    Kills: a contact of who begins inside, of who leaves, one beyond the reach, the last one instead of the first.
    """
    way = ((-1, 0), (-0.2, 0), (1, 2), (-1, 2), (-1, 2), (1, 2), (1, 0.4), (0.55, 0.4), (-1.45, 0.2), (1, 0), (-1, 0), (-1, 0))
    values = line(way, distance_m=0.05, radius_m=0.5)
    assert values["contact_time_s"] == pytest.approx(7.25, abs=1e-12)
    assert values["contact_lateral_m"] == pytest.approx(0.35, abs=1e-12)


def test_without_contact_nothing_complies() -> None:
    """NaN complies neither with below nor with above, nor as something that seldom happens; the time is infinite.

    Kills: inf, with which "closing speed above 0.05 m/s" would hold without a contact; a start that counts as outside.
    """
    values = line(((-1, 0), (-0.5, 0), (-0.9, 0), (0.04, 0), (-2, 0)), distance_m=0.05)
    assert values.pop("contact_time_s") == np.inf
    assert len(values) == 7
    assert all(np.isnan(x) for x in values.values())
    for form in ({"below": 1e9, "at_least": 0.5}, {"above": -1e9, "at_least": 0.5}, {"above": 1e9, "at_most": 0.5}):
        evaluator = RequirementEvaluator(Requirement.model_validate({"metric": "contact_lateral_m", **form}))
        evaluator.columns([f"{METRIC}contact_lateral_m"])
        assert not evaluator.comply(np.array([np.nan])).any()


@pytest.mark.parametrize("angle", [0.3, 2.0, 3.0])
def test_pitch_and_roll_of_turns_about_one_axis(angle: float) -> None:
    """A turn about the docking axis is a roll alone, a turn across it no roll. Kills: half angles, degrees of radians twice."""
    for axis, names in (((1, 0, 0), ("roll", "pitch_yaw")), ((0, 0.6, 0.8), ("pitch_yaw", "roll"))):
        sigma = np.array(axis) * np.tan(angle / 4.0)
        into = Rotation.from_mrp(sigma).inv()  # T to P
        steps = [step(t, into.apply([1.0 - t, 0, 0]), sigma=sigma) for t in (0.0, 1.0, 2.0)]
        full = folded("contact", steps, distance_m=0.0, radius_m=9)
        assert full[f"contact_{names[0]}_deg"] == pytest.approx(np.degrees(angle), abs=1e-9)
        assert full[f"contact_{names[1]}_deg"] == pytest.approx(0.0, abs=1e-6)


def test_a_file_with_no_docking_axis_says_that_nothing_is_measured(tmp_path: Path) -> None:
    """Kills: a contact metric that reports NaN in every flight without a word."""
    file = tmp_path / "campaign.yaml"
    file.write_text(CAMPAIGN.replace("port_m: [4, -2, 1.5]", "port_m: 0"))
    assert ["metrics.contact does nothing" in finding.found for finding in refused(problem.load(file))] == [True]
    file.write_text(CAMPAIGN)
    assert not refused(problem.load(file))


def test_the_limits_in_the_manual_can_be_pasted(tmp_path: Path) -> None:
    """The block of requirements in docs/campaigns.md is accepted beside the metric, one for each limit. Kills: a column that was
    renamed, a key that does not exist."""
    page = (Path(__file__).parents[2] / "docs" / "campaigns.md").read_text(encoding="utf-8")
    block = page.partition("The limits of a docking mechanism")[2].partition("```yaml\n")[2].partition("```")[0]
    file = tmp_path / "campaign.yaml"
    file.write_text(CAMPAIGN.replace("samples: 4", "samples: 1000") + block, encoding="utf-8")
    campaign = problem.load(file)
    columns = {name for name in campaign.metric_columns if name.startswith("contact_")}
    assert len(campaign.spec.require) == 8
    assert {requirement.metric for requirement in campaign.spec.require} == columns - {"contact_time_s"}
