"""The audit of fixed inputs: what does nothing in any sample is named; what the steps cannot follow is warned of."""

from __future__ import annotations

import json
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

from rvjax.errors import CampaignError
from rvjax.execution.audit import prove
from rvjax.execution.audit_fixed import probes, switched_off
from rvjax.report import sections
from rvjax.simulation import jax_config
from rvjax.simulation.batch import Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.effect import refused, silent, warnings
from rvjax.simulation.problem import Problem, load
from tests.campaign.dead_inputs import BASE, DEAD, LINES, UNIX
from tests.program import Run
from tests.short import SHIPPED

CAMPAIGNS = sorted(SHIPPED.glob("**/*.yaml"))


MORE_DEAD = {
    "corridor": ("corridor.half_angle_deg=5", "target.port_m=0", "corridor"),
    "sphere": ("disturbances=[{use: gravity-gradient}]", "pursuer.inertia_kgm2.moments=20", "disturbances.gravity-gradient"),
}


@pytest.fixture
def campaign(tmp_path: Path) -> Path:
    path = tmp_path / "fixed.yaml"
    path.write_text(BASE)
    return path


@pytest.mark.parametrize("case", DEAD)
def test_an_input_that_does_nothing_is_named_and_can_be_allowed(campaign: Path, case: str, rvjax: Run) -> None:
    """Kills: a check of this kind that is left out; a wrong place; a name that audit.allow does not know; a flight before it."""
    line, name, place, words = DEAD[case]
    campaign.write_text(f"{BASE}{line}\n")
    column = line.index(f"{place}: ") + len(place) + 3 if f"{place}: " in line else line.index(place) + 1
    code, _, err = rvjax("validate", campaign)
    assert code == 2, err
    (message,) = err.splitlines()
    assert message.startswith(f"{campaign}:{LINES + 1}:{column}: ")
    assert f": {name} does nothing: " in message
    assert words in message
    assert message.endswith(f", or {name} under audit.allow")
    code, _, err = rvjax("validate", campaign, "--set", f"audit.allow=[{name}]")
    assert code == 0, err


@pytest.mark.parametrize("case", MORE_DEAD)
def test_an_input_that_another_one_makes_useless_is_named(campaign: Path, case: str) -> None:
    """Kills: a cone without an axis, a gravity gradient on a sphere."""
    first, second, name = MORE_DEAD[case]
    assert not refused(load(campaign, [first]))
    both = load(campaign, [first, second])
    assert [found.name for found in silent(both)] == [name]
    assert not refused(load(campaign, [first, second, f"audit.allow=[{name}]"]))


ALIVE = (
    "disturbances=[{use: table, rows: [[1.05, 0, 0, 0, 0, 0, 0], [1.1, 1, 0, 0, 0, 0, 0], [1.15, 0, 0, 0, 0, 0, 0]]}]",
    "disturbances=[{use: plume-pulse, force_N: 1, first_s: 2.04, width_s: 0.01, edge_s: 0.02}]",
    "disturbances=[{use: plume-pulse, force_N: 1, first_s: 2.01, width_s: 0.01, edge_s: 0.02, period_s: 0.21}]",
    "disturbances=[{use: plume-pulse, force_N: 1, first_s: {uniform: [2.01, 2.03]}, width_s: 0.01, edge_s: 0.02}]",
    "faults=[{use: float, onset_s: 1.05, duration_s: 0.01}]",
    "faults=[{use: float, onset_s: 9.99}]",
    "faults=[{use: float, onset_s: 1.01, period_s: 0.21, duty: 0.1}]",
    "faults=[{use: effectiveness, onset_s: 1, remaining: [1, 1, 1, 1, 1, 0.9]}]",
    "faults=[{use: drift, onset_s: 1, growth: [0, 0, 0, 0, 0, 1], most: [0, 0, 0, 0, 0, 1]}]",
    "faults=[{use: float, onset_s: 1, schedule: {count: 0.6}}]",
    "navigation=[{use: noise, position_m: [0, 0, 1]}]",
    "navigation=[{use: noise, position_m_per_m: [0, 0, 1]}]",
    "navigation=[{use: dropouts, probability: {uniform: [0, 0.1]}}]",
    "navigation=[{use: dropouts, mean_interval_s: 3, duration_s: 1}]",
    "navigation=[{use: outage, start_s: 1.04, duration_s: 0.05}]",
    "navigation=[{use: outage, start_s: {uniform: [9.9, 11]}, duration_s: 1}]",
    "navigation=[{use: target-knowledge, port_m: [0, 0, 1]}]",
    "require=[{metric: captured, at_least: 0.5, where: {pursuer.mass_kg: {at_least: 109}}}]",
)


