"""What is refused before a flight because no flight could pass: starts in the keep-out zone, against starts tried one by one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Turn

from rvjax.errors import CampaignError
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem
from rvjax.simulation.scene_checks import _position, _starts, _turn
from rvjax.simulation.start_zone import Starts, Zone, forbidden
from tests.validated import validated

CAMPAIGN = """\
rvjax: 1
name: scene
samples: 10
horizon: {duration_s: 20, step_s: 0.05}
target: {port_m: [5, 0, 0], keep_out: {radii_m: [9, 30, 30]}}
pursuer: {mass_kg: 100, inertia_kgm2: {principal: [20, 21, 22]}}
start: {rho_m: [{uniform: [3, 20]}, {uniform: [-1, 1]}, 0]}
actuators: {upper: 4, lower: 3}
controller: {use: pd-plus}
capture: {window_s: 5}
"""


def scene(tmp_path: Path, *overrides: str) -> Problem:
    path = tmp_path / "scene.yaml"
    path.write_text(CAMPAIGN)
    return validated(path, overrides)


def in_zone_outside_cone(places: np.ndarray, rho: np.ndarray, zone: Zone, room: float) -> np.ndarray:
    """By angles. room: how far it must be from both surfaces, relatively."""
    q = rho + zone.axis * zone.apex
    angle = np.arccos(np.clip(q @ zone.axis / np.linalg.norm(q, axis=-1), -1.0, 1.0))
    return (np.sum((places / zone.radii) ** 2, axis=-1) < 1.0 - room) & (angle > np.arccos(zone.cosine) + room)


def test_a_forbidden_start_is_found_where_there_is_one() -> None:
    """300 boxes of starts, each with 20,000 starts tried. Kills: the largest for the smallest distance, a cone that is not convex
    in the check, a docking point that does not move, a part that is dropped."""
    generator = np.random.default_rng(3)
    found = 0
    for _ in range(300):
        axis = generator.normal(size=3)
        axis /= np.linalg.norm(axis)
        half = np.radians(generator.uniform(5.0, 60.0))
        radii = generator.uniform(2.0, 9.0, 3)
        zone = Zone(radii, axis, float(np.cos(half)), float(generator.choice([0.0, generator.uniform(0.0, 3.0)])), 0.01)
        port = axis * generator.uniform(1.0, 4.0)
        middle = axis * generator.uniform(2.0, 9.0) + generator.normal(size=3) * generator.uniform(0.0, 2.0)
        widths = generator.uniform(0.0, 6.0, 3) * generator.integers(0, 2, 3)
        by_rho = Turn.random(random_state=generator).as_matrix() * widths
        moved = generator.choice([0.0, 1.0]) * axis[:, None]
        starts = Starts(port + middle, middle, np.hstack([by_rho, moved]), np.hstack([by_rho, moved * 0.0]))
        u = generator.uniform(-0.5, 0.5, (20_000, 4))
        u[:16] = 0.5 * np.sign(u[:16])  # also corners
        bad = in_zone_outside_cone(starts.place + u @ starts.by_place.T, starts.rho + u @ starts.by_rho.T, zone, 1e-3)
        place = forbidden(starts, zone)
        assert place is not None or not bad.any()
        if place is not None:
            found += 1
            v, *_ = np.linalg.lstsq(starts.by_place, place - starts.place, rcond=None)
            assert np.all(np.abs(v) <= 0.5 + 1e-6) or moved.any()
            near = starts.rho + starts.by_rho @ v
            assert moved.any() or in_zone_outside_cone(place, near, zone, -1e-6)
    assert 30 < found < 270


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ((), "a start can lie inside the keep-out zone and outside of the approach cone, such as ["),
        (("corridor.radius_m=1",), ""),  # then the whole box is inside the cone
        (("corridor.radius_m=0.1",), "such as ["),
        (("target.keep_out.radii_m=7",), ""),  # then it lies outside of the zone
        (("start.sigma=[0, 0, 0.1]", "corridor.radius_m=1"), "such as ["),
        (("corridor.radius_m=1", "target.port_m=[{uniform: [4, 6]}, 0, 0]"), ""),
        (("corridor.radius_m=1", "target.port_m=[{uniform: [-6, 6]}, 0, 0]"), "such as ["),
        (("corridor.radius_m=1", "target.port_m=[5, {uniform: [-1, 1]}, 0]"), "such as ["),
        (
            ("start.rho_m={direction: 34.9}",),
            "the direction of the start in T is drawn, its distance from the docking point is 34.9 m",
        ),
        (("start.rho_m={direction: 35.1}",), ""),
        (("start.rho_m={ball: 40}",), "its distance from the docking point is 0 m"),
    ],
)
def test_starts_are_refused_or_not(tmp_path: Path, overrides: tuple[str, ...], words: str) -> None:
    """Kills: R for Rᵀ, a cone about an axis that is not certain, a bound of the distance that is not enough."""
    if not words:
        assert scene(tmp_path, *overrides).spec.target.keep_out is not None
        return
    with pytest.raises(CampaignError) as caught:
        scene(tmp_path, *overrides)
    (finding,) = caught.value.findings
    assert words in finding.found
    assert finding.path == "start.rho_m"


def test_hulls_are_apart_when_docked_and_at_the_start(tmp_path: Path) -> None:
    """To a centimetre, with a centre of mass and a hull that are not where the reference point is. Kills: the hull's centre from
    the reference point, the start in the place of the docked pose."""
    for size, met in ((3.39, False), (3.41, True)):  # the pursuer's centre of mass is at the port; its hull ends 1.6 m before it
        said = (
            "target.keep_out=null", f"target.hull={{radius_m: {size}}}",
            "pursuer.hull={radius_m: 1.5, centre_m: [-0.2, 0, 0]}", "pursuer.centre_of_mass_m=[-0.1, 0, 0]",
        )  # fmt: skip
        if not met:
            scene(tmp_path, *said)
            continue
        with pytest.raises(
            CampaignError, match=r"overlap docked, at rho 0 and sigma 0, in 10 of the first 10 samples, by up to 0\.01 m"
        ):
            scene(tmp_path, *said)
    with pytest.raises(CampaignError, match="overlap at the start in 10 of the first 10 samples"):
        scene(tmp_path, *said[:1], "target.hull={radius_m: 3}", *said[2:], "start.rho_m=[-1, 0, 0]")


FRAMED = "start={frame: %s, position_m: [{uniform: [%s, 20]}, {uniform: [-1, 1]}, 0]}"
ORBIT = "target.orbit={semi_major_axis_km: 7878, eccentricity: 0.1, true_anomaly_deg: 40}"


@pytest.mark.parametrize(
    ("said", "centred"),
    [
        (("start.sigma=[0.1, -0.2, 0.3]",), False),
        (("target.port_axis=[1, 2, -1]", FRAMED % ("port", 3)), False),
        ((ORBIT, "target.attitude_mrp=[0.2, 0.1, -0.3]", FRAMED % ("lvlh", 3)), True),
    ],
    ids=["pursuer", "port", "lvlh"],
)
def test_the_start_is_turned_as_it_flies(said: tuple[str, ...], centred: bool, tmp_path: Path) -> None:
    """The map of the check gives the places at which flights begin, by SciPy's rotation. Kills: R for Rᵀ, the axes of another
    frame, a docking point that is added to a place from the target's centre of mass, or left out of ρ."""
    problem = scene(tmp_path, "target.keep_out=null", "target.port_m=[5, {uniform: [-1, 1]}, 0]", *said)
    draws, drawn = Draws.of(problem, np.arange(10))
    place, position = _position(problem.spec.start)
    starts = _starts(position, problem.spec.target.port_m, _turn(problem.spec, drawn), centred)
    name = ".".join(map(str, place))
    u = [(draws.values[f"{name}.x"] - 11.5) / 17.0, draws.values[f"{name}.y"] / 2.0, draws.values["target.port_m.y"] / 2.0]
    rho = Turn.from_mrp(np.array(drawn.motion.sigma.parts()).T).apply(np.array(drawn.motion.rho.parts()).T)
    port = np.array(drawn.plant.port.parts()).T
    np.testing.assert_allclose(starts.rho + np.array(u).T @ starts.by_rho.T, rho, atol=1e-9)
    np.testing.assert_allclose(starts.place + np.array(u).T @ starts.by_place.T, rho + port, atol=1e-9)


