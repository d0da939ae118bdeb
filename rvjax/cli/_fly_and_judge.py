"""What `run` and `check` share: fly a campaign, print the verdicts, give the exit code."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rvjax.cli._ci_outputs import CiOutputs, campaign_name
from rvjax.cli._output import Output, verdict_documents
from rvjax.cli._resuming import resumable
from rvjax.cli._timings import show_timings
from rvjax.errors import FolderError, RvjaxError
from rvjax.places import Place
from rvjax.timings import phase

if TYPE_CHECKING:
    from rvjax.analysis.baseline import BaselineComparison
    from rvjax.execution.executors import ExecutorFactory
    from rvjax.execution.run import FinishedRun


def fly_and_judge(
    file: Path,
    out: Path | None,
    values: Sequence[str],
    output: Output,
    ci_outputs: CiOutputs,
    *,
    dask: str | None = None,
    until_decided: bool = False,
    timings: bool = False,
    rare: int | None = None,
) -> int:
    """Flies a campaign and prints its verdicts; returns the exit code. When stopped, prints what is kept and how to resume.

    rare: the number of a requirement whose search of rare failures is shown in detail.
    """
    from rvjax.run_folder.storages import storage_of

    storage_of(out or Path("reports")).check()
    with ci_outputs.promised(file, campaign_name(file, values), out) as on_folder:
        ci_outputs.expect(file, values, until_decided=until_decided)
        flown_at = None if dask is None else _workers(dask, output)  # first: a wrong address is refused at once
        with phase("imports"):
            from rvjax.execution.preparation import prepare
        prepared = prepare(file, values, out)
        with phase("imports"):  # while LLVM compiles
            from rvjax import report  # noqa: F401
            from rvjax.execution.executors.threads import local_threads
            from rvjax.execution.run import RunOptions, fly

        with resumable(output, out) as on_open, output.progress() as on_progress:

            def opened(folder: Place) -> None:
                on_open(folder)
                on_folder()

            options = RunOptions(
                command=sys.argv,
                executor=flown_at or local_threads,
                until_decided=until_decided,
                on_progress=on_progress,
                on_open=opened,
                on_warnings=output.warnings,
                on_baseline=lambda name: output.note(f"{name}, on the same draws"),
                timings=timings,
            )
            finished = fly(file, out, values, options, prepared)
        with phase("report"):
            if rare is not None:
                _show_search(finished.folder, rare, output)
            code = _show(finished, output, ci_outputs, file)
        if timings:
            show_timings(output)
        return code


def _show_search(folder: Place, number: int, output: Output) -> None:
    """The levels of a search and the regions of failure."""
    from rvjax.run_folder import rare_record

    record = rare_record.read(folder, number)
    if record is None:
        return
    rows = [
        (
            "failure" if level.level == 0.0 else f"{level.level:.4g}",
            f"{level.split.value:.3g}",
            f"{level.share:.3f}",
            "–" if level.accepted is None else f"{100 * level.accepted:.0f} %",
            f"{level.count:,} of {record.ordinary:,}",
            "" if level.agrees else "disagrees",
        )
        for level in record.levels
    ]
    output.table(("level of the margin", "probability", "share of the last", "moves accepted", "ordinary flights", ""), rows)
    rows = [
        (f"{100 * region.share:.0f} %", f"{region.distance:.2f}", ", ".join(f"{m.name} {m.mean:+.1f}" for m in region.moved[:4]))
        for region in record.regions
    ]
    if rows:
        output.table(("failing points", "|z| of the nearest", "where, in σ"), rows)
        place = folder / rare_record.folder_of(number) / rare_record.FAILING
        output.text(f"the nearest failing flight of each region: rvjax run {place}")


def _workers(dask: str, output: Output) -> ExecutorFactory:
    """Dask workers."""
    with phase("imports"):
        from rvjax.execution.executors.dask_client import parse, workers

    return workers(parse(dask), output.note)


def judge(folder: Place, output: Output, ci_outputs: CiOutputs) -> int:
    """Prints the verdicts of a run folder; returns the exit code."""
    from rvjax.analysis.verdicts import account_and_verdicts
    from rvjax.execution.run import FinishedRun
    from rvjax.run_folder import CAMPAIGN, RunFolder

    campaign = Path(folder / CAMPAIGN)
    try:
        name = RunFolder.open(folder).name
    except FolderError:  # reported below
        name = campaign_name(campaign)
    with ci_outputs.promised(campaign, name):
        account, verdicts = account_and_verdicts(folder)
        return _show(FinishedRun(folder, account, verdicts), output, ci_outputs, campaign)


def _show(finished: FinishedRun, output: Output, ci_outputs: CiOutputs, file: Path) -> int:
    """Prints verdicts and writes the CI outputs; returns the exit code. file: the campaign whose lines are annotated."""
    from rvjax.analysis.verdicts import campaign_of, exit_code
    from rvjax.components.samplers import sampling_design_of
    from rvjax.run_folder import RunFolder

    account, verdicts = finished.account, finished.verdicts
    counts = {name: count for name, count in vars(account).items() if name != "requested"}
    parts = [f"{count} {name.replace('_', ' ')}" for name, count in counts.items()]
    output.text(f"{account.requested} samples: " + ", ".join(parts))
    output.verdicts(verdicts)
    folder = RunFolder.open(finished.folder)
    campaign = campaign_of(folder)
    if sentence := sampling_design_of(campaign).sentence:
        output.text(sentence)
    output.text(f"report: {finished.folder / 'report.html'}")
    worst = ci_outputs.worst_samples(folder, verdicts, output)
    comparisons: Sequence[BaselineComparison] = ()
    try:
        comparisons = ci_outputs.compare(finished.folder, output)
    except RvjaxError as error:
        ci_outputs.write(folder, campaign.name, verdicts, worst, output=output, file=file, error=str(error))
        raise
    ci_outputs.write(folder, campaign.name, verdicts, worst, comparisons, output=output, file=file)
    code = 1 if any(comparison.significant for comparison in comparisons) else exit_code(verdicts)
    documents = [document | {"worst_sample": sample} for document, sample in zip(verdict_documents(verdicts), worst, strict=True)]
    document = {"folder": str(finished.folder), "account": vars(account), "verdicts": documents, "exit_code": code}
    against = [{**vars(comparison), "significant": comparison.significant} for comparison in comparisons]
    output.document(document | ({} if ci_outputs.against is None else {"against": against}))
    return code
