"""The parameters of a tuning: values of a campaign by their places, each over a range, and ties between them.

    linear   x = a + u (b − a)          u ∈ [0, 1]: the coordinate of a search
    log      x = a (b/a)^u
    integer  a, a + 1, …, b             with equal shares of u
    choice   a value of a list
    product  x = Π factors              a tie: it has no coordinate

Numbers have FOUR digits, so that the campaign that is written says exactly what was flown.
"""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeGuard

from pydantic_core import core_schema

from rvjax.campaign.plain_values import describe, exact, is_list, is_mapping, is_number
from rvjax.campaign.problems import Problem, refuse, unexpected
from rvjax.elementary import log, power

FOUR = 4
MOST_LEVELS = 10_000
MOST_PARAMETERS = 40
"""In a tuning. In more dimensions, no affordable budget of flights is enough."""

Value = float | int | str | bool
FORMS = "accepted: one of {linear: [a, b]}, {log: [a, b]}, {integer: [a, b]}, {choice: [a, b, …]}, {product: [name, 2.0, …]}"


def digits(x: float) -> float:
    """x to FOUR digits."""
    return float(f"{x:.{FOUR}g}")


@dataclass(frozen=True)
class Span(ABC):
    """A range of numbers; the coordinate u ∈ [0, 1] leads from its low to its high end."""

    low: float
    high: float

    levels = 0
    ordered = True

    @abstractmethod
    def exact(self, u: float) -> float:
        """The value at a coordinate, with all digits."""

    @abstractmethod
    def inverse(self, x: float) -> float:
        """The coordinate of a value."""

    def value(self, u: float) -> Value:
        """The value at a coordinate, rounded as in a campaign."""
        return min(max(digits(self.exact(u)), self.low), self.high)

    def coordinate(self, value: Value) -> float | None:
        """The inverse of `value`; None outside of the range."""
        return self.inverse(float(value)) if is_number(value) and self.low <= value <= self.high else None


class Linear(Span):
    """x = low + u (high − low)."""

    def exact(self, u: float) -> float:
        return self.low + u * (self.high - self.low)

    def inverse(self, x: float) -> float:
        return (x - self.low) / (self.high - self.low)

    def __str__(self) -> str:
        return f"{exact(self.low)} to {exact(self.high)}"


class Log(Span):
    """x = low (high/low)^u."""

    def exact(self, u: float) -> float:
        return self.low * float(power(self.high / self.low, u))

    def inverse(self, x: float) -> float:
        return float(log(x / self.low) / log(self.high / self.low))

    def __str__(self) -> str:
        return f"{exact(self.low)} to {exact(self.high)}, by ratio"


@dataclass(frozen=True)
class Levels:
    """A list of n values, the k-th at the coordinate (k + ½)/n. ordered: whole numbers, so neighbours are similar."""

    values: tuple[Value, ...]
    ordered: bool

    @property
    def levels(self) -> int:
        """How many values there are."""
        return len(self.values)

    def exact(self, u: float) -> Value:
        """As `value`."""
        return self.value(u)

    def value(self, u: float) -> Value:
        """The value at a coordinate."""
        return self.values[min(int(u * len(self.values)), len(self.values) - 1)]

    def coordinate(self, value: Value) -> float | None:
        """The inverse of `value`; None for a value that is not in the list."""
        same = [k for k, known in enumerate(self.values) if known == value and isinstance(known, bool) == isinstance(value, bool)]
        return (same[0] + 0.5) / len(self.values) if same else None

    def __str__(self) -> str:
        if self.ordered and len(self.values) > 3:
            return f"{self.values[0]}, {self.values[1]}, …, {self.values[-1]}"
        return ", ".join(str(value) for value in self.values)


@dataclass(frozen=True)
class Product:
    """Π factors: numbers, other parameters by their names, fixed numbers of the campaign by their places."""

    factors: tuple[float | str, ...]

    def __str__(self) -> str:
        return " · ".join(exact(factor) if is_number(factor) else str(factor) for factor in self.factors)


Free = Linear | Log | Levels
Parameter = Free | Product


def is_free(parameter: Parameter) -> TypeGuard[Free]:
    """Whether the parameter has a coordinate; a product has none."""
    return not isinstance(parameter, Product)


