"""What a campaign requires: a share of samples, a quantile or a mean of a metric, with a confidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from decimal import Decimal
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Protocol

from pydantic import BeforeValidator, PrivateAttr, ValidationError, WithJsonSchema, model_validator

from rvjax.campaign.bound import Bound, bound_of
from rvjax.campaign.fields import Model, count, flag, number, option
from rvjax.campaign.plain_values import exact, is_list, is_mapping, is_number
from rvjax.campaign.problems import Problem, problems, refuse, unexpected

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Method = Literal["fixed", "sequential", "sprt", "splitting", "importance"]
Accept = Literal["proof", "estimate"]
Interpretation = Literal["ensemble", "temporal", "mixed"]

METRIC = "the metric's unit"
"""Stands for the unit of a number that is compared with a metric."""

TRACED = ("id", "parent", "rationale", "source")
"""Keys that say where a requirement comes from; they decide nothing."""

RARE = ("splitting", "importance")
"""Methods for rare failures, which fly beside the samples."""

MOST_RARE = 0.05
"""A search of rare failures needs levels between all samples and those that may fail."""

_SHARES = ("at_least", "at_most", "quantile", "mean")
_SIDES = ("below", "above")


class Condition(Model):
    """The values of a draw that belong to a class of samples; all of below, at_least and equals that are set must hold."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"below": 100}, {"at_least": 100}, {"equals": 100})

    below: float | None = number("SI", default=None, doc="the draw is below this")
    at_least: float | None = number("SI", default=None, doc="the draw is at least this")
    equals: float | None = number("SI", default=None, doc="the draw is this")

    @model_validator(mode="after")
    def _some(self) -> Condition:
        if self.below is None and self.at_least is None and self.equals is None:
            refuse(Problem("nothing", "accepted: below, at_least or equals"))
        return self

    def __str__(self) -> str:
        bounds = {"<": self.below, "≥": self.at_least, "=": self.equals}
        return " and ".join(f"{sign} {exact(value)}" for sign, value in bounds.items() if value is not None)


def _conditions(given: Any) -> dict[str, Condition]:
    if not is_mapping(given):
        refuse(unexpected(given, "accepted: a mapping of draws, such as {pursuer.mass_kg: {below: 100}}"))
    wrong: list[Problem] = []
    conditions: dict[str, Condition] = {}
    for name, condition in given.items():
        try:
            conditions[str(name)] = Condition.model_validate(condition)
        except ValidationError as error:
            wrong += [problem.below((name,)) for problem in problems(error)]
    return refuse(*wrong) if wrong else conditions


_WHERE = WithJsonSchema({"type": "object", "additionalProperties": Condition.model_json_schema(), "minProperties": 1})


def _ends(given: Any) -> tuple[float, float] | None:
    if given is None:
        return None
    if not is_list(given) or len(given) != 2 or not all(is_number(end) for end in given) or not given[0] < given[1]:
        refuse(unexpected(given, "accepted: [least, most], two numbers in the metric's unit, least below most"))
    return float(given[0]), float(given[1])


_RANGE = WithJsonSchema({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2})


class Thinning(Protocol):
    """A law whose samples are some of the samples of a run (`rvjax.stats.other_laws`)."""

    @property
    def draws(self) -> tuple[str, ...]:
        """The draws that decide it."""
        ...

    def possible(self, drawn: Mapping[str, NDArray[np.float64]]) -> NDArray[np.bool_]:
        """(n,) which draws the law has. drawn: (n,) values by the name of the draw."""
        ...

    def keeps(self, samples: NDArray[np.int64], drawn: Mapping[str, NDArray[np.float64]]) -> NDArray[np.bool_]:
        """(n,) which samples are samples of the law. samples: their numbers."""
        ...


