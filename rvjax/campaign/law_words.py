"""Laws in words, for people: `uniform (low 80, high 120)`."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, cast

from rvjax.campaign.distribution_notation import forms
from rvjax.campaign.distributions import Distribution, JointDistribution

SHOWN = 6
"""Longer lists of numbers are shown by their length only."""


def in_words(law: Distribution | JointDistribution) -> str:
    """The word that a campaign uses, and the parameters, in the unit of the law."""
    word = next((word for word, (_, kind) in forms().items() if kind is type(law)), type(law).__name__)
    if word == "rotation":
        return "rotation (uniform)"
    values: dict[str, Any] = {field.name: getattr(law, field.name) for field in fields(cast("Any", law))}
    if len(set(values.get("weights", ()))) == 1:
        del values["weights"]  # equal weights
    if values.get("step") == 1.0:
        del values["step"]
    parameters = ", ".join(text for name, value in values.items() if (text := _parameter(name, value)))
    return f"{word.replace('_', ' ')} ({parameters})"


def _parameter(name: str, value: Any) -> str:
    if isinstance(value, bool):
        return name.replace("_", " ") if value else ""
    if isinstance(value, tuple):
        if len(value) > SHOWN:  # pyright: ignore[reportUnknownArgumentType]
            return f"{len(value):,} {name}"  # pyright: ignore[reportUnknownArgumentType]
        return f"{name} {', '.join(f'{number:g}' for number in value)}"  # pyright: ignore[reportUnknownVariableType]
    return f"{name.replace('_', ' ')} {value:g}"
