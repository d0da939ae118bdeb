"""Samplers: where the numbers of the samples come from. Host side, NumPy and SciPy only."""

from __future__ import annotations

from rvjax.campaign import Spec
from rvjax.components.registry import component
from rvjax.stats.sampling_design import SamplingDesign

MEMBERS = {
    "monte-carlo": "rvjax.components.samplers.monte_carlo",
    "latin-hypercube": "rvjax.components.samplers.latin_hypercube",
    "sobol": "rvjax.components.samplers.sobol",
    "grid": "rvjax.components.samplers.grid",
    "plan": "rvjax.components.samplers.values_table",
    "points": "rvjax.components.samplers.uniforms_table",
}


def sampling_design_of(spec: Spec) -> SamplingDesign:
    """What the samples of a campaign are, and so what may be said of them."""
    return component("samplers", spec.sampler.use).basis
