"""Propellant of a campaign: which is accepted, that its draws reach the flight and act, and that nothing is there without it."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rvjax.campaign.fields import validate
from rvjax.campaign.model import Pursuer
from rvjax.campaign.source import Source
from rvjax.components.registry import standard_metrics
from rvjax.execution.audit import prove
from rvjax.physics.propellant import Propellant
from rvjax.simulation.batch import Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load
from tests.short import CAMPAIGN, QUICK, SHORT

Array = NDArray[np.float64]


def room(inertia: Array, mass: Array, centre: Array, propellant: Array, tank: Array) -> Array:
    """(n,) the least eigenvalue of Σ with an empty tank, from the pseudo-inertia matrix less that of the propellant, by Schur's
    complement: an own way to the condition. inertia: about the reference point."""
    sigma = 0.5 * np.trace(inertia, axis1=-2, axis2=-1)[:, None, None] * np.eye(3) - inertia
    sigma = sigma - propellant[:, None, None] * tank[:, :, None] * tank[:, None, :]
    first = mass[:, None] * centre - propellant[:, None] * tank
    left = mass - propellant
    return np.linalg.eigvalsh(sigma - first[:, :, None] * first[:, None, :] / left[:, None, None])[:, 0]


def pursuer(raw: dict[str, Any]) -> bool:
    """Whether a pursuer is accepted."""
    return validate(Pursuer, raw, ("pursuer",), Source(""))[0] is not None


def box(low: Array, high: Array) -> list[dict[str, list[float]]]:
    return [{"uniform": [float(a), float(b)]} for a, b in zip(low, high, strict=True)]


def test_accepted_is_what_no_draw_can_break() -> None:
    """120 pursuers with a box of moments, mass, centre and tank, each against all its corners and 200 draws inside, for five
    levels of the tank. Kills: the inertia with a full tank alone, the heaviest pursuer alone, the mean propellant, a tank that is
    measured from the centre of mass."""
    generator = np.random.default_rng(7)
    verdicts: list[bool] = []
    for _ in range(120):
        moments, mass, most = np.array([20.0, 19.0, 22.0]), generator.uniform(40, 80), generator.uniform(1, 35)
        wide = generator.uniform(0.0, 0.6, 3)
        centre, tank = generator.uniform(-0.12, 0.12, (2, 3)), generator.uniform(-0.7, 0.7, (2, 3))
        low, high = np.minimum(*centre), np.maximum(*centre)
        first, last = np.minimum(*tank), np.maximum(*tank)
        raw: dict[str, Any] = {
            "mass_kg": {"uniform": [mass, mass + 25.0]},
            "inertia_kgm2": {"moments": box(moments - wide, moments + wide)},
            "centre_of_mass_m": box(low, high),
        }
        if not pursuer(raw):
            continue
        raw["propellant"] = {
            "mass_kg": {"uniform": [0.5, most]},
            "specific_impulse_s": 200,
            "tank_m": box(first, last),
        }
        lows = np.concatenate([moments - wide, [mass], low, first])
        highs = np.concatenate([moments + wide, [mass + 25.0], high, last])
        corners = np.array(list(itertools.product(*zip(lows, highs, strict=True))))
        points = np.concatenate([corners, generator.uniform(lows, highs, (200, 10))])
        inertia = points[:, :3, None] * np.eye(3)
        levels = [
            room(inertia, points[:, 3], points[:, 4:7], np.full(len(points), share * most), points[:, 7:]).min()
            for share in (0.0, 0.25, 0.5, 0.75, 1.0)
        ]
        accepted = pursuer(raw)
        assert accepted == (levels[-1] >= 0.0)
        assert min(levels) == levels[-1], "the empty tank is the worst"
        verdicts.append(accepted)
    assert len(verdicts) > 60
    assert 0.1 < np.mean(verdicts) < 0.9


@pytest.mark.parametrize("tank", [[0.3, -0.2, 0.1], {"ball": 0.4}])
def test_accepted_whatever_way_it_points(tank: Any) -> None:
    """Principal axes in any direction: the largest propellant that is accepted, against 20,000 rotations. Kills: the corners of
    the box where there is none, a condition on the propellant alone."""
    body = {
        "mass_kg": 90,
        "inertia_kgm2": {"principal": [20, 19, 22], "rotation": "uniform"},
        "centre_of_mass_m": [0.1, 0.05, -0.1],
    }
    sizes = np.arange(1.0, 89.0)
    given = [pursuer({**body, "propellant": {"mass_kg": p, "specific_impulse_s": 200, "tank_m": tank}}) for p in sizes]
    most = float(sizes[given][-1])
    assert given == [bool(p <= most) for p in sizes]
    assert 10.0 <= most < 80.0
    count, generator = 20_000, np.random.default_rng(3)
    turned = Rotation.random(count, rng=generator).as_matrix()
    inertia = turned @ np.diag([20.0, 19.0, 22.0]) @ np.swapaxes(turned, 1, 2)
    ways = generator.normal(size=(count, 3))
    places = 0.4 * ways / np.linalg.norm(ways, axis=1)[:, None] if isinstance(tank, dict) else np.tile(tank, (count, 1))
    same = np.full(count, 90.0), np.tile([0.1, 0.05, -0.1], (count, 1))
    assert room(inertia, *same, np.full(count, most), places).min() >= 0.0


def test_rejected_bodies_exist_with_an_empty_tank_too() -> None:
    """Kills: a redraw that looks at the full tank alone, draws of the tank that are not redrawn with the body."""
    overrides = [
        "pursuer.inertia_kgm2={moments: [20, 19, {normal: [22, 3]}], reject: true}",
        "pursuer.propellant={mass_kg: {uniform: [5, 25]}, specific_impulse_s: 200, tank_m: {box: 0.6}}",
    ]
    draws, drawn = Draws.of(load(CAMPAIGN, overrides), np.arange(4000))
    j, propellant = drawn.plant.inertia, drawn.propellant
    assert isinstance(propellant, Propellant)
    matrices = np.moveaxis(np.array([[j.xx, j.xy, j.xz], [j.xy, j.yy, j.yz], [j.xz, j.yz, j.zz]]), -1, 0)
    tank = np.stack(propellant.tank.parts(), axis=-1)
    assert room(matrices, drawn.plant.mass, tank * 0.0, propellant.mass, tank).min() >= -1e-9
    rejected = draws.values["pursuer.inertia_kgm2.rejected"]
    assert 0.2 < (rejected > 0).mean() < 0.9


@pytest.mark.parametrize(
    "propellant",
    [
        "{mass_kg: {uniform: [2, 4]}, specific_impulse_s: {uniform: [180, 220]}, tank_m: {box: 0.1}}",
        "{mass_kg: 3, specific_impulse_s: 200, tank_m: [0.1, 0, 0], torque_arm_m: {uniform: [0.4, 0.6]}}",
    ],
)
def test_every_draw_reaches_the_flight_and_acts(propellant: str) -> None:
    """Kills: an impulse, a tank or an arm that the flight does not get, a specific impulse in another unit."""
    problem = load(CAMPAIGN, [*SHORT, QUICK, f"pursuer.propellant={propellant}"])
    found = prove(problem, Flyer.of(problem))
    draws, _ = Draws.of(problem, np.arange(2))
    assert found.columns == len(draws.values)
    assert not found.idle
    names = [name for name in draws.values if name.startswith("pursuer.propellant.")]
    assert len(names) == (5 if "box" in propellant else 1)


def test_without_propellant_nothing_is_there() -> None:
    """Kills: a state, numbers or columns of propellant in every campaign."""
    problem = load(CAMPAIGN, SHORT)
    assert Draws.of(problem, np.arange(1))[1].propellant == ()
    assert problem.metrics == standard_metrics()
    assert not [name for name in problem.metric_columns if "propellant" in name]
    with_it = load(CAMPAIGN, [*SHORT, "pursuer.propellant={mass_kg: 2, specific_impulse_s: 220}"])
    more = with_it.metric_columns.keys() - problem.metric_columns.keys()
    assert more == {"propellant_used_kg", "propellant_left_kg"}
