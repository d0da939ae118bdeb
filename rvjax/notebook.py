"""Campaigns and runs as objects, for notebooks and scripts: everything that the command line does, with the same words.

    campaign = rvjax.Campaign("campaign.yaml").with_({"controller.gains.k1": 0.15}, samples=2000)
    run = campaign.fly("reports/mine")
    run.samples, run.verdicts, run.replay(17)

docs/python.md shows each.
"""

from __future__ import annotations

import html
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from rvjax.campaign.source import Source, read
from rvjax.components import user_watch
from rvjax.components.object_files import file_of
from rvjax.components.registry import FAMILY_OF
from rvjax.places import Place, place_of

if TYPE_CHECKING:
    import pandas as pd

    from rvjax.analysis.compare import Comparison
    from rvjax.analysis.verdicts import Verdict
    from rvjax.columns import Column
    from rvjax.execution.progress import OnProgress
    from rvjax.report.plots import Plots
    from rvjax.run_folder import Account, RunFolder
    from rvjax.run_folder.tuning_record import Searched
    from rvjax.search.worst_case import Worst
    from rvjax.simulation.problem import Problem


class Campaign:
    """A campaign file with changed values. It never changes itself: `with_` gives another campaign."""

    def __init__(self, path: str | Path, overrides: Sequence[str] = ()) -> None:
        """overrides: `place=value`, as in `--set`. The file is read by the first use that needs it."""
        user_watch.refuse_flights()
        self.path = Path(path)
        self.overrides = tuple(overrides)
        self._code: dict[str, bytes] = {}

    def with_(self, values: Mapping[str, Any] | None = None, /, **sections: Any) -> Self:
        """The campaign with other values: by their places, `{"controller.gains.k1": 0.15}`, or as sections, `samples=2000`.

        A component object (`CONTROLLER`) stands for its Python file, or for the notebook cell that made it;
        `(CONTROLLER, {"gains": {"kp": 0.02}})` gives its parameters. Lists of components take objects too. Errors: UsageError
        where an object has neither a file nor a cell, or the cell is not plain Python; CampaignError where the file cannot be
        read.
        """
        changed = type(self)(self.path, self.overrides)
        changed._code = dict(self._code)
        for place, value in {**(values or {}), **sections}.items():
            plain = changed._plain(value, place in FAMILY_OF)
            changed.overrides += (f"{place}={json.dumps(plain, ensure_ascii=False)}",)
        return changed

    def _plain(self, value: Any, section: bool) -> Any:
        """The value as a campaign says it."""
        if isinstance(value, list):
            return [self._plain(item, section) for item in value]
        component, parameters = value if section and isinstance(value, tuple) else (value, {})
        if not hasattr(component, "family"):
            return component if not parameters else {"use": component, **parameters}
        file = file_of(component)
        self._code |= file.sources
        return {"use": str(file), **parameters}

    @property
    def source(self) -> Path | Source:
        """What is loaded: the file, and with it the code of component objects."""
        if not self._code:
            return self.path
        return replace(read(self.path), inputs=dict(self._code))

    @cached_property
    def problem(self) -> Problem:
        """The campaign, checked. Errors: CampaignError with every finding."""
        from rvjax.simulation.problem import load

        return load(self.source, self.overrides)

    def fly(self, out: str | Place | None = None, *, progress: bool | OnProgress = True, until_decided: bool = False) -> Run:
        """Flies into a run folder, or resumes it; as `rvjax run`. Errors as of `rvjax.fly_campaign`."""
        from rvjax.execution.run import run

        return Run(run(self.source, out, self.overrides, progress=progress, until_decided=until_decided))

    def tune(self, out: str | Path | None = None, *, progress: bool | OnProgress = True) -> tuple[Path, Searched]:
        """Searches better gains; as `rvjax tune`. Returns the folder and the record of the search."""
        from rvjax.execution.progress_display import lines
        from rvjax.search.tuning.tune import tune

        with lines(progress) as say:
            return tune(self.source, out, self.overrides, progress=progress, on_message=say)

    def find_worst(
        self, requirement: int = 1, *, flights: int = 20_000, vary: Sequence[str] = (), progress: bool = True
    ) -> Worst:
        """Searches the draws with the smallest margin of a requirement; as `rvjax worst`."""
        from rvjax.execution.progress_display import lines
        from rvjax.search.worst_case import find_worst_case

        with lines(progress) as say:

            def show(done: int, margin: float) -> None:
                say(f"{done:,} of {flights:,} flights, smallest margin {margin:.4g}")

            options = {"flights": flights, "vary": vary, "on_progress": show}
            return find_worst_case(self.source, requirement, self.overrides, **options)

    def __repr__(self) -> str:
        changes = f", {list(self.overrides)!r}" if self.overrides else ""
        return f"Campaign({str(self.path)!r}{changes})"


