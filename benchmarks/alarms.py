"""How often a CI campaign fails for nothing, and how surely for a reason: `python -m benchmarks.alarms [--campaign NAME]`.

Each campaign of `campaigns/ci` is flown with N samples of another seed. The share that complies with a requirement is then at
least its lower 99.99 % Clopper-Pearson bound; with that share the exact chance that one run of the campaign does not end in PASS
is summed over all numbers of failures (and over all looks of a sequential one). The same for weakened controllers, on 1,664
samples, with the upper bound: the chance that at least one requirement does not pass; and what is worse than the sound controller
on the campaign's own draws. What came out: docs/ci.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

CAMPAIGNS = Path(__file__).parents[1] / "campaigns" / "ci"
SEED, WEAK = 987_654_321, 1664
BOUND = 0.9999

GAINS = {"k1": 0.1, "k_sigma": 0.4, "k2_force": 40.0, "k2_torque": 15.0, "k3": 8.0, "gamma_bound": 6.0}
WEAKENED: Mapping[str, tuple[Sequence[str], str]] = {
    "all gains −30 %": ([f"controller.gains.{name}={0.7 * value}" for name, value in GAINS.items()], ""),
    **{f"{name} −30 %": ([f"controller.gains.{name}={0.7 * value}"], "") for name, value in GAINS.items()},
    "D̂ off": (["controller.adapt_bound=false"], ""),
    "sign of D̂ ∘ z₂/√(z₂²+ε²) flipped": ([], "saturated_adaptive.direction"),
    "sign of K₂z₂ flipped": ([], "saturated_adaptive.feedback"),
    "sign of Ŷθ flipped": ([], "saturated_adaptive.model"),
}
"""Overrides of campaigns/ci/docking.yaml, and the function of the law whose sign is flipped."""

OBSERVER_GAINS = {
    "k1": 0.19,
    "k_sigma": 0.089,
    "k2_force": 61.0,
    "k2_torque": 28.0,
    "c_force": 3.4,
    "c_torque": 5.8,
    "observer_force_rad_s": 0.99,
    "observer_torque_rad_s": 0.91,
}
OBSERVER: Mapping[str, tuple[Sequence[str], str]] = {
    "all gains −30 %": ([f"controller.gains.{name}={0.7 * value}" for name, value in OBSERVER_GAINS.items()], ""),
    **{f"{name} −30 %": ([f"controller.gains.{name}={0.7 * value}"], "") for name, value in OBSERVER_GAINS.items()},
    "observer off": ([f"controller.gains.observer_{name}_rad_s=1.0e-9" for name in ("force", "torque")], ""),
    "sign of L M₀x₂ flipped": ([], "disturbance_observer.momentum"),
    "sign of Y₀θ₀ in the observer flipped": ([], "disturbance_observer.model"),
}
"""The same of campaigns/ci/measured.yaml."""

RARE = {name: WEAKENED[name] for name in ("D̂ off", "sign of K₂z₂ flipped")}
"""The same of campaigns/ci/rare.yaml, which asks for nothing but the clearance and the capture."""

WATCHED = {"docking": WEAKENED, "measured": OBSERVER, "rare": RARE}


def flown(path: Path, samples: int, overrides: Sequence[str] = (), flipped: str = "") -> tuple[Any, pd.DataFrame]:
    """The campaign, and a table of its samples under another seed."""
    from rvjax.simulation.batch import LANES, Flyer
    from rvjax.simulation.draws import Draws
    from rvjax.simulation.engines import choice
    from rvjax.simulation.problem import load

    module, _, function = flipped.partition(".")
    law = import_module(f"rvjax.components.controllers.{module}") if flipped else None
    right: Callable[..., Any] | None = getattr(law, function) if flipped else None
    if right is not None:
        setattr(law, function, lambda *given: -right(*given))
        choice._choices.clear()  # an engine that was traced before flies the right law
    try:
        problem = load(path, [f"seed={SEED}", f"samples={samples}", *overrides])
        flyer, steps = Flyer.of(problem), problem.spec.horizon.steps
        parts: list[pd.DataFrame] = []
        for first in range(0, samples, LANES):
            numbers = np.arange(first, min(first + LANES, samples))
            _, drawn = Draws.of(problem, np.arange(first, first + LANES))
            one = flyer.fly(drawn, steps, steps)
            lost = np.isfinite(one.lost_s)
            words = np.where(lost, "not_finite", np.where(one.values["captured"] > 0, "captured", "not_settled"))
            table = {f"metric.{name}": np.asarray(values, dtype=float) for name, values in one.values.items()}
            parts.append(pd.DataFrame({"outcome": words, **table}).iloc[: len(numbers)].assign(sample=numbers))
    finally:
        if right is not None:
            setattr(law, function, right)
            choice._choices.clear()
    return problem.spec, pd.concat(parts, ignore_index=True)


def complying(requirement: Any, table: pd.DataFrame) -> tuple[int, int]:
    """How many samples comply, of how many."""
    from rvjax.analysis.verdicts.compliance import RequirementEvaluator

    reading = RequirementEvaluator(requirement)
    return int(reading.comply(reading.values(table, {})).sum()), len(table)


def misses(requirement: Any, samples: int, share: float) -> float:
    """The chance not to end in PASS where a sample complies with this probability."""
    from rvjax.simulation.batch import LANES
    from rvjax.stats import e_boundary, schedule, verdict_chances, walk

    if requirement.method == "fixed":
        found = verdict_chances(samples, requirement.limit, requirement.confidence, share)
        return float(found.fails + found.undecided)
    ends = walk(share, e_boundary(schedule(samples, LANES), requirement.limit, 1 - requirement.confidence))
    return ends.fails + ends.undecided


def main() -> None:
    """Prints both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--reference", type=int, default=20_800)
    parser.add_argument("--campaign", choices=sorted(WATCHED), help="this one only")
    given = parser.parse_args()
    watched = [given.campaign] if given.campaign else sorted(WATCHED)
    from rvjax.analysis import baseline
    from rvjax.simulation import jax_config

    jax_config.configure("float64")
    from rvjax.analysis.verdicts.sentences import title
    from rvjax.campaign import load
    from rvjax.stats import clopper_pearson_lower

    print("| campaign | requirement | complying | at least | chance not to pass |\n|---|---|---|---|---|")
    total = 0.0
    for path in (CAMPAIGNS / f"{name}.yaml" for name in watched):
        own, table = load(path), flown(path, given.reference)[1]
        for requirement in own.require:
            k, n = complying(requirement, table)
            low = clopper_pearson_lower(k, n, BOUND)
            chance = misses(requirement, own.samples, low)
            total += chance
            print(f"| {own.name} | {title(requirement)} | {k:,} of {n:,} | {100 * low:.4f} % | {chance:.1e} |", flush=True)
    print(f"| all | | | | at most {total:.1e} |\n")
    print("| campaign | weakened | fails most surely | complying | at most | chance not to pass | worse on common draws |")
    print("|---|---|---|---|---|---|---|")
    for campaign in watched:
        path = CAMPAIGNS / f"{campaign}.yaml"
        own = load(path)
        same, paired = (f"seed={own.seed}",), min(own.samples, baseline.MOST)
        sound = flown(path, paired, same)[1]
        for name, (overrides, flipped) in WATCHED[campaign].items():
            chance, words, k, n, high = most_surely(own, flown(path, WEAK, overrides, flipped)[1])
            worse = ", ".join(worse_than(sound, flown(path, paired, (*same, *overrides), flipped)[1])) or "nothing"
            words = words if chance > 0.5 else "none"
            print(f"| {own.name} | {name} | {words} | {k:,} of {n:,} | {100 * high:.2f} % | {chance:.6f} | {worse} |", flush=True)


