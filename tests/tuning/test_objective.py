"""What candidates are worth, and who is worse: against brute force, and with computed error rates."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy import stats as scipy_stats

from rvjax.campaign import Requirement
from rvjax.campaign.tuning import Objective
from rvjax.columns import Column
from rvjax.search.tuning.objective import POWER, Judge, Measure, needed, tail_mean
from rvjax.stats.pareto import Score

COLUMNS = {
    "metric.settling_time_s": Column("settling_time_s", "s", "", "lower"),
    "metric.margin.m": Column("margin.m", "1", "", "higher"),
    "metric.captured": Column("captured", "1", "", "higher"),
    "metric.saturation_duty.any": Column("saturation_duty.any", "1", "", "lower"),
}


def measure(**said: object) -> Measure:
    return Measure.of(Objective.model_validate(said), COLUMNS)


def table(x: NDArray[np.float64], lost: int = 0) -> pd.DataFrame:
    """Flights whose settling time is x, whose margin −x; the last `lost` are lost."""
    n = len(x)
    outcome = np.where(np.arange(n) >= n - lost, "not_finite", "captured")
    x = np.where(outcome == "not_finite", math.nan, x)
    captured = (outcome == "captured") * 1.0
    return pd.DataFrame(
        {
            "sample": np.arange(n),
            "outcome": outcome,
            "metric.settling_time_s": x,
            "metric.margin.m": -x,
            "metric.captured": captured,
            "metric.saturation_duty.any": x,
        }
    )


def judge(*measures: Measure, require: tuple[Requirement, ...] = (), goal: str = "weighted") -> Judge:
    made = Judge(require, measures, goal)  # type: ignore[arg-type]
    made.columns(list(COLUMNS))
    return made


def test_values_are_those_of_brute_force() -> None:
    """Kills: the wrong tail of a metric that is to be large, a quantile beside its sample, a lost flight that is left out."""
    rng = np.random.default_rng(0)
    for n in (1, 2, 7, 40):
        x = rng.normal(size=n)
        ordered = sorted(x)
        frame = table(x)
        for q in (0.05, 0.25, 0.5, 0.9):
            rank = next(k for k in range(n) if (k + 1) / n >= q - 1e-12)
            one = measure(metric="settling_time_s", quantile=q)
            assert one.shown(one.value(one.losses(frame))) == ordered[rank]
            large = measure(metric="margin.m", quantile=q)
            assert large.shown(large.value(large.losses(frame))) == sorted(-x)[rank]
            fine = np.repeat(np.array(ordered), 1000)  # the worst share of a distribution of n steps, in a thousandth of a step
            worst = fine[len(fine) - max(1, round((1 - q) * len(fine))) :]
            assert tail_mean(x, q) == pytest.approx(worst.mean(), abs=0.02)
        assert measure(metric="settling_time_s", mean=True).value(x) == pytest.approx(x.mean())
    share = measure(metric="settling_time_s", probability=True, below=0.0)
    assert share.shown(share.value(share.losses(table(np.array([-1.0, 1.0, -2.0, -3.0]), lost=1)))) == 0.5
    assert measure(metric="captured", probability=True).losses(table(np.zeros(3), lost=1)).tolist() == [0.0, 0.0, 1.0]
    for said in ({"quantile": 0.95}, {"mean": True}, {"cvar": 0.9}):
        lost = measure(metric="settling_time_s", **said)
        assert lost.value(lost.losses(table(np.zeros(3), lost=1))) == math.inf
        most = measure(metric="margin.m", **said)
        assert most.losses(table(np.zeros(3), lost=1))[2] == math.inf


def test_a_collided_flight_is_lost_whatever_its_numbers_say() -> None:
    """Its metrics of safety are numbers. Kills: an objective that takes them for those of a flight."""
    frame = table(np.zeros(3)).assign(outcome=["captured", "captured", "collided"])
    for said in ({"mean": True}, {"quantile": 0.95}):
        assert measure(metric="settling_time_s", **said).losses(frame)[2] == math.inf
    assert measure(metric="settling_time_s", probability=True, below=1.0).losses(frame).tolist() == [0.0, 0.0, 1.0]


def test_requirements_come_before_objectives() -> None:
    """Kills: a violation that is traded for an objective; a class of samples that counts all; a mean with the wrong side."""
    required = Requirement(metric="settling_time_s", at_least=0.9, below=1.0)
    made = judge(measure(metric="settling_time_s", mean=True), require=(required,))
    x = np.array([0.0] * 8 + [5.0] * 2)
    assert made.score(table(x)) == Score(pytest.approx(0.1), (1.0,))
    assert made.score(table(x)) > made.score(table(np.full(10, 0.99)))
    mean = Requirement(metric="settling_time_s", mean=True, above=2.0)
    assert judge(measure(metric="settling_time_s", mean=True), require=(mean,)).score(table(x)).violation == pytest.approx(0.5)
    of_class = Requirement.model_validate(
        {"metric": "settling_time_s", "at_least": 0.5, "below": 1.0, "where": {"mass": {"below": 3.0}}}
    )
    frame = table(x).assign(**{"draw.mass": [9.0] * 8 + [1.0] * 2})
    chosen = Judge((of_class,), (measure(metric="settling_time_s", mean=True),), "weighted")
    assert chosen.columns([*COLUMNS, "draw.mass"])[-1] == "draw.mass"
    assert chosen.score(frame).violation == pytest.approx(0.5)


def test_a_requirement_that_is_met_is_no_violation() -> None:
    """The second is captured less often than the first, significantly, but as often as it has to be; it misses something else by
    one sample, which is no evidence. Kills: a candidate that leaves for what it is allowed."""
    required = (
        Requirement(metric="captured", at_least=0.8),
        Requirement(metric="saturation_duty", channel="any", at_least=0.95, below=1.0),
    )
    made = judge(measure(metric="settling_time_s", mean=True), require=required)
    k = np.arange(100)
    first = table(np.full(100, 2.0)).assign(**{"metric.saturation_duty.any": np.where(k < 5, 2.0, 0.0)})
    second = table(np.full(100, 1.0)).assign(
        **{"metric.saturation_duty.any": np.where(k < 6, 2.0, 0.0), "outcome": np.where(k < 85, "captured", "not_settled")}
    )
    assert made.score(first).violation == 0.0
    assert made.score(second).violation == pytest.approx(0.01)
    assert made.p_fails(second, first) < 1e-3
    assert made.p_worse(second, first) == 0.5


def test_objectives_are_compared_with_who_is_shown_to_comply() -> None:
    """A third slower, in every sample, than one whose 100 captures show no 99 %: no evidence; 400 captures do. Of means alike.
    Kills: the best candidate that leaves since a faster one has not been seen to fail yet."""
    required = (Requirement(metric="captured", at_least=0.99),)
    made = judge(measure(metric="settling_time_s", mean=True), require=required)
    for n, shown in ((100, False), (400, True)):
        slow, fast = table(np.linspace(3.0, 4.0, n)), table(np.linspace(2.0, 3.0, n) ** 1.01)
        assert made.complies(fast) is shown
        assert (made.p_worse(slow, fast) < 1e-3) is shown
    mean = Requirement(metric="saturation_duty", channel="any", mean=True, below=2.52)
    made = judge(measure(metric="settling_time_s", mean=True), require=(mean,))
    assert [made.complies(table(np.linspace(2.0, 3.0, n))) for n in (20, 4000)] == [False, True]
    assert not made.complies(table(np.linspace(2.0, 3.0, 4000), lost=1))


def test_what_is_needed_passes_on_fresh_draws() -> None:
    """By the binomial law itself, 4,096 samples for 99 % at 95 %. Kills: the limit itself, where a verdict is a matter of luck;
    a class whose size nobody knows; a demand that no share could meet."""
    one = Requirement(metric="captured", at_least=0.99, confidence=0.95)
    share = needed(one, 4096)
    most = max(k for k in range(60) if scipy_stats.binom.cdf(k, 4096, 0.01) <= 0.05)
    assert scipy_stats.binom.cdf(most, 4096, 1 - share) == pytest.approx(POWER, abs=1e-5)
    assert 0.99 < share < 0.995
    assert needed(one, 100) == 0.99
    assert needed(one.model_copy(update={"where": {"pursuer.mass_kg": None}}), 4096) == 0.99
    frame = table(np.zeros(1000), lost=8)
    made = Judge((one,), (measure(metric="settling_time_s", quantile=0.5),), "weighted", 4096)
    made.columns(list(COLUMNS))
    assert made.score(frame).violation == pytest.approx(share - 0.992)
    assert judge(measure(metric="settling_time_s", quantile=0.5), require=(one,)).score(frame).violation == 0.0


def test_weights_and_orders_of_several_objectives() -> None:
    """Kills: a weight that is not used, the second objective before the first."""
    both = (measure(metric="settling_time_s", mean=True, weight=2.0), measure(metric="margin.m", mean=True, weight=0.5))
    frame = table(np.array([1.0, 3.0]))
    assert judge(*both).score(frame).objectives == (2.0 * 2.0 + 0.5 * 2.0,)
    assert judge(*both, goal="lexicographic").score(frame).objectives == (2.0, 2.0)
    assert judge(*both).values(frame) == (2.0, -2.0)


FORMS = (
    {"metric": "settling_time_s", "mean": True},
    {"metric": "settling_time_s", "quantile": 0.8},
    {"metric": "settling_time_s", "cvar": 0.5},
    {"metric": "settling_time_s", "probability": True, "below": 1.0},
)
REPEATS, LEVEL = 600, 0.05


@pytest.mark.parametrize("said", FORMS, ids=["mean", "quantile", "cvar", "probability"])
def test_two_alike_are_seldom_called_worse(said: dict[str, object]) -> None:
    """Two candidates of one law on common draws: the better of the two by its score calls the other worse at level 5 % in at most
    10 % of the repeats (either may be the better one), beyond which chance goes in 1 of 10,000. Kills: a two-sided p-value, the
    sign of the difference, a deviation of single samples in the place of that of pairs."""
    rng = np.random.default_rng(3)
    made = judge(measure(**said))
    called = 0
    for _ in range(REPEATS):
        common = rng.exponential(size=60)
        a, b = (table(common + 0.3 * rng.exponential(size=60)) for _ in range(2))
        better, other = (a, b) if made.score(a) <= made.score(b) else (b, a)
        called += made.p_worse(other, better) <= LEVEL
    assert called <= scipy_stats.binom.isf(1e-4, REPEATS, 2 * LEVEL)


@pytest.mark.parametrize("said", FORMS, ids=["mean", "quantile", "cvar", "probability"])
def test_one_that_is_worse_is_called_so(said: dict[str, object]) -> None:
    """By half a unit on common draws of spread 1: nearly always with 200 pairs. Kills: p-values of the other side."""
    rng = np.random.default_rng(4)
    made = judge(measure(**said))
    common = rng.exponential(size=200)
    a, b = table(common), table(common + 0.5 + 0.1 * rng.normal(size=200))
    assert made.p_worse(b, a) < 1e-3
    several = judge(measure(**said), measure(metric="margin.m", mean=True))
    assert several.p_worse(b, a) < 1e-3
    trade = judge(measure(**said), measure(metric="saturation_duty", channel="any", mean=True), goal="pareto")
    assert trade.p_worse(b, a) < 1e-3
    swapped = b.assign(**{"metric.saturation_duty.any": 0.0})
    assert trade.p_worse(swapped, a) == 1.0  # better in one of them: no worse


def test_who_loses_flights_is_worse() -> None:
    """Kills: infinite losses that become NaN and then no difference; one lost flight of many that throws a candidate out."""
    made = judge(measure(metric="settling_time_s", mean=True))
    x = np.linspace(0.0, 1.0, 100)
    assert made.p_worse(table(x, lost=20), table(x)) < 1e-5
    assert made.p_worse(table(x, lost=1), table(x)) == 0.5
    required = Requirement(metric="captured", at_least=0.95)
    strict = judge(measure(metric="settling_time_s", mean=True), require=(required,))
    assert strict.p_fails(table(x, lost=20), table(x)) < 1e-5
    assert strict.p_fails(table(x), table(x, lost=20)) == 1.0
