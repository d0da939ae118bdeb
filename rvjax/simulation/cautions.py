"""What is hardly meant in a campaign. It flies all the same."""

from __future__ import annotations

from rvjax.errors import Finding
from rvjax.simulation import effect, plausibility
from rvjax.simulation.problem import Problem


def cautions(problem: Problem) -> tuple[Finding, ...]:
    """Every warning, in the order of the file: what the steps cannot follow, and what cannot fit the plant."""
    findings = [*effect.warnings(problem), *plausibility.warnings(problem)]
    return tuple(sorted(dict.fromkeys(findings), key=lambda finding: finding.order))
