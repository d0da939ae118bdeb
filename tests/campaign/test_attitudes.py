"""Attitudes and angular rates in the notations that people have, against SciPy's rotations."""

from __future__ import annotations

import json
import math
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ruamel.yaml import YAML
from scipy.spatial.transform import Rotation

from rvjax.campaign import load, parse
from rvjax.campaign.attitudes import read_attitude
from rvjax.components.manual import campaign_schema
from rvjax.physics.vectors import Vector, rotation
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load as problem
from tests.short import CAMPAIGN

FIELDS = ("start.sigma", "target.attitude_mrp")
TURNS = [
    Rotation.from_rotvec(np.array(axis) * angle)
    for angle in (0.0, 1e-3, 1.0, 3.0, math.pi - 1e-9, 4.0)
    for axis in ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.6, 0.0, 0.8), (0.36, -0.48, 0.8))
]


def sigma(given: Any, field: str = "start.sigma") -> np.ndarray:
    """The MRP of a notation."""
    section, name = field.split(".")
    quantity = getattr(getattr(load(CAMPAIGN, [f"{field}={given}"]), section), name)
    return np.array([part.low for part in quantity.parts])


def refusal(*given: str) -> str:
    """The findings of a campaign with other values."""
    return "\n".join(map(str, parse(CAMPAIGN, given)[1]))


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("turn", TURNS)
def test_a_quaternion_is_its_mrp(turn: Rotation, sign: float, field: str) -> None:
    """SciPy's MRP of the shorter turn, in both orders, q and −q alike. Kills: the scalar part at the other end, the sign of q_0
    lost (the longer turn), 2 atan for 4 atan."""
    q = sign * turn.as_quat()
    expected = turn.as_mrp()
    for given in ({"scalar_last": q.tolist()}, {"scalar_first": np.roll(q, 1).tolist()}):
        found = sigma({"quaternion": given}, field)
        np.testing.assert_allclose(found, expected, atol=1e-12)
        assert np.linalg.norm(found) <= 1.0


@pytest.mark.parametrize("axis", [[1, 0, 0], [0.6, 0, -0.8], [0.48, 0.64, 0.6], [-1 / 3, 2 / 3, 2 / 3]])
def test_half_a_turn_has_norm_one(axis: list[float]) -> None:
    """Kills: a norm above 1 after rounding, which the range refuses."""
    found = sigma({"quaternion": {"scalar_last": [*axis, 0]}})
    np.testing.assert_allclose(found, axis, atol=1e-12)


def test_no_half_turn_has_a_norm_above_one() -> None:
    """2,000 axes, of which rounding lengthens many. Kills: |σ| that is above 1 by the last bit."""
    axes = np.random.default_rng(1).normal(size=(2_000, 3))
    for axis in (axes / np.linalg.norm(axes, axis=1)[:, None]).tolist():
        found = read_attitude({"quaternion": {"scalar_last": [*axis, 0]}})
        assert found is not None
        assert math.hypot(*found) <= 1.0


@pytest.mark.parametrize("angles", list(product((-170.0, 0.0, 35.0), (-89.0, 0.0, 50.0), (-20.0, 179.0))))
def test_euler_angles_are_3_2_1(angles: tuple[float, float, float]) -> None:
    """Intrinsic z, y, x. Kills: another sequence, fixed axes for moving axes, radians for degrees."""
    expected = Rotation.from_euler("ZYX", angles, degrees=True)
    found = Rotation.from_mrp(sigma({"yaw_pitch_roll_deg": list(angles)}))
    assert (found * expected.inv()).magnitude() < 1e-12


@pytest.mark.parametrize("turn", TURNS[4:12])
def test_the_flight_turns_the_same_way(turn: Rotation) -> None:
    """The direction cosine matrix of the flight resolves a vector in the turned frame: the transpose of SciPy's matrix.

    Kills: a quaternion that is read as the inverse turn."""
    matrix = rotation(Vector(*sigma({"quaternion": {"scalar_last": turn.as_quat().tolist()}})))
    rows = np.array([row.parts() for row in (matrix.a, matrix.b, matrix.c)])
    np.testing.assert_allclose(rows, turn.as_matrix().T, atol=1e-6)  # JAX in single precision


def test_a_quaternion_near_the_unit_sphere_is_normalised() -> None:
    """Within 1e-6. Kills: a tolerance on the square, MRP of the numbers as they stand."""
    for norm in (1.0 - 9e-7, 1.0 + 9e-7):
        np.testing.assert_allclose(
            sigma({"quaternion": {"scalar_first": [0.8 * norm, 0.6 * norm, 0, 0]}}), [1 / 3, 0, 0], atol=1e-15
        )
    for norm in (1.0 - 1.1e-6, 1.0 + 1.1e-6):
        given = {"quaternion": {"scalar_last": [0, 0, 0.6 * norm, 0.8 * norm]}}
        assert f"start.sigma.quaternion.scalar_last: the norm of the quaternion is {norm:.9g}; accepted: 1 within 1e-06" in (
            refusal(f"start.sigma={given}")
        )


