"""Laws in words, for people: `uniform (low 80, high 120)`."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, cast

from rvjax.campaign.distribution_notation import forms
from rvjax.campaign.distributions import Distribution, JointDistribution

SHOWN = 6
"""Numbers that are told one by one; of more, how many there are."""


def in_words(law: Distribution | JointDistribution) -> str:
    """The word that a campaign uses, and the parameters, in the unit of the law."""
    word = next((word for word, (_, kind) in forms().items() if kind is type(law)), type(law).__name__)
    if word == "rotation":
        return "rotation (uniform)"
    told: dict[str, Any] = {field.name: getattr(law, field.name) for field in fields(cast("Any", law))}
    if len(set(told.get("weights", ()))) == 1:
        del told["weights"]  # all alike
    if told.get("step") == 1.0:
        del told["step"]
    parameters = ", ".join(text for name, value in told.items() if (text := _parameter(name, value)))
    return f"{word.replace('_', ' ')} ({parameters})"


def _parameter(name: str, value: Any) -> str:
    if isinstance(value, bool):
        return name.replace("_", " ") if value else ""
    if isinstance(value, tuple):
        if len(value) > SHOWN:  # pyright: ignore[reportUnknownArgumentType]
            return f"{len(value):,} {name}"  # pyright: ignore[reportUnknownArgumentType]
        return f"{name} {', '.join(f'{one:g}' for one in value)}"  # pyright: ignore[reportUnknownVariableType]
    return f"{name.replace('_', ' ')} {value:g}"
