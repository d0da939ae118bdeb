"""Guesses, bounds and gains of the controllers follow the nominal body of the campaign, unless the campaign gives them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.stats

from rvjax.campaign.nominal_body import NominalBody
from rvjax.components.registry import component, members
from rvjax.components.settings import default
from rvjax.errors import CampaignError
from rvjax.execution.run import run
from rvjax.run_folder import RunFolder
from rvjax.simulation.problem import Problem, load
from tests.short import CAMPAIGN, SHORT

HEAVY_KG = 15_334.0
MASS = {"k2_force", "c_force", "gamma_bound", "gamma_mass", "mass_guess_kg", "mass_min_kg", "mass_max_kg"}
INERTIA = {
    *("k2_torque", "c_torque", "gamma_inertia", "inertia_guess_kgm2"),
    *("moment_min_kgm2", "moment_max_kgm2", "product_max_kgm2"),
}
"""Gains in kg, N·s/m or N/m, and in kg·m², N·m·s or N·m: by their units, written down here and not read from the program."""


def gains(problem: Problem) -> dict[str, float]:
    """The gains of the controller that flies."""
    parts = {name: quantity.parts[0] for name, quantity in problem.controller.quantities.items()}
    assert all(part.low == part.high for part in parts.values())
    return {name.removeprefix("gains."): part.low for name, part in parts.items()}


def flown_with(controller: str, *overrides: str) -> dict[str, float]:
    """The gains of a controller in the quickstart campaign."""
    return gains(load(CAMPAIGN, [f"controller={{use: {controller}}}", *overrides]))


@pytest.mark.parametrize("controller", members("controllers"))
def test_a_law_is_scaled_to_the_plant_that_it_flies(controller: str) -> None:
    """Kills: a guess, bound or gain that stays at 100 kg; mass and inertia exchanged."""
    heavy = flown_with(controller, f"pursuer.mass_kg={HEAVY_KG}", "pursuer.inertia_kgm2={principal: [1000, 1200, 1700]}")
    for name, usual in flown_with(controller).items():
        factor = HEAVY_KG / 100.0 if name in MASS else 1300.0 / (65.0 / 3.0) if name in INERTIA else 1.0
        assert heavy[name] == pytest.approx(usual * factor, rel=1e-11), name


@pytest.mark.parametrize("controller", ["pd-plus", "sliding-mode", "disturbance-observer"])
def test_the_guess_of_a_heavy_body_is_its_mass(controller: str) -> None:
    """Kills: a guess of 100 kg for 15,334 kg."""
    assert flown_with(controller, f"pursuer.mass_kg={HEAVY_KG}")["mass_guess_kg"] == HEAVY_KG


@pytest.mark.parametrize("controller", members("controllers"))
def test_the_tuned_numbers_stay_for_the_body_that_they_were_tuned_for(controller: str) -> None:
    """Kills: a default that is moved by rounding, or by another reference body. Exact: the results of campaigns depend on it."""
    defaults = component("controllers", controller).parameters().gains
    assert flown_with(controller) == {name: getattr(defaults, name).parts[0].low for name in type(defaults).model_fields}


def test_what_the_campaign_gives_stays() -> None:
    """Kills: a given number that is scaled or replaced."""
    heavy = f"pursuer.mass_kg={HEAVY_KG}"
    given = flown_with("sliding-mode", "controller.gains={mass_guess_kg: 12000}", heavy)
    assert given["mass_guess_kg"] == 12000.0
    bounds = flown_with("anti-windup", "controller.gains={mass_max_kg: 20000, k2_force: 7}", heavy)
    assert (bounds["mass_max_kg"], bounds["k2_force"], bounds["mass_guess_kg"]) == (20000.0, 7.0, pytest.approx(10_733.8))


def test_a_given_start_outside_the_bounds_of_this_body_is_refused() -> None:
    """Kills: bounds that are checked at 100 kg and flown at 15,334 kg. The message names the bounds of this body."""
    heavy = f"pursuer.mass_kg={HEAVY_KG}"
    assert flown_with("anti-windup", "controller.gains={mass_guess_kg: 15000}", heavy)["mass_guess_kg"] == 15000.0
    with pytest.raises(CampaignError, match=r"starts outside its bounds; accepted: from 3066.8 to 46002 in every draw"):
        flown_with("anti-windup", "controller.gains={mass_guess_kg: 100}", heavy)
    with pytest.raises(CampaignError) as refused:  # another mistake elsewhere does not bring the bounds of 100 kg back
        flown_with("anti-windup", "controller.gains={mass_guess_kg: 15000}", heavy, "samples=0")
    assert "outside its bounds" not in str(refused.value)


@pytest.mark.parametrize(
    ("law", "median"),
    [
        ("93", 93.0),
        ("{uniform: [80, 120]}", 100.0),
        ("{log_uniform: [50, 200]}", 100.0),
        ("{triangular: [80, 90, 140]}", scipy.stats.triang(c=1 / 6, loc=80, scale=60).median()),
        ("{truncated_normal: [100, 10, 95, 150]}", scipy.stats.truncnorm(-0.5, 5, loc=100, scale=10).median()),
        ("{beta: [2, 5, 80, 120]}", scipy.stats.beta(2, 5, loc=80, scale=40).median()),
        ("{choice: [80, 120]}", 100.0),
        ("{choice: {values: [80, 120], weights: [3, 1]}}", 80.0),
        ("{choice: [80, 90, 130]}", 90.0),
    ],
)
def test_the_nominal_mass_is_the_median_of_its_law(law: str, median: float) -> None:
    """Kills: the mean, the middle of the range, one side of a step."""
    problem = load(CAMPAIGN, [f"pursuer.mass_kg={law}"])
    assert NominalBody.of(problem.spec.pursuer).mass == pytest.approx(median, rel=1e-8)


@pytest.mark.parametrize(
    "inertia",
    ["{principal: [20, 22, 30]}", "{principal: [20, 22, 30], tilt_deg: 40}", "{principal: [20, 22, 30], rotation: uniform}"],
)
def test_the_nominal_inertia_is_about_the_centre_of_mass(inertia: str) -> None:
    """Kills: Steiner's term with the wrong sign or factor; a sum without its third. Against J of point masses."""
    given = ["pursuer.mass_kg=100", f"pursuer.inertia_kgm2={inertia}", "pursuer.centre_of_mass_m=[0.1, -0.05, 0.02]"]
    centre = np.array([0.1, -0.05, 0.02])
    about_centre = np.diag([20.0, 22.0, 30.0]) - 100.0 * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    body = NominalBody.of(load(CAMPAIGN, given).spec.pursuer)
    assert body.inertia == pytest.approx(np.linalg.eigvalsh(about_centre).mean(), rel=1e-11)