@pytest.mark.parametrize("change", ALIVE)
def test_an_input_that_acts_in_some_sample_passes(campaign: Path, change: str) -> None:
    """The neighbours of the cases above. Kills: an instant at half a step, a recurring event or a channel forgotten."""
    assert not silent(load(campaign, [change]))


@pytest.mark.parametrize("margin", ["from_s: 3.01, to_s: 3.02", "from_s: 11"])
def test_a_window_without_a_step_is_refused(campaign: Path, margin: str) -> None:
    """Such a margin has no value, so audit.allow does not help. Kills: min and max over nothing, +∞ and −∞."""
    with pytest.raises(CampaignError, match=r"margins\.calm\.always\.(to|from)_s: .*accepted: "):
        load(campaign, [f"margins={{calm: {{always: {{signal: speed_m_s, below: 1, {margin}}}}}}}", "audit.allow=[margins]"])


@pytest.mark.parametrize("path", CAMPAIGNS, ids=[str(path.relative_to(SHIPPED)) for path in CAMPAIGNS])
def test_every_campaign_of_this_repository_passes(path: Path) -> None:
    """Nothing of them needs a probe flight: all their components have draws. Kills: a check that refuses what is sound."""
    problem = load(path)
    assert not refused(problem)
    assert not warnings(problem)
    assert not probes(problem, Draws.of(problem, np.arange(2, dtype=np.int64))[0].streams)


FLOWN = """\
disturbances:
  - {use: constant, force_N: [0.01, 0, 0]}
  - {use: constant, name: tiny, force_N: [1.0e-30, 0, 0]}
  - {use: sinusoid, force_N: [0.1, 0, 0], rate_rad_s: 0, phase_deg: 0}
faults:
  - {use: effectiveness, channels: [fx, fz], onset_s: 2, remaining: 0.5}
navigation:
  - {use: bias, position_m: [1.0e-30, 0, 0]}
"""
IDLE = {
    "disturbances.tiny": "3:5",
    "disturbances.sinusoid": "4:5",
    "faults.effectiveness.channels.fz": "6:41",
    "navigation.bias": "8:5",
}
"""Inputs of FLOWN that change no bit, with their places: too small, sin 0, a channel without commands, lost in rounding."""


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Problem:
    jax_config.configure()
    path = tmp_path_factory.mktemp("fixed") / "flown.yaml"
    path.write_text(BASE + FLOWN)
    return load(path)


def test_what_changes_no_flight_is_named_and_can_be_allowed(flown: Problem) -> None:
    """Each is switched off in a flight. Kills: a probe that looks at the wrong channel, changes another component, or accepts
    what changes nothing; a probe that names the constant force, which acts, or fx, which is commanded."""
    assert not silent(flown)
    with pytest.raises(CampaignError) as caught:
        prove(flown, Flyer.of(flown))
    source = flown.spec.source.name
    for finding, (name, place) in zip(caught.value.findings, IDLE.items(), strict=True):
        row, column = place.split(":")
        assert finding.where == f"{source}:{int(row) + LINES}:{column}"
        assert finding.found.startswith(f"{name} does nothing: switching it off changed no number in ")
    allowed = load(source, [f"audit.allow=[{', '.join(IDLE)}]"])
    record = prove(allowed, Flyer.of(allowed)).record
    assert record.fixed == 6
    assert record.inert.keys() == IDLE.keys()
    assert "Without an effect, as audit.allow permits: disturbances.tiny (" in str(record)
    assert not prove(flown, Flyer.of(flown), baseline=True).inert, "the main run judges the fixed inputs"


