"""The record of the study, `results.json`: every number of docs/study.md, read from the run folders."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.study.controllers import CAMPAIGN, Entry
from benchmarks.study.stages import drivers, found, loaded
from rvjax.campaign import load
from rvjax.columns import CHANNELS
from rvjax.stats.binomial import clopper_pearson
from rvjax.stats.paired import mcnemar, pairs_of
from rvjax.stats.quantiles import quantile_interval
from rvjax.stats.rare.replicates import student_interval

RECORD = Path(__file__).with_name("results.json")
KINDS = ("effectiveness", "incipient", "bias", "stuck", "lag", "delay")
"""Faults that some flights have and others do not; `drift` and `dropout` are in every flight."""
WEAK = 0.4
"""Remaining effectiveness below which a channel is called weak."""
CONFIDENCE = 0.95
FEW = 10
"""Flights that both capture, of which no difference is shown."""
DRAWS = 3
"""That are named for a result."""

Json = dict[str, Any]


def samples(folder: Path) -> pd.DataFrame:
    """The samples table of a run folder, in the order of the samples."""
    return pd.read_parquet(folder / "samples").sort_values("sample", ignore_index=True)


def share(count: int, n: int) -> Json:
    """A share with its Clopper-Pearson interval; [0, 1] of nothing."""
    interval = clopper_pearson(count, n, CONFIDENCE)
    return {"count": count, "n": n, "low": interval.low, "high": interval.high}


def _judged(folder: Path) -> Json:
    """Of a run folder: outcomes, verdicts and numbers of its summary."""
    summary = loaded(folder / "summary.json")
    numbers = summary["numbers"]

    def interval(name: str) -> Json | None:
        number = numbers.get(name)
        return number and {key: number[key] for key in ("value", "low", "high")}

    quantiles = ("delta_v_m_s.q50", "delta_v_m_s.q95", "settling_time_s.q95", "window_position_error_m.q95")
    return {
        "account": summary["account"],
        "requirements": {requirement["id"]: requirement["verdict"] for requirement in summary["requirements"]},
        "captured": interval("captured.share"),
        "collided": interval("collided.share"),
        "numbers": {name: interval(name) for name in quantiles},
    }


def failures_by_kind(table: pd.DataFrame) -> dict[str, Json]:
    """Flights without capture among those with a kind of fault, and among those without it."""
    failed = (table.outcome != "captured").to_numpy()
    came: dict[str, Json] = {}
    for kind in KINDS:
        with_it = (table[f"draw.faults.{kind}.schedule.failing"] > 0).to_numpy()
        came[kind] = {
            "with": share(int(failed[with_it].sum()), int(with_it.sum())),
            "without": share(int(failed[~with_it].sum()), int((~with_it).sum())),
        }
    return came


def failures_by_channel(table: pd.DataFrame) -> Json:
    """Flights without capture among those in which a channel keeps less than WEAK of its effectiveness; and the collisions in
    which the braking channel is weak and its driver restarts as well, of all collisions.
    """
    failed, collided = (table.outcome != "captured").to_numpy(), (table.outcome == "collided").to_numpy()

    def happens(fault: str, channel: str) -> np.ndarray:
        return np.isfinite(table[f"draw.faults.{fault}.onset_s.{channel}"].to_numpy())

    weak = {
        channel: happens("effectiveness", channel) & (table[f"draw.faults.effectiveness.remaining.{channel}"] < WEAK).to_numpy()
        for channel in CHANNELS
    }
    both = weak["fx"] & happens("dropout", "fx")
    return {
        "weak": {channel: share(int(failed[which].sum()), int(which.sum())) for channel, which in weak.items()},
        "braking": {"flights": int(both.sum()), "collided": int(collided[both].sum()), "of": int(collided.sum())},
    }


def failure_classes(table: pd.DataFrame) -> Json:
    """What became of the flights: each is in one class, the gravest that it is in."""
    inside = (table["metric.window_position_error_m"] <= load(CAMPAIGN).capture.position_m).to_numpy()
    outcome = table.outcome.to_numpy()
    outside = (table["metric.keep_out_violation_s"].to_numpy() > 0) | (table["metric.corridor_violation_s"].to_numpy() > 0)
    classes = {
        "collided": outcome == "collided",
        "not finite": outcome == "not_finite",
        "left the corridor": (outcome == "not_settled") & outside,
        "attitude only": (outcome == "not_settled") & ~outside & inside,
        "position": (outcome == "not_settled") & ~outside & ~inside,
        "captured": outcome == "captured",
    }
    return {name: int(np.sum(which)) for name, which in classes.items()}


def against(table: pd.DataFrame, reference: pd.DataFrame) -> Json:
    """Captures by one controller only, on the same draws, with McNemar's exact test; and the paired difference of Δv, its median
    with an interval by order statistics, over flights that both capture.
    """
    here, there = (each.outcome.to_numpy() == "captured" for each in (table, reference))
    both, only, other, _ = pairs_of(here, there)
    difference = (table["metric.delta_v_m_s"] - reference["metric.delta_v_m_s"]).to_numpy()[here & there]
    return {"only": only, "other": other, "p": float(mcnemar(only, other)), "both": both, "delta_v": _median(difference)}


def _median(values: np.ndarray) -> Json | None:
    """The median with its interval by order statistics; None of too few."""
    if len(values) <= FEW:
        return None
    interval = quantile_interval(values, 0.5, CONFIDENCE)
    return {"value": float(np.median(values)), "low": interval.low, "high": interval.high}


def _collisions(folder: Path) -> Json:
    """Of a search for collisions: the estimate, why it was refused, and where failures lie."""
    record = loaded(folder / "rare-1" / "rare.json")
    nominal = student_interval(record["replicates"], CONFIDENCE)
    return {
        "estimate": nominal.value,
        "low": nominal.low,
        "high": nominal.high,
        "flights": record["flights"],
        "refusals": record["refusals"],
        "regions": [
            {"share": region["share"], "distance": region["distance"], "moved": region["moved"][:DRAWS]}
            for region in record["regions"][:1]
        ],
    }


def _drivers(folder: Path) -> list[Json]:
    """The draws that explain most of the variance of Δv, with their first-order shares."""
    pairs = [pair for pair in drivers(folder, "delta_v_m_s") if pair["p_holm"] < 1 - CONFIDENCE and pair["share"]]
    most = sorted(pairs, key=lambda pair: -pair["share"]["value"])[:DRAWS]
    return [{"draw": pair["draw"], **{key: pair["share"][key] for key in ("value", "low", "high")}} for pair in most]


def record(entries: Sequence[Entry], out: Path) -> Json:
    """Every number of the study."""
    folders = {entry.name: out / "flights" / "baselines" / entry.name for entry in entries}
    folders[entries[0].name] = out / "flights"
    reference = samples(folders[entries[0].name])
    controllers: dict[str, Json] = {}
    for entry in entries:
        folder = folders[entry.name]
        table = samples(folder)
        controllers[entry.name] = {
            "search": found(out / "searches" / entry.name)._asdict(),
            **_judged(folder),
            "classes": failure_classes(table),
            "kinds": failures_by_kind(table),
            "channels": failures_by_channel(table),
            "against": against(table, reference),
            "collisions": _collisions(out / "collisions" / entry.name),
            "drivers": _drivers(folder),
        }
    return {"samples": len(reference), "controllers": controllers}
