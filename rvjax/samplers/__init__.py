"""Samplers: where the numbers of the samples come from. Host side, NumPy and SciPy only."""

from __future__ import annotations

from rvjax.basis import Basis
from rvjax.family import component
from rvjax.spec import Spec

MEMBERS = {
    "monte-carlo": "rvjax.samplers.monte_carlo",
    "latin-hypercube": "rvjax.samplers.latin_hypercube",
    "sobol": "rvjax.samplers.sobol",
    "grid": "rvjax.samplers.grid",
    "plan": "rvjax.samplers.plan",
    "points": "rvjax.samplers.points",
}


def basis_of(spec: Spec) -> Basis:
    """What the samples of a campaign are, and so what may be said of them."""
    return component("samplers", spec.sampler.use).basis
