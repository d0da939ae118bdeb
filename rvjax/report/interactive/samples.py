"""Samples for the linked plots: which rows of a run the page holds, and which columns.

Up to 8,192 samples: all. Above: the first ones, whose draws are as random as all others, then of the others the failed ones,
up to 2,048, and the worst. Shares and intervals of the page count the first ones only, since the others were chosen by their
outcome.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rvjax.analysis import drivers
from rvjax.analysis.run_totals import FAILURES, metric
from rvjax.columns import METRIC, OUTCOMES, draw_column, metric_column
from rvjax.report.blocks import Code, Section, Table
from rvjax.report.interactive.data_blocks import Block, block
from rvjax.report.number_format import label
from rvjax.report.run_view import Run
from rvjax.stats.sampling_design import Independent

MOST = 8_192
"""Samples without a choice; above, the first samples that the page holds."""

COLUMNS = 32

_METRICS = (
    "captured", "settling_time_s", "attitude_settling_time_s", "window_position_error_m", "window_attitude_error_deg",
    "hull_clearance_m", "closest_approach_m", "corridor_violation_s", "keep_out_violation_s", "saturation_duty.any",
    "delta_v_m_s", "fault_recovery_s", "peak_chi", "collision_time_s", "collision_speed_m_s",
)  # fmt: skip
"""The metrics of the page, in this order, with the temporal margins and the metrics of the requirements before them."""


@dataclass(frozen=True)
class Shown:
    """rows: of the samples table; random: which of them stand for the run, before those that were chosen by their outcome."""

    rows: pd.DataFrame
    random: int


def shown_rows(run: Run) -> Shown:
    """The rows that the page holds."""
    head = run.head
    if run.flown <= MOST and len(head) == run.flown:
        return Shown(head, len(head))
    first = head.iloc[:MOST]
    held = set(first["sample"].tolist())
    others = pd.concat([head.iloc[MOST:], run.totals.failures], ignore_index=True)
    failed = others.loc[(others["outcome"] != "captured").to_numpy(), "sample"].tolist()[:FAILURES]
    wanted = [*failed, *(sample for sample in run.totals.worst["sample"].tolist() if sample not in held)]
    return Shown(pd.concat([first, rows_of(run, wanted)], ignore_index=True), len(first))


def rows_of(run: Run, samples: Sequence[int]) -> pd.DataFrame:
    """The rows of some samples, in their order, each once, without those of which the totals have no row."""
    wanted = list(dict.fromkeys(samples))
    frames = [frame[np.isin(frame["sample"].to_numpy(), wanted)] for frame in (run.head, run.totals.worst, run.totals.failures)]
    table = pd.concat([frame for frame in frames if len(frame)] or [run.head.iloc[:0]], ignore_index=True)
    places = {sample: place for place, sample in reversed(list(enumerate(table["sample"].tolist())))}
    return table.iloc[[places[sample] for sample in wanted if sample in places]].reset_index(drop=True)


def chosen_columns(run: Run, rows: pd.DataFrame, sections: Sequence[Section]) -> dict[str, dict[str, Any]]:
    """name → its values and what the page says of it: the draws that matter most first, then the metrics."""
    required = [str(requirement.metric) for requirement in run.spec.require]
    known = [name for name in run.totals.metrics if metric_column(name) in rows]
    order = [*required, *(name for name in known if name.startswith("margin.")), *_METRICS]
    metrics = [name for name in dict.fromkeys(order) if name in known][: COLUMNS // 2]
    drawn = drivers.varied(rows)
    leading = dict.fromkeys([*_leading(sections), *drawn])
    draws = [name for name in leading if name in drawn][: COLUMNS - len(metrics)]
    found: dict[str, dict[str, Any]] = {}
    for name in draws:
        stem = name.strip("|") + (".x" if name.startswith("|") else "")
        column = run.totals.columns.get(draw_column(stem))
        unit, meaning = (column.unit, column.description) if column is not None else ("", "")
        found[name] = {"values": drawn[name], "kind": "draw", "label": name, "unit": unit, "meaning": meaning}
    for name in metrics:
        column = run.column(name)
        values = metric(rows, name, run.totals.columns)
        found[METRIC + name] = {
            "values": values, "kind": "metric", "label": label(name), "unit": column.unit, "meaning": column.description,
        }  # fmt: skip
    return found


def _leading(sections: Sequence[Section]) -> list[str]:
    """The draws that the section on draws names, the clearest of each result first."""
    tables = [
        [row[0].text for row in part.rows if isinstance(row[0], Code)]
        for section in sections
        if section.key == "which-draws"
        for part in section.body
        if isinstance(part, Table)
    ]
    longest = max(map(len, tables), default=0)
    return [table[place] for place in range(longest) for table in tables if place < len(table)]


def samples_block(run: Run, shown: Shown, sections: Sequence[Section], kept: Sequence[int]) -> tuple[Block, dict[str, Any]]:
    """The columns of the samples, and what the page says of them. kept: the samples that the replay has."""
    rows = shown.rows
    chosen = chosen_columns(run, rows, sections)
    outcome = pd.Categorical(rows["outcome"], categories=OUTCOMES).codes
    number = rows["sample"].to_numpy(dtype=np.int64)
    columns: dict[str, NDArray[Any]] = {"outcome": outcome, "sample.high": number >> 15, "sample.low": number & 0x7FFF}
    packed = block(columns | {name: item["values"] for name, item in chosen.items()})
    about = [{key: item[key] for key in ("kind", "label", "unit", "meaning")} | {"name": name} for name, item in chosen.items()]
    return packed, {
        "columns": about,
        "outcomes": list(OUTCOMES),
        "random": shown.random,
        "flown": run.flown,
        "kept": list(kept),
        "folder": run.folder,
        "interval": isinstance(run.design, Independent),
        "confidence": 0.95,
    }
