"""`rvjax validate`: everything that can be checked without flying."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rvjax.cli import _completion
from rvjax.cli._app import Engine, Json, Samples, Seed, Sets, overrides
from rvjax.cli._output import Output

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rvjax.campaign.thruster_layout import Margin
    from rvjax.execution.audit import Audit
    from rvjax.simulation.problem import Problem


def command(
    files: Annotated[list[Path], typer.Argument(metavar="FILE…", help="Campaign files.", autocompletion=_completion.campaigns)],
    *,
    samples: Samples = None,
    seed: Seed = None,
    sets: Sets = None,
    engine: Engine = None,
    audit: Annotated[bool, typer.Option("--audit", help="Prove with a few flights that every dispersion acts.")] = False,
    as_json: Json = False,
) -> int:
    """Check campaigns and estimate time and memory. Does not fly, except with --audit."""
    output = Output(as_json)
    problems = _load(files, overrides(sets, samples, seed, engine))
    output.document({file: _describe(file, problem, audit, output) for file, problem in problems.items()})
    return 0


def _load(files: Sequence[Path], values: Sequence[str]) -> dict[str, Problem]:
    """The problem of every file. CampaignError with the findings of all files."""
    from rvjax.errors import CampaignError
    from rvjax.simulation import scene_checks
    from rvjax.simulation.effect import refused
    from rvjax.simulation.problem import load

    findings = []
    problems: dict[str, Problem] = {}
    for file in files:
        try:
            problem = load(file, values)
            findings += [*refused(problem), *scene_checks.findings(problem)]
            if problem.spec.tune is not None:
                from rvjax.search.tuning.tune import prepare

                prepare(file, values)
            problems[str(file)] = problem
        except CampaignError as error:
            findings += error.findings
    if findings:
        raise CampaignError(findings)
    return problems


def _describe(file: str, problem: Problem, audit: bool, output: Output) -> dict[str, object]:
    """Prints the cost of a campaign, its warnings, its losses of single thrusters and its audit; returns them as a document."""
    from rvjax.simulation import jax_config
    from rvjax.simulation.cautions import cautions
    from rvjax.simulation.cost import cost
    from rvjax.simulation.engines.choice import choice_of

    jax_config.configure(problem.spec.precision)
    expected, losses, choice = cost(problem), problem.spec.actuators.losses, choice_of(problem)
    output.text(f"{file}: {expected}; engine {choice.engine.name}")
    doubtful = cautions(problem)
    output.warnings(doubtful)
    document: dict[str, object] = {**vars(expected), "engine": choice.engine.name, "engine_reason": choice.reason}
    document["warnings"] = [vars(finding) for finding in doubtful]
    if problem.laws:
        document["laws"] = _laws(file, problem, output)
    if problem.spec.tune is not None:
        from rvjax.search.tuning.tune import plan

        output.text(f"{file}: tune: {plan(problem.spec)}")
    if losses:
        output.table(("thruster lost", "rank", "limits left", "first on"), _grouped(losses))
        document["single_losses"] = [vars(loss) for loss in losses]
    if audit:
        proof = _audit(problem)
        output.text(f"{file}: {proof}")
        document["audit"] = proof.record.model_dump()
    return document


def _laws(file: str, problem: Problem, output: Output) -> dict[str, object]:
    """Prints how many samples are kept under each law that the campaign names; returns it as a document."""
    from rvjax.simulation.named_laws import expected

    samples, found = problem.spec.samples, dict[str, object]()
    for name, law in problem.laws.items():
        kept = expected(samples, law)
        output.text(f"{file}: under {name}: about {kept:,} of {samples:,} samples are kept")
        found[name] = {"kept": kept, "beyond": law.beyond, **law.record()}
    return found


def _grouped(losses: Sequence[Margin]) -> list[tuple[str, ...]]:
    """A row for all losses with the same effect."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for loss in losses:
        groups.setdefault((str(loss.rank), f"{loss.share:.3f}", loss.channel), []).append(loss.lost)
    return [(", ".join(names), *row) for row, names in groups.items()]


def _audit(problem: Problem) -> Audit:
    """Proof that the dispersions of a campaign act."""
    from rvjax.execution.audit import prove, prove_baselines
    from rvjax.simulation.batch import Flyer

    proof = prove(problem, Flyer.of(problem))
    prove_baselines(problem)
    return proof