class RareBudget(Model):
    """The search of rare failures begins no further replicates when a limit is reached; it has at least twenty."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"flights": 500_000}, {"minutes": 30})

    flights: int | None = count(
        default=None, at_least=10_000, at_most=1_000_000_000, doc="number of flights, by default 150,000 without minutes"
    )
    minutes: float | None = number(
        "min", default=None, above=0.0, doc="time limit; the number of replicates then depends on the speed of the machine"
    )

    @model_validator(mode="after")
    def _some(self) -> RareBudget:
        if self.flights is None and self.minutes is None:
            refuse(Problem("nothing", "accepted: flights or minutes"))
        return self


class Requirement(Model):
    """P(metric below or above a value, or captured) ≥ at_least, or ≤ at_most; or a quantile or the mean below or above a value.

    A requirement on a quantile q is a requirement on a probability: below v is P(X < v) ≥ q, above v is P(X > v) ≥ 1 − q.
    """

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"metric": "captured", "at_least": 0.95},
        {"metric": "settling_time_s", "quantile": 0.9, "below": 200},
        {"metric": "saturation_duty", "channel": "any", "at_most": 0.05, "above": 0.2},
        {"metric": "settling_time_s", "mean": True, "below": 150, "range": [0, 300]},
        {"metric": "captured", "at_least": 0.95, "method": "sprt", "expected": 0.99, "power": 0.9},
        {"metric": "final_position_error_m", "above": 1.0, "at_most": 1e-6, "method": "splitting", "accept": "estimate"},
    )

    metric: str = option(doc="captured, or the name of a metric")
    channel: Literal["fx", "fy", "fz", "tx", "ty", "tz", "any"] | None = option(
        default=None, doc="of a metric that every channel has; any: the worst channel"
    )
    at_least: float | None = number("1", default=None, above=0.0, below=1.0, doc="share of the samples")
    at_most: float | None = number("1", default=None, above=0.0, below=1.0, doc="largest share of the samples")
    below: float | None = number(METRIC, default=None, doc="the metric must be below this")
    above: float | None = number(METRIC, default=None, doc="the metric must be above this")
    quantile: float | None = number("1", default=None, above=0.0, below=1.0, doc="which quantile of the metric")
    mean: bool = flag(default=False, doc="the mean of the metric instead of a share of samples")
    range: Annotated[tuple[float, float] | None, BeforeValidator(_ends), _RANGE] = option(
        default=None, doc="ends that the metric cannot exceed; with them the confidence bounds of a mean are exact"
    )
    where: Annotated[Mapping[str, Condition], BeforeValidator(_conditions), _WHERE] = option(
        default={}, doc="only samples whose draws meet these conditions: {pursuer.mass_kg: {below: 100}}"
    )
    under: str | None = option(
        default=None, doc="name of a law in the section laws: judged by the samples that are samples of that law"
    )
    interpretation: Interpretation | None = option(
        default=None, doc="what the share counts: samples (ensemble), time (temporal) or both (mixed)"
    )
    confidence: float = number("1", default=0.95, at_least=0.5, below=1.0, doc="confidence of the verdict")
    method: Method = option(
        default="fixed",
        doc="fixed: judged once, after all samples; sequential, sprt: judged after every chunk; splitting, importance: for rare "
        "failures, by a search beside the samples",
    )
    expected: float | None = number(
        "1",
        default=None,
        above=0.0,
        below=1.0,
        doc="sprt: share that the design is expected to reach, better than the required share",
    )
    power: float | None = number(
        "1", default=None, at_least=0.5, below=1.0, doc="sprt: probability of PASS at the expected share; by default 0.9"
    )
    accept: Accept | None = option(
        default=None,
        doc="splitting, importance: proof (the default): an estimate alone is UNDECIDED, since a failure region that no flight "
        "reached would not show; estimate: the estimate decides where nothing is proved",
    )
    budget: RareBudget | None = option(default=None, doc="splitting, importance: limits of the search")
    name: str | None = option(default=None, doc="shown in the report")
    id: str | None = option(default=None, example="SYS-042", doc="of the requirement in its specification; each has another")
    parent: str | None = option(default=None, example="MIS-007", doc="id of the requirement that it is derived from")
    rationale: str | None = option(default=None, example="A clearance of half a metre.", doc="why it is required")
    source: str | None = option(default=None, example="ICD-3, section 4.2", doc="the document that states it")

    _thinning: Thinning | None = PrivateAttr(None)

    @property
    def thinning(self) -> Thinning | None:
        """Which samples are samples of the law `under`; None without `under`, and until `judged_under`."""
        return self._thinning if self.under is not None else None

    def judged_under(self, laws: Mapping[str, Thinning]) -> Requirement:
        """The requirement with the law that it names."""
        if self.under is None or self.under not in laws:
            return self
        found = self.model_copy()
        found._thinning = laws[self.under]
        return found

    @property
    def origin(self) -> dict[str, str]:
        """Where it comes from: those of `TRACED` that are stated."""
        return {name: text for name in TRACED if (text := getattr(self, name)) is not None}

    @property
    def is_sequential(self) -> bool:
        """Whether it is judged after every chunk; otherwise once, after all samples."""
        return self.method in ("sequential", "sprt")

    @property
    def is_rare(self) -> bool:
        """Whether its failures are searched beside the samples."""
        return self.method in RARE

    @property
    def allowed(self) -> float:
        """The largest share of samples that may fail to comply, 1 - limit without its rounding error."""
        if self.at_most is not None:
            return self.at_most
        share = self.quantile if self.quantile is not None else self.at_least
        if share is None:
            return 0.0
        if self.quantile is not None and self.below is None:
            return share
        return float(1 - Decimal(repr(share)))

    @property
    def bound(self) -> Bound | None:
        """The value that the metric must stay below or above; None where the outcome is required."""
        return bound_of(self.below, self.above)

    @property
    def limit(self) -> float:
        """The share of samples that must comply. With `at_most`, a sample complies if it does not meet the bound."""
        if self.at_most is not None:
            return 1.0 - self.at_most
        if self.quantile is not None:
            return self.quantile if self.below is not None else 1.0 - self.quantile
        return self.at_least if self.at_least is not None else 1.0

    @property
    def design(self) -> float:
        """SPRT: the share of samples that is expected to comply."""
        expected = self.expected if self.expected is not None else 1.0
        return 1.0 - expected if self.at_most is not None else expected

    @property
    def strength(self) -> float:
        """SPRT: the probability of PASS at the expected share."""
        return 0.9 if self.power is None else self.power

    @model_validator(mode="after")
    def _consistent(self) -> Requirement:
        """The forms exclude each other, so that a requirement means one thing."""
        values = {name: getattr(self, name) for name in (*_SHARES, *_SIDES, "channel")}
        given = {name for name, value in values.items() if value is not None and value is not False}
        if self.metric == "captured":
            accepted = f"accepted: metric, at_least, where, under, confidence, method, name, {', '.join(TRACED)}"
            wrong = [Problem(f"captured has no {name}", accepted, (name,), at_key=True) for name in sorted(given - {"at_least"})]
            if "at_least" not in given:
                wrong.append(Problem("missing", accepted, ("at_least",), at_key=True))
        else:
            wrong = [*_exactly_one(given, _SIDES), *_exactly_one(given, _SHARES)]
        if not wrong:
            wrong = [*self._method(), *self._mean()]
        return refuse(*wrong) if wrong else self

    def _method(self) -> list[Problem]:
        """Only SPRT compares the limit with a better share."""
        wrong = self._rare()
        if self.method != "sprt":
            given = [name for name in ("expected", "power") if getattr(self, name) is not None]
            return wrong + [
                Problem(f"method {self.method} has no {name}", "accepted: method: sprt", (name,), at_key=True) for name in given
            ]
        if wrong:
            return wrong
        if self.expected is None:
            return [Problem("missing", "accepted: the share that the design is expected to reach", ("expected",), at_key=True)]
        if self.design <= self.limit:
            side, limit = ("above", self.limit) if self.at_most is None else ("below", self.at_most)
            accepted = f"accepted: a share {side} the required {exact(limit)}"
            return [Problem(f"found {exact(self.expected)}", accepted, ("expected",))]
        return []

    def _rare(self) -> list[Problem]:
        """Only a search of rare failures has a budget and an estimate; it flies all draws, so it knows no class of samples."""
        if not self.is_rare:
            accepted = f"accepted: method: {' or '.join(RARE)}"
            given = [name for name in ("accept", "budget") if getattr(self, name) is not None]
            return [Problem(f"method {self.method} has no {name}", accepted, (name,), at_key=True) for name in given]
        wrong: list[Problem] = []
        for name in ("where", "under"):
            if getattr(self, name):
                accepted = f"accepted: method fixed, sequential or sprt with {name}"
                wrong.append(Problem(f"method {self.method} has no {name}", accepted, (name,), at_key=True))
        if self.interpretation in ("temporal", "mixed"):
            wrong.append(Problem(f"found {self.interpretation}", f"accepted with {self.method}: ensemble", ("interpretation",)))
        if not self.mean and self.allowed > MOST_RARE:
            accepted = f"accepted: method: fixed, or at most {MOST_RARE:g} of the samples may fail"
            wrong.append(Problem(f"{exact(self.allowed)} of the samples may fail, which is not rare", accepted, ("method",)))
        return wrong

    def _mean(self) -> list[Problem]:
        """A mean is judged once. A bound outside its range is decided without any flight."""
        if not self.mean:
            accepted = "accepted: with mean: true"
            return [] if self.range is None else [Problem("found without a mean", accepted, ("range",), at_key=True)]
        if self.method != "fixed":
            return [Problem(f"a mean has no method {self.method}", "accepted: fixed", ("method",))]
        bound = self.bound
        if self.range is None or bound is None or self.range[0] < bound.value < self.range[1]:
            return []
        low, high = self.range
        accepted = f"accepted: a value inside the range of {exact(low)} to {exact(high)}"
        return [Problem(f"{exact(bound.value)} decides nothing", accepted, (bound.side,))]


def repeated_ids(require: Sequence[Requirement]) -> list[Problem]:
    """A problem for each requirement with the id of one before it."""
    ids = [requirement.id for requirement in require]
    accepted = "accepted: an id that no other requirement has"
    twice = [(index, name) for index, name in enumerate(ids) if name is not None and name in ids[:index]]
    return [Problem(f"the id {name} is used twice", accepted, (index, "id")) for index, name in twice]


def _exactly_one(given: set[str], names: tuple[str, ...]) -> list[Problem]:
    """A problem unless exactly one of these keys is set."""
    of_them = [name for name in names if name in given]
    if len(of_them) == 1:
        return []
    listed = f"{', '.join(names[:-1])} and {names[-1]}"
    message = f"{' and '.join(of_them)} together" if of_them else f"neither {' nor '.join(names)}"
    return [Problem(message, f"accepted: one of {listed}")]
