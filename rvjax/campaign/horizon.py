"""How long a flight lasts, and the instants at which something happens in it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import ValidationInfo, field_validator

from rvjax.campaign.fields import Model, number
from rvjax.campaign.plain_values import exact, shortest
from rvjax.campaign.problems import Problem, refuse

MOST_STEPS = 10_000_000
WHOLE = 1e-9
"""How far a duration may be from a whole number of steps, relative."""


def _divides(step: float, span: float) -> bool:
    """Whether a span of time is a whole number of steps that a flight may have, at least 1."""
    whole = max(round(span / step), 1) if step > 0.0 else 0
    return step <= span * (1.0 + WHOLE) and span / step <= MOST_STEPS and abs(whole * step - span) <= WHOLE * span


def not_whole(period: float, step: float) -> Problem | None:
    """What is wrong with a period that is not a whole number of steps."""
    if _divides(step, period):
        return None
    nearest = shortest(max(round(period / step), 1) * step, lambda x: _divides(step, x))
    return Problem(
        f"{exact(period)} s is {exact(period / step)} steps", f"accepted: a whole number of steps, such as {nearest} s"
    )


class Horizon(Model):
    """How long a flight lasts, and the step of its integration."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"duration_s": 300, "step_s": 0.05},)

    duration_s: float = number("s", above=0.0, doc="duration of a flight")
    step_s: float = number("s", above=0.0, doc="step of the integration; the duration is a whole number of steps")
    control_period_s: float | None = number(
        "s",
        default=None,
        above=0.0,
        doc="period of a sampled controller with zero-order hold, a whole number of steps; by default it is continuous",
    )

    @field_validator("step_s")
    @classmethod
    def _whole(cls, step: float, info: ValidationInfo) -> float:
        if "duration_s" not in info.data:
            return step
        duration = info.data["duration_s"]
        if step > duration:
            refuse(Problem(f"{exact(step)} s is longer than the flight", f"accepted: at most {exact(duration)} s"))
        if duration / step > MOST_STEPS:
            least = shortest(duration / MOST_STEPS, lambda x: _divides(x, duration))
            accepted = f"accepted: at most {MOST_STEPS} steps, such as steps of {least} s"
            refuse(Problem(f"the flight has {exact(duration / step)} steps", accepted))
        if not _divides(step, duration):
            nearest = shortest(duration / round(duration / step), lambda x: _divides(x, duration))
            accepted = f"accepted: a whole number of steps, such as {nearest} s"
            refuse(Problem(f"{exact(duration)} s is {exact(duration / step)} steps", accepted))
        return step

    @field_validator("control_period_s")
    @classmethod
    def _whole_steps(cls, period: float | None, info: ValidationInfo) -> float | None:
        if period is not None and "step_s" in info.data:
            wrong = not_whole(period, info.data["step_s"])
            if wrong is not None:
                refuse(wrong)
        return period

    @property
    def control_steps(self) -> int:
        """Steps between two instants of a sampled controller; 0: it acts continuously."""
        return 0 if self.control_period_s is None else round(self.control_period_s / self.step_s)

    @property
    def steps(self) -> int:
        """duration / step."""
        return round(self.duration_s / self.step_s)
