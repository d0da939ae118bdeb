"""`rvjax run`: flies a campaign into a run folder."""

from __future__ import annotations

from rvjax.cli._app import Campaign, Dask, Engine, Json, JunitXml, Out, Quiet, Samples, Seed, Sets, TimingsOption, overrides
from rvjax.cli._ci_outputs import CiOutputs
from rvjax.cli._fly_and_judge import fly_and_judge
from rvjax.cli._output import Output


def command(
    file: Campaign,
    *,
    out: Out = None,
    samples: Samples = None,
    seed: Seed = None,
    sets: Sets = None,
    engine: Engine = None,
    dask: Dask = None,
    junit_xml: JunitXml = None,
    timings: TimingsOption = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Fly a campaign, write its report, print the verdicts. Resumes a folder."""
    output = Output(as_json, quiet)
    values = overrides(sets, samples, seed, engine)
    return fly_and_judge(file, out, values, output, CiOutputs(junit_xml), dask=dask, timings=timings)
