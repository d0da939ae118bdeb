"""`rvjax rare`: the probability of a rare failure, by a search beside the samples."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

from rvjax.cli._app import Campaign, Engine, Json, JunitXml, Out, Quiet, Samples, Seed, Sets, overrides
from rvjax.cli._ci_outputs import CiOutputs
from rvjax.cli._fly_and_judge import fly_and_judge
from rvjax.cli._output import Output


def command(
    file: Campaign,
    *,
    requirement: Annotated[int, typer.Option("--requirement", min=1, metavar="N", help="Which requirement, from 1.")] = 1,
    method: Annotated[
        Literal["splitting", "importance"] | None,
        typer.Option("--method", help="Replaces the campaign's; default splitting where the campaign has neither."),
    ] = None,
    flights: Annotated[
        int | None, typer.Option("--flights", min=10_000, help="Flights of the search; replaces the campaign's budget.")
    ] = None,
    minutes: Annotated[
        float | None, typer.Option("--minutes", min=0.01, help="Minutes of the search; replaces the campaign's budget.")
    ] = None,
    out: Out = None,
    samples: Samples = None,
    seed: Seed = None,
    sets: Sets = None,
    engine: Engine = None,
    junit_xml: JunitXml = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Estimate the probability of a rare failure. Resumes a folder."""
    output, values = Output(as_json, quiet), overrides(sets, samples, seed, engine)
    values = [*values, *_of_requirement(file, values, requirement, method, flights, minutes)]
    return fly_and_judge(file, out, values, output, CiOutputs(junit_xml), rare=requirement)


def _of_requirement(
    file: Campaign, values: list[str], number: int, method: str | None, flights: int | None, minutes: float | None
) -> list[str]:
    """Overrides that make a requirement one on rare failures. CampaignError where there is no such requirement."""
    from rvjax.campaign import load
    from rvjax.errors import CampaignError

    spec = load(file, values)
    if not 1 <= number <= len(spec.require):
        accepted = f"1 to {len(spec.require)}" if spec.require else "a campaign with a section require"
        message = f"there is no requirement {number}"
        raise CampaignError([spec.source.finding(("require",), message, f"accepted: {accepted}", key=True)])
    place, requirement = f"require.{number - 1}", spec.require[number - 1]
    chosen = method or (requirement.method if requirement.is_rare else "splitting")
    more = [f"{place}.method={chosen}"] if chosen != requirement.method else []
    more += [f"{place}.{name}=null" for name in ("expected", "power") if getattr(requirement, name) is not None]
    budget = {"flights": flights, "minutes": minutes}
    given = ", ".join(f"{name}: {value}" for name, value in budget.items() if value is not None)
    return [*more, f"{place}.budget={{{given}}}"] if given else more
