"""Sentences of a comparison of two runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rvjax.stats import Estimate

HINT = " Use --margin to set how much worse is acceptable."
"""The hint after an undecided comparison without a margin."""


def finding(verdict: str, score: Estimate, margin: float, confidence: float) -> str:
    """Whether B is worse by more than the margin, and the difference that shows it; empty without a margin."""
    if not margin:
        return ""
    most, certainty = f"{100 * margin:.6g} %", f"with {100 * confidence:.6g} % confidence"
    low, high = (f"{100 * end:+.3g} %".replace("-", "−") for end in (score.low, score.high))
    return {
        "PASS": f"B is not worse by more than {most}: the difference is at least {low} {certainty}; ",
        "FAIL": f"B is worse by more than {most}: the difference is at most {high} {certainty}; ",
        "UNDECIDED": f"the samples do not show whether B is worse by more than {most}: the difference is at least {low} and "
        f"at most {high}, each {certainty}; ",
    }[verdict]


def result(word: str, p: float) -> str:
    """The result of McNemar's test in words. p: adjusted."""
    text = "no difference is shown" if word == "no difference shown" else f"B is significantly {word}"
    return f"{text} (p {_equals(p)})"


def outlook(more: int | None) -> str:
    """How many further samples would decide."""
    decide = "More samples would not decide" if more is None else f"About {more:,} more samples would decide"
    return f" {decide} if the shares stayed the same."


def p_value(p: float) -> str:
    """The p-value to two digits; below 1e-300 it prints as <1e-300."""
    return f"{p:.2g}" if p >= 1e-300 else "<1e-300"


def _equals(p: float) -> str:
    return f"= {p_value(p)}" if p >= 1e-300 else "< 1e-300"
