"""The available signals of the flights of a campaign; findings about margins with unknown signals or mixed units."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from rvjax.campaign import Quantity, Source
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.formula import MOST_SUGGESTIONS, Formula, Junction, Predicate, Reader, Until, parts_of, walk
from rvjax.campaign.plain_values import shorten
from rvjax.columns import EFFECT, NAVIGATION, SIGNAL
from rvjax.components.controllers.interface import Controller, DiscreteController
from rvjax.components.effects.interface import Effect
from rvjax.components.navigation.interface import NavigationError
from rvjax.errors import Finding
from rvjax.simulation.signals import MEAN_WRENCH, Signal, derived, interrupting, moved, recorded, reported
from rvjax.simulation.temporal_margins import unit

ControllerChoice = tuple[Controller | DiscreteController, Mapping[str, Quantity]]
"""A controller and its gains."""

EffectChoice = tuple[Effect, Mapping[str, Quantity]]
"""An effect and its numbers."""


@dataclass(frozen=True)
class AvailableSignals:
    """signals: of a flight with the controller, by name. known: whether the signals of the controller are included. baselines:
    the signals with each baseline, by its name. effects, navigation: their names, and whether their signals are included.
    thrusters: their number, None if unknown."""

    signals: Mapping[str, Signal]
    known: bool
    baselines: Mapping[str, Mapping[str, Signal]]
    effects: Mapping[str, bool]
    navigation: Mapping[str, bool]
    thrusters: int | None

    @classmethod
    def of(
        cls,
        controller: ControllerChoice | None,
        baselines: Mapping[str, ControllerChoice],
        effects: Mapping[str, EffectChoice | None],
        navigation: Mapping[str, NavigationError | None],
        thrusters: int | None,
        propellant: bool,
        guided: bool = False,
    ) -> AvailableSignals:
        """controller, effects, navigation: None where a part of the campaign is wrong. effects, navigation: in the order of the
        campaign. propellant: whether the pursuer has propellant; guided: whether a guidance moves the reference point."""
        moving = {name: (choice[0], moved(*choice)) for name, choice in effects.items() if choice is not None}
        interrupted = interrupting({name: error for name, error in navigation.items() if error is not None})

        def signals(choice: ControllerChoice | None) -> dict[str, Signal]:
            meanings, values = ({}, {}) if choice is None else (choice[0].signals, reported(*choice))
            fixed = bool(navigation), thrusters or 0, moving, propellant, interrupted, guided
            return recorded(meanings, values, *fixed) | derived()

        others = {name: signals(choice) for name, choice in baselines.items()}
        included = {name: name in moving for name in effects}, {name: error is not None for name, error in navigation.items()}
        return cls(signals(controller), controller is not None, others, *included, thrusters)

    def findings(self, margins: Any, source: Source) -> list[Finding]:
        """Every finding about names and units in the margins of a campaign, even if other parts of it are wrong."""
        reader = Reader()
        formulas = reader.margins(margins)
        findings: list[Finding] = []
        for predicate in reader.predicates:
            if wrong := self._wrong_name(predicate.signal, few=len(findings) >= MOST_SUGGESTIONS):
                findings.append(source.finding(("margins", *predicate.place, "signal"), *wrong))
        return findings + [
            source.finding(("margins", *place), f"margins in {' and in '.join(units)} put together", _ONE_UNIT)
            for formula in formulas.values()
            for place, units in self._mixed_units(formula)
        ]

    def _wrong_name(self, name: str, few: bool) -> tuple[str, str] | None:
        """(message, accepted) if a name is no signal. few: do not look for the nearest name."""
        shown = shorten(name)
        if name in self.signals:
            lacking = [baseline for baseline, signals in self.baselines.items() if name not in signals]
            message = f"{shown} is no signal of the baseline {', '.join(lacking)}"
            return (message, "accepted: a signal of every controller that flies") if lacking else None
        if name.startswith(SIGNAL):
            known = [signal for signal in self._shared if signal.startswith(SIGNAL)]
            return (f"{shown} is no signal of the controller", _nearest(name, known, few)) if self.known else None
        if name.startswith(EFFECT):
            return self._wrong_name_of_effect(name, few)
        if name in MEAN_WRENCH:
            return f"{shown} is a mean over the steps from a row of the trace to the next, no signal", _AT_AN_INSTANT
        if name.startswith(NAVIGATION) and not all(self.navigation.values()):
            return None
        if name.startswith("seen_") and name in recorded({}, {}, True, 0):
            return f"{shown} is not recorded: there is no navigation", f"accepted: {name.removeprefix('seen_')}, the true one"
        if name in recorded({}, {}, False, 0, propellant=True):
            return f"{shown} is not recorded: there is no propellant", "accepted: a signal of the flight, or pursuer.propellant"
        if re.fullmatch(r"thrust_t[0-9]{1,3}_N", name):
            if self.thrusters is None:
                return None
            fly = f"{self.thrusters} thrusters fly" if self.thrusters else "no thrusters fly"
            return f"{shown} is not recorded: {fly}", "accepted: the thrust of an existing thruster"
        return f"{shown} is no signal", _nearest(name, self._shared, few)

    def _wrong_name_of_effect(self, name: str, few: bool) -> tuple[str, str] | None:
        shown, known = shorten(name), [signal for signal in self.signals if signal.startswith(EFFECT)]
        if not self.effects:
            return f"{shown} is not recorded: there are no effects", "accepted: a signal of the flight, or an effect in `effects`"
        effect = next((effect for effect in self.effects if name.startswith(f"{EFFECT}{effect}.")), None)
        if effect is None:
            return (f"{shown} is no signal of an effect", _nearest(name, known, few)) if all(self.effects.values()) else None
        known = [signal for signal in known if signal.startswith(f"{EFFECT}{effect}.")]
        return (f"{shown} is no signal of the effect {effect}", _nearest(name, known, few)) if self.effects[effect] else None

    @property
    def _shared(self) -> list[str]:
        """The signals of every controller that flies."""
        return [name for name in self.signals if all(name in signals for signals in self.baselines.values())]

    def _mixed_units(self, formula: Formula) -> Iterator[tuple[tuple[str | int, ...], list[str]]]:
        """(place, units) of each part of a formula that combines margins of different units."""
        nodes = list(walk(formula))
        if any(isinstance(node, Predicate) and node.signal not in self.signals for node in nodes):
            return
        for node in nodes:
            if isinstance(node, (Junction, Until)):
                units = dict.fromkeys(unit(part, self.signals) for part in parts_of(node))
                if len(units) > 1:
                    yield node.place, ["no unit" if name == "1" else name for name in units]


_AT_AN_INSTANT = "accepted: a wrench at an instant, such as applied_fx or dist_fx"
_ONE_UNIT = "accepted: one unit, or scale in each predicate, the amount of its signal that counts as 1"


def _nearest(name: str, known: list[str], few: bool) -> str:
    suggestion = "" if few else did_you_mean(name, known)
    return (
        suggestion
        if suggestion.startswith("did")
        else f"accepted: one of `rvjax explain signals`, such as {', '.join(known[-3:])}"
    )


def controller_of(controller: Controller | DiscreteController, quantities: Mapping[str, Quantity]) -> ControllerChoice:
    """A controller with its gains, from all its quantities in the campaign."""
    return controller, {name.removeprefix("gains."): gain for name, gain in quantities.items() if name.startswith("gains.")}
