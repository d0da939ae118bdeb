"""Commands that fly or judge: run, check, report, replay."""

from __future__ import annotations

import shlex
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rvjax.cli.app import Campaign, Dask, Folder, Json, JunitXml, Out, Quiet, Samples, Seed, Sets, Terminated, app, overrides
from rvjax.cli.output import Output, say, verdict_documents
from rvjax.cli.telling import Tell
from rvjax.errors import IncompleteError, RvjaxError, UsageError

if TYPE_CHECKING:
    from rvjax.analysis.baseline import BaselineComparison
    from rvjax.analysis.verdicts import Verdict
    from rvjax.run_folder import Account


@app.command()
def run(
    file: Campaign,
    out: Out = None,
    samples: Samples = None,
    seed: Seed = None,
    sets: Sets = None,
    dask: Dask = None,
    junit_xml: JunitXml = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Fly a campaign into a run folder, write the report, print the verdicts. Again on the same folder: resumes."""
    return fly(file, out, overrides(sets, samples, seed), Output(as_json, quiet), dask, Tell(junit_xml))


@app.command()
def check(
    place: Annotated[Path, typer.Argument(metavar="DIR|FILE", help="A run folder, or a campaign file, which is flown first.")],
    out: Out = None,
    samples: Samples = None,
    seed: Seed = None,
    sets: Sets = None,
    dask: Dask = None,
    junit_xml: JunitXml = None,
    against: Annotated[
        Path | None, typer.Option("--against", metavar="PATH", help="Fail where this is significantly worse than a baseline.")
    ] = None,
    write_baseline: Annotated[Path | None, typer.Option("--write-baseline", metavar="PATH", help="Make such a baseline.")] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Verdicts on a campaign's requirements, as words and as exit code. A FILE is flown until all are decided."""
    output, given = Output(as_json, quiet), overrides(sets, samples, seed)
    tell = Tell(junit_xml, against, write_baseline)
    if not place.is_dir():
        return fly(place, out, given, output, dask, tell, until_decided=True)
    if out is not None or given or dask is not None:
        accepted = "--junit-xml, --against, --write-baseline, --json, --quiet; or a campaign file"
        raise UsageError(f"{place}: a run folder is judged as it is; accepted: {accepted}")
    return judge(place, output, tell)


@app.command()
def report(folder: Folder, as_json: Json = False) -> int:
    """Make the report again from a run folder alone."""
    from rvjax.report import build

    output = Output(as_json)
    page = build(folder)
    output.text(str(page))
    output.document({"report": str(page)})
    return 0


@app.command()
def replay(
    folder: Folder,
    sample: Annotated[int, typer.Option("--sample", min=0, help="Number of the sample.")],
    out: Annotated[Path | None, typer.Option("--out", metavar="F", help="Trace file, .parquet or .csv.")] = None,
    every: Annotated[int, typer.Option("--every", min=1, help="Keep one step of so many.")] = 1,
    as_json: Json = False,
) -> int:
    """Fly one sample of a run again, with its full trace; its metrics equal the table's row."""
    from rvjax.execution.replay import replay as fly_again
    from rvjax.execution.replay import save, trace_file

    output = Output(as_json)
    target = trace_file(out or Path(f"sample-{sample:07d}.parquet"))
    trace, columns, row = fly_again(folder, sample, every)
    save(target, trace, columns)
    metrics = {name.removeprefix("metric."): value for name, value in row.items() if name.startswith("metric.")}
    output.text(f"sample {sample}: {row['outcome']} at {row['outcome_time_s']:.6g} s; {len(trace)} rows in {target}")
    output.table(("metric", "value"), [(name, f"{value:.6g}") for name, value in metrics.items()])
    output.document({"sample": sample, "outcome": row["outcome"], "trace": str(target), "rows": len(trace), "metrics": metrics})
    return 0


def fly(
    file: Path,
    out: Path | None,
    given: list[str],
    output: Output,
    dask: str | None = None,
    tell: Tell | None = None,
    until_decided: bool = False,
) -> int:
    """Flies a campaign and judges it; when stopped, says what is kept and how to go on."""
    from rvjax.execution.executors.threads import inline
    from rvjax.execution.run import run as fly_campaign

    tell = tell or Tell()
    tell.begin()
    crew = inline
    if dask is not None:
        from rvjax.execution.executors.dask_client import parse, workers

        crew = workers(parse(dask), output.note)

    started = time.monotonic()
    folder: list[Path] = []
    results: list[tuple[Account, tuple[Verdict, ...]]] = []
    try:
        with tell.broken(file.stem), output.progress() as progress:
            place = fly_campaign(
                file,
                out,
                given,
                progress,
                sys.argv,
                folder.append,
                crew,
                lambda *found: results.append(found),
                lambda name: output.note(f"{name}, on the same draws"),
                until_decided,
            )
    except (KeyboardInterrupt, Terminated, IncompleteError):
        if folder:
            again = [
                "rvjax",
                "check" if until_decided else "run",
                str(file),
                "--out",
                str(folder[0]),
                *(part for one in given for part in ("--set", one)),
            ]
            again += [] if dask is None else ["--dask", dask]
            say(f"stopped; what was flown is kept in {folder[0]}. Go on with\n  {shlex.join(again)}", sys.stderr)
            output.document({"stopped": str(folder[0]), "go_on_with": again})
        raise
    output.note(f"done in {time.monotonic() - started:.0f} s")
    return _show(place, *results[0], output, tell, file)


def judge(folder: Path, output: Output, tell: Tell) -> int:
    """Prints the verdicts of a run folder; returns the exit code."""
    from rvjax.analysis.verdicts import account_and_verdicts

    tell.begin()
    with tell.broken(folder.absolute().name):
        found = account_and_verdicts(folder)
    return _show(folder, *found, output, tell, folder / "campaign.yaml")


def _show(folder: Path, account: Account, verdicts: Sequence[Verdict], output: Output, tell: Tell, file: Path) -> int:
    """Prints verdicts, and tells them to whoever runs this. file: the campaign, on whose lines they are annotated."""
    from rvjax.analysis.verdicts import campaign_of, exit_code
    from rvjax.components.samplers import sampling_design_of
    from rvjax.run_folder import RunFolder

    counts = {name: count for name, count in vars(account).items() if name != "requested"}
    output.text(
        f"{account.requested} samples: " + ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in counts.items())
    )
    output.verdicts(verdicts)
    opened = RunFolder.open(folder)
    campaign = campaign_of(opened)
    if sentence := sampling_design_of(campaign).sentence:
        output.text(sentence)
    output.text(f"report: {folder / 'report.html'}")
    worst = tell.worst(opened, verdicts, output)
    compared: Sequence[BaselineComparison] = ()
    try:
        compared = tell.compare(folder, output)
    except RvjaxError as error:
        tell.tell(opened, campaign.name, verdicts, worst, (), output, file, str(error))
        raise
    tell.tell(opened, campaign.name, verdicts, worst, compared, output, file)
    code = 1 if any(one.significant for one in compared) else exit_code(verdicts)
    told = [one | {"worst_sample": sample} for one, sample in zip(verdict_documents(verdicts), worst, strict=True)]
    document = {"folder": str(folder), "account": vars(account), "verdicts": told, "exit_code": code}
    against = [{**vars(one), "significant": one.significant} for one in compared]
    output.document(document | ({} if tell.against is None else {"against": against}))
    return code