def test_a_thruster_is_switched_off_alone(campaign: Path) -> None:
    """Kills: faults on thrusters that no probe reaches; a fault that is switched off on another thruster, or in all samples."""
    layout = "actuators={use: thrusters, layout: pinwheel-12, size_m: 1, max_N: 1}"
    problem = load(campaign, [layout, "faults=[{use: float, channels: [t3, t5], onset_s: 2}]"])
    draws, drawn = Draws.of(problem, np.arange(4, dtype=np.int64))
    first, _ = probes(problem, draws.streams)
    assert (first.name, first.place) == ("faults.float.channels.t3", ("faults", 0, "channels", 0))
    changed = switched_off(problem, drawn, [(first, np.array([False, True, False, False]))])
    before, after = (np.array(numbers.faults[0].onset_s.parts()) for numbers in (drawn, changed))
    assert [tuple(place) for place in np.argwhere(before != after)] == [(2, 1)]
    assert after[2, 1] > problem.spec.horizon.duration_s


def impulse(instants: Sequence[float], values: Sequence[float]) -> float:
    """∫ d dt of a polygon, by quadrature between its corners."""
    return sum(quad(lambda t: float(np.interp(t, instants, values)), a, b)[0] for a, b in pairwise(instants))


@pytest.mark.parametrize(
    ("instants", "values"),
    [
        ((1.02, 1.05, 1.08), (0.0, 1.0, 0.0)),
        ((1.08, 1.1, 1.12), (0.0, 1.0, 0.0)),
        ((2.03, 2.04, 2.3, 2.31), (0.0, 2.0, 2.0, 0.0)),
    ],
    ids=["between-steps", "on-a-step", "long-with-steep-edges"],
)
@pytest.mark.parametrize("scale", [1.0, -3.0])
def test_a_table_with_details_shorter_than_a_step_is_warned_of(
    campaign: Path, instants: tuple[float, ...], values: tuple[float, ...], scale: float
) -> None:
    """The impulse of the steps is integrated here by RK4, step by step. Kills: the other weights, the other channel, a scale
    that is forgotten, a warning about smooth tables (below)."""
    rows = [[t, 0, value, 0, 0, 0, 0] for t, value in zip(instants, values, strict=True)]
    background = [{"use": "constant", "force_N": 1}, {"use": "table", "rows": rows, "scale": scale}]
    problem = load(campaign, [f"disturbances={json.dumps(background)}", "audit.allow=[disturbances.table]"])
    seen, h = 0.0, 0.1
    for k in range(100):
        first, last = (scale * float(np.interp(t, instants, values)) for t in (k * h, (k + 1) * h))
        seen += h * (first + 4.0 * 0.5 * (first + last) + last) / 6.0
    found = [finding.found for finding in warnings(problem)]
    if instants[0] == 1.02:
        assert not found, "it is refused, and allowed: no warning on top"
        return
    (text,) = found
    assert (
        f"on fy the steps see an impulse of {seen:.4g} N s, the campaign has {scale * impulse(instants, values):.4g} N s" in text
    )


@pytest.mark.parametrize("edge", [0.01, 0.05])
@pytest.mark.parametrize("first", [2.0, 2.03])
def test_a_pulse_with_edges_shorter_than_a_step_is_warned_of(campaign: Path, edge: float, first: float) -> None:
    """Kills: another impulse than a w per pulse, a pulse that is cut off by the end and counted in full, wrong weights."""
    width, period = 0.13, 0.9
    pulse = (
        f"disturbances=[{{use: plume-pulse, force_N: 1, first_s: {first}, width_s: {width}, edge_s: {edge}, period_s: {period}}}]"
    )

    def height(t: float) -> float:
        since = (t - first) % period if t >= first else 0.0
        up, down = (min(max(x / edge, 0.0), 1.0) for x in (since, since - width))
        return sum(sign * (10 * x**3 - 15 * x**4 + 6 * x**5) for sign, x in ((1, up), (-1, down)))

    seen = sum(0.1 / 6 * (height(0.1 * k) + 4 * height(0.1 * k + 0.05) + height(0.1 * k + 0.1)) for k in range(100))
    starts = [first + j * period for j in range(9) if first + j * period < 10]
    whole = sum(
        quad(height, s, min(s + width + edge, 10.0), points=[min(s + edge, 9.99), min(s + width, 9.99)])[0] for s in starts
    )
    found = [finding.found for finding in warnings(load(campaign, [pulse]))]
    if abs(seen / whole - 1) < 0.01:
        assert not found
    else:
        assert f"the steps see {seen / whole:.4g} times" in found[0]