UP = "start={frame: lvlh, position_m: [{uniform: [-1, 1]}, 0, {uniform: [-20, -%s]}]}"


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ((FRAMED % ("port", 6), "corridor.half_angle_deg=12"), ""),
        ((FRAMED % ("port", 3), "corridor.half_angle_deg=12"), "such as ["),
        ((FRAMED % ("port", 3), "target.port_axis=[0, 0, 1]", "corridor.half_angle_deg=80"), ""),
        ((FRAMED % ("lvlh", 11), "target.orbit={semi_major_axis_km: 6878}"), ""),
        ((FRAMED % ("lvlh", 9), "target.orbit={semi_major_axis_km: 6878}"), "such as ["),
        ((UP % 8, "target.orbit={semi_major_axis_km: 6878}", "corridor.half_angle_deg=25"), ""),
        ((UP % 8, "target.orbit={semi_major_axis_km: 6878}", "corridor.half_angle_deg=5"), "such as ["),
        ((FRAMED % ("lvlh", 9), "target.attitude_mrp={box: 0.1}"), "distance from the target's centre of mass is 9 m"),
        ((FRAMED % ("lvlh", 11), "target.attitude_mrp={box: 0.1}"), ""),
    ],
    ids=[
        "port",
        "port, too near",
        "another axis",
        "lvlh, outside",
        "lvlh, too near",
        "in the cone",
        "beside it",
        "turned",
        "far",
    ],
)
def test_starts_in_frames(said: tuple[str, ...], words: str, tmp_path: Path) -> None:
    """The same of starts in the frames of the port and of LVLH. The zone has a radius of 10 m, the port is at 5 m on x.

    Kills: the axes of T for those of the port, the docking point for the target's centre of mass.
    """
    more = ("target={orbit: {}, keep_out: {radii_m: 10}, port_m: [5, 0, 0]}",)
    if not words:
        scene(tmp_path, *more, *said)
        return
    with pytest.raises(CampaignError) as caught:
        scene(tmp_path, *more, *said)
    (finding,) = caught.value.findings
    assert finding.path == "start.position_m"
    assert words in finding.found
