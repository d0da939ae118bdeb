"""Gains for the controllers that are compared with, by the same procedure for each: `python -m benchmarks.fair NAME …`.

Start: position, attitude and velocity loops as steep as those of the controller under test at its defaults. Then 40 candidates on
416 samples of benchmarks/docking.yaml under another seed than the campaign's: the start, 15 with every gain drawn
log-uniformly within a span about the start, 24 about the best so far: the step that led to it twice as far, or else every gain
within a factor of two, never outside the span. The span is a factor of five, so velocity loops of 2 rad/s and more are open to
all; where a loop's steepness is a quotient of two gains, each has the root of that, and where one gain stands for the product of
two, their product. Guidance (the largest approach speed) and rates of adaptation, which hardly matter here, stay.

Best: the smallest error in tubes that 99 % of the samples keep within over the closing window, though nothing below one tube
counts; then the smallest 95 % quantile of the settling time; then the least Δv. (What the campaign requires, made continuous.)
Gains have two digits, so what is shipped is what was flown. What came out: docs/controllers.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES, Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load

CAMPAIGN = Path(__file__).with_name("docking.yaml")
SEED, WIDE, NEAR = 4057, 15, 24

LOOPS = {"k1": 0.06, "k_sigma": 0.25}
FEEDBACK = {**LOOPS, "k2_force": 40.0, "k2_torque": 15.0}
FIRST = {"c_force": 10.0, "c_torque": 4.0}
STARTS: Mapping[str, Mapping[str, float]] = {
    "pd-plus": {"k_rho": 0.024, "k_nu": 0.4, "k_sigma": 0.17, "k_omega": 0.69},
    "sliding-mode": {**LOOPS, "k_force": 0.0175, "phi_force": 0.044, "k_torque": 0.016, "phi_torque": 0.023},
    "nominal-backstepping": {**FEEDBACK, **FIRST},
    "anti-windup": {**FEEDBACK, **FIRST, "k_zeta_force": 0.4, "k_zeta_torque": 0.7},
    "command-filtered": {**FEEDBACK, **FIRST, "filter_rad_s": 5.0},
    "disturbance-observer": {**FEEDBACK, **FIRST, "observer_force_rad_s": 0.5, "observer_torque_rad_s": 1.0},
    "saturated-adaptive": {**FEEDBACK, "k3": 2.0, "kappa": 0.5, "gamma_bound": 6.0},
}
"""The gains that are searched, by controller: where the search starts. The controller under test and PD+ are searched for
comparison only and keep their defaults."""

SPAN = 5.0
SPANS = {("sliding-mode", gain): SPAN**0.5 for gain in ("k_force", "phi_force", "k_torque", "phi_torque")} | {
    ("pd-plus", gain): SPAN**2 for gain in ("k_rho", "k_sigma")
}
"""Largest factor between a candidate's gain and that of the start, where it is not SPAN."""


class Outcome(NamedTuple):
    """captured: samples; error: 99 % quantile, in tubes; settling: 95 % quantile [s]; delta_v: median [m/s]; gains."""

    captured: int
    error: float
    settling: float
    delta_v: float
    gains: dict[str, float]

    @property
    def rank(self) -> tuple[float, float, float]:
        """The smaller the better."""
        return max(self.error, 1.0), self.settling, self.delta_v


class Range:
    """The campaign under the seed of the search, flown with one controller; compiled once for every candidate."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.flyer: Flyer | None = None

    def fly(self, gains: dict[str, float]) -> Outcome:
        """What comes of some gains."""
        said = ", ".join(f"{name}: {value:g}" for name, value in gains.items())
        problem = load(CAMPAIGN, [f"seed={SEED}", f"controller={{use: {self.name}, gains: {{{said}}}}}"])
        if self.flyer is None:
            self.flyer = Flyer.of(problem)
        _, drawn = Draws.of(problem, np.arange(LANES))
        steps = problem.spec.horizon.steps
        values, capture = self.flyer.fly(drawn, steps, steps).values, problem.spec.capture
        attitude = np.tan(np.radians(values["window_attitude_error_deg"]) / 4.0) / capture.attitude_mrp
        error = np.maximum(values["window_position_error_m"] / capture.position_m, attitude)
        return Outcome(
            int(np.nansum(values["captured"])),
            most(error, 0.99),
            most(values["settling_time_s"], 0.95),
            float(np.nanmedian(values["delta_v_m_s"])),
            gains,
        )


def most(values: Any, share: float) -> float:
    """The quantile of what is the better the smaller; a flight that was lost has the worst."""
    return float(np.quantile(np.where(np.isnan(values), np.inf, values), share, method="inverted_cdf"))


def search(name: str) -> Outcome:
    """Flies every candidate and prints what came of it."""
    start, place = STARTS[name], Range(name)
    span = {gain: SPANS.get((name, gain), SPAN) for gain in start}
    generator = np.random.default_rng(SEED)

    def some(widest: float) -> dict[str, float]:
        return {gain: min(widest, span[gain]) ** generator.uniform(-1.0, 1.0) for gain in start}

    def fly(stage: str, centre: Mapping[str, float], step: Mapping[str, float]) -> Outcome:
        kept = {gain: min(max(x * step[gain], start[gain] / span[gain]), start[gain] * span[gain]) for gain, x in centre.items()}
        return told(stage, place.fly({gain: float(f"{x:.2g}") for gain, x in kept.items()}))

    best = told("start", place.fly(dict(start)))
    best = min([best, *(fly("wide", start, some(np.inf)) for _ in range(WIDE))], key=lambda outcome: outcome.rank)
    step: Mapping[str, float] | None = None
    for _ in range(NEAR):
        taken = step or some(2.0)
        tried = fly("near", best.gains, taken)
        better = tried.rank < best.rank
        step, best = ({gain: x * x for gain, x in taken.items()}, tried) if better else (None, best)
    return best


def told(stage: str, outcome: Outcome) -> Outcome:
    """Printed."""
    gains: Any = ", ".join(f"{name}: {value:g}" for name, value in outcome.gains.items())
    print(
        f"{stage:5s} {outcome.captured:4d}  {outcome.error:8.2f}  {outcome.settling:7.2f} s  {outcome.delta_v:6.3f} m/s  {gains}",
        flush=True,
    )
    return outcome


def main() -> None:
    """Prints every candidate of each controller, the best at the end."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="+", choices=STARTS, metavar="NAME", help=", ".join(STARTS))
    jax_config.configure()
    for name in parser.parse_args().names:
        print(f"{name}: captured of {LANES}, 99 % error in tubes, 95 % settling time, median delta-v, gains")
        told("best", search(name))


if __name__ == "__main__":
    main()
