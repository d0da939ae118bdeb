"""What is wrong with the values of a campaign: collected, raised together through pydantic, made findings at the end."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NoReturn

from pydantic import ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError

from rvjax.campaign.plain_values import Place, describe

_KIND = "rvjax"
_ACCEPTED = {
    "int_type": "a whole number",
    "bool_type": "true or false",
    "string_type": "text",
    "tuple_type": "a list",
    "greater_than_equal": "at least {ge}",
    "less_than_equal": "at most {le}",
}


@dataclass(frozen=True)
class Problem:
    """message: what is wrong; accepted: what would be right; place: below the value that is read; at_key: the key is wrong."""

    message: str
    accepted: str
    place: Place = ()
    at_key: bool = False

    def below(self, place: Place) -> Problem:
        """The same problem, with `place` in front of its place."""
        return replace(self, place=(*place, *self.place))


def unexpected(value: object, accepted: str, place: Place = (), at_key: bool = False) -> Problem:
    """`found <value>; <accepted>`: the form of a message about a wrong value."""
    return Problem(f"found {describe(value)}", accepted, place, at_key)


_REPORTED = Problem("", "")
"""A problem that something else has reported. Without any problem pydantic would go on with a model that lacks the field."""


def refuse(*problems: Problem) -> NoReturn:
    """Raise all problems together as a pydantic error, which keeps their places when it passes through outer models. Without a
    problem: the value is refused, and there is a finding about it already."""
    raise ValidationError.from_exception_data(
        _KIND,
        [
            InitErrorDetails(
                type=PydanticCustomError(_KIND, "{message}", {"message": p.message, "accepted": p.accepted, "at_key": p.at_key}),
                loc=p.place,
                input=None,
            )
            for p in problems or (_REPORTED,)
        ],
    )


def problems(error: ValidationError) -> list[Problem]:
    """Every problem in a pydantic error; pydantic's texts become messages of the house form."""
    found = (_problem(details) for details in error.errors(include_url=False))
    return [problem for problem in found if problem.message]


def _problem(details: Any) -> Problem:
    place, kind, context = tuple(details["loc"]), details["type"], details.get("ctx", {})
    if kind == _KIND:
        return Problem(context["message"], context["accepted"], place, context["at_key"])
    words = _ACCEPTED.get(kind)
    accepted = words.format(**context) if words else details["msg"].removeprefix("Input should be ")
    return unexpected(details["input"], f"accepted: {accepted}", place)
