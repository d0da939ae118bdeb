"""The picture of the guidance is that of its script, and its way is that of the law."""

from __future__ import annotations

import math
import runpy
from pathlib import Path

import jax.numpy as jnp
import pytest

from rvjax.components.guidance import corridor
from rvjax.components.guidance.interface import Situation
from rvjax.physics.state import Motion, Numbers, TargetMotion
from rvjax.physics.state import Path as Reference
from rvjax.physics.vectors import Vector

DOCS = Path(__file__).parents[2] / "docs"
SCRIPT = runpy.run_path(str(DOCS / "guidance_path.py"))


def test_the_picture_is_that_of_its_script() -> None:
    """Kills: a script that was changed without its picture."""
    assert (DOCS / "guidance-path.svg").read_text(encoding="utf-8") == SCRIPT["picture"](), "run: python docs/guidance_path.py"


def test_the_way_in_the_picture_is_that_of_the_law() -> None:
    """The wanted velocities at places of every part of the way, those of the package for a target at rest with the pursuer at the
    point, and the defaults of the gains. Kills: a picture of another law, or of other gains."""
    defaults = {name: q.medians[0] for name, q in corridor.Parameters().quantities().items()}
    numbers = Numbers({name: jnp.asarray(x) for name, x in defaults.items()})
    nothing, places = Vector(0.0, 0.0, 0.0), SCRIPT["way"]()
    target = TargetMotion(Vector(0.0, 0.0, 1.0e30), nothing, nothing)
    for x, y in places[:: len(places) // 12]:
        point = Vector(jnp.asarray(x), jnp.asarray(y), jnp.asarray(0.0))
        motion = Motion(point, nothing, nothing, nothing)
        port = Vector(SCRIPT["PORT"], 0.0, 0.0)
        situation = Situation(jnp.asarray(0.0), motion, target, nothing, port, Vector(1.0, 0.0, 0.0))
        path = Reference(jnp.asarray(0.0), point, nothing, nothing)
        u = corridor.wanted(situation, path, (), numbers).velocity
        assert [float(u.x), float(u.y)] == pytest.approx(SCRIPT["wanted"]((x, y)), abs=1e-6)
    outside = [math.hypot(x + SCRIPT["PORT"], y) for x, y in places if abs(y) > 1.0]
    assert min(outside) > SCRIPT["KEEP_OUT"]
    assert math.hypot(*places[-1]) < 0.05
