"""What `run` and `check` tell beside what they print: JUnit XML, a comparison with a baseline, GitHub's annotations."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rvjax.cli.output import Output
from rvjax.errors import RvjaxError, UsageError

if TYPE_CHECKING:
    from rvjax.analysis.baseline import BaselineComparison
    from rvjax.analysis.verdicts import Verdict
    from rvjax.run_folder import RunFolder


@dataclass(frozen=True)
class Tell:
    """Files of verdicts: JUnit XML to write, a baseline to compare with, one to write."""

    junit_xml: Path | None = None
    against: Path | None = None
    write_baseline: Path | None = None

    def begin(self) -> None:
        """Refuses before anything flies what could not be done behind it, and takes an earlier run's JUnit XML away.

        UsageError where the baseline is none, or where a file is to be written in the place of a folder.
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
            from rvjax.analysis import baseline as against

            with self.broken("baseline"):
                against.read(self.against)

    @contextmanager
    def broken(self, name: str) -> Iterator[None]:
        """Whatever keeps verdicts from coming about is in the JUnit XML as well, under this name."""
        try:
            yield
        except RvjaxError as error:
            self._junit(name, (), (), (), str(error))
            raise

    def worst(self, folder: RunFolder, verdicts: Sequence[Verdict], output: Output) -> list[int | None]:
        """Of each requirement that does not pass the sample to look at first, where somebody is told."""
        if self.junit_xml is None and not output.as_json:
            return [None] * len(verdicts)
        from rvjax.analysis.worst_samples import worst_samples

        failing = [place for place, one in enumerate(verdicts) if one.verdict != "PASS"]
        found = dict(zip(failing, worst_samples(folder, [verdicts[place].requirement for place in failing]), strict=True))
        return [found.get(place) for place in range(len(verdicts))]

    def compare(self, folder: Path, output: Output) -> Sequence[BaselineComparison]:
        """The run against the baseline, where one is given; then the baseline that it makes itself."""
        found: Sequence[BaselineComparison] = ()
        if self.against is None and self.write_baseline is None:
            return found
        from rvjax.analysis import baseline as against

        if self.against is not None:
            found = against.against(folder, self.against)
            rows = [
                ("WORSE" if one.significant else "–", one.what, str(one.worse), str(one.better), f"{one.p:.2g}") for one in found
            ]
            output.table(("", f"against {self.against}", "worse", "better", "p"), rows)
        if self.write_baseline is not None:
            against.write(folder, self.write_baseline)
            output.note(f"baseline: {self.write_baseline}")
        return found

    def tell(
        self,
        folder: RunFolder,
        name: str,
        verdicts: Sequence[Verdict],
        worst: Sequence[int | None],
        compared: Sequence[BaselineComparison],
        output: Output,
        file: Path,
        error: str = "",
    ) -> None:
        """JUnit XML where it is asked for; annotations and a summary where GitHub actions run this. name: of the campaign. error:
        why nothing could be compared."""
        from rvjax.report.ci import github

        if self.junit_xml is None and not github.active():
            return
        from rvjax.campaign.source import read

        self._junit(name, verdicts, [_advice(folder.path, sample) for sample in worst], compared, error)
        if github.active():
            source = read(file)
            output.annotate(github.of_verdicts(verdicts, [source.where(("require", n)) for n in range(len(verdicts))]))
            output.annotate(github.of_comparisons(compared, str(self.against), source.where(("controller",), key=True)))
            try:
                github.append_summary(github.summary(name, verdicts, compared))
            except OSError as problem:
                output.note(f"no job summary: {problem}")

    def _junit(
        self, name: str, verdicts: Sequence[Verdict], advice: Sequence[str], compared: Sequence[BaselineComparison], error: str
    ) -> None:
        if self.junit_xml is None:
            return
        from rvjax.report.ci import junit
        from rvjax.run_folder import atomic_files

        cases = [*junit.of_verdicts(verdicts, advice), *junit.of_comparisons(compared, str(self.against))]
        if error:
            cases.append(junit.of_error("baseline" if verdicts else "campaign", error))
        atomic_files.replace(self.junit_xml, junit.junit(name, cases))


def _advice(folder: Path, sample: int | None) -> str:
    """Where the report is, and how the worst sample flies again."""
    again = "" if sample is None else f"\nrvjax replay {shlex.quote(str(folder))} --sample {sample}"
    return f"report: {folder / 'report.html'}{again}"
