"""The audit: every dispersion of a sound campaign passes; whichever of them is cut off from the flight is found and named."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import jax
import numpy as np
import pytest

from rvjax.components.faults.interface import fault
from rvjax.errors import AuditError, CampaignError
from rvjax.execution.audit import _unlike, audit, prove  # pyright: ignore[reportPrivateUsage]
from rvjax.execution.audit_readback import ReadBack
from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES, Flyer
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.draws import Draws
from rvjax.simulation.engines.llvm.engine import LlvmEngine
from rvjax.simulation.problem import Problem, load
from tests.program import Run
from tests.short import CAMPAIGN, SHORT

OVERRIDES = (
    *SHORT,
    "target.orbit={semi_major_axis_km: {uniform: [6800, 6900]}, eccentricity: {uniform: [0, 0.01]}, "
    "true_anomaly_deg: {uniform: [0, 360]}}",
    "target.attitude_mrp={ball: 0.9}",
    "target.inertia_kgm2={principal: [{uniform: [490, 510]}, 550, 600], tilt_deg: {uniform: [0, 20]}}",
    "pursuer.inertia_kgm2={principal: [{uniform: [17, 26]}, {uniform: [16, 24]}, 20], tilt_deg: {half_normal: 3}}",
    "faults=[{use: bias, onset_s: {uniform: [2, 10]}, share: {uniform: [-0.05, 0.05]}, schedule: {probability: 0.3}}, "
    "{use: effectiveness, onset_s: 3, remaining: {uniform: [0.5, 1]}, channels: [fx, tz], schedule: {count: {choice: [0, 1]}}}]",
    "controller={use: pd-plus, gains: {k_nu: {uniform: [0.09, 0.11]}}}",
)
"""A campaign of 20 s with a draw of every kind."""


class Disconnected(Flyer):
    """Flies other numbers than it is given: `cut` puts them in."""

    def __init__(self, flyer: Flyer, cut: Callable[[Drawn], Drawn]) -> None:
        self._flyer, self._cut = flyer, cut

    def watch(self, drawn: Drawn, *more: Any) -> None:
        self._flyer.watch(self._cut(drawn), *more)


@pytest.fixture(scope="module")
def problem() -> Problem:
    return load(CAMPAIGN, OVERRIDES)


@pytest.fixture(scope="module")
def flyer(problem: Problem) -> Flyer:
    jax_config.configure()
    return Flyer.of(problem)


def test_a_sound_campaign_passes(problem: Problem, flyer: Flyer) -> None:
    """Kills: a formula of the readings that is another one than that of the flight; a column that nobody reads."""
    found = prove(problem, flyer)
    draws, _ = Draws.of(problem, np.arange(2, dtype=np.int64))
    assert (found.columns, found.streams) == (len(draws.values), len(draws.streams))
    assert not found.unlike
    assert not found.idle


def test_it_tells_what_each_dispersion_moved(problem: Problem, flyer: Flyer) -> None:
    """Forces show in the rate of their own axis, torques likewise. Kills: what comes first, since in the end all moves all."""
    kept = prove(problem, flyer).record
    assert (kept.dispersions, kept.acting) == (len(kept.moved), len(kept.moved))
    assert list(kept.moved) == list(Draws.of(problem, np.arange(2, dtype=np.int64))[0].streams)
    for axis in "xyz":
        assert kept.moved[f"start.rho_m.{axis}"] == f"motion.rho.{axis}"
        assert kept.moved[f"faults.bias.share.f{axis}"] == f"motion.nu.{axis}"
        assert kept.moved[f"faults.bias.onset_s.t{axis}"] == f"motion.omega.{axis}"
    assert kept.moved["pursuer.mass_kg"].startswith("motion.nu.")
    assert kept.moved["target.orbit.true_anomaly_rad"].startswith("target.")


def test_a_rare_fault_is_tried_where_it_comes(flyer: Flyer) -> None:
    """One channel in a hundred fails. Kills: streams of a schedule tried on any samples, of which hardly one notices."""
    rare = load(CAMPAIGN, [text.replace("probability: 0.3", "probability: 0.01") for text in OVERRIDES])
    assert not prove(rare, flyer).idle


def leaves(problem: Problem) -> list[tuple[str, int]]:
    """Name and number of everything in the flight's numbers that differs from sample to sample."""
    _, drawn = Draws.of(problem, np.arange(64, dtype=np.int64))
    found = jax.tree_util.tree_flatten_with_path(drawn)[0]
    return [(jax.tree_util.keystr(path), place) for place, (path, leaf) in enumerate(found) if np.min(leaf) < np.max(leaf)]


