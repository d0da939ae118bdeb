"""Ways of kept flights in the orbital frame and about the port: the lines are where an independent computation puts them."""

from __future__ import annotations

import matplotlib
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rvjax.report.blocks import Drawing
from rvjax.report.plotting import STYLE
from rvjax.report.run_view import open_run
from rvjax.report.sections import trajectories
from tests.export.conftest import ATTITUDE, PORT, Truth, made_folder


@pytest.fixture(scope="module")
def truth() -> Truth:
    return Truth.flown()


@pytest.fixture(scope="module")
def drawing(tmp_path_factory: pytest.TempPathFactory, truth: Truth) -> Drawing:
    """Of a flight that SciPy made, with a keep-out ellipsoid."""
    folder = made_folder(tmp_path_factory.mktemp("ways") / "run", truth, "keep_out: {radii_m: [9, 8, 7]}; hull: {radius_m: 3}")
    with matplotlib.rc_context(STYLE):
        section = trajectories.section(open_run(folder))
    assert section is not None
    return section.drawings[0]


def lines(drawing: Drawing, panel: int) -> dict[str, NDArray[np.float64]]:
    """The points of the lines of a panel, by label."""
    return {str(line.get_label()): np.array(line.get_data()).T for line in drawing.figure.axes[panel].get_lines()}


def test_the_orbital_frame(drawing: Drawing, truth: Truth) -> None:
    """Kills: axes of another frame, a sign of R-bar, a way from the port instead of the target's centre."""
    z = -truth.r / np.linalg.norm(truth.r, axis=1)[:, None]
    h = np.cross(truth.r, truth.v)
    x = np.cross(-h / np.linalg.norm(h, axis=1)[:, None], z)
    away = truth.p - truth.r
    expected = np.stack([np.sum(x * away, axis=1), np.sum(z * away, axis=1)], axis=1)
    np.testing.assert_allclose(lines(drawing, 0)["1"], expected, atol=1e-6)
    assert drawing.figure.axes[0].yaxis_inverted()


def test_the_port_frame(drawing: Drawing, truth: Truth) -> None:
    """Kills: a way from the target's centre, the axis of another frame, y in the place of z."""
    body = truth.target.inv().apply(truth.p - truth.r) - PORT
    n = PORT / np.linalg.norm(PORT)
    turn, _ = Rotation.align_vectors([n], [[1.0, 0.0, 0.0]])  # the shortest turn
    for panel, side in ((1, [0, 1, 0]), (2, [0, 0, 1])):
        expected = np.stack([body @ n, body @ turn.apply(side)], axis=1)
        np.testing.assert_allclose(lines(drawing, panel)["1"], expected, atol=1e-6)


def test_silhouettes(drawing: Drawing) -> None:
    """The outline of many points of the ellipsoid, seen in the port frame. Kills: a section in the place of the silhouette, radii
    of other axes, a zone about the port."""
    source = np.random.Generator(np.random.Philox(key=1))
    points = source.standard_normal((200_000, 3))
    points *= np.array([9.0, 8.0, 7.0]) / np.linalg.norm(points, axis=1)[:, None]
    n = PORT / np.linalg.norm(PORT)
    turn, _ = Rotation.align_vectors([n], [[1.0, 0.0, 0.0]])
    seen = np.stack([(points - PORT) @ n, (points - PORT) @ turn.apply([0, 1, 0])], axis=1)
    outline = lines(drawing, 1)["keep-out zone"]
    np.testing.assert_allclose(outline.max(axis=0), seen.max(axis=0), atol=0.02)
    np.testing.assert_allclose(outline.min(axis=0), seen.min(axis=0), atol=0.02)


def test_the_corridor_opens_by_its_angle(drawing: Drawing) -> None:
    """Kills: the full angle for the half."""
    (x0, y0), (x1, y1) = lines(drawing, 1)["corridor"]
    assert np.degrees(np.arctan2(y1 - y0, x1 - x0)) == pytest.approx(10.0)


def test_a_turning_target_has_no_corridor_in_the_orbital_frame(drawing: Drawing) -> None:
    """Kills: the corridor of one instant for the whole flight."""
    assert np.linalg.norm(ATTITUDE) > 0
    assert "there the corridor is left out" in drawing.caption
