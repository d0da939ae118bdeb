"""What a field of a campaign holds: a number or a quantity, its unit, range and meaning. It reads the field and describes it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from pydantic import GetJsonSchemaHandler, ValidationInfo
from pydantic.fields import FieldInfo
from pydantic_core import core_schema

from rvjax.campaign.attitudes import attitude_forms
from rvjax.campaign.distribution_notation import PLAIN, Range, Reader, VectorNotation, with_unit
from rvjax.campaign.json_forms import distribution, drawn_attitude, joint_distribution
from rvjax.campaign.plain_values import exact, is_number
from rvjax.campaign.problems import Problem, refuse, unexpected
from rvjax.campaign.quantity import Quantity, Shape
from rvjax.campaign.reference_body import Follows
from rvjax.campaign.thruster_layout import MOST
from rvjax.columns import CHANNELS


@dataclass(frozen=True)
class Declared(ABC):
    """What a field holds. unit: SI; symbol: of the key's unit; factor: to SI; optional: may be left out; follows: what of the
    campaign's nominal body the default is in proportion to."""

    unit: str
    factor: float
    symbol: str
    range: Range
    doc: str
    optional: bool
    follows: Follows | None

    @abstractmethod
    def read(self, raw: Any) -> Any:
        """The field's value in SI, or every problem at once."""

    @abstractmethod
    def json_schema(self) -> dict[str, Any]:
        """What the key accepts, as JSON Schema."""

    def flown(self, names: tuple[str, ...]) -> Declared:
        """The same field for the actuators of the campaign, by their names."""
        del names
        return self

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        def read(raw: Any, info: ValidationInfo) -> Any:
            return self.flown(actuators(info)).read(raw)

        return core_schema.with_info_plain_validator_function(read)

    def __get_pydantic_json_schema__(self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return self.json_schema()

    def bounds(self) -> dict[str, Any]:
        """A plain number inside the range, as JSON Schema."""
        words = {"at_least": "minimum", "above": "exclusiveMinimum", "at_most": "maximum", "below": "exclusiveMaximum"}
        limits = {words[name]: value for name, value in vars(self.range).items() if value is not None}
        return {"type": "number", **limits}


@dataclass(frozen=True)
class DeclaredNumber(Declared):
    """A fixed number."""

    def read(self, raw: Any) -> float | None:
        """The number in SI; None only where the field may be left out."""
        if raw is None and self.optional:
            return None
        if not is_number(raw) or not self.range.admits(raw, raw):
            limits = self.range.words(self.symbol)
            number = f"a number {limits}" if limits else with_unit("a number", self.symbol, " in ")
            refuse(unexpected(raw, f"accepted: {number}"))
        return raw * self.factor

    def json_schema(self) -> dict[str, Any]:
        return {"anyOf": [self.bounds(), {"type": "null"}]} if self.optional else self.bounds()


@dataclass(frozen=True)
class DeclaredQuantity(Declared):
    """A quantity, fixed or drawn. largest_norm: upper limit of |X|, in the unit of the key; thrusters: their number;
    notation: further notations of a vector."""

    shape: Shape
    largest_norm: float | None = None
    thrusters: int = 0
    notation: VectorNotation = PLAIN

    def flown(self, names: tuple[str, ...]) -> Declared:
        """One number per thruster instead of per channel, where thrusters fly."""
        if self.shape != "channels" or names == CHANNELS:
            return self
        return replace(self, shape="thrusters", thrusters=len(names))

    def read(self, raw: Any) -> Quantity | None:
        """The quantity in SI; None only where the field may be left out."""
        if isinstance(raw, Quantity) or (raw is None and self.optional):
            return raw
        reader = Reader(self.symbol, self.range)
        parts, joint = reader.quantity(self.shape, raw, self.thrusters, self.notation)
        if reader.problems:
            refuse(*reader.problems)
        quantity = Quantity(self.shape, parts, joint, self.unit, self.doc)
        if self.largest_norm is not None and quantity.largest_norm > self.largest_norm:
            most = with_unit(exact(self.largest_norm), self.symbol)
            message = f"the norm reaches {with_unit(exact(quantity.largest_norm), self.symbol)}"
            refuse(Problem(message, f"accepted: a norm of at most {most} in every draw"))
        try:
            scaled = tuple(part.scaled(self.factor) for part in parts)
            return replace(quantity, parts=scaled, joint=joint and joint.scaled(self.factor))
        except ValueError as error:
            refuse(Problem(f"in {self.unit}, {error}", "accepted: a wider range"))

    def json_schema(self) -> dict[str, Any]:
        nothing = [{"type": "null"}] if self.optional else []
        scalar = {"anyOf": [self.bounds(), distribution(), *nothing]}
        if self.shape == "scalar":
            return scalar
        if self.shape == "vector":
            return {"anyOf": [*scalar["anyOf"], _list_of(scalar, 3), joint_distribution(), *self._more_forms(scalar)]}
        half = {"anyOf": [*scalar["anyOf"], _list_of(scalar, 3)]}
        halves = {
            "properties": {"force": half, "torque": half},
            "required": ["force", "torque"],
            "additionalProperties": False,
        }
        return {"anyOf": [*scalar["anyOf"], _list_of(scalar, 6, MOST), {"type": "object", **halves}]}

    def _more_forms(self, scalar: dict[str, Any]) -> list[dict[str, Any]]:
        """The further notations of a vector, as JSON Schema."""
        forms = [drawn_attitude()] if self.unit == "1" else []
        forms += attitude_forms() if self.notation.attitude else []
        if names := self.notation.named:
            keys = dict.fromkeys(names, scalar)
            forms.append({"type": "object", "properties": keys, "required": list(names), "additionalProperties": False})
        return forms


def _list_of(items: dict[str, Any], count: int, most: int = 0) -> dict[str, Any]:
    return {"type": "array", "items": items, "minItems": count, "maxItems": most or count}


def actuators(info: ValidationInfo) -> tuple[str, ...]:
    """The names of the campaign's actuators: the channels unless `validate` got other names."""
    context: Mapping[str, Any] = info.context or {}
    return context.get("actuators", CHANNELS)


def declared(info: FieldInfo) -> Declared | None:
    """What a field holds, where it is a number or a quantity."""
    return next((item for item in info.metadata if isinstance(item, Declared)), None)