def test_other_warnings_and_none_for_what_the_steps_follow(campaign: Path) -> None:
    """Kills: a table in Unix time that is a constant wrench unnoticed; a sinusoid that the steps see as a slower one; a warning
    about fine rows of a smooth table, or about a pulse with soft edges."""
    held = UNIX.replace("[1700000000, 0", "[1700000000, 0.5")
    (late,) = warnings(load(campaign, [f"disturbances=[{{use: table, rows: {held}}}]"]))
    assert "sees only the first row of the table, a constant wrench: its times are 1700000000 s to 1700000060 s" in late.found
    (fast,) = warnings(load(campaign, ["disturbances=[{use: sinusoid, force_N: [1, 0, 0], rate_rad_s: 32, phase_deg: 0}]"]))
    assert "on fx the period is shorter than two steps" in fast.found
    smooth = [[t, float(np.sin(t)), 0, 0, 0, 0, 0] for t in np.arange(0.0, 12.0, 0.02).round(3)]
    for sound in (
        [{"use": "table", "rows": smooth}],
        [{"use": "plume-pulse", "force_N": 1, "first_s": 2, "width_s": 1, "edge_s": 0.3}],
        [{"use": "sinusoid", "force_N": [1, 0, 0], "rate_rad_s": 31, "phase_deg": 0}],
    ):
        assert not warnings(load(campaign, [f"disturbances={json.dumps(sound)}"]))


COARSE = {
    "update-rate, period_s: 0.1": "is one step: the measurement is new in every step",
    "update-rate, period_s: 10": "is not shorter than the flight: it has one measurement",
    "dropouts, mean_interval_s: 5, duration_s: 0.04": "0.04 s is shorter than the step of 0.1 s",
    "dropouts, mean_interval_s: 0.04, duration_s: 1": "0.04 s is shorter than the step of 0.1 s",
}
FINE = ("update-rate, period_s: 0.2", "dropouts, mean_interval_s: 0.1, duration_s: 0.1", "outage, start_s: 1, duration_s: 1")


def test_a_sensor_that_the_steps_cannot_follow_is_named(campaign: Path) -> None:
    """Kills: a warning at the wrong key, or about what the steps follow."""
    for said, words in COARSE.items():
        (found,) = warnings(load(campaign, [f"navigation=[{{use: {said}}}]"]))
        assert words in found.found
        assert found.path.split(".")[-1] in said
    for said in FINE:
        assert not warnings(load(campaign, [f"navigation=[{{use: {said}}}]"]))


def test_a_warning_is_on_stderr_and_in_the_report(
    campaign: Path, tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: a warning that only one of them shows, that refuses the campaign, or that --quiet hides."""
    monkeypatch.setattr(sections, "SECTIONS", (sections.provenance.section,))
    table = "[[1.08, 0, 0, 0, 0, 0, 0], [1.1, 1, 0, 0, 0, 0, 0], [1.12, 0, 0, 0, 0, 0, 0], [12, 0, 0, 0, 0, 0, 0]]"
    campaign.write_text(f"{BASE}disturbances: [{{use: table, rows: {table}}}]\n")
    words = "on fx the steps see an impulse of 0.1 N s, the campaign has 0.02 N s"
    code, _, err = rvjax("validate", campaign)
    assert code == 0
    assert err.startswith(
        f"warning: {campaign}:12:35: disturbances.0.rows: rows 0.02 s apart are shorter than the step of 0.1 s: "
    )
    assert words in err
    code, out, _ = rvjax("validate", campaign, "--json")
    assert words in json.loads(out)[str(campaign)]["warnings"][0]["found"]
    code, _, err = rvjax("run", campaign, "--out", tmp_path / "run", "--quiet")
    assert code == 0, err
    assert words in err
    for file in ("report.md", "report.html"):
        assert words in (tmp_path / "run" / file).read_text()
