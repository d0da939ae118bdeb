"""Warnings about what can fly but is hardly meant: each with its place, its numbers, and what would be right."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from rvjax.run_folder import RunFolder
from rvjax.simulation.plausibility import warnings
from rvjax.simulation.problem import load
from tests.program import Run
from tests.short import CAMPAIGN, SHIPPED, SHORT

HEAVY = "pursuer={mass_kg: 15334, inertia_kgm2: {principal: [3000, 3300, 3700]}}"
STRONG = "actuators={upper: {force: 613, torque: 123}, lower: {force: 460, torque: 92}}"


def found(*overrides: str) -> list[str]:
    """The warnings of the quickstart campaign with these values, without their places."""
    return [f"{finding.path}: {finding.found}; {finding.accepted}" for finding in warnings(load(CAMPAIGN, overrides))]


def test_no_shipped_campaign_is_warned_about() -> None:
    """Kills: a threshold that meets a campaign which flies as meant."""
    for file in sorted(SHIPPED.rglob("*.yaml")):
        assert not warnings(load(file)), file.name


def test_a_heavy_body_with_its_actuators_is_as_meant() -> None:
    """Kills: a check against 100 kg instead of the nominal body."""
    assert not found(HEAVY, STRONG)


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (
            [HEAVY, STRONG, "controller={use: pd-plus, gains: {mass_guess_kg: 100}}"],
            "controller.gains.mass_guess_kg: the guess is 100 kg, 0.00652 times the nominal mass of the pursuer; "
            "right would be about 15334 kg, which is the default",
        ),
        (
            ["controller={use: sliding-mode, gains: {inertia_guess_kgm2: 21700}}"],
            "controller.gains.inertia_guess_kgm2: the guess is 21700 kg·m², 1e+03 times the nominal inertia of the pursuer; "
            "right would be about 21.6667 kg·m², which is the default",
        ),
        (
            ["pursuer.mass_kg={choice: [80, 120]}", "samples=8", "controller={use: anti-windup, gains: {mass_max_kg: 110}}"],
            "controller.gains.mass_max_kg: the estimate stays from 20 to 110 kg, but the mass of {outside} of the first 8 "
            "samples are outside: from 80 to 120 kg; right would be mass_max_kg of at least 120",
        ),
        (
            ["pursuer.inertia_kgm2={principal: [1, 20, 20.5]}", "controller.use=nominal-backstepping"],
            "controller.gains.moment_min_kgm2: the estimate stays from 1.91538 to 38.3077 kg·m², but the moments of inertia of "
            "416 of the first 416 samples are outside: from 1 to 20.5 kg·m²; right would be moment_min_kgm2 of at most 1",
        ),
        (
            ["pursuer.inertia_kgm2={moments: [20, 22, 23], products: [0, 0, -6]}"],
            "controller.gains.product_max_kgm2: the estimate stays from -5 to 5 kg·m², but the products of inertia of 416 of the "
            "first 416 samples are outside: from -6 to 0 kg·m²; right would be product_max_kgm2 of at least 6",
        ),
        (
            ["disturbances=[{use: constant, force_N: [0, -2, 0]}]"],
            "controller.gains.bound_share: the estimated bound of the force ends at 1.75 N, but constant is above it in 416 of "
            "the first 416 samples: up to 2 N; right would be a bound_share of at least 0.572",
        ),
        (
            ["disturbances=[{use: constant, torque_Nm: [0, -0.7, 0]}]", "controller={use: pd-plus}"],
            "disturbances.0.torque_Nm: the torque reaches 0.7 N·m on an axis, in 416 of the first 416 samples more than the "
            "actuators can give; right would be at most 0.6 N·m, or stronger actuators",
        ),
        (
            [HEAVY],
            "controller.gains.k1: the approach brakes with up to 0.0195 m/s², but 3 N give 15334 kg only 0.000196 m/s²: it "
            "arrives too fast to stop; right would be k1 times v_max_m_s of at most 0.000602 m/s², or stronger actuators",
        ),
        (
            ["guidance={use: corridor, acceleration: 0.1}"],
            "guidance.acceleration: the reference point speeds up with 0.1 m/s², but 3 N give 100 kg only 0.03 m/s²; right would "
            "be at most 0.03 m/s²",
        ),
        (
            ["guidance={use: corridor, far_speed_m_s: 1, slope: 0.04}"],
            "guidance.far_speed_m_s: the reference point flies 0.5 m/s at most: from 1 m/s it could not brake in time; right "
            "would be 0.5 m/s, a smaller slope or a larger acceleration",
        ),
        (
            ["guidance={use: waypoints, points: [{frame: port, at_m: [6, 0, 8], speed_m_s: 0.1}]}"],
            "guidance.points.0: the last waypoint is 10 m from the docking point: no sample is captured; right would be {frame: "
            "port, at_m: [0, 0, 0], …}, unless holding is what is studied",
        ),
        (
            ["guidance={use: waypoints, points: [{frame: lvlh, at_m: [0, 0, 0], speed_m_s: 0.1}]}"],
            "guidance.points.0: the last waypoint is fixed in LVLH: no sample is captured; right would be {frame: port, "
            "at_m: [0, 0, 0], …}, unless holding is what is studied",
        ),
        (
            ["pursuer.mass_kg=100000", "controller={use: pd-plus}"],
            "pursuer.inertia_kgm2: 100000 kg with a mean moment of 21.67 kg·m² are as dense as a ball of 0.0233 m with 1.89e+09 "
            "kg/m³; right would be 0.01 to 22,600 kg/m³; masses are in kg, moments of inertia in kg·m²",
        ),
        (
            ["actuators={use: thrusters, layout: cube-24, size_m: 1000, max_N: 1.2}"],
            "actuators.size_m: the thrusters are up to 866 m from the reference point, but the inertia is that of a ball with a "
            "radius of 0.736 m; right would be 0.0736 to 7.36 m; places are in m",
        ),
    ],
)
def test_a_warning_names_the_numbers_and_what_would_be_right(overrides: list[str], words: str) -> None:
    """Kills: a check that is missing, a bound of the wrong side, a number of another quantity."""
    both = [text for text in found(*overrides) if words.partition(":")[0] in text]
    outside = next((text.partition("the mass of ")[2].partition(" ")[0] for text in both), "")
    assert both == [words.replace("{outside}", outside)]


def test_the_samples_outside_of_the_bounds_are_those_that_fly() -> None:
    """Kills: a count over other samples than the campaign's, or over channels instead of samples."""
    given = ["controller={use: anti-windup, gains: {mass_max_kg: 110}}", "samples=40"]
    (warning,) = found(*given)
    from rvjax.simulation.draws import Draws

    draws, _ = Draws.of(load(CAMPAIGN, given), np.arange(40, dtype=np.int64))
    assert f"the mass of {int((draws.values['pursuer.mass_kg'] > 110.0).sum())} of the first 40" in warning