class Parameters:
    """Reads the parameters of a tuning, by place or by a free name."""

    def read(self, raw: Any) -> dict[str, Parameter]:
        """Every parameter, or every problem at once."""
        if not is_mapping(raw) or not raw:
            refuse(unexpected(raw, "accepted: a mapping, such as {controller.gains.k1: {log: [0.03, 0.3]}}"))
        problems: list[Problem] = []
        parameters: dict[str, Parameter] = {}
        for name, value in raw.items():
            parameter = _parameter(value, problems, (name,))
            if parameter is not None:
                parameters[name] = parameter
        if not problems and not any(map(is_free, parameters.values())):
            problems.append(Problem("nothing varies", "accepted: a parameter that is linear, log, integer or choice"))
        if len(parameters) > MOST_PARAMETERS:
            problems.append(Problem(f"{len(parameters)} parameters", f"accepted: at most {MOST_PARAMETERS}"))
        for name, parameter in parameters.items():
            if isinstance(parameter, Product):
                problems += _factor_problems(name, parameter, parameters)
        return refuse(*problems) if problems else parameters

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        ends = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
        plain = {"type": ["number", "string", "boolean"]}
        lists = {"choice": plain, "product": {"type": ["number", "string"]}}
        forms: dict[str, Any] = dict.fromkeys(("linear", "log", "integer"), ends)
        forms |= {name: {"type": "array", "items": items, "minItems": 1 + (name == "choice")} for name, items in lists.items()}
        parameter = {"type": "object", "properties": forms, "minProperties": 1, "maxProperties": 1, "additionalProperties": False}
        return {"type": "object", "additionalProperties": parameter, "minProperties": 1}


def _factor_problems(name: str, product: Product, parameters: Mapping[str, Parameter]) -> Iterator[Problem]:
    """What is wrong with the factors of a product."""
    for index, factor in enumerate(product.factors):
        other, place = parameters.get(str(factor)), (name, "product", index)
        if isinstance(other, Product):
            accepted = "accepted: a parameter with a range, a fixed number of the campaign, or a number"
            yield Problem(f"{factor} is itself a product", accepted, place)
        elif isinstance(other, Levels) and not all(map(is_number, other.values)):
            yield Problem(f"{factor} is not a number", "accepted: a parameter whose values are numbers", place)


def _parameter(raw: Any, problems: list[Problem], place: tuple[str, ...]) -> Parameter | None:
    if not is_mapping(raw) or len(raw) != 1 or next(iter(raw)) not in _READERS:
        problems.append(unexpected(raw, FORMS, place))
        return None
    ((form, values),) = raw.items()
    parameter, message, accepted = _READERS[form](values)
    if parameter is None:
        problems.append(Problem(message, accepted, (*place, form)))
    return parameter


_Read = tuple[Parameter | None, str, str]
"""The parameter, or None with a message and what is accepted."""


def _ends(raw: Any, kind: str) -> tuple[float, float] | None:
    if not is_list(raw) or len(raw) != 2 or not all(map(is_number, raw)) or not raw[0] < raw[1]:
        return None
    if kind == "integer" and not all(float(end).is_integer() for end in raw):
        return None
    return raw[0], raw[1]


def _describe(raw: Any) -> str:
    return f"found {raw if is_list(raw) and len(raw) == 2 and all(map(is_number, raw)) else describe(raw)}"


def _linear(raw: Any) -> _Read:
    ends = _ends(raw, "linear")
    return (
        Linear(float(ends[0]), float(ends[1])) if ends else None,
        _describe(raw),
        "accepted: [a, b], two numbers, a below b",
    )


def _log(raw: Any) -> _Read:
    ends, accepted = _ends(raw, "log"), "accepted: [a, b], two numbers above 0, a below b"
    if ends and ends[0] <= 0:
        return None, f"the range {exact(ends[0])} to {exact(ends[1])} is not above 0", accepted
    return Log(float(ends[0]), float(ends[1])) if ends else None, _describe(raw), accepted


def _integer(raw: Any) -> _Read:
    ends = _ends(raw, "integer")
    accepted = f"accepted: [a, b], two whole numbers, a below b, less than {MOST_LEVELS} apart"
    if ends is None or ends[1] - ends[0] >= MOST_LEVELS:
        return None, _describe(raw), accepted
    return Levels(tuple(range(int(ends[0]), int(ends[1]) + 1)), ordered=True), "", ""


def _choice(raw: Any) -> _Read:
    accepted = "accepted: a list of two or more different numbers, texts, or true and false"
    if not is_list(raw) or not 2 <= len(raw) <= MOST_LEVELS or not all(isinstance(value, int | float | str) for value in raw):
        return None, _describe(raw), accepted
    if len({json.dumps(value) for value in raw}) < len(raw):
        return None, "a value occurs twice", accepted
    return Levels(tuple(raw), ordered=False), "", ""


def _product(raw: Any) -> _Read:
    accepted = "accepted: a list of names and numbers, with one or more names, such as [x, 0.5]"
    named = is_list(raw) and any(isinstance(factor, str) for factor in raw)
    if not named or not all(isinstance(factor, str) or is_number(factor) for factor in raw):
        return None, _describe(raw), accepted
    return Product(tuple(factor if isinstance(factor, str) else float(factor) for factor in raw)), "", ""


_READERS: Mapping[str, Any] = {"linear": _linear, "log": _log, "integer": _integer, "choice": _choice, "product": _product}
