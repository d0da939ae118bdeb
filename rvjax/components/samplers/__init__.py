"""Samplers: they give the uniform numbers that decide the draws. One file per member; NumPy and SciPy only, no JAX."""

from __future__ import annotations

from rvjax.campaign import Spec
from rvjax.campaign.python_files import PythonFile
from rvjax.components.registry import component
from rvjax.stats.sampling_design import Exploration, SamplingDesign

MEMBERS = {
    "monte-carlo": "rvjax.components.samplers.monte_carlo",
    "latin-hypercube": "rvjax.components.samplers.latin_hypercube",
    "sobol": "rvjax.components.samplers.sobol",
    "grid": "rvjax.components.samplers.grid",
    "plan": "rvjax.components.samplers.values_table",
    "points": "rvjax.components.samplers.uniforms_table",
}


def sampling_design_of(spec: Spec) -> SamplingDesign:
    """The sampling design of a campaign: whether its samples are independent, and so whether verdicts are possible. A sampler in
    a user's file counts as an exploration: nobody has proved that its samples are independent, and judging a run does not execute
    its code."""
    if isinstance(spec.sampler.use, PythonFile):
        return Exploration()
    return component("samplers", spec.sampler.use).design
