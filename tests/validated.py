"""A campaign read as `rvjax validate` reads it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rvjax.errors import CampaignError
from rvjax.simulation import scene_checks
from rvjax.simulation.effect import refused
from rvjax.simulation.problem import Problem, load


def validated(path: Path, overrides: Sequence[str] = ()) -> Problem:
    """The problem of a campaign; CampaignError also for what never acts."""
    problem = load(path, overrides)
    if findings := [*refused(problem), *scene_checks.findings(problem)]:
        raise CampaignError(findings)
    return problem
