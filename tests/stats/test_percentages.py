"""Shares as percentages: 0 and 100 only for 0 and 1, and digits that agree with the share."""

from __future__ import annotations

from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rvjax.analysis import comparison_sentences
from rvjax.analysis.percentages import chosen, estimated
from rvjax.analysis.verdicts.sentences import of_share, title
from rvjax.campaign import Requirement
from rvjax.stats import Estimate

SHARES = st.builds(
    lambda near_one, mantissa, zeros: (
        float(Decimal(1) - part if near_one else part) if (part := Decimal(mantissa).scaleb(-zeros - 4)) else 0.0
    ),
    st.booleans(),
    st.integers(1, 9999),
    st.integers(0, 7),
)


@example(0.9999995)
@example(0.99996)
@example(1.0)
@example(0.0)
@given(SHARES)
def test_a_percentage_is_0_or_100_only_for_0_or_1(share: float) -> None:
    """Kills: six digits, two decimals, a share rounded to the nearest percentage whatever it is."""
    for text in (chosen(share), *(estimated(share, 3, way) for way in (ROUND_FLOOR, ROUND_CEILING, "ROUND_HALF_EVEN"))):
        assert (Decimal(text) == 100) == (share == 1.0)
        assert (Decimal(text) == 0) == (share == 0.0)
    exact = Decimal(repr(share)) * 100
    assert Decimal(chosen(share)) == exact
    assert Decimal(estimated(share, 3, ROUND_FLOOR)) <= exact <= Decimal(estimated(share, 3, ROUND_CEILING))
    assert abs(Decimal(estimated(share)) - exact) <= Decimal("0.0051") * exact


def test_computed_shares_have_six_digits() -> None:
    """Kills: all the digits of a quotient, digits counted from the point where the share is near 1."""
    assert chosen(1 / 3) == "33.3333"
    assert chosen(1 - 0.1 * (1 - 0.999999)) == "99.99999"
    assert chosen(1.5) == "150"


@pytest.mark.parametrize("limit", [0.9999995, 0.999999999, 1e-7])
def test_sentences_state_the_share_that_is_required(limit: float) -> None:
    """Kills: 100 % or 0 % required, "at least 1" in a title."""
    requirement = Requirement(metric="captured", at_least=limit, confidence=0.9999999)  # pyright: ignore
    assert title(requirement) == f"captured: at least {limit!r}"
    share = Estimate(0.9999999, 0.9999993, 0.99999999999, 10**7, 0.9999999, "made up")
    text = of_share(requirement, 10**7 - 1, share, None, "")
    assert "100.00 %" not in text
    assert "99.99999 %" in text
    required = text.partition("; ")[2].partition(" %")[0]
    assert Decimal(required) == Decimal(repr(limit)) * 100


def test_differences_are_rounded_outwards() -> None:
    """−0.99996 percentage points are not within 1. Kills: an end of an interval rounded to nearest, 0 for a small difference."""
    assert comparison_sentences.points(-0.0099961, ROUND_FLOOR) == "−1"
    assert comparison_sentences.points(-0.01234, ROUND_FLOOR) == "−1.24"
    assert comparison_sentences.points(-0.01234, ROUND_CEILING) == "−1.23"
    assert comparison_sentences.points(0.012341, ROUND_CEILING) == "+1.24"
    assert comparison_sentences.points(0.99999) == "+99.999"
    assert comparison_sentences.points(-1.0) == "−100"
    assert comparison_sentences.points(0.0) == "+0"
