"""The section `tune`: what it refuses, and how points become campaigns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rvjax.campaign.tuning_parameters import Levels, Linear, Log
from rvjax.components.settings import setting
from rvjax.errors import CampaignError
from rvjax.search.tuning.space import Space
from rvjax.search.tuning.tune import prepare
from rvjax.simulation.problem import load
from tests.short import CAMPAIGN, SHIPPED, SHORT
from tests.spec.corpus import bad_files, check_refused

BAD = bad_files(Path(__file__).parent / "bad")
PARAMETERS = (
    "controller.gains.k1: {log: [0.03, 0.3]}, controller.gains.k_sigma: {product: [x, controller.gains.k3, 0.1]}, "
    "x: {linear: [1, 2]}, horizon.step_s: {choice: [0.05, 0.1]}, controller.nussbaum: {choice: [exp-cos, none]}, "
    "pursuer.mass_kg: {integer: [90, 110]}"
)
TUNE = f"tune={{parameters: {{{PARAMETERS}}}, objective: {{metric: delta_v_m_s, mean: true}}}}"


@pytest.mark.parametrize("path", BAD, ids=[path.stem for path in BAD])
def test_bad_file(path: Path) -> None:
    check_refused(path, prepare)


def test_all_mistakes_come_at_once() -> None:
    """Kills: the first mistake only; a section that is wrong but hides what else is wrong with the campaign."""
    said = (
        TUNE.replace("k1: {log: [0.03", "k1: {log: [-1")
        .replace("delta_v_m_s", "delta_v")
        .replace("{linear: [1, 2]}", "{linear: [1, 1]}")
    )
    with pytest.raises(CampaignError) as caught:
        prepare(CAMPAIGN, [said, "samples=0"])
    assert {"samples", "tune.parameters.controller.gains.k1.log", "tune.parameters.x.linear", "tune.objective.metric"} <= {
        finding.path for finding in caught.value.findings
    }
    with pytest.raises(CampaignError, match="there is nothing to tune"):
        prepare(CAMPAIGN)


@pytest.mark.parametrize(
    "form", [Linear(-2.0, 3.0), Log(1e-4, 1e3), Levels(tuple(range(-3, 9)), True), Levels(("a", True, 1), False)]
)
@given(u=st.floats(0.0, 1.0))
def test_values_and_coordinates_are_inverse(form: Linear | Log | Levels, u: float) -> None:
    """To four digits, and inside of the range. Kills: rounding that leaves the range, true that is taken for 1."""
    value = form.value(u)
    back = form.coordinate(value)
    assert back is not None
    assert 0.0 <= back <= 1.0
    assert form.value(back) == value
    if isinstance(form, Linear | Log):
        assert abs(back - u) < 1e-3
        assert form.coordinate(form.high * 1.001) is None


def test_a_candidate_is_the_campaign_with_its_values() -> None:
    """Kills: a tie that is not followed, a value that is not the one that is written, a start that is not the campaign's."""
    space, _ = Space.of(CAMPAIGN, [*SHORT, TUNE])
    assert list(space.free) == ["controller.gains.k1", "x", "horizon.step_s", "controller.nussbaum", "pursuer.mass_kg"]
    assert space.fixed == {"controller.gains.k3": 8.0}
    assert space.original == {
        "controller.gains.k1": 0.1,
        "controller.gains.k_sigma": 0.4,
        "horizon.step_s": 0.05,
        "controller.nussbaum": "exp-cos",
    }
    assert space.start == pytest.approx([np.log(0.1 / 0.03) / np.log(10), 0.5, 0.25, 0.25, 0.5])
    values = space.values(np.array([0.5, 0.5, 0.9, 0.9, 1.0]))
    assert values == {
        "controller.gains.k1": 0.09487,
        "controller.gains.k_sigma": pytest.approx(1.2),
        "x": 1.5,
        "horizon.step_s": 0.1,
        "controller.nussbaum": "none",
        "pursuer.mass_kg": 110,
    }
    sets = [
        "controller.gains.k1=0.09487",
        "controller.gains.k_sigma=1.2",
        "horizon.step_s=0.1",
        "controller.nussbaum=none",
        "pursuer.mass_kg=110",
    ]
    assert space.load(values).fingerprint == load(CAMPAIGN, [*SHORT, *sets]).fingerprint


@pytest.mark.parametrize(
    ("place", "value"),
    [
        ("pursuer.mass_kg", None),
        ("target.orbit.semi_major_axis_km", 6878),
        ("corridor.half_angle_deg", 10.0),
        ("capture.window_s", 5),
        ("controller.gains.v_max_m_s", 0.6),
        ("controller.nussbaum", "exp-cos"),
        ("faults.bias.onset_s", None),
        ("nothing.at_all", None),
        ("controller.gains", None),
    ],
)
def test_what_a_campaign_has_at_a_place(place: str, value: object) -> None:
    """Said or by default, in the unit of the key. Kills: radians for degrees."""
    found = setting(load(CAMPAIGN, SHORT).spec, place)
    assert found == (value if not isinstance(value, float) else pytest.approx(value))


def test_programs_are_told_apart_by_functions_not_by_numbers() -> None:
    """Kills: a compile for each candidate; one program for two controllers."""
    same = load(CAMPAIGN, SHORT).structure
    for numbers in (
        ["controller.gains.k1=0.1"],
        ["pursuer.mass_kg=90"],
        ["horizon.step_s=0.1"],
        ["seed=4"],
        ["start.rho_m=[1,2,3]"],
    ):
        assert load(CAMPAIGN, [*SHORT, *numbers]).structure == same
    for functions in (
        ["controller.nussbaum=none"],
        ["controller.shaped=false"],
        ["faults=[]"],
        ["horizon.control_period_s=0.2"],
        ["saturation={use: hard-clip}"],
        ["pursuer.propellant={mass_kg: 2, specific_impulse_s: 220}"],
    ):
        assert load(CAMPAIGN, [*SHORT, *functions]).structure != same
    burning = {
        load(CAMPAIGN, [*SHORT, f"pursuer.propellant={{mass_kg: {mass}, specific_impulse_s: 220{more}}}"]).structure
        for mass in (2, 3)
        for more in ("", ", torque_arm_m: 0.5")
    }
    assert len(burning) == 2


@pytest.mark.parametrize("path", sorted((SHIPPED / "tuning").glob("*.yaml")), ids=lambda path: path.stem)
def test_the_campaigns_that_come_with_it_can_be_tuned(path: Path) -> None:
    """Kills: a campaign of ours that nobody has read since it was edited. The one with the results is flown as it is."""
    if path.stem == "bakeoff":
        assert len(load(path).spec.baselines) == 6
    else:
        _, tuning, _, _ = prepare(path)
        assert tuning.budget.candidates == 200
