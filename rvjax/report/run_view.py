"""The opened run that every section looks at: totals of all samples, the account, verdicts, envelopes and traces.

Values of samples that ended not finite are the worst possible ones wherever they are read here, so that no section
can drop a failed sample by accident.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.analysis.accumulator import RunAccumulator
from rvjax.analysis.run_totals import Totals, metric
from rvjax.analysis.verdicts import Verdict, campaign_of
from rvjax.campaign import Spec
from rvjax.columns import CHANNELS
from rvjax.components.samplers import sampling_design_of
from rvjax.errors import FolderError, IncompleteError
from rvjax.report.blocks import Number
from rvjax.report.number_format import count
from rvjax.run_folder import BASELINES, Account, Audited, Column, RunFolder
from rvjax.run_folder.manifest import Entry
from rvjax.stats.quantile_sketch import Sketch
from rvjax.stats.sampling_design import SamplingDesign

CONFIDENCE = 0.95
"""Of every two-sided interval in the report; a requirement brings its own."""

REJECTED = ".rejected"
"""End of the name of a column that counts the draws that were rejected, and is no draw itself."""

OVERLAID = 5
"""Worst flights that are drawn over the histories of all."""


@dataclass(frozen=True)
class Run:
    """A run folder, read and judged. `folder`: the path to show and to type; `head`: the rows of the first samples; `basis`: what
    the samples are, and so what may be said of them.

    baselines: totals of the other controllers that flew the same draws, by name.
    """

    folder: str
    spec: Spec
    totals: Totals
    head: pd.DataFrame
    account: Account
    basis: SamplingDesign
    verdicts: Sequence[Verdict]
    envelopes: pd.DataFrame
    traces: Mapping[int, pd.DataFrame]
    identity: Mapping[str, Any]
    provenance: Mapping[str, Any]
    audit: Audited | None
    chunks: tuple[Entry, ...]
    extract: bytes | None
    baselines: Mapping[str, Totals]

    @property
    def flown(self) -> int:
        """How many samples have a row."""
        return self.totals.n

    @property
    def of_head(self) -> str:
        """What a caption adds where `head` does not have all samples; empty where it has."""
        return f" Of the first {count(len(self.head))} samples." if len(self.head) < self.flown else ""

    def metrics(self, pattern: str) -> list[str]:
        """Names of the metrics (without `metric.`) that match a whole regular expression, in column order."""
        return [name for name in self.totals.metrics if re.fullmatch(pattern, name)]

    def metric(self, name: str) -> Sketch:
        """The values of all samples in SI; NaN, as of a sample that ended not finite, counts as the worst value."""
        return self.totals.metrics[name]

    def metric_of_head(self, name: str) -> NDArray[np.float64]:
        """(n,) values of the first samples, one for each row of `head`."""
        return metric(self.head, name, self.totals.columns)

    def column(self, name: str) -> Column:
        """Unit and meaning of a metric."""
        return self.totals.columns[f"metric.{name}"]

    def draws(self, pattern: str = ".*") -> list[str]:
        """Paths of the numeric draws (without `draw.`) that match a whole regular expression."""
        return [path for path in self.totals.reach if re.fullmatch(pattern, path) and not path.endswith(REJECTED)]

    def rejections(self) -> list[str]:
        """Paths of the columns that count rejected draws."""
        return [path for path in self.totals.reach if path.endswith(REJECTED)]

    def draw_of_head(self, path: str) -> NDArray[np.float64]:
        """(n,) drawn values in SI of the first samples, one for each row of `head`."""
        return self.head[f"draw.{path}"].to_numpy(dtype=float)

    def quantile(self, name: str, q: float) -> Number:
        """The q-quantile of a metric with its order-statistic interval."""
        estimate = self.basis.quantile(self.metric(name), q, CONFIDENCE)
        return Number(f"{name}.q{q * 100:g}", estimate, self.column(name).unit, percent=is_share(name))

    @property
    def band(self) -> float | None:
        """Half-width of the band about the distribution function of a metric; None where there is none."""
        return self.basis.band(self.flown, CONFIDENCE)

    def share(self, name: str, holds: int) -> Number:
        """The share of flown samples for which something holds, given their number, with its Clopper-Pearson interval."""
        return Number(f"{name}.share", self.basis.share(holds, self.flown, CONFIDENCE), percent=True)

    def severity(self, channel: str) -> NDArray[np.float64] | None:
        """(n,) 1 - product of what the faults leave of a channel's effectiveness, of the first samples; None without such a draw.

        A fault that sets in after the end of the flight takes nothing.
        """
        kept = [self._remaining(path) for path in self.draws(rf"faults\..*\.remaining\.{channel}")]
        return 1 - np.prod(kept, axis=0) if kept else None

    def _remaining(self, path: str) -> NDArray[np.float64]:
        onset = path.replace(".remaining.", ".onset_s.")
        late = self.draw_of_head(onset) >= self.spec.horizon.duration_s if self.draws(re.escape(onset)) else False
        return np.where(late, 1.0, self.draw_of_head(path))

    def limits(self, channel: str) -> tuple[float, float]:
        """(-lower, upper) nominal limit of a channel in N or N·m; the middle of its range where it is drawn."""
        place = CHANNELS.index(channel)
        actuators = self.spec.actuators
        lower, upper = (sum(limits.supports[place]) / 2 for limits in (actuators.lower, actuators.upper))
        return -lower, upper

    @property
    def overrides(self) -> list[str]:
        """What was set beside the campaign file, as `path=value`."""
        return [str(item) for item in self.provenance.get("overrides", ())]

    def onsets(self) -> tuple[float, float] | None:
        """Earliest and latest drawn fault onset in seconds, over all samples; None where no fault begins."""
        found = [self.totals.reach[path] for path in self.draws(r"faults\..*\.onset_s\..*")]
        reach = [(low, high) for low, high in found if low <= high]
        return (min(low for low, _ in reach), max(high for _, high in reach)) if reach else None


def open_run(path: str | Path) -> Run:
    """Reads and verifies a run folder, one chunk in memory at a time, and judges its requirements.

    FolderError where it is none or is damaged, IncompleteError where no chunk is finished.
    """
    folder = RunFolder.open(path)
    campaign = campaign_of(folder)
    fold = RunAccumulator(campaign.require, sampling_design_of(campaign), campaign.keep)
    for chunk, frame, columns in folder.tables():
        fold.add(chunk, frame, columns)
    return opened(folder, fold, campaign)


def opened(folder: RunFolder, fold: RunAccumulator, campaign: Spec, others: Mapping[str, Totals] | None = None) -> Run:
    """The run of a folder whose samples have been folded; reads envelopes and the traces that are shown, no samples. others: of
    the baselines whose samples have been folded, too, their totals by name; the samples of the others are read.

    FolderError where those are damaged, IncompleteError where no chunk is finished.
    """
    totals = fold.totals
    if not totals.n:
        raise IncompleteError(f"{folder.path}: no chunk is finished yet; fly it with `rvjax run` and the same --out")
    names = [choice.name for choice in campaign.baselines]
    kept = set(folder.trace_samples())
    overlaid = [sample for sample in totals.worst["sample"].tolist() if sample in kept][:OVERLAID]
    return Run(
        folder=str(folder.path),
        spec=campaign,
        totals=totals,
        head=totals.head,
        account=totals.account(folder.requested),
        basis=sampling_design_of(campaign),
        verdicts=fold.verdicts,
        envelopes=folder.envelopes(),
        traces={sample: folder.trace(sample) for sample in overlaid},
        identity=folder.identity,
        provenance=folder.provenance,
        audit=folder.audit,
        chunks=folder.chunks,
        extract=fold.extract(folder.chunks),
        baselines={name: one for name in names if (one := _baseline(folder, name, totals, others or {}))},
    )


def _baseline(folder: RunFolder, name: str, own: Totals, others: Mapping[str, Totals]) -> Totals | None:
    """The totals of another controller's run, None where it has not flown all of the samples; FolderError where it flew other
    draws than the run that it stands beside."""
    path = folder.path / BASELINES / name
    totals = others.get(name)
    if totals is None:
        if not path.is_dir():
            return None
        totals = Totals()
        for table in RunFolder.open(path).tables():
            totals.add(*table)
    drawn = [name for name in own.head.columns if name.startswith("draw.") and not name.startswith("draw.controller.")]
    if totals.n != own.n:
        return None
    if not totals.head[["sample", *drawn]].equals(own.head[["sample", *drawn]]):
        raise FolderError(f"{path}: not the draws of the run that it is compared with; fly the campaign again with another --out")
    return totals


def is_share(name: str) -> bool:
    """Whether a metric is a share of time, shown in percent."""
    return name.startswith("saturation_duty")
