"""How a campaign writes a quantity: a number is fixed, a mapping with a single key is a distribution.

A vector is a list of three of these, a joint distribution (box, ball, direction, …), or a single entry that every component
shares and draws independently. Channels are a list of six, a single entry, or `{force: …, torque: …}`, each a list of three or a
single entry. Thrusters are a list with an entry for each, or a single entry.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, cast

from rvjax.campaign.attitudes import read_attitude
from rvjax.campaign.csv_text import CsvFile
from rvjax.campaign.distributions import (
    Attitude,
    Ball,
    Beta,
    Direction,
    Distribution,
    Empirical,
    Exponential,
    Fixed,
    HalfNormal,
    JointDistribution,
    LogNormal,
    LogUniform,
    Normal,
    Pick,
    Poisson,
    Triangular,
    TruncatedNormal,
    Uniform,
    VonMisesFisher,
    Weibull,
)
from rvjax.campaign.distributions.interface import ABOVE_ZERO
from rvjax.campaign.plain_values import Place, exact, is_list, is_mapping, is_number, shorten
from rvjax.campaign.problems import Problem, unexpected
from rvjax.campaign.quantity import Shape
from rvjax.campaign.zero_width import only_number

LAWS: dict[str, tuple[tuple[str, ...], Callable[..., Distribution]]] = {
    "uniform": (("low", "high"), Uniform),
    "normal": (("mean", "sd"), Normal),
    "truncated_normal": (("mean", "sd", "low", "high"), TruncatedNormal),
    "log_uniform": (("low", "high"), LogUniform),
    "half_normal": (("sd",), HalfNormal),
    "log_normal": (("median", "sigma_log"), LogNormal),
    "triangular": (("low", "mode", "high"), Triangular),
    "beta": (("a", "b", "low", "high"), Beta),
    "exponential": (("mean",), Exponential),
    "weibull": (("scale", "shape"), Weibull),
    "poisson": (("mean",), Poisson),
}
"""By the word in a campaign: the names of the parameters in order, and the distribution. `choice` takes a list of any length."""

RADIAL: dict[str, Callable[[float], JointDistribution]] = {"ball": Ball, "direction": Direction}
"""Laws of a vector that take a radius, by the word in a campaign."""

ABOUT = ("mean", "kappa", "radius")
"""Parameters of `von_mises_fisher`."""

SCALAR_WORDS = (*LAWS, "choice", "table")
VECTOR_WORDS = ("box", *RADIAL, "von_mises_fisher", "rotation")
"""`box` is three independent uniform distributions."""

NOTHING = Fixed(0.0)
"""Stands for a component of a vector of radius 0, and in for a distribution with a problem."""


@dataclass(frozen=True)
class Range:
    """The range of a number, in the unit of its key. The whole support of a distribution must lie inside."""

    at_least: float | None = None
    above: float | None = None
    at_most: float | None = None
    below: float | None = None

    def admits(self, low: float, high: float) -> bool:
        """Whether every number from low to high is accepted."""
        return (
            (self.at_least is None or low >= self.at_least)
            and (self.above is None or low > self.above)
            and (self.at_most is None or high <= self.at_most)
            and (self.below is None or high < self.below)
        )

    def words(self, unit: str) -> str:
        """`at least 0 and below 1 kg`; empty where every number is accepted."""
        bounds = (("at least", self.at_least), ("above", self.above), ("at most", self.at_most), ("below", self.below))
        return " and ".join(f"{words} {with_unit(exact(value), unit)}" for words, value in bounds if value is not None)


def with_unit(text: str, unit: str, between: str = " ") -> str:
    """`3 kg`; the text alone where there is no unit, or where the components have different units."""
    return text if unit == "1" or "," in unit else f"{text}{between}{unit}"


def forms() -> dict[str, tuple[str, type[Any]]]:
    """(notation in a campaign, class) of every distribution, by its word."""
    scalars = {word: (names[0] if len(names) == 1 else f"[{', '.join(names)}]", law) for word, (names, law) in LAWS.items()}
    others: dict[str, tuple[str, Any]] = {
        "choice": ("[value, …] or {values: [value, …], weights: [weight, …]}", Pick),
        "table": ("{csv: file, column: name}, optionally with interpolate: true", Empirical),
        **{word: ("radius", law) for word, law in RADIAL.items()},
        "von_mises_fisher": ("{mean: [x, y, z], kappa: k, radius: r}", VonMisesFisher),
        "rotation": ("uniform", Attitude),
    }
    return {word: (f"{{{word}: {form}}}", cast("type[Any]", law)) for word, (form, law) in (scalars | others).items()}


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """`did you mean mass_kg?`, or else the list of the known names."""
    names = list(known)
    near = difflib.get_close_matches(word[:64], names, n=1, cutoff=0.7)
    return f"did you mean {near[0]}?" if near else f"accepted: {', '.join(names) or 'none'}"


@dataclass(frozen=True)
class VectorNotation:
    """Further notations of a vector. named: names of its components, in the order of a list; attitude: quaternions and Euler
    angles, as MRP."""

    named: tuple[str, ...] = ()
    attitude: bool = False


PLAIN = VectorNotation()


@dataclass(frozen=True)
class Reader:
    """Reads a quantity in the unit `unit` and collects every problem with its place."""

    unit: str
    range: Range
    problems: list[Problem] = field(default_factory=list[Problem])

    def quantity(
        self, shape: Shape, raw: Any, thrusters: int = 0, notation: VectorNotation = PLAIN
    ) -> tuple[tuple[Distribution, ...], JointDistribution | None]:
        """Parts and joint distribution of a quantity; not valid if there are problems."""
        if shape == "thrusters":
            return self.parts(raw, thrusters, ()), None
        if shape == "scalar":
            return (self.scalar(raw, ()),), None
        if shape == "channels":
            return self.channels(raw), None
        if notation.attitude and (mrp := read_attitude(raw)) is not None:
            return tuple(map(Fixed, mrp)), None
        if is_mapping(raw) and raw.keys() & set(notation.named):
            return self.components(raw, notation.named), None
        if is_mapping(raw) and len(raw) == 1:
            ((word, given),) = raw.items()
            if word == "box":
                return self.box(given, (word,)), None
            if word in VECTOR_WORDS:
                joint = self.joint(word, given, (word,))
                return ((NOTHING,) * 3, None) if joint is None else ((), joint)
        return self.parts(raw, 3, (), VECTOR_WORDS), None

    def components(self, raw: Any, names: tuple[str, ...]) -> tuple[Distribution, ...]:
        """`{xy: …, xz: …, yz: …}`: every component by its name, in any order; the order of the names is that of the list."""
        for key in sorted(raw.keys() ^ set(names)):
            accepted = f"accepted: {', '.join(sorted(names))}, all of them"
            self.refuse((key,), "unknown key" if key in raw else "missing", accepted, at_key=True)
        return tuple(self.scalar(raw[name], (name,)) if name in raw else NOTHING for name in names)

    def channels(self, raw: Any) -> tuple[Distribution, ...]:
        """A list of six, a scalar for every channel, or `{force: …, torque: …}`."""
        halves = {"force", "torque"}
        if not is_mapping(raw) or not raw.keys() & halves:
            return self.parts(raw, 6, (), extra=("force and torque",))
        for key in sorted(raw.keys() ^ halves):
            self.refuse((key,), "unknown key" if key in raw else "missing", "accepted: force and torque, both", at_key=True)
        return tuple(part for key in sorted(halves & raw.keys()) for part in self.parts(raw[key], 3, (key,)))

    def parts(self, raw: Any, count: int, place: Place, extra: tuple[str, ...] = ()) -> tuple[Distribution, ...]:
        """A list of `count` scalars, or a single scalar for all. extra: further words, listed in the message."""
        if not is_list(raw):
            return (self.scalar(raw, place, extra),) * count
        if len(raw) != count:
            self.unexpected(place, raw, f"accepted: a list of {count}, or a single number or distribution for all")
        return tuple(self.scalar(item, (*place, index)) for index, item in enumerate(raw))

    def scalar(self, raw: Any, place: Place, extra: tuple[str, ...] = ()) -> Distribution:
        """A number, or a mapping with a single key that is a distribution."""
        if is_number(raw):
            return self.checked("", lambda: Fixed(float(raw)), place)
        if not is_mapping(raw) or len(raw) != 1:
            words = ", ".join((*SCALAR_WORDS, *extra))
            return self.unexpected(
                place,
                raw,
                f"accepted: {with_unit('a number', self.unit, ' in ')} or one of {words}",
            )
        ((word, given),) = raw.items()
        at = (*place, word)
        if word == "choice":
            return self.choice(given, at)
        if word == "table":
            return self.table(given, at)
        if word in LAWS:
            names, law = LAWS[word]
            values = self.numbers(given, names, at)
            return self.law(word, values, lambda: law(*values), at) if values else NOTHING
        if word in VECTOR_WORDS:
            return self.refuse(
                at, f"{word} is the distribution of a whole vector", f"accepted: {', '.join(SCALAR_WORDS)}", at_key=True
            )
        return self.refuse(at, "unknown distribution", did_you_mean(word, (*SCALAR_WORDS, *extra)), at_key=True)

    def choice(self, given: Any, place: Place) -> Distribution:
        """A list of values, or `{values: […], weights: […]}`."""
        if not is_mapping(given):
            values = self.numbers(given, None, place)
            return self.listed("choice", lambda: Pick.of(values), place) if values else NOTHING
        if given.keys() != {"values", "weights"}:
            return self.unexpected(place, given, "accepted: a list, or values and weights")
        values = self.numbers(given["values"], None, (*place, "values"))
        weights = self.numbers(given["weights"], None, (*place, "weights"))
        if not values or not weights:
            return NOTHING
        return self.listed("choice", lambda: Pick.of(values, weights), place)

    def table(self, given: Any, place: Place) -> Distribution:
        """`{csv: file, column: name}`, whose file has been read; optionally with `interpolate: true`."""
        keys = given.keys() if is_mapping(given) else set[str]()
        if not {"csv", "column"} <= keys <= {"csv", "column", "interpolate"}:
            return self.unexpected(place, given, "accepted: csv and column, and optionally interpolate: true")
        file, name, smooth = given["csv"], given["column"], given.get("interpolate", False)
        if not isinstance(smooth, bool):
            return self.unexpected((*place, "interpolate"), smooth, "accepted: true or false")
        if not isinstance(name, str):
            return self.unexpected((*place, "column"), name, "accepted: the name of a column")
        if not isinstance(file, CsvFile) or not file.readable:  # there is a finding about it already
            return NOTHING
        if name not in file.names:
            return self.refuse((*place, "csv"), file.without(name), did_you_mean(name, file.names), at_key=True)
        try:
            values = file.column(name)
        except ValueError as error:
            return self.refuse((*place, "csv"), str(error), "accepted: a number in every row", at_key=True)
        for (line, _), value in zip(file.rows, values, strict=True):
            if not self.range.admits(value, value):
                message = f"{file.name} line {line}, column {shorten(name)}: {with_unit(exact(value), self.unit)}"
                return self.refuse((*place, "csv"), message, f"accepted: {self.range.words(self.unit)}", at_key=True)
        return self.listed("table", lambda: Empirical.of(values, smooth), place)

    def box(self, given: Any, place: Place) -> tuple[Distribution, ...]:
        """Independent uniform numbers within ± the half side of each axis."""
        given = given if is_list(given) else [given] * 3
        halves = self.numbers(given, ("x", "y", "z"), place)
        if min(halves, default=0.0) < 0.0:
            self.refuse(place, "a half side is below 0", "accepted: at least 0")
            return ()
        return tuple(
            self.checked("box", lambda half=half: Uniform(-half, half) if half else Fixed(0.0), place) for half in halves
        )

    def joint(self, word: str, given: Any, place: Place) -> JointDistribution | None:
        """`{ball: radius}`, `{direction: radius}`, `{von_mises_fisher: {…}}` or, of an attitude, `{rotation: uniform}`. None:
        the radius is 0, or there is a problem."""
        if word == "rotation":
            return self.rotation(given, place)
        if word == "von_mises_fisher":
            return self.about(given, place)
        radius = self.radius(word, given, place)
        return RADIAL[word](radius) if radius else None

    def rotation(self, given: Any, place: Place) -> JointDistribution | None:
        """`uniform`, of modified Rodrigues parameters."""
        if self.unit != "1":
            self.refuse(
                place, "rotation is the distribution of an attitude", f"accepted: {', '.join(VECTOR_WORDS[:-1])}", at_key=True
            )
        elif given != "uniform":
            self.unexpected(place, given, "accepted: uniform")
        return Attitude()

    def about(self, given: Any, place: Place) -> JointDistribution | None:
        """`{mean: [x, y, z], kappa: k, radius: r}`."""
        if not is_mapping(given) or given.keys() != set(ABOUT):
            self.unexpected(place, given, f"accepted: a mapping with {', '.join(ABOUT)}")
            return None
        mean = self.numbers(given["mean"], ("x", "y", "z"), (*place, "mean"))
        kappa = self.numbers(given["kappa"], ("kappa",), (*place, "kappa"))
        radius = self.radius("von_mises_fisher", given["radius"], (*place, "radius"))
        if not mean or not kappa:
            return None
        try:
            law = VonMisesFisher.of((mean[0], mean[1], mean[2]), kappa[0], radius or 1.0)
            return law if radius else None
        except ValueError as error:
            self.refuse(place, f"von_mises_fisher: {error}", "")
        return None

    def radius(self, word: str, given: Any, place: Place) -> float:
        """A radius of at least 0 whose sphere is inside the range; 0 if there is a problem."""
        for radius in self.numbers(given, ("radius",), place):
            if radius >= 0.0:
                self.checked(word, lambda radius=radius: Uniform(-radius, radius) if radius else NOTHING, place)
                return radius
            self.refuse(place, f"{word}: found {exact(radius)}", f"accepted: a radius of at least {with_unit('0', self.unit)}")
        return 0.0

    def numbers(self, given: Any, names: tuple[str, ...] | None, place: Place) -> list[float]:
        """The parameters of a distribution, which are plain numbers; empty if there is a problem."""
        single = names is not None and len(names) == 1
        form = ", ".join(names or ("value", "value", "…"))
        form = form if single else f"[{form}]"
        items = [given] if single else given
        if not is_list(items) or (names is not None and len(items) != len(names)) or not items:
            self.unexpected(place, given, f"accepted: {form}")
            return []
        wrong = [index for index, item in enumerate(items) if not is_number(item)]
        for index in wrong:
            at = place if single else (*place, index)
            self.unexpected(
                at,
                items[index],
                f"accepted: {with_unit('a number', self.unit, ' in ')}, in {form}",
            )
        return [] if wrong else [float(item) for item in items]

    def law(self, word: str, values: Sequence[float], make: Callable[[], Distribution], place: Place) -> Distribution:
        """The distribution with these parameters; of width zero a fixed number."""
        only = only_number(word, values)
        return self.checked(word, make if only is None else lambda: Fixed(only), place)

    def listed(self, word: str, make: Callable[[], Distribution], place: Place) -> Distribution:
        """A distribution of listed numbers; where all are equal, this number."""
        law = self.checked(word, make, place)
        return Fixed(law.low) if law.low == law.high else law

    def checked(self, word: str, make: Callable[[], Distribution], place: Place) -> Distribution:
        """The distribution that `make` returns; its whole support must be inside the range."""
        try:
            law = make()
        except ValueError as error:
            return self.refuse(place, f"{word}: {error}", "")
        if not self.range.admits(law.low, law.high):
            low = "above 0" if law.low == ABOVE_ZERO else exact(law.low)
            ends = with_unit(low if law.low == law.high else f"{low} to {exact(law.high)}", self.unit)
            hint = "; a truncated_normal has bounds" if math.isinf(law.low) or math.isinf(law.high) else ""
            return self.refuse(
                place, f"{word} reaches from {ends}" if word else ends, f"accepted: {self.range.words(self.unit)}{hint}"
            )
        return law

    def refuse(self, place: Place, message: str, accepted: str, at_key: bool = False) -> Distribution:
        """Keep a problem."""
        self.problems.append(Problem(message, accepted, place, at_key))
        return NOTHING

    def unexpected(self, place: Place, value: object, accepted: str) -> Distribution:
        """Keep the problem that the value at a place is not accepted."""
        self.problems.append(unexpected(value, accepted, place))
        return NOTHING
