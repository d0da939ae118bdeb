"""Section: the worst samples, what they drew, and how to fly each of them again."""

from __future__ import annotations

import math
import shlex

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import rankdata

from rvjax.sections.opened import Run, is_share
from rvjax.sections.page import Cell, Code, Mark, Section, Table
from rvjax.sections.wording import label, number, quantity

SHOWN = 10
_STANDING_OUT = 3
_RANK = {"not_finite": 0, "not_settled": 1, "captured": 2}
_METRICS = ("settling_time_s", "window_position_error_m", "window_attitude_error_deg", "saturation_duty.any")


def section(run: Run) -> Section:
    """The ten worst samples: outcome, main metrics, the draws that stand out, and the replay command."""
    order = worst_first(run)[:SHOWN]
    names = [name for name in _METRICS if run.metrics(name.replace(".", r"\."))]
    ranks = _ranks(run)
    caption = (
        "Not finite first, the earliest leading; then not settled, by worst position error over the closing window; "
        "then captured, by settling time. Draws that stand out: furthest from their median in rank; p99 means larger "
        "than in 99 % of the samples. With many draws some stand out by chance in every sample."
    )
    head = ("sample", "outcome", *(label(name) for name in names), "draws that stand out")
    table = Table(caption, head, tuple(_row(run, row, names, ranks) for row in order))
    replay = "Commands that fly them again, each with its full trace."
    commands = Table(replay, ("sample", "command"), tuple(_replay(run, row) for row in order))
    lead = f"The {len(order)} worst samples, and how to fly each of them again."
    return Section("worst", "Worst samples", lead, (table, commands))


def worst_first(run: Run) -> list[int]:
    """Rows of the table from the worst sample to the best."""
    keys = pd.DataFrame(
        {"class": [_RANK.get(str(outcome), 0) for outcome in run.frame["outcome"]], "sample": run.frame["sample"]}
    )
    for key, name in (("window", "window_position_error_m"), ("settling", "settling_time_s")):
        keys[key] = -run.metric(name) if run.metrics(name) else 0.0
    keys["time"] = run.frame["outcome_time_s"].where(keys["class"] == 0, 0.0)
    keys["window"] = keys["window"].where(keys["class"] == 1, 0.0)
    return keys.sort_values(["class", "time", "window", "settling", "sample"], kind="stable").index.tolist()


def _row(run: Run, row: int, names: list[str], ranks: dict[str, NDArray[np.float64]]) -> tuple[Cell, ...]:
    sample = int(run.frame["sample"].iloc[row])
    values = (_value(run, name, row) for name in names)
    outcome = str(run.frame["outcome"].iloc[row])
    return (f"{sample}", Mark(outcome), *values, _outstanding(run, row, ranks))


def _replay(run: Run, row: int) -> tuple[Cell, ...]:
    sample = int(run.frame["sample"].iloc[row])
    return (f"{sample}", Code(f"rvjax replay {shlex.quote(run.folder)} --sample {sample}"))


def _value(run: Run, name: str, row: int) -> str:
    """The recorded value, which has no interval: it is an observation."""
    value = float(run.frame[f"metric.{name}"].iloc[row])
    if math.isnan(value):
        return "–"
    return f"{number(100 * value)} %" if is_share(name) else quantity(value, run.column(name).unit)


def _outstanding(run: Run, row: int, ranks: dict[str, NDArray[np.float64]]) -> str:
    """The draws furthest from their median in rank: path = value unit (p99)."""
    far = sorted(ranks, key=lambda path: -abs(ranks[path][row] - 0.5))[:_STANDING_OUT]
    values = {path: quantity(float(run.draw(path)[row]), run.columns[f"draw.{path}"].unit) for path in far}
    return "; ".join(f"{path} = {value} (p{100 * ranks[path][row]:.1f})" for path, value in values.items())


def _ranks(run: Run) -> dict[str, NDArray[np.float64]]:
    """Every draw that varies, as the share of samples with a smaller value; ties share their middle."""
    varied = {path: run.draw(path) for path in run.draws()}
    return {path: (rankdata(x) - 0.5) / x.size for path, x in varied.items() if np.ptp(x) > 0}
