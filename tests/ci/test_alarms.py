"""The campaigns that watch the controllers: quiet where nothing has changed, and sure where something has."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from benchmarks.alarms import (
    CAMPAIGNS,
    GAINS,
    OBSERVER_GAINS,
    WATCHED,
    WEAKENED,
    complying,
    flown,
    misses,
    most_surely,
    worse_than,
)
from rvjax.campaign import load
from rvjax.stats import clopper_pearson_lower, clopper_pearson_upper

DOCKING, MEASURED = CAMPAIGNS / "docking.yaml", CAMPAIGNS / "measured.yaml"


@pytest.mark.parametrize(("campaign", "gains"), [(DOCKING, GAINS), (MEASURED, OBSERVER_GAINS)], ids=["docking", "measured"])
def test_the_table_of_gains_has_the_defaults(campaign: Path, gains: Mapping[str, float]) -> None:
    """Kills: a weakened controller that is none, since a default has changed; a gain that is forgotten."""
    from rvjax.simulation.problem import load as resolve

    quantities = resolve(campaign).controller.quantities
    assert {name: quantities[f"gains.{name}"].parts[0].value for name in gains} == gains  # pyright: ignore


def test_weakened_gains_are_caught_and_sound_ones_are_not(request: pytest.FixtureRequest) -> None:
    """One chunk of each under a fresh seed. Caught with a chance above 0.99 at the upper bound of a share. That false alarms come
    less often than once in 10,000 runs takes more samples to show: `benchmarks.alarms`. Kills: thresholds that nothing fails."""
    if not request.config.getoption("--acceptance"):
        pytest.skip("two chunks at full length; with --acceptance")
    own = load(DOCKING)
    sound, weak = flown(DOCKING, own.samples)[1], flown(DOCKING, own.samples, WEAKENED["all gains −30 %"][0])[1]
    alarm, catch = 0.0, 0.0
    for requirement in own.require:
        k, n = complying(requirement, sound)
        alarm += misses(requirement, own.samples, clopper_pearson_lower(k, n, 0.999))
        k, n = complying(requirement, weak)
        catch = max(catch, misses(requirement, own.samples, clopper_pearson_upper(k, n, 0.999)))
    assert alarm < 0.1
    assert catch > 0.99
    assert len(worse_than(sound, weak)) >= 3
    assert worse_than(sound, sound) == []


@pytest.mark.parametrize(
    ("campaign", "name"),
    [(campaign, name) for campaign, weak in WATCHED.items() for name, (_, flipped) in weak.items() if flipped or "off" in name],
)
def test_what_is_broken_is_caught(campaign: str, name: str, request: pytest.FixtureRequest) -> None:
    """A sign, an estimate that is off: by a requirement, or on common draws. Kills: a CI that a sign error passes."""
    if not request.config.getoption("--acceptance"):
        pytest.skip("a compilation each; with --acceptance")
    path = CAMPAIGNS / f"{campaign}.yaml"
    own = load(path)
    weak = flown(path, 416, *WATCHED[campaign][name])[1]
    assert most_surely(own, weak)[0] > 0.99 or worse_than(flown(path, 416)[1], weak)
