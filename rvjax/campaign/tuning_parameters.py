"""What a tuning varies: values of a campaign by their places, each over a range, and ties between them.

    linear   x = a + u (b − a)          u ∈ [0, 1]: the coordinate of a search
    log      x = a (b/a)^u
    integer  a, a + 1, …, b             each as wide as the others
    choice   one of the values listed
    product  x = Π factors              a tie: no coordinate of its own

Numbers have FOUR digits, so that what is written into a campaign is what was flown.
"""

from __future__ import annotations

import json
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeGuard

from pydantic_core import core_schema

from rvjax.campaign.plain_values import describe, is_list, is_mapping, is_number
from rvjax.campaign.problems import Problem, refuse

FOUR = 4
MOST_LEVELS = 10_000
MOST_PARAMETERS = 40
"""Of a tuning: searches find nothing in more dimensions with any budget that anybody has."""

Value = float | int | str | bool
FORMS = "accepted: one of {linear: [a, b]}, {log: [a, b]}, {integer: [a, b]}, {choice: [a, b, …]}, {product: [name, 2.0, …]}"


def digits(x: float) -> float:
    """x to FOUR digits."""
    return float(f"{x:.{FOUR}g}")


@dataclass(frozen=True)
class Span(ABC):
    """A range of numbers, between whose ends a coordinate leads."""

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
        """The value at a coordinate, as it is written."""
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
        return f"{self.low:g} to {self.high:g}"


class Log(Span):
    """x = low (high/low)^u."""

    def exact(self, u: float) -> float:
        return self.low * (self.high / self.low) ** u

    def inverse(self, x: float) -> float:
        return math.log(x / self.low) / math.log(self.high / self.low)

    def __str__(self) -> str:
        return f"{self.low:g} to {self.high:g}, by ratio"


@dataclass(frozen=True)
class Levels:
    """One of some values, at (k + ½)/n. ordered: whole numbers, that are near each other."""

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
        """The inverse of `value`; None for any other one."""
        known = [
            index for index, one in enumerate(self.values) if one == value and isinstance(one, bool) == isinstance(value, bool)
        ]
        return (known[0] + 0.5) / len(self.values) if known else None

    def __str__(self) -> str:
        if self.ordered and len(self.values) > 3:
            return f"{self.values[0]}, {self.values[1]}, …, {self.values[-1]}"
        return ", ".join(str(value) for value in self.values)


@dataclass(frozen=True)
class Product:
    """Π factors: numbers, other parameters by their names, fixed numbers of the campaign by their places."""

    factors: tuple[float | str, ...]

    def __str__(self) -> str:
        return " · ".join(f"{factor:g}" if is_number(factor) else str(factor) for factor in self.factors)


Free = Linear | Log | Levels
Parameter = Free | Product


def is_free(parameter: Parameter) -> TypeGuard[Free]:
    """Whether it has a coordinate of its own."""
    return not isinstance(parameter, Product)


class Parameters:
    """Reads the parameters of a tuning, by place or by a name of their own."""

    def read(self, raw: Any) -> dict[str, Parameter]:
        """Every parameter, or every problem at once."""
        if not is_mapping(raw) or not raw:
            refuse(Problem(f"found {describe(raw)}", "accepted: a mapping, such as {controller.gains.k1: {log: [0.03, 0.3]}}"))
        problems: list[Problem] = []
        found: dict[str, Parameter] = {}
        for name, said in raw.items():
            parameter = _parameter(said, problems, (name,))
            if parameter is not None:
                found[name] = parameter
        if not problems and not any(map(is_free, found.values())):
            problems.append(Problem("nothing varies", "accepted: at least one of linear, log, integer, choice"))
        if len(found) > MOST_PARAMETERS:
            problems.append(Problem(f"{len(found)} parameters", f"accepted: at most {MOST_PARAMETERS}"))
        for name, parameter in found.items():
            if isinstance(parameter, Product):
                for index, factor in enumerate(parameter.factors):
                    other = found.get(str(factor))
                    if isinstance(other, Product):
                        accepted = "accepted: what has a range of its own, a fixed number of the campaign, or a number"
                        problems.append(Problem(f"{factor} is tied itself", accepted, (name, "product", index)))
                    elif isinstance(other, Levels) and not all(map(is_number, other.values)):
                        problems.append(Problem(f"{factor} is no number", "accepted: numbers", (name, "product", index)))
        return refuse(*problems) if problems else found

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        ends = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
        plain = {"type": ["number", "string", "boolean"]}
        lists = {"choice": plain, "product": {"type": ["number", "string"]}}
        forms: dict[str, Any] = dict.fromkeys(("linear", "log", "integer"), ends)
        forms |= {name: {"type": "array", "items": items, "minItems": 1 + (name == "choice")} for name, items in lists.items()}
        one = {"type": "object", "properties": forms, "minProperties": 1, "maxProperties": 1, "additionalProperties": False}
        return {"type": "object", "additionalProperties": one, "minProperties": 1}


