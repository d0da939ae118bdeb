"""What is wrong with a value, on its way through pydantic: collected, raised together, made findings at the end."""

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
    """What was found and what is accepted, at a place below the value that is being read; at_key: the key is wrong."""

    found: str
    accepted: str
    place: Place = ()
    at_key: bool = False

    def below(self, place: Place) -> Problem:
        """The same, seen from further up."""
        return replace(self, place=(*place, *self.place))


def refuse(*problems: Problem) -> NoReturn:
    """Raise all problems as one pydantic error, which keeps their places when it passes through outer models."""
    raise ValidationError.from_exception_data(
        _KIND,
        [
            InitErrorDetails(
                type=PydanticCustomError(_KIND, "{found}", {"found": p.found, "accepted": p.accepted, "at_key": p.at_key}),
                loc=p.place,
                input=None,
            )
            for p in problems
        ],
    )


def problems(error: ValidationError) -> list[Problem]:
    """Every problem in a pydantic error, pydantic's own put into this project's words."""
    return [_problem(details) for details in error.errors(include_url=False)]


def _problem(details: Any) -> Problem:
    place, kind, context = tuple(details["loc"]), details["type"], details.get("ctx", {})
    if kind == _KIND:
        return Problem(context["found"], context["accepted"], place, context["at_key"])
    words = _ACCEPTED.get(kind)
    accepted = words.format(**context) if words else details["msg"].removeprefix("Input should be ")
    return Problem(f"found {describe(details['input'])}", f"accepted: {accepted}", place)