def test_whatever_is_cut_off_from_the_flight_is_found(
    problem: Problem, flyer: Flyer, full: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each number in turn is that of the first lane in all of them. Kills: a dispersion that nobody would miss."""
    monkeypatch.setattr("rvjax.execution.audit.ROUNDS", 1)
    cut = leaves(problem)
    assert len(cut) > 80
    missed: list[str] = []
    for name, place in cut if full else cut[::7]:

        def constant(drawn: Drawn, place: int = place) -> Drawn:
            flat, structure = jax.tree.flatten(drawn)
            flat[place] = np.full(LANES, flat[place][0])
            return jax.tree.unflatten(structure, flat)

        found = audit(problem, Disconnected(flyer, constant))
        if not found.unlike and not found.idle:
            missed.append(name)
    assert not missed


def test_a_number_in_the_wrong_place_is_named(problem: Problem, flyer: Flyer) -> None:
    """Both dispersions act, but not where the table says. Kills: an audit that looks for an effect alone."""

    def swapped(drawn: Drawn) -> Drawn:
        motion = drawn.motion
        return drawn._replace(motion=motion._replace(nu=motion.omega, omega=motion.nu))

    with pytest.raises(AuditError, match=r"start\.nu_m_s\.x: the table says .*, the flight has ") as caught:
        prove(problem, Disconnected(flyer, swapped))
    assert caught.value.exit_code == 4
    assert "start.omega_rad_s.z" in str(caught.value)
    assert "start.rho" not in str(caught.value)


def test_a_component_that_does_not_look_at_its_numbers_is_named(problem: Problem) -> None:
    """The numbers are all there, in their place. Kills: an audit that reads the numbers alone."""
    deaf = fault(lambda u, since, memory, upper, numbers: u + 0.01 * upper)
    flyer = Flyer(LlvmEngine(problem.loop._replace(faults=(deaf, *problem.loop.faults[1:])), problem.metrics))
    found = audit(problem, flyer)
    assert not found.unlike
    assert list(found.idle) == [f"faults.bias.share.{channel}" for channel in ("fx", "fy", "fz", "tx", "ty", "tz")]
    assert min(found.idle.values()) > 20
    with pytest.raises(CampaignError) as caught:
        prove(problem, flyer)
    assert len(caught.value.findings) == 6
    assert prove(problem, flyer, baseline=True).idle == found.idle, "a flight may be lost before the fault comes"
    allowed = replace(
        problem, spec=problem.spec.model_copy(update={"audit": type(problem.spec.audit)(allow=("faults.bias.share",))})
    )
    kept = prove(allowed, flyer).record
    assert kept.idle == found.idle
    assert kept.dispersions == kept.acting + 6


IDLE = """\
rvjax: 1
name: idle
samples: 40
horizon: {duration_s: 10, step_s: 0.05}
target: {port_m: [5, 0, 0]}
pursuer: {mass_kg: {uniform: [90, 110]}, inertia_kgm2: {moments: 20}}
start: {rho_m: {box: 0.1}}
capture: {window_s: 5}
saturation: {use: hard-clip}
actuators: {upper: 4000, lower: [3, 3, 3, 3, 3, {uniform: [3000, 3100]}]}
controller: {use: pd-plus}
"""


def test_the_program_refuses_and_says_where(tmp_path: Any, rvjax: Run) -> None:
    """Kills: a run that goes on; a folder that looks like one with flights; a place that is only the top of the file."""
    path = tmp_path / "idle.yaml"
    path.write_text(IDLE)
    code, _, err = rvjax("run", path, "--out", tmp_path / "run")
    assert code == 2, err
    assert err.splitlines()[-1].startswith(f"{path}:10:49: actuators.lower.5: actuators.lower.tz does nothing: moving it alone")
    assert not list((tmp_path / "run" / "samples").glob("*"))
    code, out, err = rvjax("validate", "--audit", path, "--set", "audit.allow=[actuators.lower]")
    assert code == 0, err
    assert "audit: 5 columns are equal in the flight and in the table; 4 dispersions each act alone" in out
    assert "without an effect, as allowed: actuators.lower.tz" in out


MATRIX = "pursuer.inertia_kgm2={moments: [{normal: [20, 2]}, 20, {normal: [26, 3]}], products: {normal: [0, 1]}, reject: true}"
CENTRE = "pursuer.centre_of_mass_m={ball: 0.05}"


@pytest.mark.parametrize(
    "changes",
    [
        (MATRIX,),
        (
            MATRIX,
            CENTRE,
            "correlate=[{variables: [pursuer.mass_kg, pursuer.inertia_kgm2.moments.x], rank: [[1, 0.5], [0.5, 1]]}]",
        ),
        ("pursuer.inertia_kgm2={principal: [{uniform: [17, 26]}, 20, 22], rotation: uniform}", CENTRE, "sampler={use: sobol}"),
        (
            "pursuer.mass_kg={uniform: [80, 120]}",
            "samples=12",
            "sampler={use: grid, levels: {pursuer.mass_kg: 4, start.rho_m.x: 3}}",
        ),
    ],
    ids=["rejected", "centre-of-mass", "rotation", "grid"],
)
def test_every_way_to_draw_is_read_back(changes: tuple[str, ...], flyer: Flyer) -> None:
    """Kills: Steiner with the wrong sign or another mass, principal axes turned the other way, a value of a grid that does not
    fly or cannot be moved, a correlated draw that the audit does not reach."""
    other = load(CAMPAIGN, (*OVERRIDES, *changes, *(("require=[]",) if "sampler" in str(changes) else ())))
    found = prove(other, flyer)
    draws, _ = Draws.of(other, np.arange(2, dtype=np.int64))
    assert (found.columns, found.streams) == (len(draws.values), len(draws.streams))
    assert not found.idle
    if CENTRE in changes:
        cut = Disconnected(flyer, lambda drawn: drawn._replace(plant=drawn.plant._replace(centre=drawn.plant.centre * 0.0)))
        with pytest.raises(AuditError, match=r"pursuer\.centre_of_mass_m"):
            prove(other, cut)


def test_rounding_is_relative_to_the_vector() -> None:
    """Kills: a hold point 100 m away whose small component differs by the rounding of the large ones."""
    table, inside = np.array([0.66]), np.array([0.66 + 8e-14])
    assert _unlike(ReadBack(("start.position_m.x",), table, inside, exact=False, size=100.0)) == ""
    assert "the table says" in _unlike(ReadBack(("start.position_m.x",), table, inside, exact=False))