@pytest.mark.parametrize(
    ("given", "place", "words"),
    [
        ("[0, 0, 0, 1]", "", "found a list of 4; accepted: a list of 3 (MRP), or a quaternion as {quaternion: {scalar_last:"),
        ("{quaternion: [0, 0, 0, 1]}", ".quaternion", "found a list of 4; accepted: the order of the numbers"),
        ("{quaternion: {scalar_last: [0, 0, 1]}}", ".quaternion.scalar_last", "accepted: 4 plain numbers [x, y, z, w]"),
        ("{quaternion: {scalar_first: [1, 0, 0, a]}}", ".quaternion.scalar_first.3", "accepted: 4 plain numbers [w, x, y, z]"),
        ("{quaternion: {scalar_last: [0, 0, 0, 0]}}", ".quaternion.scalar_last", "the norm of the quaternion is 0"),
        ("{yaw_pitch_roll_deg: 5}", ".yaw_pitch_roll_deg", "found 5; accepted: 3 plain numbers [yaw, pitch, roll] in deg"),
        ("{yaw_pitch_roll_deg: [{uniform: [0, 1]}, 0, 0]}", ".yaw_pitch_roll_deg.0", "(3-2-1)"),
        ("{quaternion: {scalar_last: [0, 0, 0, 1]}, yaw_pitch_roll_deg: [0, 0, 0]}", "", "accepted: either quaternion or"),
    ],
)
@pytest.mark.parametrize("field", FIELDS)
def test_a_mistake_says_what_is_accepted(given: str, place: str, words: str, field: str) -> None:
    """Kills: four numbers whose order is guessed, a mistake without its place."""
    found = refusal(f"{field}={given}")
    assert f": {field}{place}: " in found
    assert words in found


@pytest.mark.parametrize("place", ["start.nu_m_s", "target.port_m", "start.omega_rad_s"])
def test_only_an_attitude_takes_attitudes(place: str) -> None:
    """Kills: angles that are read as metres."""
    assert "yaw_pitch_roll_deg" in refusal(f"{place}={{yaw_pitch_roll_deg: [1, 2, 3]}}")


@pytest.mark.parametrize(
    ("degrees", "radians"),
    [
        (
            "start: {rho_m: 1, omega_deg_s: [90, 0, {uniform: [-180, 45]}]}",
            "start: {rho_m: 1, omega_rad_s: [P/2, 0, {uniform: [-P, P/4]}]}",
        ),
        ("target: {rate_deg_s: {ball: 180}}", "target: {rate_rad_s: {ball: P}}"),
    ],
)
def test_rates_in_degrees_and_radians(degrees: str, radians: str) -> None:
    """The same draws under the same SI names. Kills: a factor that is not π/180 or is applied twice."""
    for part in ("/2", "/4", ""):
        radians = radians.replace(f"P{part}", str(math.pi / float(part[1:] or 1)))
    values = [Draws.of(problem(CAMPAIGN, [text.replace(": ", "=", 1)]), np.arange(5))[0].values for text in (degrees, radians)]
    assert values[0].keys() == values[1].keys()
    for name, numbers in values[0].items():
        np.testing.assert_allclose(numbers, values[1][name], rtol=1e-14, err_msg=name)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            "start={rho_m: 1, omega_deg_s: 1, omega_rad_s: 1}",
            "start.omega_deg_s: both omega_deg_s and omega_rad_s; accepted: one",
        ),
        ("target={rate_deg_s: 1, rate_rad_s: 1}", "target.rate_rad_s: both rate_rad_s and rate_deg_s; accepted: one of them"),
        (
            "start={rho_m: 1, omega_deg_s: {uniform: [0, a]}}",
            "start.omega_deg_s.uniform.1: found the text 'a'; accepted: a number in deg/s",
        ),
        (
            "start={rho_m: 1, omega_rpm: 1}",
            "start.omega_rpm: unknown key; accepted: omega_rad_s (radians per second) or omega_deg_s",
        ),
    ],
)
def test_a_rate_has_one_key(given: str, words: str) -> None:
    """Kills: two units of which the last wins, a problem at the key that the campaign does not have."""
    assert words in refusal(given)


def test_the_example_of_the_documents_is_accepted() -> None:
    """Kills: an example that is out of date."""
    text = (Path(__file__).parents[2] / "docs" / "campaigns.md").read_text().partition("## Attitudes and angular rates")[2]
    example = YAML(typ="safe").load(text.partition("```yaml")[2].partition("```")[0])
    assert problem(CAMPAIGN, [f"{key}={json.dumps(value)}" for key, value in example.items()])


def test_the_schema_has_the_notations() -> None:
    """Kills: a notation that editors mark as wrong, an attitude where none is accepted, two keys of a rate at once."""
    definitions = campaign_schema()["$defs"]
    start, target = definitions["Start"], definitions["Target"]
    words = ("scalar_last", "scalar_first", "yaw_pitch_roll_deg")
    for held, key in ((start, "sigma"), (target, "attitude_mrp")):
        assert all(word in json.dumps(held["properties"][key]) for word in words)
    assert not any(word in json.dumps(start["properties"]["nu_m_s"]) for word in words)
    assert {"omega_rad_s", "omega_deg_s"} <= start["properties"].keys()
    assert {"rate_rad_s", "rate_deg_s"} <= target["properties"].keys()
    assert {"not": {"required": ["omega_rad_s", "omega_deg_s"]}} in start["allOf"]
    for body in (definitions["Pursuer"], target):
        forms = body["properties"]["inertia_kgm2"]["anyOf"]
        assert [form["required"] for form in forms if "matrix" in form.get("properties", {})] == [["matrix"]]
    products = definitions["MatrixInertia"]["properties"]["products"]
    assert [form["required"] for form in products["anyOf"] if "xy" in form.get("properties", {})] == [["yz", "xz", "xy"]]
