"""`python -m benchmarks.basilisk`: flights of rvjax again in Basilisk, which `rvjax[crosscheck]` installs."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks import basilisk
from tests.oracles import absolute

ROOT = Path(__file__).parents[2]
HELD = ROOT / "campaigns" / "navigation.yaml"
SECONDS = ("horizon.duration_s=20", "capture={window_s: 5}")
CONTINUOUS = ("controller={use: pd-plus}", *SECONDS)

missing = find_spec("Basilisk") is None
needs_basilisk = pytest.mark.skipif(missing, reason="Basilisk is not installed: pip install 'rvjax[crosscheck]'")


@needs_basilisk
def test_held_commands_are_repeated_to_the_rounding_of_positions() -> None:
    """20 s of a campaign that commands ten times a second: 1e-7 m and 1e-9 rad; the target too. Kills: another frame, another
    order of the channels, a wrench of the step before, another constant of gravity."""
    flight = basilisk.flown(HELD, 0, SECONDS)
    found = basilisk.apart(flight, *basilisk.repeated(flight))
    assert len(found.position) == len(flight.trace) == 401
    assert [series.max() <= most for series, most in zip(found, (1e-7, 1e-9, 1e-6, 1e-12), strict=True)] == [True] * 4, found


@needs_basilisk
def test_what_remains_of_a_continuous_wrench_falls_with_the_square_of_the_step() -> None:
    """Ratio 4. Kills: an error that is not that of holding the wrench."""
    path = ROOT / "campaigns" / "docking-nominal.yaml"
    position, attitude = [], []
    for step in (0.1, 0.05):
        flight = basilisk.flown(path, 0, (*CONTINUOUS, f"horizon.step_s={step}"))
        found = basilisk.apart(flight, *basilisk.repeated(flight))
        position.append(found.position.max())
        attitude.append(found.attitude.max())
    assert 1e-6 < position[1] < 1e-4
    for coarse, fine in (position, attitude):
        assert 3.5 < coarse / fine < 4.5


def test_distances_are_those_of_absolute_states() -> None:
    """Without Basilisk: the states of an independent propagation are near, and moved by known amounts they are that far away.
    Kills: a distance in the wrong frame, an angle that is always 0, a moved docking point."""
    flight = basilisk.flown(HELD, 0, (*SECONDS, "horizon.duration_s=6"))
    constants = absolute.Constants(flight.mass, flight.inertia, flight.target_inertia, flight.port, flight.mu)
    r_t, v_t, r_p, v_p, q_t, q_p, w_t, w_p = np.split(
        absolute.held_states(flight.trace, constants), (3, 6, 9, 12, 16, 20, 23), axis=1
    )
    target = {"r": r_t, "v": v_t, "sigma": Rotation.from_quat(q_t).as_mrp(), "w": w_t}
    pursuer = {"r": r_p, "v": v_p, "sigma": Rotation.from_quat(q_p).as_mrp(), "w": w_p}
    near = basilisk.apart(flight, target, pursuer)
    assert [series.max() <= most for series, most in zip(near, (1e-7, 1e-9, 1e-7, 1e-12), strict=True)] == [True] * 4, near
    turned = (Rotation.from_rotvec([0.0, 0.002, 0.0]) * Rotation.from_quat(q_t)).as_mrp()
    far = basilisk.apart(flight, target, pursuer | {"r": r_p + np.array([0.0, 0.3, 0.0])})
    np.testing.assert_allclose(far.position, 0.3, rtol=1e-6)
    far = basilisk.apart(flight, target | {"sigma": turned}, pursuer)
    np.testing.assert_allclose(far.attitude, 0.002, rtol=1e-6)
    assert (far.target > 1e-4).all()
    far = basilisk.apart(flight, target | {"r": r_t * (1.0 + 1e-6)}, pursuer)
    np.testing.assert_allclose(far.radius, 1e-6 * np.linalg.norm(r_t, axis=1), rtol=1e-3)


def test_a_pursuer_whose_mass_changes_is_named() -> None:
    """Kills: a rigid body of the mass at the start for one that burns propellant."""
    burns = "pursuer.propellant={mass_kg: 5, specific_impulse_s: 200, torque_arm_m: 1, tank_m: [0.1, 0, 0]}"
    with pytest.raises(basilisk.UnfitError, match="mass changes, from"):
        basilisk.flown(ROOT / "campaigns" / "docking-nominal.yaml", 0, (*CONTINUOUS, burns))


@needs_basilisk
def test_a_wrong_campaign_ends_with_its_message(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a traceback."""
    monkeypatch.setattr(sys, "argv", ["basilisk", str(HELD), "--set", "samples=none"])
    assert basilisk.main() == 2
    assert "samples" in capsys.readouterr().err


@pytest.mark.skipif(not missing, reason="Basilisk is installed")
def test_without_basilisk_it_says_what_to_install() -> None:
    """Kills: a traceback, an exit code of success."""
    ended = subprocess.run(
        [sys.executable, "-m", "benchmarks.basilisk"], cwd=ROOT, capture_output=True, text=True, check=False, timeout=60
    )
    assert ended.returncode == 2
    assert ended.stderr == "Basilisk is not installed; accepted: pip install 'rvjax[crosscheck]'\n"
