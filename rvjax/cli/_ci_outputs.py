"""What `run` and `check` write for a CI service: JUnit XML, a comparison with a baseline, annotations on GitHub."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from rvjax.cli._app import reason
from rvjax.cli._output import Output, say
from rvjax.errors import FolderError, RvjaxError, UsageError
from rvjax.places import Place
from rvjax.timings import phase

if TYPE_CHECKING:
    from rvjax.analysis.baseline import BaselineComparison
    from rvjax.analysis.verdicts import Verdict
    from rvjax.run_folder import RunFolder


@dataclass
class CiOutputs:
    """junit_xml: a file to write. against: a baseline to compare with. write_baseline: a baseline to write."""

    junit_xml: Path | None = None
    against: Path | None = None
    write_baseline: Path | None = None
    _judged: bool = field(default=False, init=False)

    def expect(self, file: Path, values: Sequence[str], *, until_decided: bool) -> None:
        """Checks a campaign against the baseline before it flies. until_decided: the run may end before all samples are flown."""
        if self.against is None:
            return
        from rvjax.analysis import baseline
        from rvjax.campaign.model import load

        campaign = load(file, values)
        early = until_decided and all(requirement.is_sequential for requirement in campaign.require)
        baseline.check(self.against, campaign.require, None if early else campaign.samples)

    @contextmanager
    def promised(self, campaign: Path, name: str, out: Path | None = None) -> Iterator[Callable[[], None]]:
        """Whatever happens inside, the JUnit XML of this run is written: its verdicts, or why there are none.

        At first the file says that the run has not ended, for a process that is killed. Gives the function to call once the run
        folder is there. name: of the test suite, the campaign's. out: a new run folder, which must be empty until it is made.
        UsageError where `against` is no baseline, or where a file cannot be written; nothing has flown then.
        """
        self._check(campaign)
        early = self.junit_xml is None or out is None or not self.junit_xml.absolute().is_relative_to(out.absolute())
        if early:
            self._begin(name)
        elif self.junit_xml is not None:
            self.junit_xml.unlink(missing_ok=True)
        try:
            if self.against is not None:
                from rvjax.analysis import baseline

                baseline.read(self.against)
            yield lambda: None if early else self._begin(name)
        except BaseException as error:
            if not self._judged:
                self._write_error(name, error)
            raise

    def _check(self, campaign: Path) -> None:
        """UsageError where a file cannot be written, or where writing it would destroy what the command reads."""
        from rvjax.run_folder import atomic_files

        read = {os.path.realpath(campaign): "the campaign"}
        if self.against is not None:
            read[os.path.realpath(self.against)] = "the baseline"
        for option, path in (("--junit-xml", self.junit_xml), ("--write-baseline", self.write_baseline)):
            if path is None:
                continue
            what = read.get(os.path.realpath(path))
            if what is not None and (option, what) != ("--write-baseline", "the baseline"):
                raise UsageError(f"{option} {path}: this file is {what}; accepted: another path")
            read[os.path.realpath(path)] = f"the file of {option}"
            atomic_files.check_file(path)

    def _begin(self, name: str) -> None:
        """The JUnit XML of a run that has not ended."""
        self._write_junit(name, error="the run has not ended: it is running, or it was killed")

    def _write_error(self, name: str, error: BaseException) -> None:
        """The JUnit XML of a run without verdicts."""
        try:
            self._write_junit(name, error=reason(error))
        except RvjaxError as problem:  # the first error is the one to report
            say(str(problem), sys.stderr)

    def worst_samples(self, folder: RunFolder, verdicts: Sequence[Verdict], output: Output) -> list[int | None]:
        """The worst sample for each requirement that does not pass; None where it passes or no output shows it."""
        if self.junit_xml is None and not output.as_json:
            return [None] * len(verdicts)
        from rvjax.analysis.worst_samples import worst_samples

        failing = [index for index, verdict in enumerate(verdicts) if verdict.verdict != "PASS"]
        samples = worst_samples(folder, [verdicts[index].requirement for index in failing])
        worst = dict(zip(failing, samples, strict=True))
        return [worst.get(index) for index in range(len(verdicts))]

    def compare(self, folder: Place, output: Output) -> Sequence[BaselineComparison]:
        """Compares the run with the baseline, then writes the new baseline."""
        comparisons: Sequence[BaselineComparison] = ()
        if self.against is None and self.write_baseline is None:
            return comparisons
        from rvjax.analysis import baseline

        if self.against is not None:
            comparisons = baseline.against(folder, self.against)
            rows = [
                ("WORSE" if result.significant else "–", result.what, str(result.worse), str(result.better), f"{result.p:.2g}")
                for result in comparisons
            ]
            output.table(("", f"against {self.against}", "worse", "better", "p"), rows)
        if self.write_baseline is not None:
            baseline.write(folder, self.write_baseline)
            output.note(f"baseline: {self.write_baseline}")
        return comparisons

    def write(
        self,
        folder: RunFolder,
        name: str,
        verdicts: Sequence[Verdict],
        worst: Sequence[int | None],
        comparisons: Sequence[BaselineComparison] = (),
        *,
        output: Output,
        file: Path,
        error: str = "",
    ) -> None:
        """Writes JUnit XML where it is asked for; annotations and a job summary inside GitHub Actions. name: the campaign's.
        file: the campaign whose lines are annotated. error: why the comparison failed."""
        from rvjax.report.ci import github

        self._judged = True
        if self.junit_xml is None and not github.active():
            return
        from rvjax.campaign.source import read

        self._write_junit(name, verdicts, [_advice(folder.path, sample) for sample in worst], comparisons, error=error)
        if github.active():
            source = read(file)
            output.annotate(github.of_verdicts(verdicts, [source.where(("require", n)) for n in range(len(verdicts))]))
            output.annotate(github.of_comparisons(comparisons, str(self.against), source.where(("controller",), key=True)))
            try:
                github.append_summary(github.summary(name, verdicts, comparisons))
            except OSError as problem:
                output.note(f"no job summary: {problem}")

    def _write_junit(
        self,
        name: str,
        verdicts: Sequence[Verdict] = (),
        advice: Sequence[str] = (),
        comparisons: Sequence[BaselineComparison] = (),
        *,
        error: str,
    ) -> None:
        if self.junit_xml is None:
            return
        from rvjax.report.ci import junit
        from rvjax.run_folder import atomic_files

        cases = [*junit.of_verdicts(verdicts, advice), *junit.of_comparisons(comparisons, str(self.against))]
        if error:
            cases.append(junit.of_error("baseline" if verdicts else "campaign", error))
        try:
            atomic_files.replace(self.junit_xml, junit.junit(name, cases))
        except FolderError as problem:
            raise UsageError(f"{self.junit_xml}: cannot be written: {_why(problem)}; accepted: another path") from problem


def _why(problem: FolderError) -> str:
    """What the file system says."""
    cause = problem.__cause__
    return (cause.strerror if isinstance(cause, OSError) else None) or str(problem)


def campaign_name(file: Path, values: Sequence[str] = ()) -> str:
    """The name that a campaign file states, also where the campaign is wrong elsewhere; else the name of the file."""
    with phase("imports"):
        from rvjax.campaign.overrides import override
        from rvjax.campaign.source import read

    with phase("load"):
        stated = (override(read(file), values).value or {}).get("name")
    return stated if isinstance(stated, str) and stated.strip() else file.stem


def _advice(folder: Place, sample: int | None) -> str:
    """The path of the report, and the command that replays the worst sample."""
    replay = "" if sample is None else f"\nrvjax replay {shlex.quote(str(folder))} --sample {sample}"
    return f"report: {folder / 'report.html'}{replay}"
