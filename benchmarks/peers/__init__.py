"""The same small job in rvjax and in its peers, each in its environment: `python -m benchmarks.peers`. See docs/peers.md."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent


class Peer(NamedTuple):
    """package: what its script imports. install: how its environment is made. files: the job, in this folder.

    tolerance: how far its final distances may be from those of rvjax [m].
    """

    package: str
    install: str
    files: tuple[str, ...]
    tolerance: float


PEERS = {
    "numpy": Peer("numpy", "pip install numpy", ("with_numpy.py",), 1e-9),
    "openturns": Peer("openturns", "pip install openturns", ("with_openturns.py", "with_numpy.py"), 1e-9),
    "vbar": Peer("vbar", "pip install vbar (Python 3.12 or later)", ("with_vbar.py",), 1e-4),
    "cbfkit": Peer("cbfkit", "pip install . in a clone of github.com/bardhh/cbfkit", ("with_cbfkit.py",), 1e-9),
    "basilisk": Peer("Basilisk", "pip install bsk", ("with_basilisk.py",), 1e-6),
}
"""Tolerances. 1e-9: the same equations and integrator, rounded in another order. 1e-6: positions of 6.9e6 m in float64 are 1e-9 m
apart, 600 steps. 1e-4: the motion of Clohessy and Wiltshire leaves out 3n² (150 m)²/a = 1e-8 m/s² at 150 m, which a law of
9e-4/s² holds within 1e-5 m."""
