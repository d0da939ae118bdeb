"""Schedule of a fault: which channels fail in a sample, and which of them together.

count        n channels out of those that may fail, every choice of n equally likely
probability  every channel by itself with this probability
groups       with probability `together`, a group fails together: if any of its channels fails, all fail at the earliest onset
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, ValidationInfo, WithJsonSchema, model_validator

from rvjax.campaign.declarations import actuators
from rvjax.campaign.fields import Model, number, option, scalar
from rvjax.campaign.plain_values import describe, is_list
from rvjax.campaign.problems import Problem, refuse, unexpected
from rvjax.campaign.quantity import Quantity
from rvjax.columns import CHANNELS

Values = NDArray[np.float64]

_NAME = {"anyOf": [{"enum": list(CHANNELS)}, {"type": "string", "pattern": "^t[1-9][0-9]?$"}]}
LIST_OF_CHANNELS = {"type": "array", "items": _NAME, "minItems": 1, "uniqueItems": True}


def _problem(names: Any, fewest: int, known: tuple[str, ...]) -> str:
    """What is wrong with a list of channels, or of thrusters; empty where nothing is."""
    if not is_list(names) or len(names) < fewest:
        return f"found {describe(names)}"
    strange = [name for name in names if name not in known]
    repeated = [name for name in known if names.count(name) > 1]
    return f"found {describe(strange[0])}" if strange else f"{repeated[0]} occurs twice" if repeated else ""


def _words(known: tuple[str, ...]) -> str:
    return ", ".join(known) if known == CHANNELS else f"{known[0]} to {known[-1]}"


def channel_names(given: Any, info: ValidationInfo) -> tuple[str, ...]:
    """`all`, or a list of channels, as their names; of thrusters where they fly."""
    known = actuators(info)
    if given == "all":
        return known
    if message := _problem(given, 1, known):
        refuse(Problem(message, f"accepted: all, or a list out of {_words(known)}, each once"))
    return tuple(given)


def _groups(given: Any, info: ValidationInfo) -> tuple[tuple[str, ...], ...]:
    if not is_list(given):
        refuse(unexpected(given, "accepted: a list of lists of channels, such as [[fx, tz]]"))
    known = actuators(info)
    messages = {index: _problem(group, 2, known) for index, group in enumerate(given)}
    accepted = f"accepted: two or more out of {_words(known)}, each once"
    if wrong := [Problem(words, accepted, (index,)) for index, words in messages.items() if words]:
        refuse(*wrong)
    return tuple(map(tuple, given))


_GROUPS = WithJsonSchema({"type": "array", "items": LIST_OF_CHANNELS | {"minItems": 2}})


class Schedule(Model):
    """Which of the channels that may fail do so in a sample."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"count": 1},
        {"probability": 0.1},
        {"groups": [["fx", "tz"]], "together": 0.5},
    )

    count: Quantity | None = scalar("1", default=None, at_least=0.0, doc="how many channels fail, rounded to a whole number")
    probability: Quantity | None = scalar(
        "1", default=None, at_least=0.0, at_most=1.0, doc="probability that a channel fails, each by itself"
    )
    groups: Annotated[tuple[tuple[str, ...], ...], BeforeValidator(_groups), _GROUPS] = option(
        default=[], doc="channels that fail together: a list of lists"
    )
    together: float = number("1", default=1.0, above=0.0, at_most=1.0, doc="probability that a group fails together")

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if self.count is not None and self.probability is not None:
            refuse(Problem("both count and probability", "accepted: either count or probability", ("probability",), at_key=True))
        return self

    def arrange(
        self,
        onsets: Mapping[str, Values],
        take: Callable[[str, Quantity], Values],
        uniform: Callable[[str], Values],
    ) -> dict[str, Values]:
        """The onset of every channel in every sample, +∞ where it does not fail.

        onsets: drawn ones of the channels that may fail. take: draws a quantity under a name. uniform: independent uniform
        numbers under a name, which depend on nothing else.
        """
        names = list(onsets)
        fails = np.ones((len(names), len(next(iter(onsets.values())))), dtype=bool)
        if self.count is not None:
            order = np.stack([uniform(f"order.{name}") for name in names])
            rank = order.argsort(axis=0, kind="stable").argsort(axis=0, kind="stable")  # equal ones in the order of names
            fails = rank < np.rint(take("count", self.count))
        if self.probability is not None:
            lots = np.stack([uniform(f"lot.{name}") for name in names])
            fails = lots < take("probability", self.probability)
        starts = np.where(fails, np.stack(list(onsets.values())), np.inf)
        for group in self.groups:
            rows = [names.index(name) for name in group if name in onsets]
            if rows:
                joined = uniform(f"group.{'-'.join(group)}") < self.together
                starts[rows] = np.where(joined, starts[rows].min(axis=0), starts[rows])
        return dict(zip(names, starts, strict=True))
