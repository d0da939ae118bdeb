"""What `run` and `check` write for a CI service: JUnit XML, a comparison with a baseline, annotations on GitHub."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rvjax.cli._output import Output
from rvjax.errors import RvjaxError, UsageError

if TYPE_CHECKING:
    from rvjax.analysis.baseline import BaselineComparison
    from rvjax.analysis.verdicts import Verdict
    from rvjax.run_folder import RunFolder


@dataclass(frozen=True)
class CiOutputs:
    """junit_xml: a file to write. against: a baseline to compare with. write_baseline: a baseline to write."""

    junit_xml: Path | None = None
    against: Path | None = None
    write_baseline: Path | None = None

    def begin(self) -> None:
        """Checks the files before anything flies and removes the JUnit XML of an earlier run.

        UsageError where `against` is no baseline, or where a file cannot be written.
        """
        for path in (self.junit_xml, self.write_baseline):
            if path is not None and path.is_dir():
                raise UsageError(f"{path}: this is a folder; accepted: the path of a file to write")
        if self.junit_xml is not None:
            try:
                self.junit_xml.unlink(missing_ok=True)
            except OSError as error:
                raise UsageError(f"{self.junit_xml}: cannot be written: {error.strerror}; accepted: another path") from error
        if self.against is not None:
            from rvjax.analysis import baseline

            with self.errors("baseline"):
                baseline.read(self.against)

    @contextmanager
    def errors(self, name: str) -> Iterator[None]:
        """An error inside is also written into the JUnit XML, under this name of a test suite."""
        try:
            yield
        except RvjaxError as error:
            self._write_junit(name, error=str(error))
            raise

    def worst_samples(self, folder: RunFolder, verdicts: Sequence[Verdict], output: Output) -> list[int | None]:
        """The worst sample for each requirement that does not pass; None where it passes or no output shows it."""
        if self.junit_xml is None and not output.as_json:
            return [None] * len(verdicts)
        from rvjax.analysis.worst_samples import worst_samples

        failing = [index for index, verdict in enumerate(verdicts) if verdict.verdict != "PASS"]
        samples = worst_samples(folder, [verdicts[index].requirement for index in failing])
        worst = dict(zip(failing, samples, strict=True))
        return [worst.get(index) for index in range(len(verdicts))]

    def compare(self, folder: Path, output: Output) -> Sequence[BaselineComparison]:
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
        atomic_files.replace(self.junit_xml, junit.junit(name, cases))


def _advice(folder: Path, sample: int | None) -> str:
    """The path of the report, and the command that replays the worst sample."""
    replay = "" if sample is None else f"\nrvjax replay {shlex.quote(str(folder))} --sample {sample}"
    return f"report: {folder / 'report.html'}{replay}"
