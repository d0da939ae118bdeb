"""`rvjax plan`: published numbers of samples, exact chances, and what a campaign's own requirements come to."""

from __future__ import annotations

import json
import re
from decimal import Decimal
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


@pytest.mark.parametrize("most", [0.01, 1e-4, 1e-6])
@pytest.mark.parametrize("confidence", [0.95, 0.999])
def test_a_plan_for_a_share_of_bad_samples(most: float, confidence: float) -> None:
    """The smallest n for which k bad samples show a share of at most p, and the chances at smaller true shares.

    Against the beta and binomial distributions of SciPy. Kills: the share of good samples for that of bad ones, a true share on
    the wrong side, one sample too few or too many.
    """
    found = plan(most, confidence, [most / 2, most / 10], bad=True)
    assert (found.limit, found.bad, found.trues) == (most, True, (most / 2, most / 10))
    for one in found.fixed:
        assert stats.beta.ppf(confidence, one.failures + 1, one.n - one.failures) <= most * (1 + 1e-9)
        assert stats.beta.ppf(confidence, one.failures + 1, one.n - 1 - one.failures) > most * (1 - 1e-9)
        for true, chance in zip(found.trues, one.chances, strict=True):
            assert chance.passes == pytest.approx(stats.binom.cdf(one.failures, one.n, true), rel=1e-6)
    assert found.enough is not None
    assert stats.binom.cdf(found.enough.failures, found.enough.n, most / 2) >= 0.9
    assert [test.true for test in found.running] == [most / 2, most / 10]
    good = plan(1 - most, confidence, [1 - most / 2, 1 - most / 10])
    assert [one.n for one in good.fixed] == [one.n for one in found.fixed]


def test_default_shares_of_bad_samples_are_parts_of_the_limit() -> None:
    """Kills: true shares above what is allowed, those of good samples."""
    assert plan(0.02, bad=True).trues == pytest.approx((0.01, 0.005, 0.002))
    running = plan(0.02, bad=True, expected=0.001).running
    assert [(test.method, test.true) for test in running] == [
        (method, pytest.approx(share)) for method in ("sequential", "sprt") for share in (0.01, 0.005, 0.002)
    ]


@pytest.mark.parametrize(
    ("arguments", "heads"),
    [
        (("--at-least", "0.999999", "--confidence", "0.999"), ("99.99995", "99.999975", "99.99999")),
        (("--at-least", "0.9999995", "--true", "0.9999996", "--true", "0.99999999"), ("99.99996", "99.999999")),
        (("--at-least", "0.95", "--true", "0.9500000001", "--true", "0.95000001"), ("95.00000001", "95.000001")),
        (("--at-most", "0.000001"), ("0.00005", "0.000025", "0.00001")),
        (("--at-most", "0.05", "--true", "0.0499999999"), ("4.99999999",)),
    ],
)
def test_columns_say_their_shares(
    rvjax: Run, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], heads: tuple[str, ...]
) -> None:
    """Kills: shares rounded to six digits, so that two columns are headed 100 %, or as the required share."""
    monkeypatch.setenv("COLUMNS", "300")
    code, out, err = rvjax("plan", *arguments)
    assert code == 0, err
    assert re.findall(r"pass at ([\d.]+) %", out) == list(heads)
    true = re.findall(r"sequential +([\d.]+) %", out)
    assert true == list(heads)
    side, limit = arguments[0].removeprefix("--").replace("-", " "), Decimal(arguments[1]) * 100
    shown = re.search(rf"{side} ([\d.]+) % with", out)
    assert shown is not None
    assert Decimal(shown[1]) == limit


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--at-most", "0.1", "--true", "0.2"), "--true 0.2; accepted: a share below the 0.1 that is allowed, above 0"),
        (("--at-most", "0.1", "--expected", "0"), "--expected 0; accepted: a share below the 0.1 that is allowed, above 0"),
        (("--at-most", "0"), "--at-most 0; accepted: a share between 0 and 1"),
        (("--at-most", "1e-17"), "--at-most 1e-17; accepted: a share between 0 and 1"),
        (("--at-least", "0.9999995", "--true", "0.999999"), "--true 0.999999; accepted: a share above the 0.9999995 that"),
        (("--at-least", "0.9", "--at-most", "0.1"), "accepted: a campaign FILE, or --at-least SHARE, or --at-most SHARE"),
    ],
)
def test_shares_out_of_range_are_refused(rvjax: Run, arguments: tuple[str, ...], message: str) -> None:
    """Kills: a share of bad samples compared like one of good samples, a limit rounded in the message, two limits accepted."""
    code, _, err = rvjax("plan", *arguments)
    assert code == 2
    assert message in " ".join(err.split())


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
