"""What is hardly meant in a campaign. It flies all the same."""

from __future__ import annotations

from rvjax.errors import Finding
from rvjax.simulation import effect, plausibility
from rvjax.simulation.engines.choice import choice_of
from rvjax.simulation.problem import Problem


def cautions(problem: Problem) -> tuple[Finding, ...]:
    """Every warning, in the order of the file: what the steps cannot follow, what cannot fit the plant, and what keeps the fast
    engine from flying. In a process that is configured for the precision of the campaign."""
    findings = [*effect.warnings(problem), *plausibility.warnings(problem), *_engine(problem)]
    return tuple(sorted(dict.fromkeys(findings), key=lambda finding: finding.order))


def _engine(problem: Problem) -> list[Finding]:
    """A finding where a component keeps the engine `llvm` from flying."""
    choice = choice_of(problem)
    if not choice.place:
        return []
    found = f"flies with the engine xla, which is slower; in the way of llvm: {choice.reason}"
    return [problem.spec.source.finding(choice.place, found, "accepted: other operations there, or engine: xla")]
