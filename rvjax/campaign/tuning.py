"""The section `tune`: which values of the campaign are searched, for what, with which budget, and how the result is confirmed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, ValidationError, ValidationInfo, WithJsonSchema, field_validator, model_validator

from rvjax.campaign.bound import Bound, bound_of
from rvjax.campaign.choice import Choice, OneChoice
from rvjax.campaign.fields import Model, count, flag, number, option, part
from rvjax.campaign.plain_values import is_list
from rvjax.campaign.problems import Problem, problems, refuse
from rvjax.campaign.requirement import METRIC
from rvjax.campaign.tuning_parameters import Parameter, Parameters

_FORMS = ("quantile", "cvar", "mean", "probability")

Goal = Literal["weighted", "lexicographic", "pareto"]


class Objective(Model):
    """A number of all samples of a candidate that the search minimises, or maximises where larger is better."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"metric": "settling_time_s", "quantile": 0.95},
        {"metric": "settling_time_s", "cvar": 0.9},
        {"metric": "delta_v_m_s", "mean": True},
        {"metric": "delta_v_m_s", "probability": True, "below": 1.5},
        {"metric": "delta_v_m_s", "probability": True, "above": 0.1},
        {"metric": "saturation_duty", "channel": "any", "mean": True},
    )

    metric: str = option(doc="captured, or the name of a metric, also of a margin")
    channel: Literal["fx", "fy", "fz", "tx", "ty", "tz", "any"] | None = option(
        default=None, doc="of a metric that every channel has; any: the worst channel"
    )
    quantile: float | None = number("1", default=None, above=0.0, below=1.0, doc="this quantile of the metric")
    cvar: float | None = number(
        "1", default=None, above=0.0, below=1.0, doc="the mean of the samples that are worse than this share of all"
    )
    mean: bool = flag(default=False, doc="the mean of the metric")
    probability: bool = flag(default=False, doc="the share of samples below or above a value, or captured; maximised")
    below: float | None = number(METRIC, default=None, doc="probability: that the metric is below this")
    above: float | None = number(METRIC, default=None, doc="probability: that the metric is above this")
    sense: Literal["smallest", "largest"] | None = option(
        default=None, doc="for a metric of which rvjax does not know whether it should be small or large"
    )
    weight: float = number("1", default=1.0, above=0.0, doc="in the weighted sum, per unit of the metric")

    @property
    def bound(self) -> Bound | None:
        """The value of a probability's `below` or `above`; None of every other form, and where the outcome counts."""
        return bound_of(self.below, self.above)

    @model_validator(mode="after")
    def _consistent(self) -> Objective:
        given = [name for name in _FORMS if getattr(self, name) not in (None, False)]
        if len(given) != 1:
            message = f"{' and '.join(given)} together" if given else "neither quantile nor cvar nor mean nor probability"
            refuse(Problem(message, "accepted: one of quantile, cvar, mean and probability"))
        sides = [name for name in ("below", "above") if getattr(self, name) is not None]
        needed = 1 if self.probability and self.metric != "captured" else 0
        if len(sides) != needed:
            message = " and ".join(sides) if sides else "neither below nor above"
            accepted = "accepted: probability with below or above" if needed else "accepted: neither below nor above here"
            refuse(Problem(message, accepted, (sides[-1],) if sides else (), at_key=bool(sides)))
        if self.metric == "captured" and not self.probability:
            refuse(Problem(f"captured has no {given[0]}", "accepted: probability: true", (given[0],), at_key=True))
        if self.probability and self.sense is not None:
            refuse(Problem("a probability is always maximised", "accepted: no key sense", ("sense",), at_key=True))
        return self