def test_identity_holds_the_resolved_guesses_and_structure_does_not() -> None:
    """Kills: a fingerprint of the guesses as written. Written and resolved guesses of the same value are the same flights."""
    heavy, pd_plus = f"pursuer.mass_kg={HEAVY_KG}", "controller={use: pd-plus}"
    resolved, usual = load(CAMPAIGN, [pd_plus, heavy]), load(CAMPAIGN, [pd_plus])
    written = load(CAMPAIGN, [pd_plus, heavy, f"controller.gains={{mass_guess_kg: {HEAVY_KG}}}"])
    other = load(CAMPAIGN, [pd_plus, heavy, "controller.gains={mass_guess_kg: 100}"])
    assert resolved.fingerprint == written.fingerprint
    assert other.fingerprint != resolved.fingerprint
    assert resolved.structure == usual.structure == other.structure


def test_a_candidate_of_a_search_starts_from_the_resolved_gain() -> None:
    """Kills: a search that starts from, or is tied to, the gain of 100 kg; a comparison of two campaigns that shows it."""
    problem = load(CAMPAIGN, [f"pursuer.mass_kg={HEAVY_KG}"])
    assert default(problem.spec, "controller.gains.k2_force") == pytest.approx(40.0 * HEAVY_KG / 100.0)


C = 153.34
SCALED = (
    f"pursuer.mass_kg={{uniform: [{80 * C}, {120 * C}]}}",
    f"pursuer.inertia_kgm2.moments=[{{uniform: [{17.6 * C}, {26.4 * C}]}}, {{uniform: [{16 * C}, {24 * C}]}}, "
    f"{{uniform: [{18.4 * C}, {27.6 * C}]}}]",
    f"pursuer.inertia_kgm2.products={{box: {0.5 * C}}}",
    f"actuators.upper={{force: {4 * C}, torque: {0.8 * C}}}",
    f"actuators.lower={{force: {3 * C}, torque: {0.6 * C}}}",
    f"disturbances.sinusoid.force_N={{uniform: [0, {0.02 * C}]}}",
    f"disturbances.sinusoid.torque_Nm={{uniform: [0, {0.005 * C}]}}",
)


@pytest.mark.usefixtures("bare")
@pytest.mark.parametrize("controller", ["saturated-adaptive", "pd-plus"])
def test_a_scaled_plant_makes_the_same_motion(controller: str, tmp_path: Path, full: bool) -> None:
    """Newton and Euler are linear in mass and inertia: c times the body, the actuators and the disturbances is the same motion,
    and forces are c times as large. 15,334 kg fly like 100 kg. Kills: a gain, rate or bound in N, N·m, kg or kg·m² that is not
    scaled."""
    if controller == "pd-plus" and not full:
        pytest.skip("the law with a gain of every kind by default; the other one with --long")
    sets = [*SHORT, "samples=8", f"controller={{use: {controller}}}", "audit={allow: [pursuer, faults, disturbances, actuators]}"]
    usual, scaled = (
        RunFolder.open(run(CAMPAIGN, tmp_path / name, [*sets, *more])).samples().frame
        for name, more in (("1", ()), ("c", SCALED))
    )
    names = [name for name in usual.columns if name.startswith("metric.")]
    assert len(names) > 20
    for name in names:
        factor = C if "impulse" in name or "torque" in name else 1.0
        np.testing.assert_allclose(scaled[name], usual[name] * factor, rtol=1e-6, atol=1e-12, err_msg=name)
