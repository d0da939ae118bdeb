"""What `rvjax.analysis.drivers` needs of a run folder: the draws and the results of its first samples, without flying."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from rvjax.analysis import drivers
from rvjax.analysis.drivers import Result, Values
from rvjax.analysis.verdicts.folders import campaign_of
from rvjax.campaign import Spec
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.draw_names import covers
from rvjax.columns import DRAW, METRIC, Column
from rvjax.components.samplers import sampling_design_of
from rvjax.errors import IncompleteError, UsageError
from rvjax.places import Place
from rvjax.run_folder import RunFolder
from rvjax.stats.sampling_design import SamplingDesign

FAILURES = "failures"
"""The word for every indicator of failures."""


@dataclass(frozen=True)
class Sample:
    """drawn: the draws that vary, by name; units: of them; results; design: of the samples; requested: samples of the run."""

    drawn: Mapping[str, Values]
    units: Mapping[str, str]
    results: Sequence[Result]
    design: SamplingDesign
    requested: int


def first_samples(folder: RunFolder, most: int) -> tuple[pd.DataFrame, dict[str, Column]]:
    """The rows of the first chunks, up to `most` samples, and their columns. IncompleteError if no chunk is finished."""
    frames: list[pd.DataFrame] = []
    columns: dict[str, Column] = {}
    for chunk in sorted(folder.chunks.number.tolist()):
        for _, frame, described in folder.tables([chunk]):
            frames.append(frame)
            columns = described
        if sum(map(len, frames)) >= most:
            break
    if not frames:
        raise IncompleteError(f"{folder.path}: no chunk is finished yet; fly it with `rvjax run` and the same --out")
    return pd.concat(frames, ignore_index=True).iloc[:most], columns


def opened(place: str | Place, results: Sequence[str], beginnings: Sequence[str], most: int) -> Sample:
    """results: names of metrics, or `failures`; all without any. beginnings: of the names of draws; all without any.

    UsageError for a name that is not there, or fewer than 30 samples; other errors as of `RunFolder.open`.
    """
    folder = RunFolder.open(place)
    campaign = campaign_of(folder)
    frame, columns = first_samples(folder, most)
    if len(frame) < drivers.FEWEST:
        raise UsageError(f"{place}: {len(frame)} samples; accepted: a run of {drivers.FEWEST} or more")
    known = [
        FAILURES,
        *(name.removeprefix(METRIC) for name in columns if name.startswith(METRIC) and name != f"{METRIC}captured"),
    ]
    for name in results:
        if name not in known:
            raise UsageError(f"--result {name}: no metric of this run; {did_you_mean(name, known)}")
    drawn = drivers.varied(frame)
    for beginning in beginnings:
        if not any(covers(beginning, name.strip("|")) for name in drawn):
            raise UsageError(f"--draw {beginning}: no draw of this run that varies; {did_you_mean(beginning, list(drawn))}")
    if beginnings:
        drawn = {name: x for name, x in drawn.items() if any(covers(beginning, name.strip("|")) for beginning in beginnings)}
    if not drawn:
        raise UsageError(f"{place}: no draw varies; accepted: a run of a campaign with a distribution")
    units = {name: _unit(name, columns) for name in drawn}
    return Sample(drawn, units, _results(campaign, frame, columns, results), sampling_design_of(campaign), folder.requested)


def _unit(name: str, columns: Mapping[str, Column]) -> str:
    """The unit of a draw; of |name| that of its components."""
    column = DRAW + (f"{name.strip('|')}.x" if name.startswith("|") else name)
    return columns[column].unit if column in columns else ""


def _results(campaign: Spec, frame: pd.DataFrame, columns: Mapping[str, Column], names: Sequence[str]) -> list[Result]:
    failing = drivers.failures(frame, campaign.require) if not names or FAILURES in names else []
    return [*failing, *(drivers.metrics(frame, columns, names) if not names or set(names) != {FAILURES} else [])]