def _parameter(raw: Any, problems: list[Problem], place: tuple[str, ...]) -> Parameter | None:
    if not is_mapping(raw) or len(raw) != 1 or next(iter(raw)) not in _READERS:
        problems.append(Problem(f"found {describe(raw)}", FORMS, place))
        return None
    ((form, given),) = raw.items()
    parameter, found, accepted = _READERS[form](given)
    if parameter is None:
        problems.append(Problem(found, accepted, (*place, form)))
    return parameter


_Read = tuple[Parameter | None, str, str]


def _ends(given: Any, kind: str) -> tuple[float, float] | None:
    if not is_list(given) or len(given) != 2 or not all(map(is_number, given)) or not given[0] < given[1]:
        return None
    if kind == "integer" and not all(float(end).is_integer() for end in given):
        return None
    return given[0], given[1]


def _found(given: Any) -> str:
    return f"found {given}" if is_list(given) and len(given) == 2 and all(map(is_number, given)) else f"found {describe(given)}"


def _linear(given: Any) -> _Read:
    ends = _ends(given, "linear")
    return (
        Linear(float(ends[0]), float(ends[1])) if ends else None,
        _found(given),
        "accepted: [a, b], two numbers, the first below",
    )


def _log(given: Any) -> _Read:
    ends, accepted = _ends(given, "log"), "accepted: [a, b], two numbers above 0, the first below"
    if ends and ends[0] <= 0:
        return None, f"the range {ends[0]:g} to {ends[1]:g} is not above 0", accepted
    return Log(float(ends[0]), float(ends[1])) if ends else None, _found(given), accepted


def _integer(given: Any) -> _Read:
    ends = _ends(given, "integer")
    accepted = f"accepted: [a, b], two whole numbers, the first below, at most {MOST_LEVELS:,} apart"
    if ends is None or ends[1] - ends[0] >= MOST_LEVELS:
        return None, _found(given), accepted
    return Levels(tuple(range(int(ends[0]), int(ends[1]) + 1)), ordered=True), "", ""


def _choice(given: Any) -> _Read:
    accepted = "accepted: a list of two or more different numbers, texts, or true and false"
    if not is_list(given) or not 2 <= len(given) <= MOST_LEVELS or not all(isinstance(one, int | float | str) for one in given):
        return None, f"found {describe(given)}", accepted
    if len({json.dumps(one) for one in given}) < len(given):
        return None, "a value stands twice", accepted
    return Levels(tuple(given), ordered=False), "", ""


def _product(given: Any) -> _Read:
    accepted = "accepted: a list of names and numbers, at least one of them a name, such as [x, 0.5]"
    named = is_list(given) and any(isinstance(one, str) for one in given)
    if not named or not all(isinstance(one, str) or is_number(one) for one in given):
        return None, f"found {describe(given)}", accepted
    return Product(tuple(one if isinstance(one, str) else float(one) for one in given)), "", ""


_READERS: Mapping[str, Any] = {"linear": _linear, "log": _log, "integer": _integer, "choice": _choice, "product": _product}
