"""What a campaign requires: a share of samples, or a quantile of a metric, with a confidence."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from rvjax.spec.fields import Model, number, option
from rvjax.spec.problem import Problem, refuse


class Requirement(Model):
    """P(metric below or above a value, or captured) ≥ at_least, or quantile of the metric below or above a value.

    A requirement on a quantile q is one on a probability: below v is P(X < v) ≥ q, above v is P(X > v) ≥ 1 − q.
    """

    metric: str = option(doc="captured, or the name of a metric")
    channel: Literal["fx", "fy", "fz", "tx", "ty", "tz", "any"] | None = option(
        default=None, doc="of a metric that every channel has; any: the worst channel"
    )
    at_least: float | None = number("1", default=None, above=0.0, below=1.0, doc="share of the samples")
    below: float | None = number("1", default=None, doc="the metric must be below this, in its unit")
    above: float | None = number("1", default=None, doc="the metric must be above this, in its unit")
    quantile: float | None = number("1", default=None, above=0.0, below=1.0, doc="which quantile of the metric")
    confidence: float = number("1", default=0.95, at_least=0.5, below=1.0, doc="of the verdict")
    name: str | None = option(default=None, doc="shown in the report")

    @model_validator(mode="after")
    def _one_form(self) -> Requirement:
        """The forms exclude each other, so that a requirement means one thing."""
        given = {name for name in ("at_least", "below", "above", "quantile", "channel") if getattr(self, name) is not None}
        if self.metric == "captured":
            accepted = "accepted: metric, at_least, confidence, name"
            found = [Problem("captured has none", accepted, (name,), at_key=True) for name in sorted(given - {"at_least"})]
            if "at_least" not in given:
                found.append(Problem("missing", accepted, ("at_least",), at_key=True))
        else:
            found: list[Problem] = []
            for pair in (("below", "above"), ("at_least", "quantile")):
                if len(given & set(pair)) != 1:
                    words = "both of" if given >= set(pair) else "neither of"
                    found.append(Problem(f"{words} {pair[0]} and {pair[1]}", f"accepted: one of {pair[0]} and {pair[1]}"))
        return refuse(*found) if found else self
