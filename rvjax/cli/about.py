"""Commands that fly nothing: init, validate, list, explain, schema, doctor."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rvjax.cli.app import Json, Samples, Seed, Sets, app, overrides
from rvjax.cli.output import Output

if TYPE_CHECKING:
    from rvjax.campaign.thruster_layout import Margin
    from rvjax.execution.audit import Audit
    from rvjax.simulation.problem import Problem


@app.command()
def init(
    folder: Annotated[Path, typer.Argument(metavar="[DIR]", help="Where to write; default here.")] = Path(),
    as_json: Json = False,
) -> int:
    """Write a commented starter campaign, and the schema that editors complete it with."""
    from rvjax.cli.starter import write

    output = Output(as_json)
    campaign, schema = write(folder)
    output.text(str(campaign), str(schema))
    output.note(f"fly it with\n  rvjax run {campaign}")
    output.document({"campaign": str(campaign), "schema": str(schema)})
    return 0


@app.command()
def validate(
    files: Annotated[list[Path], typer.Argument(metavar="FILE…", help="Campaign files.")],
    samples: Samples = None,
    seed: Seed = None,
    sets: Sets = None,
    audit: Annotated[bool, typer.Option("--audit", help="Prove by a few flights that every dispersion acts.")] = False,
    as_json: Json = False,
) -> int:
    """Parse campaigns, check units and ranges, print samples, chunks, estimated time and memory. Flies nothing, or an audit."""
    from rvjax.errors import CampaignError
    from rvjax.simulation.cost import cost
    from rvjax.simulation.problem import load

    output = Output(as_json)
    findings = []
    problems: dict[str, Problem] = {}
    for file in files:
        try:
            problems[str(file)] = load(file, overrides(sets, samples, seed))
            if problems[str(file)].spec.tune is not None:
                from rvjax.search.tuning.tune import prepare

                prepare(file, overrides(sets, samples, seed))
        except CampaignError as error:
            findings += error.findings
    if findings:
        raise CampaignError(findings)
    documents: dict[str, dict[str, object]] = {}
    for file, problem in problems.items():
        expected, losses = cost(problem), problem.spec.actuators.losses
        output.text(f"{file}: {expected}")
        documents[file] = dict(vars(expected))
        if problem.spec.tune is not None:
            from rvjax.search.tuning.tune import plan

            output.text(f"{file}: tune: {plan(problem.spec)}")
        if losses:
            output.table(("one lost", "rank", "limits left", "first on"), _alike(losses))
            documents[file]["single_losses"] = [vars(loss) for loss in losses]
        if audit:
            found = _proven(problem)
            output.text(f"{file}: {found}")
            documents[file]["audit"] = found.record.model_dump()
    output.document(documents)
    return 0


def _alike(losses: list[Margin]) -> list[tuple[str, ...]]:
    """A row for all losses that leave the same."""
    alike: dict[tuple[str, ...], list[str]] = {}
    for loss in losses:
        alike.setdefault((str(loss.rank), f"{loss.share:.3f}", loss.channel), []).append(loss.lost)
    return [(", ".join(names), *row) for row, names in alike.items()]


def _proven(problem: Problem) -> Audit:
    """Proof that the dispersions of a campaign act."""
    from rvjax.execution.audit import prove
    from rvjax.simulation import jax_config
    from rvjax.simulation.batch import Flyer

    jax_config.configure(problem.spec.precision)
    return prove(problem, Flyer(problem.loop, problem.metrics))


@app.command("list")
def list_components(as_json: Json = False) -> int:
    """The components there are, and where each comes from."""
    from rvjax.components import manual

    output = Output(as_json)
    found = [(family, name, origin, manual.page(family, name).summary) for family, name, origin in manual.components()]
    for family in dict.fromkeys(row[0] for row in found):
        rows = [(name, f"{summary}\n{origin}") for own, name, origin, summary in found if own == family]
        output.table((family, "what it is, and where it comes from"), rows)
    output.document({"components": [dict(zip(("family", "name", "from", "summary"), row, strict=True)) for row in found]})
    return 0


@app.command()
def explain(
    name: Annotated[str, typer.Argument(help="A component, a metric, a distribution, or a section of the campaign file.")],
    as_json: Json = False,
) -> int:
    """One component's manual page: equations, source, parameters with units and defaults."""
    from rvjax.components import manual

    output = Output(as_json)
    pages = manual.pages_called(name)
    for page in pages:
        output.text(f"{page.name}  ({page.family}, from {page.origin})", "", page.text, "")
        if page.rows:
            output.table(("key", "accepted", "default", "meaning"), page.rows)
    output.document({"pages": [vars(page) for page in pages]})
    return 0


@app.command()
def schema(as_json: Json = False) -> int:
    """The JSON Schema of a campaign file, with the parameters of every component."""
    from rvjax.components.manual import campaign_schema

    del as_json  # it is JSON anyway
    print(json.dumps(campaign_schema(), indent=2, ensure_ascii=False))
    return 0


@app.command()
def doctor(
    folder: Annotated[Path | None, typer.Argument(metavar="[DIR]", help="A run folder to verify as well.")] = None,
    as_json: Json = False,
) -> int:
    """Versions, devices, settings, and what is wrong with them; with DIR, whether every file of a run is intact."""
    from rvjax.execution.doctor import examine

    output = Output(as_json)
    found = examine(folder)
    output.table(("what", "value"), [(name, str(value)) for name, value in found.facts.items()])
    output.text(*[f"wrong: {complaint}" for complaint in found.complaints] or ["nothing is wrong"])
    output.document({"facts": found.facts, "complaints": found.complaints, "exit_code": found.exit_code})
    return found.exit_code