@pytest.mark.parametrize(
    ("guess", "warned"), [(50.0, False), (49.9, True), (200.0, False), (200.1, True), ("{uniform: [80, 120]}", False)]
)
def test_a_guess_may_be_half_or_twice_the_nominal_mass(guess: object, warned: bool) -> None:
    """Kills: another factor; a check of one side; a drawn guess that is read at one of its ends."""
    assert bool(found(f"controller={{use: pd-plus, gains: {{mass_guess_kg: {guess}}}}}")) == warned


def test_what_is_switched_off_is_not_warned_about() -> None:
    """Kills: bounds of an estimate that does not move."""
    low = "controller={use: saturated-adaptive, adapt_parameters: false, gains: {mass_max_kg: 110}}"
    assert not found(low)
    assert not found("disturbances=[{use: constant, force_N: 2}]", "controller={use: saturated-adaptive, adapt_bound: false}")


def test_the_deceleration_is_that_of_the_approach() -> None:
    """Kills: another factor than 3√3/16. Against the profile on a fine grid."""
    k1, speed = 0.1, 0.6
    rho = np.linspace(0.0, 60.0, 600_001)
    profile = k1 * rho / np.sqrt(1.0 + (k1 * rho / speed) ** 2)
    steepest = float((profile * np.gradient(profile, rho)).max())
    limit = 5.0 * 3.0 / steepest  # kg that 3 N brake with a fifth of it
    body = "pursuer.inertia_kgm2={{principal: [{0}, {0}, {0}]}}"
    for share, warned in ((0.999, False), (1.001, True)):
        mass = share * limit
        given = [f"pursuer.mass_kg={mass}", body.format(mass / 4.0)]
        assert any("brakes" in text for text in found(*given)) == warned


HULLS = ["target.port_m=[5, 0, 0]", "start={frame: port, position_m: [20, 0, 0]}", "target.hull={radius_m: 3.4}"]


