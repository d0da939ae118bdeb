"""SHA-256 of draws, for every shipped campaign and for every law: `python -m tests.golden.digests` prints them.

    python -m tests.golden.digests --write

writes tests/golden/draws.json anew, after a change of draws that is meant. A digest is that of the float64 columns of the first
chunk and of all numbers of its flights. Only `every-law sobol` may change with the versions of NumPy and SciPy.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import jax
import numpy as np

from rvjax.campaign.actuators import Thrusters
from rvjax.campaign.thruster_layout import LAYOUTS, Layout, limits
from rvjax.elementary.pseudo_inverse import pseudo_inverse
from rvjax.simulation import jax_config
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load

HOME = Path(__file__).parent
STORED = HOME / "draws.json"
CAMPAIGNS = HOME.parents[1] / "campaigns"
EVERY_LAW = HOME / "every-law.yaml"
SAMPLES = 416
START = (
    "start={frame: %s, relative_to: lvlh, position_m: {box: 60}, velocity_m_s: {ball: 0.1}, "
    "attitude_mrp: {rotation: uniform}, rate_deg_s: {box: 1}}"
)
AXIS = "target.port_axis=[-2, 0.3, 1]"


def cases() -> dict[str, tuple[Path, Sequence[str]]]:
    """By name: a campaign and overrides."""
    shipped = {path.stem: (path, ()) for path in sorted(CAMPAIGNS.glob("*.yaml"))}
    samplers = {f"every-law {use}": (EVERY_LAW, (f"sampler={{use: {use}}}",)) for use in ("latin-hypercube", "sobol")}
    framed = {f"every-law {frame}": (EVERY_LAW, (START % frame, AXIS)) for frame in ("port", "lvlh", "pursuer")}
    return {**shipped, "every-law": (EVERY_LAW, ()), **samplers, **framed}


def digest(columns: Iterable[tuple[str, Any]]) -> str:
    """Of names and float64 numbers."""
    total = hashlib.sha256()
    for name, values in columns:
        total.update(name.encode() + b"\0" + np.ascontiguousarray(values, dtype="<f8").tobytes())
    return total.hexdigest()[:16]


def of_campaign(path: Path, overrides: Sequence[str]) -> str:
    """Of its draws and of the numbers of its flights."""
    draws, drawn = Draws.of(load(path, overrides), np.arange(SAMPLES, dtype=np.int64))
    return digest([*sorted(draws.values.items()), *(("", leaf) for leaf in jax.tree.leaves(drawn))])


def of_layout(layout: Layout) -> str:
    """Of the limits and the pseudo-inverse of thrusters, which are constants of a flight."""
    scaled = layout.matrix * np.array(layout.most) / np.sum(limits(layout), axis=0)[:, None]
    return digest([("limits", limits(layout)), ("inverse", pseudo_inverse(scaled))])


def digests() -> dict[str, str]:
    """All of them, by name."""
    crooked = load(EVERY_LAW).spec.actuators
    assert isinstance(crooked, Thrusters)
    layouts = {name: make(1.1, 1.3) for name, make in LAYOUTS.items()} | {"thrusters of every-law": crooked.geometry}
    return {name: of_campaign(*case) for name, case in cases().items()} | {
        name: of_layout(layout) for name, layout in layouts.items()
    }


if __name__ == "__main__":
    jax_config.configure("float64")
    text = json.dumps(digests(), indent=2) + "\n"
    if "--write" in sys.argv[1:]:
        STORED.write_text(text, encoding="utf-8")
    else:
        print(text, end="")
