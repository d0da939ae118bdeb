"""Which signals the flights of a campaign have, and what is wrong with margins that name others or put unlike units together."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from rvjax.campaign import Quantity, Source
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.formula import MOST_SUGGESTIONS, Formula, Junction, Predicate, Reader, Until, parts_of, walk
from rvjax.campaign.plain_values import shorten
from rvjax.columns import SIGNAL
from rvjax.components.controllers.interface import Controller
from rvjax.errors import Finding
from rvjax.simulation.signals import Signal, derived, recorded, reported
from rvjax.simulation.temporal_margins import unit

ControllerChoice = tuple[Controller, Mapping[str, Quantity]]
"""A law, and the gains that it gets."""


@dataclass(frozen=True)
class AvailableSignals:
    """signals: of a flight under the controller, by name. known: whether its own signals are among them; baselines: the signals
    under each other controller, by its name. thrusters: how many fly, None where nobody knows."""

    signals: Mapping[str, Signal]
    known: bool
    baselines: Mapping[str, Mapping[str, Signal]]
    thrusters: int | None

    @classmethod
    def of(
        cls, controller: ControllerChoice | None, baselines: Mapping[str, ControllerChoice], measured: bool, thrusters: int | None
    ) -> AvailableSignals:
        """controller: None where the campaign says nothing right about it. measured: whether there are navigation errors."""

        def flown(one: ControllerChoice | None) -> dict[str, Signal]:
            meanings, own = ({}, {}) if one is None else (one[0].signals, reported(*one))
            return recorded(meanings, own, measured, thrusters or 0) | derived()

        return cls(flown(controller), controller is not None, {name: flown(one) for name, one in baselines.items()}, thrusters)

    def wrong(self, source: Source) -> list[Finding]:
        """Every finding about the names and the units in the margins of a campaign, whatever else is wrong with it."""
        reader = Reader()
        formulas = reader.margins((source.value or {}).get("margins", {}))
        found: list[Finding] = []
        for one in reader.predicates:
            if wrong := self._name(one.signal, few=len(found) >= MOST_SUGGESTIONS):
                found.append(source.finding(("margins", *one.place, "signal"), *wrong))
        return found + [
            source.finding(("margins", *place), f"margins in {' and in '.join(units)} put together", _ONE_UNIT)
            for formula in formulas.values()
            for place, units in self._unlike(formula)
        ]

    def _name(self, name: str, few: bool) -> tuple[str, str] | None:
        """What is wrong with the name of a signal. few: without looking for the nearest."""
        said = shorten(name)
        if name in self.signals:
            lacking = [other for other, theirs in self.baselines.items() if name not in theirs]
            found = f"{said} is no signal of the baseline {', '.join(lacking)}"
            return (found, "accepted: a signal of every controller that flies") if lacking else None
        if name.startswith(SIGNAL):
            own = [one for one in self.signals if one.startswith(SIGNAL)]
            return (f"{said} is no signal of the controller", _nearest(name, own, few)) if self.known else None
        if name.startswith("seen_") and name in recorded({}, {}, True, 0):
            return f"{said} is not recorded: there is no navigation", f"accepted: {name.removeprefix('seen_')}, the true one"
        if re.fullmatch(r"thrust_t[0-9]{1,3}_N", name):
            if self.thrusters is None:
                return None
            fly = f"{self.thrusters} thrusters fly" if self.thrusters else "no thrusters fly"
            return f"{said} is not recorded: {fly}", "accepted: the thrust of one that does"
        return f"{said} is no signal", _nearest(name, list(self.signals), few)

    def _unlike(self, formula: Formula) -> Iterator[tuple[tuple[str | int, ...], list[str]]]:
        """Places of the parts of a formula whose own parts have margins of different units, and the units."""
        nodes = list(walk(formula))
        if any(isinstance(node, Predicate) and node.signal not in self.signals for node in nodes):
            return
        for node in nodes:
            if isinstance(node, (Junction, Until)):
                units = dict.fromkeys(unit(part, self.signals) for part in parts_of(node))
                if len(units) > 1:
                    yield node.place, ["no unit" if one == "1" else one for one in units]


_ONE_UNIT = "accepted: one unit, or scale in each predicate, the amount of its signal that counts as 1"


def _nearest(name: str, known: list[str], few: bool) -> str:
    said = "" if few else did_you_mean(name, known)
    return said if said.startswith("did") else f"accepted: one of `rvjax explain signals`, such as {', '.join(known[-3:])}"


def controller_of(law: Controller, quantities: Mapping[str, Quantity]) -> ControllerChoice:
    """A law with its gains, out of all that a campaign says of it."""
    return law, {name.removeprefix("gains."): one for name, one in quantities.items() if name.startswith("gains.")}
