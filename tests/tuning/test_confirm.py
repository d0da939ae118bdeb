"""The comparison on fresh draws: signs, verdicts and optimism of every form, against what was put in."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rvjax.search.tuning.confirm import _difference, _row
from tests.tuning.test_objective import measure, table

RNG = np.random.default_rng(0)
COMMON = RNG.exponential(size=600)

FORMS = (
    {"metric": "settling_time_s", "mean": True},
    {"metric": "settling_time_s", "quantile": 0.9},
    {"metric": "settling_time_s", "cvar": 0.8},
    {"metric": "settling_time_s", "probability": True, "below": 1.0},
    {"metric": "margin.m", "quantile": 0.1},
    {"metric": "margin.m", "mean": True},
    {"metric": "captured", "probability": True},
)


@pytest.mark.parametrize("said", FORMS, ids=lambda said: "-".join(map(str, said.values())))
@pytest.mark.parametrize("better", [True, False])
def test_who_is_better_is_called_so(said: dict[str, object], better: bool) -> None:
    """Half a unit faster, or slower, in every sample; 60 more, or fewer, flights lost in the place of that where captures count.
    Kills: the sign of a difference, of a metric that is to be large, of a share; an interval that is turned round; an optimism
    that is a pessimism."""
    one = measure(**said)
    if said["metric"] == "captured":
        tuned, own = (table(COMMON, lost=lost) for lost in ((20, 80) if better else (80, 20)))
    else:
        tuned, own = table(COMMON + (-0.5 if better else 0.5)), table(COMMON)
    x, y = one.losses(tuned), one.losses(own)
    values = [one.shown(one.value(loss)) for loss in (x, y)]
    estimate = _difference(one, x, y, 0.95)
    assert estimate.value == pytest.approx(values[0] - values[1], abs=1e-9)
    assert estimate.low <= estimate.value <= estimate.high
    large = one.largest or one.objective.probability
    seen = values[0] + (0.3 if large else -0.3)  # the search saw more than there is
    row = _row(str(one), one.unit, one.objective.probability, seen, values, estimate, large)
    assert row.verdict == ("better" if better else "worse")
    assert row.optimism == pytest.approx(0.3)


def test_what_cannot_be_told_apart_or_said() -> None:
    """Kills: a verdict where both are alike or both infinite; an optimism with the wrong sign where one is infinite."""
    one = measure(metric="settling_time_s", quantile=0.9)
    x = one.losses(table(COMMON))
    shuffled = one.losses(table(RNG.permutation(COMMON)))
    row = _row("", "s", False, 1.0, [1.0, 1.0], _difference(one, x, shuffled, 0.95), False)
    assert row.verdict == "not told apart"
    lost = one.losses(table(COMMON, lost=100))
    both = _row("", "s", False, math.inf, [math.inf, math.inf], _difference(one, lost, lost, 0.95), False)
    assert both.verdict == "not told apart"
    assert math.isnan(both.optimism), "no number says how much better one infinity is than another"
    assert _row("", "s", False, math.inf, [3.0, 3.0], _difference(one, x, x, 0.95), False).optimism == -math.inf
    assert _row("", "s", False, 3.0, [math.inf, 3.0], _difference(one, lost, x, 0.95), False).verdict == "worse"
