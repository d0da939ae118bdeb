"""`rvjax sensitivity`: which numbers of a flight a group exchanges, and the indices of real flights."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from rvjax.errors import UsageError
from rvjax.search import sensitivity
from rvjax.search.sensitivity import groups_of, mixed_draws, prepare
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load
from rvjax.stats.pick_freeze import indices
from tests.program import Run

CAMPAIGN = """rvjax: 1
name: groups
samples: 64
seed: 5
horizon: {duration_s: 10, step_s: 0.1}
target: {port_m: [5, 0, 0]}
pursuer:
  mass_kg: {truncated_normal: [100, 5, 70, 130]}
  inertia_kgm2: {principal: [{normal: [22, 3]}, {normal: [20, 3]}, {normal: [38, 4]}], reject: true}
start: {rho_m: [2, 0, 0], nu_m_s: {ball: 0.2}, sigma: {uniform: [-0.05, 0.05]}}
actuators: {upper: {force: 4, torque: 0.8}, lower: {force: 3, torque: 0.6}, spread: {uniform: [0.9, 1.1]}}
faults:
  - {use: effectiveness, channels: [fx], onset_s: {uniform: [2, 8]}, remaining: {uniform: [0, 1]}}
  - {use: bias, name: some, channels: all, onset_s: {uniform: [200, 300]}, share: 0.001, schedule: {count: 1}}
navigation: [{use: noise, position_m: 0.001}]
correlate:
  - {variables: [pursuer.mass_kg, actuators.spread.upper.fx], rank: [[1, 0.5], [0.5, 1]]}
controller: {use: pd-plus, gains: {k_rho: 0.05, k_nu: 0.5}}
capture: {position_m: 4.6, attitude_mrp: 0.5, window_s: 2}
require:
  - {metric: delta_v_m_s, below: 0.35, at_least: 0.5}
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("groups") / "groups.yaml"
    path.write_text(CAMPAIGN)
    return path


def test_groups_are_sections_faults_and_noise(file: Path) -> None:
    """Kills: correlated draws in two groups, noise in the group of its section, faults in one group."""
    groups = groups_of(load(file))
    assert set(groups) == {"actuators + pursuer", "start", "faults.effectiveness", "faults.some", sensitivity.NOISE}
    assert groups[sensitivity.NOISE] == ("navigation.noise.noise",)
    assert "pursuer.mass_kg" in groups["actuators + pursuer"]
    assert "actuators.spread.upper.fx" in groups["actuators + pursuer"]
    everything = [name for names in groups.values() for name in names]
    assert len(everything) == len(set(everything))


@pytest.mark.parametrize("group", ["actuators + pursuer", "start", "faults.effectiveness", "faults.some", sensitivity.NOISE])
def test_a_group_exchanges_its_numbers_and_no_other(file: Path, group: str) -> None:
    """Kills: noise keys that stay, redraws of rejected bodies with the old numbers, a schedule that stays, other groups touched.
    To the last bit: the numbers of the group are those of the later sample, all others those of the sample."""
    problem, n, later = load(file), 48, 1000
    samples = np.arange(n, dtype=np.int64)
    groups = groups_of(problem)
    mine, a = Draws.of(problem, samples)
    _, b = Draws.of(problem, samples + later)
    _, c = mixed_draws(problem, samples, set(groups[group]).__contains__, later)
    parts = {
        "start": lambda x: x.motion,
        "faults.effectiveness": lambda x: x.faults[0],
        "faults.some": lambda x: x.faults[1],
        "actuators + pursuer": lambda x: (x.plant.mass, x.plant.inertia, x.plant.upper, x.plant.lower),
        sensitivity.NOISE: lambda x: x.navigation,
    }
    import jax

    for name, part in parts.items():
        theirs = jax.tree.leaves(part(b if name == group else a))
        for ours, expected in zip(jax.tree.leaves(part(c)), theirs, strict=True):
            assert np.array_equal(ours, expected)
    assert mine.values["pursuer.inertia_kgm2.rejected"].sum() > 0
    nothing = mixed_draws(problem, samples, lambda name: False, later)[1]
    everything = mixed_draws(problem, samples, lambda name: True, later)[1]
    for found, expected in ((nothing, a), (everything, b)):
        assert all(np.array_equal(x, y) for x, y in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True))


