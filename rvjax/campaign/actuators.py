"""Actuators of a campaign: a wrench with limits on its six channels, or thrusters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BeforeValidator, ValidationError, ValidationInfo, model_validator

from rvjax.campaign.choice import Choice, OneChoice
from rvjax.campaign.distributions import Fixed
from rvjax.campaign.fields import Model, channels, number, option, part, scalar
from rvjax.campaign.plain_values import exact, is_mapping
from rvjax.campaign.problems import Problem, refuse
from rvjax.campaign.quantity import Quantity
from rvjax.campaign.short_choices import ALLOCATION
from rvjax.campaign.thruster_layout import FEWEST, LAYOUTS, MOST, Layout, Margin, limits, margins, rank
from rvjax.campaign.triples import Direction, Triple
from rvjax.columns import CHANNELS
from rvjax.elementary import length


class Actuators(Model):
    """−lower ≤ commanded wrench ≤ upper on each channel, each of the twelve limits times an independent draw of spread."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"upper": {"force": 4, "torque": 0.8}, "lower": {"force": 3, "torque": 0.6}},
    )

    upper: Quantity = channels("N, N·m", above=0.0, doc="upper limits")
    lower: Quantity = channels("N, N·m", above=0.0, doc="lower limits, as positive numbers")
    spread: Quantity = scalar("1", default=1.0, above=0.0, doc="factor on each limit, drawn independently for each")

    @property
    def losses(self) -> list[Margin]:
        """Empty: without thrusters there are no single losses to compare."""
        return []

    def _quantities(self, prefix: str) -> Iterator[tuple[str, Quantity]]:
        """With the spread of each of the twelve limits: `spread.upper` and `spread.lower`."""
        six = replace(self.spread, shape="channels", parts=self.spread.parts * 6)
        limits = {"upper": self.upper, "lower": self.lower, "spread.upper": six, "spread.lower": six}
        yield from ((prefix + name, quantity) for name, quantity in limits.items())


