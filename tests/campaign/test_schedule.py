"""Schedules of faults: how many channels fail, which, and which together; and that nothing else is drawn anew."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from rvjax.columns import CHANNELS
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load
from tests.short import CAMPAIGN

N = 6000
ALARM = 1e-9
"""Probability that one of the statistical statements below is false by chance; the seed is the campaign's."""

ONSET = "{uniform: [30, 150]}"


def drawn(fault: str) -> tuple[dict[str, NDArray[np.float64]], NDArray[np.float64]]:
    """All draws with this fault as the only one, and (6, N) onsets that fly."""
    problem = load(CAMPAIGN, [f"faults=[{{use: effectiveness, remaining: 0.5, {fault}}}]"])
    draws, numbers = Draws.of(problem, np.arange(N, dtype=np.int64))
    return draws.values, np.array(numbers.faults[0].onset_s.parts())


def likely(count: int, probability: float) -> bool:
    """Whether a binomial count of N lies where all but ALARM of them lie."""
    low, high = stats.binom.interval(1 - ALARM, N, probability)
    return bool(low <= count <= high)


def test_a_fixed_number_of_channels_fails_and_every_choice_of_them_is_equally_likely() -> None:
    """Kills: one channel too many, channels in the order of their names, the same lots for two channels."""
    values, onset = drawn(f"onset_s: {ONSET}, channels: [fx, fy, tx, tz], schedule: {{count: 2}}")
    fails = np.isfinite(onset) & (onset < 1e30)
    assert (fails.sum(axis=0) == 2).all()
    np.testing.assert_array_equal(values["faults.effectiveness.schedule.failing"], 2.0)
    able = [CHANNELS.index(name) for name in ("fx", "fy", "tx", "tz")]
    assert all(likely(int((fails[a] & fails[b]).sum()), 1 / 6) for a, b in combinations(able, 2))


def test_the_number_of_channels_that_fail_may_be_drawn() -> None:
    """Kills: the mean of the number, a number of its own for each channel, truncation in the place of rounding."""
    values, onset = drawn(f"onset_s: {ONSET}, schedule: {{count: {{choice: [0, 1.6, 9]}}}}")
    failing = np.isfinite(onset).sum(axis=0)
    np.testing.assert_array_equal(values["faults.effectiveness.schedule.failing"], failing)
    assert set(failing) == {0, 2, 6}
    assert all(likely(int((failing == count).sum()), 1 / 3) for count in (0, 2, 6))


def test_channels_may_fail_each_by_itself_with_a_probability() -> None:
    """Kills: one lot for all channels, P(sound) for P(fails)."""
    _, onset = drawn(f"onset_s: {ONSET}, schedule: {{probability: 0.2}}")
    fails = np.isfinite(onset)
    assert all(likely(int(row.sum()), 0.2) for row in fails)
    assert all(likely(int((a & b).sum()), 0.04) for a, b in combinations(fails, 2))


@pytest.mark.parametrize("together", [1.0, 0.3])
def test_a_group_fails_as_one_at_the_first_onset_of_its_channels(together: float) -> None:
    """Kills: the last onset, a group that fails although none of its channels does, one that always fails as one."""
    said = f"{{probability: 0.4, groups: [[fx, tz], [fy, fz]], together: {together}}}"
    _, alone = drawn(f"onset_s: {ONSET}, schedule: {{probability: 0.4}}")
    _, onset = drawn(f"onset_s: {ONSET}, schedule: {said}")
    for names in (("fx", "tz"), ("fy", "fz")):
        rows = [CHANNELS.index(name) for name in names]
        first = alone[rows].min(axis=0)
        as_one = (onset[rows] == first).all(axis=0) & np.isfinite(first)
        apart = (onset[rows] == alone[rows]).all(axis=0)
        assert (as_one | apart).all()
        assert likely(int(as_one.sum()), together * (1 - 0.6**2))
    np.testing.assert_array_equal(onset[3:5], alone[3:5])


def test_a_schedule_draws_nothing_else_anew() -> None:
    """Where a channel fails it does so when it did without the schedule. Kills: a stream that others use as well."""
    before, onset = drawn(f"onset_s: {ONSET}")
    after, scheduled = drawn(f"onset_s: {ONSET}, schedule: {{probability: 0.5, groups: []}}")
    fails = np.isfinite(scheduled)
    np.testing.assert_array_equal(scheduled[fails], onset[fails])
    assert 0.4 < fails.mean() < 0.6
    names = [name for name in before if ".onset_s." not in name]
    assert names
    for name in names:
        np.testing.assert_array_equal(before[name], after[name])
    fewer, _ = drawn(f"onset_s: {ONSET}, channels: [fx, fy], schedule: {{probability: 0.5}}")
    np.testing.assert_array_equal(fewer["faults.effectiveness.onset_s.fx"], after["faults.effectiveness.onset_s.fx"])


def test_what_flies_is_what_the_table_says() -> None:
    """Kills: the onset before the schedule in the table."""
    values, onset = drawn(f"onset_s: {ONSET}, schedule: {{count: 1, groups: [[fx, fy, fz]]}}")
    for name, row in zip(CHANNELS, onset, strict=True):
        np.testing.assert_array_equal(values[f"faults.effectiveness.onset_s.{name}"], row)
    failing = np.isfinite(onset).sum(axis=0)
    assert set(failing) == {1, 3}
    np.testing.assert_array_equal(values["faults.effectiveness.schedule.failing"], failing)