def test_the_indices_of_real_flights(file: Path, rvjax: Run) -> None:
    """Kills: sets exchanged, rows out of order, a fault that begins after the flight taken for one that matters, curves of
    another signal. The fault `some` begins after the end, so it changes no bit of any flight."""
    rows = 450
    flights = prepare(file)
    found = sensitivity.sensitivity(flights, rows, ["delta_v_m_s"])
    assert found.flights == rows * (len(found.groups) + 2)
    by_name = {(result.name, result.kind): result.groups for result in found.results}
    whole = by_name["delta_v_m_s", "finite values"]
    assert whole["start"].total.value > 0.5
    assert whole["faults.some"].total.value == 0.0
    assert found.unchanged["faults.some"] == pytest.approx(1 - 0.05 ** (1 / rows))
    assert found.unchanged["start"] is None
    curve = found.curves["position error"]["start"]
    assert len(curve.first_of) == len(found.times_s)
    assert found.curves["position error"]["faults.some"].total == pytest.approx(0.0, abs=1e-12)
    again = flights.fly(rows)
    values = {name: frame["metric.delta_v_m_s"].to_numpy() for name, frame in again.frames.items()}
    swapped = {name: x for name, x in values.items() if name not in (sensitivity.FIRST, sensitivity.SECOND)}
    rng = np.random.Generator(np.random.Philox(key=1))
    by_hand = indices(values[sensitivity.FIRST], values[sensitivity.SECOND], swapped, rng=rng, resamples=0)
    for name, part in by_hand.items():
        assert part.first.value == whole[name].first.value
        assert part.total.value == whole[name].total.value
    code, told, _ = rvjax("sensitivity", file, "--rows", rows, "--result", "delta_v_m_s", "--json", "-q")
    assert code == 0
    document = json.loads(told)
    kept = next(result for result in document["results"] if result["kind"] == "finite values")
    assert kept["groups"]["start"]["total"]["value"] == whole["start"].total.value
    assert "not captured" in document["constant"] or any(result["name"] == "not captured" for result in document["results"])


def test_a_group_may_have_any_name(file: Path) -> None:
    """Kills: sets whose names a group can have, so that the flights of a group stand for those of the samples."""
    frames = {name: prepare(file, given={name: ["start"]}).fly(30).frames for name in ("A", "B", "other")}
    for name in ("A", "B"):
        for theirs in (sensitivity.FIRST, sensitivity.SECOND, "actuators + pursuer"):
            assert frames[name][theirs].equals(frames["other"][theirs])
        assert frames[name][name].equals(frames["other"]["other"])


def test_groups_of_ones_own(file: Path) -> None:
    """Kills: a group that leaves its draws in their sections, names that nobody has, a draw in two groups, a group that silently
    joins the section of its name."""
    groups = groups_of(load(file), {"where": ["start.nu_m_s"], "masses": ["pursuer.inertia_kgm2"]})
    assert groups["where"] == ("start.nu_m_s",)
    assert "start.nu_m_s" not in groups["start"]
    with pytest.raises(UsageError, match="no draw begins with start"):
        groups_of(load(file), {"where": ["start.speed"]})
    with pytest.raises(
        UsageError, match=r"--group start: the group of a section, with start\.sigma\S* in it as well; accepted: "
    ):
        groups_of(load(file), {"start": ["pursuer.mass_kg", "start.nu_m_s"]})
    assert "start.sigma.x" in groups_of(load(file), {"start": ["start"]})["start"]
    with pytest.raises(UsageError, match="is in the group one too"):
        groups_of(load(file), {"one": ["start"], "two": ["start.nu_m_s"]})


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--group", "masses"), "--group masses; accepted: NAME=DRAW"),
        (("--result", "speed"), "--result speed: no metric of this campaign; accepted: "),
        (("--set", "sampler={use: sobol}", "--set", "require=[]"), "sampler: sobol decides draws together"),
    ],
)
def test_mistakes(file: Path, rvjax: Run, arguments: tuple[str, ...], told: str) -> None:
    """Kills: each check."""
    code, _, said = rvjax("sensitivity", file, *arguments)
    assert code == 2
    assert told in said
