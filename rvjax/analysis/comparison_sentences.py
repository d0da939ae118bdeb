"""Sentences of a comparison of two runs."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN
from typing import TYPE_CHECKING, Any, cast

from rvjax.analysis.percentages import chosen, estimated

if TYPE_CHECKING:
    from rvjax.stats import Estimate

HINT = " Use --margin to set how much worse is acceptable."
"""The hint after an undecided comparison without a margin."""


def finding(verdict: str, score: Estimate, margin: float, confidence: float) -> str:
    """Whether B is worse by more than the margin, and the difference that shows it; empty without a margin."""
    if not margin:
        return ""
    most, certainty = f"{chosen(margin)} %", f"with {chosen(confidence)} % confidence"
    low, high = f"{points(score.low, ROUND_FLOOR)} %", f"{points(score.high, ROUND_CEILING)} %"
    return {
        "PASS": f"B is not worse by more than {most}: the difference is at least {low} {certainty}; ",
        "FAIL": f"B is worse by more than {most}: the difference is at most {high} {certainty}; ",
        "UNDECIDED": f"the samples do not show whether B is worse by more than {most}: the difference is at least {low} and "
        f"at most {high}, each {certainty}; ",
    }[verdict]


def points(difference: float, way: str = ROUND_HALF_EVEN) -> str:
    """A difference of shares in percentage points to three digits: −1.23. way: of rounding."""
    text = estimated(difference, way=way).replace("-", "−")
    return text if difference < 0 else f"+{text}"


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


def code(name: str, a: Any, b: Any) -> str:
    """That A and B flew different code of a file or package. a, b: its digest, of an installed package with versions; None: not
    flown."""
    if a is None or b is None:
        return f"only {'A' if b is None else 'B'} flies the code of {name}"
    return f"{name}'s code differs (digests {_digest(a)} and {_digest(b)})"


def _digest(code: Any) -> str:
    """The digest of a file, or of a package and its version."""
    if not isinstance(code, Mapping):
        return str(code)
    known = cast("Mapping[str, str]", code)
    versions = [f"{package} {version}" for package, version in known.items() if package != "code"]
    return f"{known['code']} of {', '.join(versions)}" if versions else known["code"]
