"""The campaigns that watch the controllers: quiet where nothing has changed, and sure where something has."""

from __future__ import annotations

import pytest

from benchmarks.alarms import CAMPAIGNS, GAINS, WEAKENED, complying, flown, misses, worse_than
from rvjax.spec import load
from rvjax.stats import clopper_pearson_lower, clopper_pearson_upper

DOCKING = CAMPAIGNS / "docking.yaml"


def test_the_table_of_gains_has_the_defaults() -> None:
    """Kills: a weakened controller that is none, since a default has changed."""
    from rvjax.campaign import load as resolve

    problem = resolve(DOCKING)
    assert {name: problem.controller.quantities[f"gains.{name}"].parts[0].value for name in GAINS} == GAINS  # pyright: ignore


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


@pytest.mark.parametrize("name", [name for name, (_, flipped) in WEAKENED.items() if flipped or "off" in name])
def test_flipped_signs_are_caught(name: str, request: pytest.FixtureRequest) -> None:
    """By a requirement, or on common draws. Kills: a CI that a sign error passes."""
    if not request.config.getoption("--acceptance"):
        pytest.skip("a compilation each; with --acceptance")
    own = load(DOCKING)
    weak = flown(DOCKING, own.samples, *WEAKENED[name])[1]
    counted = [(requirement, *complying(requirement, weak)) for requirement in own.require]
    caught = [misses(one, own.samples, clopper_pearson_upper(k, n, 0.999)) for one, k, n in counted]
    assert max(caught) > 0.99 or worse_than(flown(DOCKING, own.samples)[1], weak)
