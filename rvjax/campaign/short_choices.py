"""Components that a campaign may choose by their name alone: `allocation: pseudo-inverse` in place of `{use: pseudo-inverse}`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rvjax.campaign.plain_values import is_mapping

ALLOCATION = ("actuators", "allocation")
SHORT = (ALLOCATION,)
"""The places of these components."""


def value_of(campaign: Any, place: tuple[str, ...]) -> Any:
    """The value at a place of mappings; None where there is none."""
    value = campaign
    for step in place:
        value = value.get(step) if is_mapping(value) else None
    return value


def short_choices(campaign: Any) -> Iterator[tuple[tuple[str, ...], dict[str, Any]]]:
    """(place, the mapping that holds it) of every component that a campaign chooses by its name alone."""
    for place in SHORT:
        holder = value_of(campaign, place[:-1])
        if is_mapping(holder) and isinstance(holder.get(place[-1]), str):
            yield place, holder
