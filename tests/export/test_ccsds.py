"""OEM and AEM: positions, velocities, attitudes and rates are those of a flight that SciPy made in the inertial frame."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rvjax.errors import UsageError
from rvjax.execution.exporting import Options, export
from tests.export.conftest import LOST, PLANE, Truth

STEPS = 121


def read(path: Path) -> tuple[dict[str, str], list[str], NDArray[np.float64]]:
    """Keys, instants and numbers of a message, read by its definition."""
    text = path.read_text(encoding="ascii")
    keys = dict(re.findall(r"^([A-Z_]+) = (.*)$", text, re.MULTILINE))
    rows = [line.split() for line in text.splitlines() if re.match(r"\d{4}-", line)]
    return keys, [row[0] for row in rows], np.array([[float(x) for x in row[1:]] for row in rows])


@pytest.fixture(scope="module")
def oem(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The messages of pursuer and target, in a tilted plane."""
    return export(folder, tmp_path_factory.mktemp("oem") / "flight.oem", 1, Options(plane=PLANE))


@pytest.fixture(scope="module")
def aem(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """As `oem`."""
    return export(folder, tmp_path_factory.mktemp("aem") / "flight.aem", 1, Options(plane=PLANE, epoch="2030-12-31T23:59:30"))


def test_positions_and_velocities(oem: list[Path], truth: Truth) -> None:
    """Kills: a port that is not added or does not swing; a transposed attitude; a plane that turns the wrong way; metres."""
    tilt = Rotation.from_euler("ZXZ", PLANE, degrees=True)
    pursuer, target = (read(path)[2] * 1000.0 for path in oem)
    np.testing.assert_allclose(target[:, :3], tilt.apply(truth.r), atol=2e-5, rtol=0)
    np.testing.assert_allclose(target[:, 3:], tilt.apply(truth.v), atol=1e-7, rtol=0)
    np.testing.assert_allclose(pursuer[:, :3] - target[:, :3], tilt.apply(truth.p - truth.r), atol=1e-7, rtol=0)
    np.testing.assert_allclose(pursuer[:, 3:] - target[:, 3:], tilt.apply(truth.w - truth.v), atol=1e-9, rtol=0)


def test_attitudes_and_rates(aem: list[Path], truth: Truth) -> None:
    """Kills: a quaternion of the inverse turn; the scalar part first; a rate relative to the target; radians; signs that jump."""
    tilt = Rotation.from_euler("ZXZ", PLANE, degrees=True)
    for path, body, rate in zip(aem, (truth.pursuer, truth.target), (truth.rate, None), strict=True):
        _, _, numbers = read(path)
        away = (tilt * body).inv() * Rotation.from_quat(numbers[:, :4])
        assert away.magnitude().max() < 1e-10
        assert (np.sum(numbers[1:, :4] * numbers[:-1, :4], axis=1) > 0.9).all()
        if rate is not None:
            np.testing.assert_allclose(numbers[:, 4:], np.degrees(rate), atol=1e-10, rtol=0)


def test_the_head_says_frames_epoch_and_object(oem: list[Path], aem: list[Path]) -> None:
    """Kills: an epoch that is not stated; a day that does not end; the time system of a date in UTC; one name for two objects."""
    keys, instants, _ = read(oem[0])
    assert (keys["CCSDS_OEM_VERS"], keys["REF_FRAME"], keys["TIME_SYSTEM"]) == ("2.0", "EME2000", "TT")
    assert "J2000.0 (2000-01-01T12:00:00 TT)" in oem[0].read_text()
    assert (instants[1], keys["STOP_TIME"]) == ("2000-01-01T12:00:00.500000000", instants[-1])
    keys, instants, _ = read(aem[1])
    assert (keys["TIME_SYSTEM"], keys["REF_FRAME_A"], keys["REF_FRAME_B"]) == ("UTC", "EME2000", "SC_BODY_1")
    assert instants[-1] == "2031-01-01T00:00:30.000000000"
    assert keys["OBJECT_NAME"] == "MADE-ELSEWHERE-TARGET"
    assert all(len(line) <= 254 for path in (*oem, *aem) for line in path.read_text().splitlines())


def test_a_flight_that_diverged_ends_before(folder: Path, tmp_path: Path) -> None:
    """Kills: NaN in a message, or rows that are left out without a word."""
    pursuer, _ = export(folder, tmp_path / "lost.oem", 2)
    assert len(read(pursuer)[1]) == STEPS - LOST
    assert f"its last {LOST} rows are left out" in pursuer.read_text()


@pytest.mark.parametrize("epoch", ["yesterday", "9999-12-31T00:00:00"])
def test_an_epoch_that_is_no_date(folder: Path, tmp_path: Path, epoch: str) -> None:
    """Kills: a traceback."""
    with pytest.raises(UsageError, match=f"--epoch {epoch}: .*; accepted: "):
        export(folder, tmp_path / "x.oem", 1, Options(epoch=epoch))


def test_an_independent_reader_of_oem(oem: list[Path], truth: Truth) -> None:
    """By the package `oem` (B. Sease), where it is installed; it interpolates, and checks the format as it reads."""
    reader = pytest.importorskip("oem", reason="pip install oem")
    message = reader.OrbitEphemerisMessage.open(oem[0])
    states = list(message.segments[0].states)
    assert len(states) == STEPS
    assert message.segments[0].metadata["OBJECT_ID"] == "MADE-ELSEWHERE-PURSUER"
    tilt = Rotation.from_euler("ZXZ", PLANE, degrees=True)
    np.testing.assert_allclose([1000.0 * state.position for state in states], tilt.apply(truth.p), atol=2e-5, rtol=0)


def test_an_independent_reader_of_aem(aem: list[Path]) -> None:
    """By the package `ccsds-ndm-py`, where it is installed, which knows 504.0-B-2."""
    reader = pytest.importorskip("ccsds_ndm", reason="pip install ccsds-ndm-py")
    if not hasattr(reader, "Aem"):
        pytest.skip("pip install ccsds-ndm-py; another package of the same name is installed")
    (segment,) = reader.Aem.from_file(str(aem[0])).segments
    assert segment.metadata.angvel_frame == "SC_BODY_1"
    np.testing.assert_array_equal([state.values for state in segment.data.attitude_states], read(aem[0])[2])
