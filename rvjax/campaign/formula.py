"""Temporal margins of a campaign: formulas over signals, read into frozen values. Free of JAX.

    formula    {always: state}, {eventually: state}, {until_settled: state}, {until: {hold: state, reach: state}},
               {all: [formula, …]}, {any: [formula, …]}, {not: formula}; or, not inside another, {time_share: state}
    state      {signal: name, below: x}, {signal: name, above: x}, {all: [state, …]}, {any: [state, …]}, {not: state}

A state is true or false at an instant; a formula is true or false of a flight. `from_s` and `to_s`, next to the state of always
and eventually or next to hold and reach, select the instants that count. `rvjax.simulation.temporal_margins` defines the
operators.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from pydantic import ValidationInfo
from pydantic_core import core_schema

from rvjax.campaign.choice import NAME, NAME_WORDS
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.plain_values import Place, exact, is_list, is_mapping, is_number, shorten
from rvjax.campaign.problems import Problem, refuse, unexpected

MOST = 256
"""Predicates in the margins of a campaign."""

MOST_SUGGESTIONS = 20
"""Unknown keys that get a suggestion each; comparing words takes time."""

STEPS = 1e-6
"""Rounding tolerance of the ends of a window, in steps."""

TEMPORAL = ("always", "eventually", "until_settled", "until", "time_share")
BOOLEAN = ("all", "any", "not")
WINDOW = ("from_s", "to_s")
PREDICATE = ("signal", "below", "above", "scale")
A_FORMULA = "accepted: a formula, such as {always: {signal: position_error_m, below: 30}}"
A_STATE = "accepted: {signal: …, below: …}, {signal: …, above: …}, or all, any or not of these"
NOT_NESTED = (
    "accepted: predicates with all, any and not; a margin is computed during the flight in fixed memory, "
    "and nested temporal operators would need the whole trace"
)


@dataclass(frozen=True)
class Predicate:
    """signal < value, or signal > value if `above`, in the unit of the signal. scale: divisor of its margin."""

    signal: str
    above: bool
    value: float
    scale: float | None = None
    place: Place = field(default=(), compare=False)


@dataclass(frozen=True)
class Junction:
    """all: every part is true; any: one or more parts are true."""

    word: Literal["all", "any"]
    parts: tuple[Formula, ...]
    place: Place = field(default=(), compare=False)


@dataclass(frozen=True)
class Negation:
    """The part is not true."""

    part: Formula


@dataclass(frozen=True)
class Window:
    """The instants t with start ≤ t ≤ end [s]; end None: to the end of the flight."""

    start: float = 0.0
    end: float | None = None

    def steps(self, step_s: float) -> tuple[float, float]:
        """(first, last) step of the window; the window is empty where the first is after the last."""
        return math.ceil(self.start / step_s - STEPS), math.inf if self.end is None else math.floor(self.end / step_s + STEPS)


@dataclass(frozen=True)
class Always:
    """The part is true at every instant of the window."""

    part: Formula
    window: Window = Window()


@dataclass(frozen=True)
class Eventually:
    """The part is true at some instant of the window."""

    part: Formula
    window: Window = Window()


@dataclass(frozen=True)
class TimeShare:
    """A number rather than a formula: the share of the instants of the window at which the part is true."""

    part: Formula
    window: Window = Window()


@dataclass(frozen=True)
class UntilSettled:
    """The part is true at every instant before settling, the first instant from which both capture tubes hold until the end."""

    part: Formula


@dataclass(frozen=True)
class Until:
    """reach is true at some instant of the window, and hold at every earlier instant of the flight."""

    hold: Formula
    reach: Formula
    window: Window = Window()
    place: Place = field(default=(), compare=False)


Formula = Predicate | Junction | Negation | Always | Eventually | UntilSettled | Until | TimeShare


@dataclass
class Reader:
    """Reads margins and collects every problem and every predicate. horizon: duration and step [s], where known."""

    horizon: tuple[float, float] | None = None
    problems: list[Problem] = field(default_factory=list[Problem])
    predicates: list[Predicate] = field(default_factory=list[Predicate])
    _suggested: int = 0

    def margins(self, raw: Any) -> dict[str, Formula]:
        """The formulas by name, in the order of the names; those with a problem are left out."""
        if not is_mapping(raw):
            self._unexpected(raw, "accepted: a mapping from names to formulas", ())
            return {}
        formulas: dict[str, Formula] = {}
        for name, value in sorted(raw.items()):
            if not NAME.fullmatch(name):
                self._unexpected(name, NAME_WORDS, (name,), at_key=True)
            if (formula := self.formula(value, (name,))) is not None:
                formulas[name] = formula
        if len(self.predicates) > MOST:
            self._wrong(f"{len(self.predicates):,} predicates", f"accepted: at most {MOST} in all margins", ())
        return formulas

    def formula(self, raw: Any, place: Place, inside: str = "") -> Formula | None:
        """A formula, or a state inside the temporal operator `inside`; None where there is a problem."""
        accepted = A_STATE if inside else A_FORMULA
        if not is_mapping(raw):
            return self._unexpected(raw, accepted, place)
        words = [key for key in raw if key in (*BOOLEAN, *TEMPORAL, "signal")]
        if not words:
            if not raw or set(raw) <= {*PREDICATE, *WINDOW}:
                return self._wrong("no operator and no signal" if not inside else "no signal", accepted, place)
            return self._unknown(set(raw) - {*PREDICATE, *WINDOW}, (*BOOLEAN, *TEMPORAL, *PREDICATE), place)
        if len(words) > 1:
            return self._wrong(
                f"{' and '.join(words)} in the same mapping", "accepted: a single operator, or all: [{…}, {…}]", place
            )
        (word,) = words
        known = {word, *PREDICATE} if word == "signal" else {word}
        clean = set(raw) <= known or self._unknown(set(raw) - known, sorted(known), place, word) is not None
        if word in TEMPORAL:
            formula = self._temporal(word, raw[word], (*place, word), inside)
        elif word == "signal":
            formula = self._predicate(raw, place, inside)
        elif word == "not":
            part = self.formula(raw[word], (*place, word), inside)
            formula = None if part is None else Negation(part)
        else:
            formula = self._junction("all" if word == "all" else "any", raw[word], (*place, word), inside)
        return formula if clean else None

    def _junction(self, word: Literal["all", "any"], raw: Any, place: Place, inside: str) -> Formula | None:
        if not is_list(raw) or not raw:
            return self._unexpected(raw, "accepted: a list with one or more entries", place)
        parts = [self.formula(part, (*place, index), inside) for index, part in enumerate(raw)]
        whole = tuple(part for part in parts if part is not None)
        return Junction(word, whole, place) if len(whole) == len(parts) else None

    def _temporal(self, word: str, raw: Any, place: Place, inside: str) -> Formula | None:
        if inside:
            return self._wrong(f"{word} inside {inside}", NOT_NESTED, place, at_key=True)
        if word == "until_settled":
            part = self.formula(raw, place, word)
            return None if part is None else UntilSettled(part)
        if not is_mapping(raw):
            return self._unexpected(raw, A_STATE, place)
        window = self._window(raw, place)
        if word == "until":
            return self._until(raw, place, window)
        part = self.formula({key: value for key, value in raw.items() if key not in WINDOW}, place, word)
        if part is None or window is None:
            return None
        if word == "time_share" and len(place) > 2:
            accepted = "accepted: time_share alone under the name of a margin; it is a share of time and not a margin"
            return self._wrong(
                f"time_share inside {place[-3 if isinstance(place[-2], int) else -2]}", accepted, place, at_key=True
            )
        return {"always": Always, "eventually": Eventually, "time_share": TimeShare}[word](part, window)

    def _until(self, raw: Mapping[str, Any], place: Place, window: Window | None) -> Formula | None:
        sides = ("hold", "reach")
        self._unknown(set(raw) - {*sides, *WINDOW}, (*sides, *WINDOW), place)
        for side in sides:
            if side not in raw:
                self._wrong("missing", "accepted: hold, true until then, and reach, what ends it", (*place, side), at_key=True)
        hold, reach = (self.formula(raw[side], (*place, side), "until") if side in raw else None for side in sides)
        if hold is None or reach is None or window is None or not set(raw) <= {*sides, *WINDOW}:
            return None
        return Until(hold, reach, window, place)

    def _predicate(self, raw: Mapping[str, Any], place: Place, inside: str) -> Formula | None:
        before = len(self.problems)
        signal, sides = raw["signal"], [side for side in ("below", "above") if side in raw]
        if not isinstance(signal, str):
            self._unexpected(signal, "accepted: the name of a signal, such as position_error_m", (*place, "signal"))
        if len(sides) != 1:
            words = "both below and above" if sides else "neither below nor above"
            self._wrong(words, "accepted: below or above", place)
        for key in (*sides, "scale"):
            if key in raw and not is_number(raw[key]):
                self._unexpected(raw[key], "accepted: a number in the unit of the signal", (*place, key))
            elif key == "scale" and key in raw and raw[key] <= 0:
                self._unexpected(raw[key], "accepted: a number above 0, in the unit of the signal", (*place, key))
        if not inside:
            self._wrong(
                "no temporal operator around this predicate", f"accepted: the predicate inside {', '.join(TEMPORAL)}", place
            )
        plain = len(self.problems) == before
        value, scale = (float(raw[sides[0]]), raw.get("scale")) if plain else (0.0, None)
        predicate = Predicate(str(signal), sides == ["above"], value, None if scale is None else float(scale), place)
        if isinstance(signal, str):
            self.predicates.append(predicate)
        return predicate if plain else None

    def _window(self, raw: Mapping[str, Any], place: Place) -> Window | None:
        before = len(self.problems)
        for key in WINDOW:
            if key in raw and not (is_number(raw[key]) and raw[key] >= 0):
                self._unexpected(raw[key], "accepted: a number of seconds, 0 or more", (*place, key))
        if len(self.problems) > before:
            return None
        window = Window(float(raw.get("from_s", 0.0)), float(raw["to_s"]) if "to_s" in raw else None)
        end = math.inf if window.end is None else window.end
        last = (*place, "to_s" if "to_s" in raw else "from_s")
        if window.start > end:
            return self._wrong(
                f"an empty window, from {exact(window.start)} s to {exact(end)} s", "accepted: from_s up to to_s", last
            )
        if self.horizon is None:
            return window
        duration, step = self.horizon
        for key in WINDOW:
            if raw.get(key, 0.0) > duration * (1.0 + STEPS):
                message = f"{exact(raw[key])} s is after the end of the flight"
                self._wrong(message, f"accepted: at most {exact(duration)} s", (*place, key))
        first, behind = window.steps(step)
        if first > min(behind, round(duration / step)) and len(self.problems) == before:
            ends = f"{exact(window.start)} s and {exact(min(end, duration))} s"
            message = f"an empty window: no step of {exact(step)} s falls between {ends}"
            self._wrong(message, "accepted: a window that contains a step", last)
        return window if len(self.problems) == before else None

    def _unknown(self, unknown: set[str], known: Any, place: Place, word: str = "") -> None:
        for key in sorted(unknown):
            if key == "within_s" or (key in WINDOW and word):
                accepted = f"accepted: {', '.join(WINDOW)} next to the state of always, eventually or until"
            else:
                self._suggested += 1
                accepted = did_you_mean(key, known) if self._suggested <= MOST_SUGGESTIONS else f"accepted: {', '.join(known)}"
            self._wrong("unknown key", accepted, (*place, key), at_key=True)

    def _wrong(self, message: str, accepted: str, place: Place, at_key: bool = False) -> None:
        self.problems.append(Problem(message, accepted, place, at_key))

    def _unexpected(self, value: object, accepted: str, place: Place, at_key: bool = False) -> None:
        self.problems.append(unexpected(value, accepted, place, at_key))


class Margins:
    """Reads the section `margins` of a campaign, after the horizon."""

    def read(self, raw: Any, info: ValidationInfo) -> Mapping[str, Formula]:
        """The formulas by name, or every problem at once."""
        horizon = info.data.get("horizon")
        reader = Reader(None if horizon is None else (horizon.duration_s, horizon.step_s))
        formulas = reader.margins(raw)
        return refuse(*reader.problems) if reader.problems else formulas

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.with_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        return {"type": "object", "propertyNames": {"pattern": f"^{NAME.pattern}$"}}


def walk(formula: Formula) -> Iterator[Formula]:
    """The formula and everything below it."""
    yield formula
    for part in parts_of(formula):
        yield from walk(part)


def parts_of(formula: Formula) -> tuple[Formula, ...]:
    """The direct parts of a formula."""
    if isinstance(formula, Predicate):
        return ()
    if isinstance(formula, Until):
        return formula.hold, formula.reach
    return formula.parts if isinstance(formula, Junction) else (formula.part,)


def in_words(formula: Formula, units: Mapping[str, str]) -> str:
    """`always from 60 s (closing_speed_m_s below 0.5 m/s)`. units: of the signals."""
    if isinstance(formula, Predicate):
        unit = units.get(formula.signal, "")
        unit = "" if unit in ("", "1") else f" {unit}"
        scaled = "" if formula.scale is None else f", per {exact(formula.scale)}{unit}"
        return f"{shorten(formula.signal)} {'above' if formula.above else 'below'} {exact(formula.value)}{unit}{scaled}"
    inner = [in_words(part, units) for part in parts_of(formula)]
    if isinstance(formula, Junction):
        return f"{formula.word} of ({'; '.join(inner)})"
    if isinstance(formula, Negation):
        return f"not ({inner[0]})"
    if isinstance(formula, UntilSettled):
        return f"until settled ({inner[0]})"
    start, end = formula.window.start, formula.window.end
    window = (f" from {exact(start)} s" if start else "") + ("" if end is None else f" to {exact(end)} s")
    if isinstance(formula, Until):
        return f"hold ({inner[0]}) until{window} ({inner[1]})"
    words = {Always: "always", Eventually: "eventually", TimeShare: "share of time"}
    return f"{words[type(formula)]}{window} ({inner[0]})"
