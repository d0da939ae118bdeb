"""The opened run that every section looks at: the table, its columns, the account, verdicts, envelopes and traces.

Values of samples that ended not finite are the worst possible ones wherever they are read here, so that no section
can drop a failed sample by accident.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax import check, stats
from rvjax.check import Verdict
from rvjax.columns import CHANNELS
from rvjax.results import Account, Column, RunFolder
from rvjax.results.manifest import Entry
from rvjax.sections.page import Number
from rvjax.spec import Spec

CONFIDENCE = 0.95
"""Of every two-sided interval in the report; a requirement brings its own."""


@dataclass(frozen=True)
class Run:
    """A run folder, read and judged. `frame` has one row per flown sample; `folder` is the path to show and to type."""

    folder: str
    spec: Spec
    frame: pd.DataFrame
    columns: Mapping[str, Column]
    account: Account
    verdicts: Sequence[Verdict]
    envelopes: pd.DataFrame
    traces: Mapping[int, pd.DataFrame]
    identity: Mapping[str, Any]
    provenance: Mapping[str, Any]
    chunks: tuple[Entry, ...]

    @property
    def flown(self) -> int:
        """How many samples have a row."""
        return len(self.frame)

    def metrics(self, pattern: str) -> list[str]:
        """Names of the metrics (without `metric.`) that match a whole regular expression, in column order."""
        names = [name.removeprefix("metric.") for name in self.frame.columns if name.startswith("metric.")]
        return [name for name in names if re.fullmatch(pattern, name)]

    def metric(self, name: str) -> NDArray[np.float64]:
        """(n,) values in SI; NaN, as of a sample that ended not finite, is replaced by the worst value."""
        values = self.frame[f"metric.{name}"].to_numpy(dtype=float)
        return np.where(np.isnan(values), self.worst(name), values)

    def worst(self, name: str) -> float:
        """+inf where lower is better or nothing is said, -inf where higher is better."""
        return -math.inf if self.column(name).better == "higher" else math.inf

    def column(self, name: str) -> Column:
        """Unit and meaning of a metric."""
        return self.columns[f"metric.{name}"]

    def draws(self, pattern: str = ".*") -> list[str]:
        """Paths of the numeric draws (without `draw.`) that match a whole regular expression."""
        drawn = [name for name in self.frame.columns if name.startswith("draw.")]
        numeric = [name.removeprefix("draw.") for name in drawn if pd.api.types.is_numeric_dtype(self.frame[name])]
        return [name for name in numeric if re.fullmatch(pattern, name)]

    def draw(self, path: str) -> NDArray[np.float64]:
        """(n,) drawn values in SI."""
        return self.frame[f"draw.{path}"].to_numpy(dtype=float)

    def is_outcome(self, outcome: str) -> NDArray[np.bool_]:
        """(n,) whether each sample ended so."""
        return (self.frame["outcome"] == outcome).to_numpy(dtype=bool)

    def quantile(self, name: str, q: float) -> Number:
        """The q-quantile of a metric with its order-statistic interval."""
        unit = self.column(name).unit
        estimate = stats.quantile_interval(self.metric(name), q, CONFIDENCE, worst=self.worst(name))
        return Number(f"{name}.q{q * 100:g}", estimate, unit, percent=is_share(name))

    def share(self, name: str, holds: NDArray[np.bool_]) -> Number:
        """The share of flown samples for which something holds, with its Clopper-Pearson interval."""
        estimate = stats.clopper_pearson(int(holds.sum()), holds.size, CONFIDENCE)
        return Number(f"{name}.share", estimate, percent=True)

    def severity(self, channel: str) -> NDArray[np.float64] | None:
        """(n,) 1 - product of what the faults leave of a channel's effectiveness; None where no fault draws it.

        A fault that sets in after the end of the flight takes nothing.
        """
        kept = [self._remaining(path) for path in self.draws(rf"faults\..*\.remaining\.{channel}")]
        return 1 - np.prod(kept, axis=0) if kept else None

    def _remaining(self, path: str) -> NDArray[np.float64]:
        onset = path.replace(".remaining.", ".onset_s.")
        late = self.draw(onset) >= self.spec.horizon.duration_s if self.draws(re.escape(onset)) else False
        return np.where(late, 1.0, self.draw(path))

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
        """Earliest and latest drawn fault onset in seconds, over all samples."""
        drawn = [self.draw(path) for path in self.draws(r"faults\..*\.onset_s\..*")]
        return (float(np.min(drawn)), float(np.max(drawn))) if drawn else None


def open_run(path: str | Path) -> Run:
    """Reads and verifies a run folder and judges its requirements.

    FolderError where it is none or is damaged, IncompleteError where no chunk is finished.
    """
    folder = RunFolder.open(path)
    campaign = check.campaign_of(folder)
    table = folder.samples()
    return Run(
        folder=str(path),
        spec=campaign,
        frame=table.frame,
        columns=table.columns,
        account=folder.account(),
        verdicts=check.judge_all(campaign.require, table),
        envelopes=folder.envelopes(),
        traces={sample: folder.trace(sample) for sample in folder.trace_samples()},
        identity=folder.identity,
        provenance=folder.provenance,
        chunks=folder.chunks,
    )


def is_share(name: str) -> bool:
    """Whether a metric is a share of time, shown in percent."""
    return name.startswith("saturation_duty")
