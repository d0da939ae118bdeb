"""The documented scenarios: one chunk of each by default, all 2,048 with `--acceptance`."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from rvjax.simulation.batch import LANES, Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load
from tests.short import SHIPPED

RUNAWAY = SHIPPED / "nussbaum-runaway.yaml"
DOCUMENTED = 0.996
"""2,040 of 2,048: the share of the shaped law's flights that has to be captured."""

SHAPED = ("controller.shaped=true",)
SHAPED_NONE = ("controller.shaped=true", "controller.nussbaum=none")
TEXTBOOK: tuple[str, ...] = ()
NO_BOUND = ("controller.shaped=true", "controller.adapt_bound=false")


def captured(overrides: tuple[str, ...], samples: int) -> int:
    """How many of the first samples of the runaway campaign are captured."""
    problem = load(RUNAWAY, overrides)
    flyer = Flyer.of(problem)
    count = 0
    for first in range(0, samples, LANES):
        _, drawn = Draws.of(problem, np.arange(first, first + LANES))
        flown = flyer.fly(drawn, problem.spec.horizon.steps, problem.spec.horizon.steps)
        count += int((flown.values["captured"] * np.isinf(flown.lost_s))[: samples - first].sum())
    return count


def test_the_shaped_law_captures_and_the_textbook_law_does_not() -> None:
    """Kills: adaptation switched off, h' left out of the augmented system, a sign of the Nussbaum loop, shaping ignored.

    If the share is as documented (at least 0.996, below 0.05), this fails with probability below 1e-6 on either side.
    """
    least = int(stats.binom.ppf(1e-6, LANES, DOCUMENTED))
    most = int(stats.binom.isf(1e-6, LANES, 0.05))
    assert least >= 0.96 * LANES
    assert most <= 0.13 * LANES
    assert captured(SHAPED, LANES) >= least
    assert captured(TEXTBOOK, LANES) <= most


@pytest.mark.parametrize(
    ("overrides", "at_least", "at_most"),
    [(SHAPED, 2040, 2048), (SHAPED_NONE, 2040, 2048), (TEXTBOOK, 0, 102), (NO_BOUND, 0, 20)],
    ids=["shaped", "shaped, no Nussbaum gain", "textbook", "shaped, no bound adaptation"],
)
def test_all_2048(overrides: tuple[str, ...], at_least: int, at_most: int, request: pytest.FixtureRequest) -> None:
    if not request.config.getoption("--acceptance"):
        pytest.skip("minutes; with --acceptance")
    assert at_least <= captured(overrides, 2048) <= at_most