class Run:
    """A finished run, read from its folder."""

    def __init__(self, path: str | Place) -> None:
        self.path = place_of(path)

    @cached_property
    def folder(self) -> RunFolder:
        """The files. Errors: FolderError where the path is no run folder, or it is damaged."""
        from rvjax.run_folder import RunFolder

        return RunFolder.open(self.path)

    @cached_property
    def samples(self) -> pd.DataFrame:
        """The samples table: a row per sample."""
        return self.folder.samples().frame

    @cached_property
    def columns(self) -> Mapping[str, Column]:
        """Unit and meaning of each column of `samples`."""
        return self.folder.columns()

    @cached_property
    def _judged(self) -> tuple[Account, tuple[Verdict, ...]]:
        from rvjax.analysis.verdicts.folders import account_and_verdicts

        return account_and_verdicts(self.path)

    @property
    def account(self) -> Account:
        """How the samples ended."""
        return self._judged[0]

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """The verdict on each requirement."""
        return self._judged[1]

    @property
    def report(self) -> Place:
        """The report."""
        return self.path / "report.html"

    @cached_property
    def summary(self) -> dict[str, Any]:
        """Every number of the report, with its interval."""
        return json.loads(self.folder.read_bytes("summary.json"))

    @cached_property
    def plot(self) -> Plots:
        """The figures of the report: `run.plot.settling()` and others, as Matplotlib axes."""
        from rvjax.report.plots import Plots

        return Plots.of(self.path)

    def replay(self, sample: int, every: int = 1) -> pd.DataFrame:
        """The trace of a sample, flown again bit for bit. Errors as of `rvjax.replay_sample`."""
        from rvjax.execution.replay import replay

        return replay(self.path, sample, every)[0]

    def export(self, to: str | Path, sample: int | None = None, **options: Any) -> list[Path]:
        """The samples table, or the trace of a sample, as a file for another tool; options as of `Options` in
        `rvjax.execution.exporting`. Returns the files. Errors as of `rvjax.export_run`."""
        from rvjax.execution.exporting import Options, export

        return export(self.path, to, sample, Options(**options))

    def compare(self, other: Run | str | Path, **options: Any) -> Comparison:
        """This run as A, the other as B, on the same draws; options as of `rvjax.compare_runs`."""
        from rvjax.analysis.compare import compare

        return compare(self.path, other.path if isinstance(other, Run) else other, **options)

    def __repr__(self) -> str:
        words = ", ".join(verdict.verdict for verdict in self.verdicts) or "no requirements"
        account = self.account
        return f"Run({str(self.path)!r}: {account.captured} of {account.requested} captured; {words})"

    def _repr_html_(self) -> str:
        """The verdicts as a table, for a notebook."""
        rows = "".join(
            f"<tr><td><b>{verdict.verdict}</b></td><td style='text-align:left'>{html.escape(verdict.text)}</td></tr>"
            for verdict in self.verdicts
        )
        account = self.account
        head = f"{account.captured:,} of {account.requested:,} samples captured"
        return f"<p>{head}; report: <code>{html.escape(str(self.report))}</code></p><table>{rows}</table>"
