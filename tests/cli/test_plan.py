"""`rvjax plan`: published numbers of samples, exact chances, and what a campaign's own requirements come to."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from scipy import stats

from rvjax.analysis.sample_size import of_requirement, plan
from rvjax.campaign import Requirement
from tests.program import Run
from tests.short import CAMPAIGN


def test_published_plans() -> None:
    """299, 473, 628, … samples for 0, 1, 2, … failures at 99 % with 95 %; a quarter of the failures passes 47, 79, 95 %.

    Kills: one sample too few, the power at another share, chances of FAIL for PASS.
    """
    found = plan(0.99, 0.95, [0.9975])
    assert [one.n for one in found.fixed] == [299, 473, 628, 773, 913, 1049, 1693]
    chances = {one.failures: one.chances[0].passes for one in found.fixed}
    assert [round(100 * chances[k]) for k in (0, 2, 5)] == [47, 79, 95]
    for one in found.fixed:
        assert one.chances[0].passes == pytest.approx(stats.binom.cdf(one.failures, one.n, 0.0025))
        assert sum(one.chances[0]) == pytest.approx(1.0)


@pytest.mark.parametrize("power", [0.5, 0.9, 0.99])
def test_the_plan_with_enough_power_is_the_first(power: float) -> None:
    """Against all plans with fewer failures. Kills: a bisection past the first, the power at the limit itself."""
    found = plan(0.95, 0.9, [0.98], power).enough
    assert found is not None

    def passing(k: int) -> float:
        n = next(n for n in range(k + 1, 5000) if stats.binom.cdf(k, n, 0.05) <= 0.1)
        return float(stats.binom.cdf(k, n, 0.02))

    assert passing(found.failures) == pytest.approx(found.chances[0].passes)
    assert found.chances[0].passes >= power
    assert all(passing(k) < power for k in range(max(0, found.failures - 3), found.failures))


def test_no_plan_is_said_to_be_none() -> None:
    """A true share that is hardly above the limit. Kills: an endless search."""
    assert plan(0.9, 0.95, [0.9001], budget=2000).enough is None


def test_a_requirement_of_a_campaign_has_its_own_method() -> None:
    """Kills: at_most taken for at_least, all samples where a sequential method stops."""
    (one,) = of_requirement(Requirement(metric="x", above=1.0, at_most=0.05), 100, [0.99], 416)  # pyright: ignore
    assert one.passes == pytest.approx(stats.binom.cdf(1, 100, 0.01))  # 1 of 100 passes 95 % with 95 %: 93 samples are needed
    (one,) = of_requirement(Requirement(metric="captured", at_least=0.9, method="sequential"), 4160, [0.99], 416)  # pyright: ignore
    assert (one.method, one.budget) == ("sequential", 4160)
    assert 416 <= one.samples < 420
    assert one.passes > 0.999


def test_the_command(rvjax: Run, tmp_path: Path) -> None:
    """Kills: a document that cannot be read, mistakes told one at a time, a campaign's cost left out."""
    code, out, err = rvjax("plan", "--at-least", "0.99", "--true", "0.9975", "--expected", "0.998")
    assert code == 0, err
    assert "1,049" in out
    assert "47.3 %" in out
    assert "sprt" in out
    code, out, _ = rvjax("plan", "--at-least", "0.99", "--json")
    assert code == 0
    assert json.loads(out)["fixed"][0]["n"] == 299
    code, out, err = rvjax("plan", CAMPAIGN)
    assert code == 0, err
    assert "512 samples in 2 chunks" in out
    assert "1. captured: at least 0.99" in out
    code, _, err = rvjax("plan", "--at-least", "1", "--confidence", "1", "--true", "0.5", "--power", "0")
    assert code == 2
    assert len(err.strip().splitlines()) == 4
    for wrong in ((), (CAMPAIGN, "--at-least", "0.9")):
        code, _, err = rvjax("plan", *wrong)
        assert code == 2
        assert "accepted: a campaign FILE, or --at-least SHARE" in err
    campaign = tmp_path / "mean.yaml"
    text = CAMPAIGN.read_text()
    campaign.write_text(text[: text.index("require:")] + "require:\n  - {metric: delta_v_m_s, mean: true, below: 3}\n")
    assert "the chances of a mean depend on its distribution" in rvjax("plan", campaign)[1]