def test_docked_hulls_are_farther_apart_than_the_capture_radius() -> None:
    """A captured pursuer may be capture.position_m off the docked place, toward the target too. Its hull ends 1.5 m before the
    port. Kills: no check, twice the radius, the distance at the start, a hull from the reference point."""
    given = [*HULLS, "pursuer.hull={radius_m: 1.5, centre_m: [-0.1, 0, 0]}", "pursuer.centre_of_mass_m=[-0.1, 0, 0]"]
    assert not found(*given, "capture.position_m=0.1")
    assert found(*given, "capture.position_m=0.11") == [
        "capture.position_m: docked, at rho 0 and sigma 0, the hulls are 0.1 m apart, nearer than the capture radius of 0.11 m, "
        "in 416 of the first 416 samples: a captured pursuer can touch the target; right would be at most 0.1 m, smaller hulls, "
        "or a target.port_m farther out"
    ]
    drawn = found(*HULLS[:2], "target.hull={radius_m: {choice: [3.4, 3]}}", *given[3:], "capture.position_m=0.2", "samples=40")
    assert " of the first 40 samples" in drawn[0]
    assert "in 40 of" not in drawn[0]


@pytest.mark.parametrize("kind", ["pd-plus", "anti-windup"])
def test_density_of_a_ball(kind: str) -> None:
    """Kills: 2/5 for 5/2, a radius without its root. A ball of osmium is accepted, a slightly denser one is not."""
    for density, warned in ((22_500.0, False), (22_700.0, True), (0.0101, False), (0.0099, True)):
        mass = density * 4.0 / 3.0 * math.pi
        given = [f"pursuer.mass_kg={mass}", f"pursuer.inertia_kgm2={{principal: [{0.4 * mass}, {0.4 * mass}, {0.4 * mass}]}}"]
        assert any("dense" in text for text in found(f"controller={{use: {kind}}}", *given)) == warned


def test_validate_names_file_line_and_column(rvjax: Run, tmp_path: Path) -> None:
    """Kills: a warning without a place, on stdout, or missing in the document; an exit code that a warning changes."""
    file = tmp_path / "heavy.yaml"
    text = CAMPAIGN.read_text().replace("{use: saturated-adaptive}", "{use: pd-plus, gains: {mass_guess_kg: 1}}")
    file.write_text(text + "baselines:\n  - {use: sliding-mode, gains: {mass_guess_kg: 1000}}\n")
    line = next(number for number, words in enumerate(text.split("\n"), 1) if "mass_guess_kg" in words)
    column = text.split("\n")[line - 1].index("1}") + 1
    code, out, err = rvjax("validate", file)
    one = f"warning: {file}:{line}:{column}: controller.gains.mass_guess_kg: the guess is 1 kg, 0.01 times"
    two = "baselines.0.gains.mass_guess_kg: the guess is 1000 kg, 10 times"
    assert code == 0
    assert "warning" not in out
    first, second = err.splitlines()
    assert first.startswith(one)
    assert two in second
    _, out, _ = rvjax("validate", file, "--json")
    assert [item["path"] for item in json.loads(out)[str(file)]["warnings"]] == [
        "controller.gains.mass_guess_kg",
        "baselines.0.gains.mass_guess_kg",
    ]


@pytest.mark.usefixtures("bare")
def test_a_run_warns_and_its_report_repeats_it(rvjax: Run, tmp_path: Path) -> None:
    """Kills: a run that is silent, or quiet, about it; a folder that forgets it; an identity that depends on the words."""
    sets = [part for value in (*SHORT, "samples=8", "require=[]") for part in ("--set", value)]
    sets += ["--set", "controller={use: pd-plus, gains: {mass_guess_kg: 10}}", "--quiet"]
    code, _, err = rvjax("run", CAMPAIGN, *sets, "--out", tmp_path / "run")
    words = "controller.gains.mass_guess_kg: the guess is 10 kg, 0.1 times the nominal mass of the pursuer"
    assert code == 0
    assert err.count(words) == 1
    folder = RunFolder.open(tmp_path / "run")
    assert [words in text for text in folder.provenance["warnings"]] == [True]
    assert words not in json.dumps(folder.identity)
    assert "the guess is 10 kg, 0.1 times" in (tmp_path / "run" / "report.html").read_text()
    assert "the guess is 10 kg, 0.1 times" in (tmp_path / "run" / "report.md").read_text()
