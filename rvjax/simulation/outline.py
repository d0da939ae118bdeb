"""The outline of a campaign file: the parts that are checked even if other parts of the file are wrong."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from rvjax.campaign import Source
from rvjax.campaign.actuators import actuator_names, thruster_layout
from rvjax.campaign.choice import entry_names
from rvjax.campaign.plain_values import Place, is_list, is_mapping
from rvjax.campaign.short_choices import SHORT, value_of
from rvjax.campaign.thruster_layout import Layout
from rvjax.columns import MARGIN
from rvjax.components.registry import FAMILY_OF


class Entry(NamedTuple):
    """A component that a campaign names: its section, its place, and its mapping as written; alone: a name without a mapping."""

    section: str
    place: Place
    raw: Mapping[str, Any]
    alone: bool = False

    @property
    def name_place(self) -> Place:
        """Where the component is named."""
        return self.place if self.alone else (*self.place, "use")


@dataclass(frozen=True)
class Outline:
    """components: every mapping with a `use`. baselines, effects, navigation: their names, in order. actuators: names of the
    channels or thrusters, empty if the actuators are wrong. layout: of the thrusters, None without or if they are wrong.
    duration_s: of a flight, None if it is no number. margins: as written, None without. metric_uses: place and mapping of each
    requirement and objective. places: what the sections target and pursuer say, such as `target.hull`.
    """

    components: tuple[Entry, ...]
    baselines: tuple[str, ...]
    effects: tuple[str, ...]
    actuators: tuple[str, ...]
    layout: Layout | None
    navigation: tuple[str, ...]
    guided: bool
    duration_s: float | None
    margins: Any
    metric_uses: tuple[tuple[Place, Mapping[str, Any]], ...]
    places: frozenset[str]

    @classmethod
    def of(cls, source: Source) -> Outline:
        """The outline of any source, valid or not."""
        campaign: Mapping[str, Any] = source.value or {}
        horizon = campaign.get("horizon")
        duration = horizon.get("duration_s") if is_mapping(horizon) else None
        actuators = campaign.get("actuators")
        layout = thruster_layout(actuators)
        return cls(
            components=tuple(_components(campaign)),
            baselines=_names(campaign.get("baselines")),
            effects=_names(campaign.get("effects")),
            actuators=actuator_names(actuators, layout),
            layout=layout,
            navigation=_names(campaign.get("navigation")),
            guided=value_of(campaign, ("guidance", "use")) not in (None, "direct"),
            duration_s=duration if isinstance(duration, (int, float)) else None,
            margins=campaign.get("margins"),
            metric_uses=tuple(_metric_uses(campaign)),
            places=frozenset(_places(campaign)),
        )

    def has(self, place: str) -> bool:
        """Whether the campaign says something at a place, such as `target.hull`."""
        return place in self.places

    @property
    def margin_metrics(self) -> list[str]:
        """The names of the metrics of the margins."""
        return [f"{MARGIN}{name}" for name in self.margins] if is_mapping(self.margins) else []


def _places(campaign: Mapping[str, Any]) -> Iterator[str]:
    for section in ("target", "pursuer"):
        body = campaign.get(section)
        yield from (f"{section}.{key}" for key, value in (body.items() if is_mapping(body) else ()) if value is not None)


def _names(entries: Any) -> tuple[str, ...]:
    """The names of the entries of a list."""
    return tuple(entry_names(entries if is_list(entries) else []))


def _components(campaign: Mapping[str, Any]) -> Iterator[Entry]:
    for section in FAMILY_OF:
        at: Place = tuple(section.split("."))
        value = value_of(campaign, at)
        if at in SHORT and isinstance(value, str):
            yield Entry(section, at, {"use": value}, alone=True)
        for place, raw in _mappings(at, value):
            if isinstance(raw.get("use"), str):
                yield Entry(section, place, raw)


def _metric_uses(campaign: Mapping[str, Any]) -> Iterator[tuple[Place, Mapping[str, Any]]]:
    tuning = campaign.get("tune")
    yield from _mappings(("require",), campaign.get("require"))
    yield from _mappings(("tune", "objective"), tuning.get("objective") if is_mapping(tuning) else None)


def _mappings(place: Place, raw: Any) -> Iterator[tuple[Place, Mapping[str, Any]]]:
    """A mapping, or each mapping of a list, with its place."""
    if is_mapping(raw):
        yield place, raw
    for index, item in enumerate(raw if is_list(raw) else []):
        if is_mapping(item):
            yield (*place, index), item
