"""Run: what the sections read of a run folder: totals of all samples, the account, verdicts, envelopes and traces.

The value of a not finite sample is read as the worst possible value everywhere, so that no section can drop a failed sample.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.analysis.accumulator import RunAccumulator
from rvjax.analysis.run_totals import Totals, metric
from rvjax.analysis.verdicts import Verdict, campaign_of
from rvjax.analysis.verdicts.rare import conclude_all
from rvjax.campaign import Spec
from rvjax.columns import CHANNELS, draw_column, drawn_columns, metric_column
from rvjax.components.samplers import sampling_design_of
from rvjax.errors import FolderError, IncompleteError
from rvjax.places import Place
from rvjax.report import fault_severity
from rvjax.report.blocks import Number
from rvjax.report.number_format import count
from rvjax.run_folder import BASELINES, Account, Audited, Column, RunFolder, rare_record
from rvjax.run_folder.entries import EntryRows
from rvjax.run_folder.rare_record import RareRecord
from rvjax.run_folder.storages import is_run_folder
from rvjax.stats.quantile_sketch import Sketch
from rvjax.stats.sampling_design import SamplingDesign

CONFIDENCE = 0.95
"""Of every two-sided interval in the report; requirements state their confidence."""

REJECTED = ".rejected"
"""Suffix of a column that counts rejected draws; the column is not a draw."""

OVERLAID = 5
"""Number of worst flights that are drawn over the bands of all flights."""


@dataclass(frozen=True)
class Run:
    """A run folder, read and judged.

    folder: its path, as commands need it; head: the rows of the first samples; design: how the samples were drawn, which decides
    whether estimates have intervals; baselines: by name, the totals of the other controllers on the same draws; searches: of rare
    failures, by the number of their requirement.
    """

    folder: str
    spec: Spec
    totals: Totals
    head: pd.DataFrame
    account: Account
    design: SamplingDesign
    verdicts: Sequence[Verdict]
    envelopes: pd.DataFrame
    traces: Mapping[int, pd.DataFrame]
    identity: Mapping[str, Any]
    provenance: Mapping[str, Any]
    audit: Audited | None
    chunks: EntryRows
    extract: bytes | None
    baselines: Mapping[str, Totals]
    searches: Mapping[int, RareRecord] = field(default_factory=dict[int, RareRecord])

    @property
    def flown(self) -> int:
        """The number of flown samples."""
        return self.totals.n

    @property
    def head_note(self) -> str:
        """A sentence for captions if `head` does not hold all samples; otherwise empty."""
        return f" Of the first {count(len(self.head))} samples." if len(self.head) < self.flown else ""

    @property
    def lost(self) -> str:
        """What counts as the worst value of a metric, as the subject of a sentence."""
        collided = "collided (but in metrics of safety) or " if self.account.collided else ""
        return f"A {collided}not finite sample"

    def metrics(self, pattern: str) -> list[str]:
        """Names of the metrics (without `metric.`) that fully match a regular expression, in column order."""
        return [name for name in self.totals.metrics if re.fullmatch(pattern, name)]

    def metric(self, name: str) -> Sketch:
        """The values of all samples in SI; NaN, the value of a not finite sample, counts as the worst value."""
        return self.totals.metrics[name]

    def metric_of_head(self, name: str) -> NDArray[np.float64]:
        """(n,) values of the first samples, in the order of `head`."""
        return metric(self.head, name, self.totals.columns)

    def column(self, name: str) -> Column:
        """Unit and description of a metric."""
        return self.totals.columns[metric_column(name)]

    def draws(self, pattern: str = ".*") -> list[str]:
        """Paths of the numeric draws (without `draw.`) that fully match a regular expression."""
        return [path for path in self.totals.reach if re.fullmatch(pattern, path) and not path.endswith(REJECTED)]

    def rejections(self) -> list[str]:
        """Paths of the columns that count rejected draws."""
        return [path for path in self.totals.reach if path.endswith(REJECTED)]

    def draw_of_head(self, path: str) -> NDArray[np.float64]:
        """(n,) drawn values in SI of the first samples, in the order of `head`."""
        return self.head[draw_column(path)].to_numpy(dtype=float)

    def quantile(self, name: str, q: float) -> Number:
        """The q-quantile of a metric with its order-statistic interval."""
        estimate = self.design.quantile(self.metric(name), q, CONFIDENCE)
        return Number(f"{name}.q{q * 100:g}", estimate, self.column(name).unit, percent=is_share(name))

    @property
    def band(self) -> float | None:
        """Half-width of the confidence band of a distribution function; None for an exploration."""
        return self.design.band(self.flown, CONFIDENCE)

    def share(self, name: str, successes: int) -> Number:
        """successes / flown samples, with its Clopper-Pearson interval."""
        return Number(f"{name}.share", self.design.share(successes, self.flown, CONFIDENCE), percent=True)

    def severity(self, channel: str) -> NDArray[np.float64] | None:
        """(n,) fault severity of a channel in the first samples; None if no fault takes effectiveness from it."""
        return fault_severity.severity(self.spec, self.head, channel)

    def limits(self, channel: str) -> tuple[float, float]:
        """(−lower, upper) nominal limit of a channel in N or N·m; the middle of the range if the limit is drawn."""
        index = CHANNELS.index(channel)
        actuators = self.spec.actuators
        lower, upper = (sum(limits.supports[index]) / 2 for limits in (actuators.lower, actuators.upper))
        return -lower, upper

    @property
    def overrides(self) -> list[str]:
        """The settings that override the campaign file, as `path=value`."""
        return [str(item) for item in self.provenance.get("overrides", ())]

    def onsets(self) -> tuple[float, float] | None:
        """Earliest and latest drawn fault onset in seconds, over all samples; None if no fault begins."""
        ranges = [self.totals.reach[path] for path in self.draws(r"faults\..*\.onset_s\..*")]
        begun = [(low, high) for low, high in ranges if low <= high]
        return (min(low for low, _ in begun), max(high for _, high in begun)) if begun else None


def open_run(path: str | Place) -> Run:
    """Reads and verifies a run folder, with one chunk in memory at a time, and judges its requirements.

    Raises FolderError if the path is not a run folder or is damaged, and IncompleteError if no chunk is finished.
    """
    folder = RunFolder.open(path)
    campaign = campaign_of(folder)
    accumulator = RunAccumulator(campaign.require, sampling_design_of(campaign), campaign.keep)
    for chunk, frame, columns in folder.tables():
        accumulator.add(chunk, frame, columns)
    return assemble_run(folder, accumulator, campaign)


def assemble_run(
    folder: RunFolder, accumulator: RunAccumulator, campaign: Spec, baselines: Mapping[str, Totals] | None = None
) -> Run:
    """The run of a folder whose samples are accumulated already. Reads only the envelopes and the traces that the report shows.

    baselines: known totals of baselines, by name. The samples of the other baselines are read.
    Raises FolderError if those are damaged, and IncompleteError if no chunk is finished.
    """
    totals = accumulator.totals
    if not totals.n:
        raise IncompleteError(f"{folder.path}: no chunk is finished yet; fly it with `rvjax run` and the same --out")
    names = [choice.name for choice in campaign.baselines]
    traced = set(folder.trace_samples())
    overlaid = [sample for sample in totals.worst["sample"].tolist() if sample in traced][:OVERLAID]
    return Run(
        folder=str(folder.path),
        spec=campaign,
        totals=totals,
        head=totals.head,
        account=totals.account(folder.requested),
        design=sampling_design_of(campaign),
        verdicts=conclude_all(accumulator.verdicts, folder.path),
        envelopes=folder.envelopes(),
        traces={sample: folder.trace(sample) for sample in overlaid},
        identity=folder.identity,
        provenance=folder.provenance,
        audit=folder.audit,
        chunks=folder.chunks,
        extract=accumulator.extract(folder.chunks),
        baselines={name: other for name in names if (other := _baseline(folder, name, totals, baselines or {}))},
        searches={
            number: record
            for number, requirement in enumerate(campaign.require, 1)
            if requirement.is_rare and (record := rare_record.read(folder.path, number)) is not None
        },
    )


def _baseline(folder: RunFolder, name: str, run: Totals, known: Mapping[str, Totals]) -> Totals | None:
    """The totals of a baseline; None if it has not flown all samples of the run. FolderError if the draws differ."""
    path = folder.path / BASELINES / name
    totals = known.get(name)
    if totals is None:
        if not is_run_folder(path):
            return None
        totals = Totals()
        for table in RunFolder.open(path).tables():
            totals.add(*table)
    drawn = drawn_columns(run.head.columns)
    if totals.n != run.n:
        return None
    if not totals.head[["sample", *drawn]].equals(run.head[["sample", *drawn]]):
        raise FolderError(f"{path}: the draws differ from those of the run; fly the campaign again with another --out")
    return totals


def is_share(name: str) -> bool:
    """Whether a metric is a share of time, shown in percent."""
    return name.startswith("saturation_duty")
