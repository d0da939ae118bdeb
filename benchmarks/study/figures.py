"""The figures of docs/study.md: the cost of every controller against its failures, and the tail of the clearance."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from benchmarks.study.results import samples

DOCS = Path(__file__).parents[2] / "docs"
COLOURS = ("#0072B2", "#999999", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#8C564B")
LINES = ("-", ":", "-", "-", "--", "--", "-.", ":", "-.")
MARKS = "oXs^vDPhd"


def _saved(figure: Figure, path: Path) -> None:
    with matplotlib.rc_context({"svg.hashsalt": path.name}):
        figure.savefig(path, metadata={"Date": None}, bbox_inches="tight")


def cost(record: Mapping[str, Any], folder: Path) -> None:
    """Share of flights that are not captured over the 95 % quantile of Δv, with intervals."""
    figure = Figure(figsize=(8, 4.6))
    axes = figure.add_subplot()
    floor = 0.3 / record["samples"]
    for (name, of), colour, mark in zip(record["controllers"].items(), cycle(COLOURS), cycle(MARKS), strict=False):
        fuel, captured = of["numbers"]["delta_v_m_s.q95"], of["captured"]
        low, value, high = (max(1 - captured[key], floor) for key in ("high", "value", "low"))
        if not isinstance(fuel["value"], (int, float)):
            continue
        spread = [[value - low], [high - value]], [[fuel["value"] - fuel["low"]], [fuel["high"] - fuel["value"]]]
        axes.errorbar(fuel["value"], value, *spread, fmt=mark, color=colour, capsize=2, label=name)
    axes.axhline(0.01, color="#555555", linestyle="--", linewidth=0.8)
    axes.annotate("accepted: 1 %", (0.995, 0.0108), xycoords=("axes fraction", "data"), fontsize=8, ha="right")
    axes.set(yscale="log", xlabel="Δv, 95 % quantile [m/s]", ylabel="flights that are not captured")
    axes.grid(which="major", linewidth=0.3)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), fontsize=8, frameon=False)
    _saved(figure, folder / "study-cost.svg")


def clearance(record: Mapping[str, Any], out: Path, folder: Path) -> None:
    """Share of flights that come nearer to the target than a distance, of every controller."""
    figure = Figure(figsize=(8, 4.6))
    axes = figure.add_subplot()
    for place, (name, line, colour) in enumerate(zip(record["controllers"], cycle(LINES), cycle(COLOURS), strict=False)):
        run = out / "flights" / "baselines" / name if place else out / "flights"
        nearest = np.sort(samples(run)["metric.hull_clearance_m"].dropna().to_numpy())
        share = np.arange(1, len(nearest) + 1) / len(nearest)
        kept = np.unique(np.concatenate([np.arange(min(60, len(nearest))), np.geomspace(1, len(nearest), 120).astype(int) - 1]))
        axes.step(nearest[kept], share[kept], line, where="post", color=colour, linewidth=1.4, label=name)
    axes.axvline(0, color="#555555", linewidth=0.8)
    axes.plot([0.5, 0], [1e-3, 1e-4], "k_", markersize=12)
    axes.annotate("accepted: 10⁻³", (0.5, 1e-3), (8, -10), textcoords="offset points", fontsize=8)
    axes.annotate("accepted: 10⁻⁴", (0, 1e-4), (8, -10), textcoords="offset points", fontsize=8)
    axes.set(yscale="log", xlim=(-0.6, 1.05), xlabel="smallest distance between the hulls [m]; below 0: collision")
    axes.set_ylabel("flights that come nearer")
    axes.grid(which="major", linewidth=0.3)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), fontsize=8, frameon=False)
    _saved(figure, folder / "study-clearance.svg")