class Thruster(Model):
    """One thruster: it pushes the spacecraft at `at_m` along `along`, between nothing and `max_N`."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"at_m": [0.5, 0.5, 0], "along": [-1, 0, 0], "max_N": 2},)

    at_m: Triple = option(doc="place from the reference point, in the pursuer's frame [m]")
    along: Direction = option(doc="direction of the force on the spacecraft, of any length but 0")
    max_N: float = number("N", above=0.0, doc="largest thrust")


class Thrusters(Model):
    """Thrusters, which only push: a named layout with size_m and max_N, or a list of them. See `rvjax explain layout`."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"layout": "cube-24", "size_m": 1, "max_N": 2},
        {"layout": "cube-24", "size_m": 1, "max_N": 2, "least_margin": 0.5},
        {"thrusters": LAYOUTS["pinwheel-12"](1.0, 2.0).entries},
    )

    use: Literal["thrusters"] = option(doc="thrusters; without this key: a wrench with upper and lower limits")
    layout: Literal["cube-24", "pinwheel-12"] | None = option(default=None, doc="where the thrusters are; or else `thrusters`")
    size_m: float | None = number("m", default=None, above=0.0, doc="edge of the cube of a layout")
    max_N: float | None = number("N", default=None, above=0.0, doc="largest thrust of each thruster of a layout")
    thrusters: tuple[Thruster, ...] = part(default=[], doc=f"{FEWEST} to {MOST} thrusters, instead of a layout")
    allocation: Annotated[Choice, OneChoice(ALLOCATION)] = part(
        default="bounded-least-squares", doc="how the commanded wrench becomes thrusts: a name, or use with parameters"
    )
    spread: Quantity = scalar("1", default=1.0, above=0.0, doc="factor on each largest thrust, drawn independently for each")
    least_margin: float | None = number(
        "1",
        default=None,
        at_least=0.0,
        at_most=1.0,
        doc="share of every limit that must remain after the loss of any thruster",
    )

    @classmethod
    def _instead(cls, key: str) -> str:
        """As of every model; `centre` is a parameter of an allocation."""
        return "accepted: allocation: {use: pseudo-inverse, centre: 0.5}" if key == "centre" else super()._instead(key)

    @model_validator(mode="after")
    def _able(self) -> Self:
        self._either_layout_or_list()
        at: tuple[str, ...] = ("thrusters",) if self.thrusters else ("layout",)
        layout = self.geometry
        if (spanned := rank(layout)) < 6:
            refuse(Problem(f"these thrusters span {spanned} of the six directions of force and torque", "accepted: all six", at))
        sides = zip((*("+" + name for name in CHANNELS), *("-" + name for name in CHANNELS)), _both(layout), strict=True)
        if missing := [side for side, limit in sides if limit <= 0.0]:
            message = f"with the other five channels at zero these thrusters cannot produce {', '.join(missing)}"
            refuse(Problem(message, "accepted: thrusters that can produce a wrench in every direction by pushing only", at))
        if self.least_margin is not None:
            worst = min(margins(layout), key=lambda margin: margin.share)
            if worst.share < self.least_margin:
                message = f"without {worst.lost} only {exact(worst.share)} of the limit {worst.channel} remains"
                accepted = f"accepted: at most {exact(worst.share)}, the share that remains after every single loss"
                refuse(Problem(message, accepted, ("least_margin",)))
        return self

    def _either_layout_or_list(self) -> None:
        sizes = {"size_m": self.size_m, "max_N": self.max_N}
        if (self.layout is None) == (not self.thrusters):
            message = "both layout and thrusters" if self.thrusters else "neither layout nor thrusters"
            refuse(Problem(message, "accepted: either layout or thrusters", ("thrusters",), at_key=True))
        if self.layout is not None:
            missing = [key for key, value in sizes.items() if value is None]
            if missing:
                accepted = "accepted: size_m and max_N of a layout"
                refuse(*(Problem("missing", accepted, (key,), at_key=True) for key in missing))
            return
        if unused := [key for key, value in sizes.items() if value is not None]:
            accepted = "accepted: only at_m, along and max_N of each thruster"
            refuse(*(Problem(f"{key} together with a list of thrusters", accepted, (key,), at_key=True) for key in unused))
        if not FEWEST <= len(self.thrusters) <= MOST:
            refuse(Problem(f"found {len(self.thrusters)} thrusters", f"accepted: {FEWEST} to {MOST}", ("thrusters",)))

    @property
    def geometry(self) -> Layout:
        """Nominal places, directions and largest thrusts."""
        if self.layout is not None:
            assert self.size_m is not None
            assert self.max_N is not None
            return LAYOUTS[self.layout](self.size_m, self.max_N)
        along = [np.array(thruster.along) / length(*thruster.along) for thruster in self.thrusters]
        return Layout(
            tuple(thruster.at_m for thruster in self.thrusters),
            tuple((float(x), float(y), float(z)) for x, y, z in along),
            tuple(thruster.max_N for thruster in self.thrusters),
        )

    @property
    def losses(self) -> list[Margin]:
        """The margin after the loss of each single thruster."""
        return list(margins(self.geometry))

    @property
    def upper(self) -> Quantity:
        """Nominal upper limits of the channels."""
        return self._limit(0, "upper limits")

    @property
    def lower(self) -> Quantity:
        """Nominal lower limits of the channels, as positive numbers."""
        return self._limit(1, "lower limits, as positive numbers")

    def _limit(self, side: int, doc: str) -> Quantity:
        return Quantity("channels", tuple(map(Fixed, limits(self.geometry)[side])), None, "N, N·m", doc)

    def _quantities(self, prefix: str) -> Iterator[tuple[str, Quantity]]:
        """The spread of each thruster."""
        yield f"{prefix}spread", replace(self.spread, shape="thrusters", parts=self.spread.parts * len(self.geometry.most))


def _both(layout: Layout) -> tuple[float, ...]:
    upper, lower = limits(layout)
    return (*upper, *lower)


def _form(raw: Any, info: ValidationInfo) -> Any:
    """Reads thrusters if the entry has the key `use`, or else limits of the six channels."""
    if isinstance(raw, Model):
        return raw
    form = Thrusters if is_mapping(raw) and "use" in raw else Actuators
    return form.model_validate(raw, context=info.context)


AnyActuators = Annotated[Actuators | Thrusters, BeforeValidator(_form)]


def thruster_layout(raw: Any) -> Layout | None:
    """The nominal thrusters of the section `actuators`; None where it has none, or wrong ones."""
    if not is_mapping(raw) or "use" not in raw:
        return None
    try:
        return Thrusters.model_validate(raw).geometry
    except ValidationError:
        return None


def actuator_names(raw: Any, layout: Layout | None) -> tuple[str, ...]:
    """The names of the actuators that may fail; empty where the section `actuators` is wrong. layout: its nominal thrusters."""
    if layout is not None:
        return layout.names
    return () if is_mapping(raw) and "use" in raw else CHANNELS
