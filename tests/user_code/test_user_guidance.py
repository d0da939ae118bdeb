"""A user's guidance: with a memory, in LVLH, and with mistakes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rvjax.execution.replay import replay
from rvjax.execution.run import run
from tests.oracles.reference_point import columns
from tests.program import Run
from tests.short import CAMPAIGN

FILE = '''"""Waits for a time, then goes along V-bar."""
import jax.numpy as jnp
from rvjax.components import Course, Guidance, GuidanceParameters, scalar


class Along(GuidanceParameters):
    """Times."""

    wait_s: float = scalar("s", default=3.0, at_least=0.0, doc="time to wait")


def start(approach, numbers):
    return jnp.zeros(())


def course(approach, since, numbers):
    down = -approach.target_r / jnp.linalg.norm(approach.target_r)
    h = jnp.cross(approach.target_r, approach.target_v)
    ahead = jnp.cross(-h / jnp.linalg.norm(h), down)
    return Course(jnp.where(since >= numbers.wait_s, 0.2, 0.0) * ahead, since + 0.05)


GUIDANCE = Guidance(Along, course, start, frame="lvlh")
'''
SETS = ("samples=2", "faults=[]", "disturbances=[]", "require=[]", "guidance={use: ./along.py}", "controller={use: pd-plus}",
        "correlate=[]", "audit={allow: [start, pursuer]}", "capture.window_s=5", "start.nu_m_s=0")  # fmt: skip


@pytest.mark.usefixtures("bare")
def test_a_memory_and_lvlh(tmp_path: Path) -> None:
    """The point of a user's guidance waits by its memory and then moves along V-bar, as LVLH from r and v says. Kills: a
    velocity relative to T, a memory that is not kept, or that begins anew."""
    campaign = tmp_path / "campaign.yaml"
    campaign.write_text(CAMPAIGN.read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "along.py").write_text(FILE, encoding="utf-8")
    trace = replay(run(campaign, tmp_path / "run", [*SETS, "horizon.duration_s=23"], progress=False), 0)[0]
    r, v = columns(trace, "target_r_*_m"), columns(trace, "target_v_*_m_s")
    q = columns(trace, "ref_*_m") + np.array([5.0, 0.0, 0.0])
    h = np.cross(r, v)
    z, y = -r / np.linalg.norm(r, axis=1, keepdims=True), -h / np.linalg.norm(h, axis=1, keepdims=True)
    placed = np.stack([np.sum(axis * q, axis=1) for axis in (np.cross(y, z), y, z)], axis=1)
    speed = np.gradient(placed, trace["t_s"], axis=0)
    t = trace["t_s"].to_numpy()
    resting = (t > 2.7) & (t < 2.95)
    moving = t > 18.0
    assert np.max(np.abs(speed[moving] - [0.2, 0.0, 0.0])) < 2e-3
    assert np.max(np.abs(speed[resting][:, 0])) < 0.05
    assert speed[np.argmax(t > 4.5), 0] > speed[resting][-1, 0] + 0.015


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("* ahead, since", "* ahead[:2], since", "the velocity of course has the shape (2,)"),
        (", since + 0.05)", ", (since, since))", "the memory of course"),
        ("Course(jnp.where", "(jnp.where", "course returns a tuple"),
        ("Along(GuidanceParameters)", "Along(Parameters)", "a class that inherits from GuidanceParameters"),
        ('frame="lvlh"', 'frame="LVLH"', "target or lvlh"),
        ("since >= numbers.wait_s", "since >= 3.0", "does not use wait_s"),
    ],
)
def test_mistakes_are_named(old: str, new: str, words: str, tmp_path: Path, rvjax: Run) -> None:
    """Exit code 2 with the file and the words. Kills: a traceback, a wrong result that flies."""
    assert old in FILE
    text = FILE.replace(old, new).replace("GuidanceParameters, scalar", "GuidanceParameters, Parameters, scalar")
    (tmp_path / "along.py").write_text(text, encoding="utf-8")
    code, _, err = rvjax("check-component", tmp_path / "along.py")
    assert code == 2
    assert words in err
    assert "along.py:" in err
    assert "Traceback" not in err