def most_surely(own: Any, table: pd.DataFrame) -> tuple[float, str, int, int, float]:
    """The largest chance that a requirement does not pass, at the upper bound of the share that complies; which requirement, how
    many comply, of how many, and the bound."""
    from rvjax.analysis.verdicts.sentences import title
    from rvjax.stats import clopper_pearson_upper

    found: list[tuple[float, str, int, int, float]] = []
    for requirement in own.require:
        k, n = complying(requirement, table)
        high = clopper_pearson_upper(k, n, BOUND)
        found.append((misses(requirement, own.samples, high), title(requirement), k, n, high))
    return max(found)


def worse_than(sound: pd.DataFrame, table: pd.DataFrame) -> list[str]:
    """The metrics that `check --against` would call significantly worse, each with how many samples are."""
    from rvjax.analysis import baseline

    found: list[str] = []
    for name in baseline.METRICS:
        old, new = (
            np.where(np.isfinite(one[f"metric.{name}"]), one[f"metric.{name}"], np.inf).astype(float) for one in (sound, table)
        )
        worse, _ = baseline.steps(old, new, higher=False)
        if len(baseline.METRICS) * baseline.more_than_half(int(worse.sum()), len(worse)) <= baseline.RISK:
            found.append(f"{name} ({int(worse.sum())} of {len(worse)})")
    return found


if __name__ == "__main__":
    main()
