"""A start in a frame, as a part of a campaign: both forms, the default of relative_to, the audit, the docking axis."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from rvjax.campaign import load as read
from rvjax.campaign.start import FramedStart, Start
from rvjax.errors import AuditError, CampaignError
from rvjax.execution.audit import prove
from rvjax.simulation import effect, jax_config
from rvjax.simulation.batch import Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem, load
from tests.campaign.test_audit import Disconnected
from tests.program import Run
from tests.short import CAMPAIGN, QUICK, SHORT

TARGET = (
    "target={orbit: {semi_major_axis_km: {uniform: [7800, 7900]}, eccentricity: {uniform: [0, 0.1]}, true_anomaly_deg: "
    "{uniform: [0, 360]}}, attitude_mrp: {ball: 0.9}, rate_deg_s: {box: 1}, port_m: {box: 5}}"
)
ALONG = TARGET.replace("port_m", "port_axis: [-2, 1, 0], port_m")
DRAWN = "position_m: {box: 40}, velocity_m_s: {box: 0.1}, attitude_mrp: {rotation: uniform}, rate_deg_s: {box: 0.5}"
RESTS = {"port": "lvlh", "lvlh": "inertial", "pursuer": "port"}
"""Frame → relative_to, so that each is audited once."""

PARTS = {"rho": "position_m", "nu": "velocity_m_s", "sigma": "attitude_mrp", "omega": "rate_rad_s"}


def framed(frame: str, *more: str, target: str = TARGET) -> Problem:
    return load(CAMPAIGN, [*SHORT, QUICK, target, f"start={{frame: {frame}, relative_to: {RESTS[frame]}, {DRAWN}}}", *more])


@pytest.fixture(scope="module")
def flyer() -> Flyer:
    """Of every campaign here: the start is no part of the program."""
    jax_config.configure()
    return Flyer.of(framed("port"))


@pytest.mark.parametrize("target", [TARGET, ALONG], ids=["port_m", "port_axis"])
@pytest.mark.parametrize("frame", RESTS)
def test_every_draw_of_a_start_is_read_back_and_acts(frame: str, target: str, flyer: Flyer) -> None:
    """Kills: a column that nobody reads, a formula of the readings that is another one than that of the flight."""
    problem = framed(frame, target=target)
    found = prove(problem, flyer)
    draws, _ = Draws.of(problem, np.arange(2, dtype=np.int64))
    started = [name for name in draws.streams if name.startswith("start.")]
    assert len(started) == 10
    assert set(started) <= found.moved.keys()
    assert (found.columns, found.unlike, found.idle) == (len(draws.values), (), {})


@pytest.mark.parametrize(("part", "drawn"), PARTS.items())
@pytest.mark.parametrize("frame", RESTS)
def test_a_motion_that_is_not_that_of_the_table_is_named(frame: str, part: str, drawn: str, flyer: Flyer) -> None:
    """A hundred-millionth too much. Kills: readings that are compared with themselves, or not at all."""

    def wrong(numbers: Any) -> Any:
        motion = numbers.motion
        return numbers._replace(motion=motion._replace(**{part: getattr(motion, part) * (1.0 + 1e-8)}))

    with pytest.raises(AuditError, match=rf"start\.{drawn}\.x.*: the table says") as caught:
        prove(framed(frame), Disconnected(flyer, wrong))
    assert caught.value.exit_code == 4


def test_each_form_is_read_by_its_keys() -> None:
    """Kills: a form that is chosen by another key, a default that is another one, a frame as a part of the program."""
    given = {"port": "port", "lvlh": "lvlh", "pursuer": "port"}
    plain = load(CAMPAIGN)
    assert isinstance(plain.spec.start, Start)
    for frame, rest in given.items():
        short, whole = (f"start={{frame: {frame}, position_m: 9{more}}}" for more in ("", f", relative_to: {rest}"))
        problem = load(CAMPAIGN, [short])
        assert isinstance(problem.spec.start, FramedStart)
        assert problem.spec.start.rest == rest
        assert problem.fingerprint == load(CAMPAIGN, [whole]).fingerprint
        assert problem.structure == plain.structure
        others = (whole.replace(f"relative_to: {rest}", f"relative_to: {word}") for word in RESTS.values())
        assert len({load(CAMPAIGN, [other]).fingerprint for other in others}) == 3


def test_the_frame_of_the_pursuer_at_rest_relative_to_the_port_is_the_other_form_on_a_target_at_rest() -> None:
    """Without a rate of the target both forms say the same. Kills: a position, a velocity or a rate in other axes."""
    target = "target={port_m: [3, -2, 1], attitude_mrp: [0.1, 0.2, -0.3]}"
    one = "start={rho_m: [20, 5, -3], nu_m_s: [-0.1, 0, 0.2], sigma: [0.3, -0.2, 0.1], omega_deg_s: [1, -2, 0.5]}"
    other = one.replace("rho_m", "frame: pursuer, position_m").replace("nu_m_s", "velocity_m_s")
    other = other.replace("sigma", "attitude_mrp").replace("omega", "rate")
    first, second = (Draws.of(load(CAMPAIGN, [target, text]), np.arange(1, dtype=np.int64))[1].motion for text in (one, other))
    for a, b in zip(first, second, strict=True):
        np.testing.assert_allclose(np.array(a.parts()), np.array(b.parts()), rtol=1e-14, atol=1e-15)


def test_a_corridor_needs_a_docking_axis() -> None:
    """Of either kind. Kills: a given axis that does not count."""
    corridor = "corridor={half_angle_deg: 5}"
    assert [name for name, _ in effect.silent(load(CAMPAIGN, ["target={}", corridor]))] == ["corridor"]
    assert not effect.silent(load(CAMPAIGN, ["target={port_axis: [0, 1, 0]}", corridor]))
    assert not effect.silent(load(CAMPAIGN, ["target={port_m: [0, 1, 0]}", corridor]))


def test_an_orbit_may_be_stated_without_numbers_and_a_port_by_its_axis() -> None:
    """Kills: an orbit that is looked for by its numbers, a frame of the port that needs the point."""
    for target, frame in (("{orbit: {}}", "lvlh"), ("{port_axis: [0, 1, 0]}", "port"), ("{}", "pursuer")):
        assert read(CAMPAIGN, [f"target={target}", f"start={{frame: {frame}, position_m: 9}}"])
    with pytest.raises(CampaignError, match=r"states no target\.orbit"):
        read(CAMPAIGN, ["target={port_m: 1}", "start={frame: lvlh, position_m: 9}"])


def test_the_manual_has_both_forms(rvjax: Run) -> None:
    """Kills: a page of one form only, frames without their definitions."""
    code, out, err = rvjax("explain", "start")
    assert (code, err) == (0, "")
    for key in ("rho_m", "position_m", "attitude_mrp", "relative_to", "omega_rad_s"):
        assert f"start.{key}" in out or key in out, key
    for name in ("frame", "relative_to", "frames", "lvlh"):
        _, out, _ = rvjax("explain", name)
        assert "V-bar" in out, name


def test_a_folder_is_flown_and_resumed(rvjax: Run, tmp_path: Path) -> None:
    """With drawn numbers of a start in LVLH. Kills: a command that asks for the keys of the other form."""
    start = "start={frame: lvlh, position_m: [{uniform: [-22, -18]}, 0, 0], attitude_mrp: {ball: 0.1}}"
    sets = [word for text in (*SHORT[1:], QUICK, start, "require=[]") for word in ("--set", text)]
    folder = tmp_path / "run"
    for samples in (8, 16):
        code, _, err = rvjax("run", CAMPAIGN, "--samples", str(samples), "--out", folder, *sets)
        assert code == 0, err
    table = pd.read_parquet(next(folder.rglob("samples")))
    assert len(table) == 16
    assert table["draw.start.position_m.x"].between(-22.0, -18.0).all()
    assert {f"draw.start.attitude_mrp.{axis}" for axis in "xyz"} <= set(table.columns)
    assert not any(name.startswith("draw.start.rho") for name in table.columns)
