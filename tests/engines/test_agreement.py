"""The engines `xla` and `llvm` fly to the same ends, in every shipped campaign."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES, Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load
from tests.golden.flights import CAMPAIGNS, FOLDER

CONTINUOUS = "controller={use: saturated-adaptive, derivative: none}"
"""Without the sign switches of the Levant differentiator, which turn the last digit into another flight."""


SHORT = 200
"""Steps after which metrics are compared where flights without the differentiator do not stay near each other: of most samples of
these campaigns it loses control, and a lost flight multiplies the last digit."""

LOSING = ("bakeoff.yaml", "faults.yaml", "navigation.yaml")


def flown(name: str, *overrides: str, steps: int | None = None) -> Mapping[str, Any]:
    """The metrics of the first chunk, and the times of loss, at the end or after some steps."""
    problem = load(FOLDER / name, overrides)
    jax_config.configure(problem.spec.precision)
    _, drawn = Draws.of(problem, np.arange(LANES, dtype=np.int64))
    last = steps or problem.spec.horizon.steps
    result = Flyer.of(problem).fly(drawn, last, last)
    return {**result.values, "lost_s": result.lost_s}


def apart(ours: Any, theirs: Any) -> float:
    """The largest difference, relative to the largest number; ∞ where only one of two is finite."""
    a, b = np.asarray(ours), np.asarray(theirs)
    both = np.isfinite(a) & np.isfinite(b)
    if not np.array_equal(a[~both], b[~both], equal_nan=True):
        return np.inf
    return float(np.max(np.abs(a - b)[both], initial=0.0) / max(np.max(np.abs(b)[both], initial=0.0), 1e-300))


@pytest.mark.parametrize("name", CAMPAIGNS)
def test_engines_agree(name: str, figure: Any) -> None:
    """Every outcome is equal; without the Levant differentiator every metric is, to 1e-9. Kills: a wrong
    instruction that a test of single operations does not see; noise in single precision, where XLA contracts; a decision that
    the last digit makes."""
    ours, theirs = (flown(name, f"engine={engine}") for engine in ("llvm", "xla"))
    assert np.array_equal(ours["captured"], theirs["captured"], equal_nan=True)
    assert np.array_equal(np.isfinite(ours["lost_s"]), np.isfinite(theirs["lost_s"]))
    steps = SHORT if name in LOSING else None
    controller = load(FOLDER / name).spec.controller
    switching = controller.use == "saturated-adaptive" and controller.parameters.get("derivative", "levant") == "levant"
    if switching or steps:
        changes = [CONTINUOUS] if switching else []
        ours, theirs = (flown(name, f"engine={engine}", *changes, steps=steps) for engine in ("llvm", "xla"))
    differences = {metric: apart(ours[metric], theirs[metric]) for metric in ours}
    worst = max(differences, key=lambda metric: differences[metric])
    when = f" after {steps} steps" if steps else ""
    figure(f"engines in {name}: outcomes of {LANES} samples equal, metrics{when} to {differences[worst]:.0e} ({worst})")
    assert differences[worst] <= 1e-9, worst
