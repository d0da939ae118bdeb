"""Preparation: a campaign becomes a problem with its identity, and its step begins to compile.

This module imports neither pandas nor what writes tables: those are imported while LLVM compiles in another thread.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rvjax.campaign import Source
from rvjax.execution.identity import identity, short
from rvjax.places import Place, place_of
from rvjax.run_folder.storages import is_run_folder
from rvjax.simulation import jax_config
from rvjax.simulation.draws import Draws
from rvjax.simulation.engines.choice import engine_of
from rvjax.simulation.problem import Problem, load
from rvjax.timings import phase


class Prepared(NamedTuple):
    """A problem, in a process that is configured for its precision; its identity; and the run folder that it flies into."""

    problem: Problem
    identity: Mapping[str, Any]
    place: Place


def prepare(path: str | Path | Source, overrides: Sequence[str], out: str | Place | None) -> Prepared:
    """Loads a campaign. out: the run folder, by default `reports/<name>/<identity>`. Where that is no run folder yet, the step
    begins to compile. Errors: CampaignError with every finding."""
    with phase("load"):
        problem = load(path, overrides)
        jax_config.configure(problem.spec.precision)
        flown_by = identity(problem)
        place = place_of(out) if out is not None else Path("reports") / problem.spec.name / short(flown_by)
        if not is_run_folder(place):
            drawn = Draws.of(problem, np.arange(1, dtype=np.int64))[1]
            engine_of(problem).prepare(drawn, problem.spec.samples * problem.spec.horizon.steps)
    return Prepared(problem, flown_by, place)