class Budget(Model):
    """The search ends as soon as any limit is reached."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"candidates": 200}, {"flights": 200_000}, {"minutes": 30})

    candidates: int | None = count(default=None, at_least=1, at_most=1_000_000, doc="number of candidates")
    flights: int | None = count(default=None, at_least=1, doc="number of flights")
    minutes: float | None = number(
        "min", default=None, above=0.0, doc="time limit; the result then depends on the speed of the machine"
    )

    @model_validator(mode="after")
    def _some(self) -> Budget:
        if self.candidates is None and self.flights is None and self.minutes is None:
            refuse(Problem("nothing", "accepted: candidates, flights or minutes"))
        return self


class Race(Model):
    """All candidates fly a few samples; those that are not worse fly more."""

    first: int | None = count(
        default=None, at_least=2, doc="samples of the first round, by default a sixteenth of the last; equal to the last: no race"
    )
    growth: float = number("1", default=2.0, above=1.0, at_most=16.0, doc="ratio of the samples of successive rounds")
    keep: float = number(
        "1",
        default=0.5,
        above=0.0,
        at_most=1.0,
        doc="largest share of candidates in the next round; 1: only tests eliminate candidates",
    )
    risk: float = number(
        "1", default=0.05, above=0.0, at_most=0.5, doc="probability that the tests of a race eliminate its best candidate"
    )
    hard: int = count(default=0, at_most=10_000, doc="number of the hardest known samples that fly in every first round too")


class Confirmation(Model):
    """Compares the winner with the original campaign, on draws that the search has not used."""

    samples: int | None = count(default=None, at_least=1, example=4096, doc="number of samples; by default the campaign's")
    seed: int | None = count(default=None, example=11, doc="seed of the draws; by default the campaign's")
    confidence: float = number(
        "1", default=0.95, at_least=0.5, below=1.0, doc="confidence of the comparison with the original campaign"
    )


def _objectives(given: Any) -> tuple[Objective, ...]:
    """A single objective, or a list; problems keep the places in the file."""
    if not is_list(given):
        return (Objective.model_validate(given),)
    if not given:
        refuse(Problem("found an empty list", "accepted: an objective, or a list of objectives"))
    wrong: list[Problem] = []
    read: list[Objective] = []
    for index, value in enumerate(given):
        try:
            read.append(Objective.model_validate(value))
        except ValidationError as error:
            wrong += [problem.below((index,)) for problem in problems(error)]
    return refuse(*wrong) if wrong else tuple(read)


_OBJECTIVES = WithJsonSchema(
    {"anyOf": [Objective.model_json_schema(), {"type": "array", "items": Objective.model_json_schema(), "minItems": 1}]}
)


class Tuning(Model):
    """A search for better values of a campaign, on draws that are the same for all candidates."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {
            "parameters": {"controller.gains.k1": {"log": [0.03, 0.3]}},
            "objective": {"metric": "settling_time_s", "quantile": 0.95},
        },
    )

    parameters: Annotated[Mapping[str, Parameter], Parameters()] = part(doc="what is varied, by its place, and over which range")
    objective: Annotated[tuple[Objective, ...], BeforeValidator(_objectives), _OBJECTIVES] = part(
        doc="an objective or a list; the requirements of the campaign take precedence over all"
    )
    goal: Goal = option(
        default="weighted", doc="of several objectives: their sum, the first before the second, or all trade-offs"
    )
    method: Annotated[Choice, OneChoice()] = part(default={"use": "cma-es"}, doc="how candidates are proposed")
    budget: Budget = part(default={"candidates": 200}, doc="when the search ends")
    samples: int = count(default=1248, at_least=2, at_most=10_000_000, doc="samples of a candidate that reaches the last round")
    seed: int | None = count(default=None, example=7, doc="seed of the search and its draws; by default the campaign's plus 1")
    race: Race = part(default={}, doc="how many samples a candidate flies")
    confirm: Confirmation = part(default={}, doc="the final verdict")

    @field_validator("samples")
    @classmethod
    def _affordable(cls, samples: int, info: ValidationInfo) -> int:
        budget = info.data.get("budget")
        if budget is not None and budget.flights is not None and budget.flights < samples:
            message = f"a candidate of {samples} samples exceeds the budget of {budget.flights} flights"
            refuse(Problem(message, f"accepted: at most {budget.flights} samples, or a larger budget"))
        return samples

    @field_validator("race")
    @classmethod
    def _shorter(cls, race: Race, info: ValidationInfo) -> Race:
        samples = info.data.get("samples")
        if samples is not None and race.first is not None and race.first > samples:
            refuse(Problem(f"found {race.first}", f"accepted: at most the {samples} samples of the last round", ("first",)))
        return race

    @property
    def rounds(self) -> tuple[int, ...]:
        """How many samples a candidate has flown after each round of a race."""
        sizes = [self.race.first or max(2, self.samples // 16)]
        while sizes[-1] < self.samples:
            sizes.append(min(self.samples, max(sizes[-1] + 1, round(sizes[-1] * self.race.growth))))
        return tuple(sizes)
