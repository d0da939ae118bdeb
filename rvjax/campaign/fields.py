"""Declaring what a part of a campaign may hold: models that are frozen, in SI, and report every problem at once.

    class Parameters(Model):
        \"\"\"d(t) = f sin(w t).\"\"\"

        force_N: Quantity = vector("N", default=0.0, doc="amplitude")
        rate_rad_s: Quantity = scalar("rad/s", key="rate_deg_s", above=0.0, doc="angular frequency")

The attribute has the SI name, which is also the name of the draws; `key` is what a campaign says where that is another
unit. Ranges and defaults are in the unit of the key, as the user writes them. A field without a default is required.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, ClassVar, Required, TypedDict, TypeVar, Unpack, cast

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    ModelWrapValidatorHandler,
    ValidationError,
    create_model,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined, core_schema

from rvjax.campaign import units
from rvjax.campaign.csv_columns import DeclaredSeries
from rvjax.campaign.declarations import Declared, DeclaredNumber, DeclaredQuantity, declared
from rvjax.campaign.distribution_notation import Range, VectorNotation, did_you_mean
from rvjax.campaign.plain_values import Place, is_mapping
from rvjax.campaign.problems import Problem, problems, refuse, unexpected
from rvjax.campaign.quantity import Quantity
from rvjax.campaign.reference_body import Follows, words
from rvjax.campaign.source import Source
from rvjax.columns import CHANNELS
from rvjax.errors import Finding

M = TypeVar("M", bound="Model")

MOST_SUGGESTIONS = 20
"""Unknown keys in a mapping that get a suggestion each; comparing words takes time."""


class Model(BaseModel):
    """A part of a campaign: its keys are its fields, nothing else is accepted, and nothing changes after loading."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=True, protected_namespaces=())

    OTHER_UNITS: ClassVar[Mapping[str, str]] = {}
    """Keys that stand for a field in another unit: omega_deg_s → omega_rad_s."""
    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ()
    """What a campaign may say: each with the required keys that it leaves out is accepted. For the manual."""

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        """A name that ends in a unit must say the SI unit of the field, and `key` the same stem."""
        super().__pydantic_init_subclass__(**kwargs)
        for name, info in cls.model_fields.items():
            known = declared(info)
            (stem, unit), (key_stem, key_unit) = units.split(name), units.split(info.alias or name)
            if known and (unit.si, key_unit.si, key_stem) != (known.unit, known.unit, stem) and unit is not units.NONE:
                raise TypeError(f"{cls.__name__}.{name}: name, key and unit disagree ({unit.si}, {key_unit.si}, {known.unit})")

    @model_validator(mode="wrap")
    @classmethod
    def _report(cls, raw: Any, read: ModelWrapValidatorHandler[Any]) -> Any:
        """Adds unknown and missing keys, with messages that name this model's keys, to the problems of the known keys."""
        if isinstance(raw, cls):
            return raw
        if not is_mapping(raw):
            refuse(unexpected(raw, f"accepted: a mapping with {', '.join(cls.keys())}"))
        keys = cls.keys()
        raw, converted = cls._converted(raw)
        unknown = sorted(raw.keys() - keys.keys())
        missing = [key for key, info in keys.items() if key not in raw and info.is_required()]
        instead = {key: cls._instead(key) for key in unknown[:MOST_SUGGESTIONS]}
        all_keys = f"accepted: {', '.join(keys)}"
        wrong = [*converted]
        wrong += [Problem("unknown key", instead.get(key, all_keys), (key,), at_key=True) for key in unknown]
        wrong += [Problem("missing", f"accepted: {keys[key].description}", (key,), at_key=True) for key in missing]
        absent = {(key,) for key in missing}
        try:
            model = read({key: value for key, value in raw.items() if key in keys})
        except ValidationError as error:
            refuse(*wrong, *(problem for problem in problems(error) if problem.place not in absent))
        return refuse(*wrong) if wrong else model

    @classmethod
    def keys(cls) -> dict[str, FieldInfo]:
        """The fields by the key that a campaign uses."""
        return {info.alias or name: info for name, info in cls.model_fields.items()}

    @classmethod
    def _converted(cls, raw: dict[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
        """The mapping with the field's key in place of each key in another unit, and what is wrong with those."""
        values, wrong = dict(raw), list[Problem]()
        for other, key in cls.OTHER_UNITS.items():
            if other not in raw:
                continue
            del values[other]
            if key in raw:
                wrong.append(
                    Problem(f"both {other} and {key}", f"accepted: one of them, {other} or {key}", (other,), at_key=True)
                )
                continue
            known, unit = declared(cls.keys()[key]), units.split(other)[1]
            assert known is not None, key
            try:
                values[key] = replace(known, factor=unit.factor, symbol=unit.symbol).read(raw[other])
            except ValidationError as error:
                wrong += [problem.below((other,)) for problem in problems(error)]
                values[key] = known.read(0.0)
        return values, wrong

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """The keys in other units are keys too; a field has one of its keys at most."""
        whole = handler.resolve_ref_schema(handler(schema))
        for other, key in cls.OTHER_UNITS.items():
            info, unit = cls.keys()[key], units.split(other)[1]
            known = declared(info)
            assert known is not None, key
            assert not info.is_required(), key
            described = {"description": f"{known.doc} [{unit.symbol}]"}
            whole["properties"][other] = {**replace(known, symbol=unit.symbol).json_schema(), **described}
            whole.setdefault("allOf", []).append({"not": {"required": [key, other]}})
        return whole

    @classmethod
    def _instead(cls, key: str) -> str:
        """The key with the same stem in another unit, or else the most similar key, or else all keys."""
        keys = cls.keys()
        others = {known: units.split(known) for known in keys}
        stems = {known: stem for known, (stem, unit) in others.items() if unit is not units.NONE}
        same = [known for known, stem in stems.items() if key == stem or key.startswith(f"{stem}_")]
        if not same:
            return did_you_mean(key, keys)
        nearest = max(same, key=lambda known: (len(stems[known]), -abs(len(known) - len(key))))
        also = (other for other, known in cls.OTHER_UNITS.items() if known == nearest)
        return " or ".join((f"accepted: {nearest} ({others[nearest][1].name})", *also))

    def quantities(self, prefix: str = "") -> dict[str, Quantity]:
        """Every quantity, fixed or drawn, by its SI name: `target.rate_rad_s`, `pursuer.inertia_kgm2.principal`."""
        return dict(self._quantities(f"{prefix}." if prefix else ""))

    def _quantities(self, prefix: str) -> Iterator[tuple[str, Quantity]]:
        for name in type(self).model_fields:
            value = getattr(self, name)
            if isinstance(value, Quantity):
                yield prefix + name, value
            elif isinstance(value, Model):
                yield from value.quantities(prefix + name).items()


class Declaration(TypedDict, total=False):
    """The arguments of a field. key: if it is not the attribute's name; the range and the default are in the unit of the key.
    follows: the default is for the reference body, and in proportion to the mass or inertia of the campaign's nominal body."""

    key: str
    default: Any
    at_least: float
    above: float
    at_most: float
    below: float
    follows: Follows
    doc: Required[str]


def _field(kind: Callable[..., Declared], unit: str, declaration: Declaration, **more: Any) -> Any:
    key, default = declaration.get("key"), declaration.get("default", PydanticUndefined)
    limits = Range(**{name: declaration.get(name) for name in ("at_least", "above", "at_most", "below")})
    converted = units.split(key)[1] if key else units.Unit(unit, unit, 1.0, unit)
    about = (declaration["doc"], default is None, declaration.get("follows"))
    held = kind(unit, converted.factor, converted.symbol, limits, *about, **more)
    description = declaration["doc"] if unit == "1" else f"{declaration['doc']} [{converted.symbol}]"
    return _info(held, default, key, description)


def _info(held: Declared, default: Any, key: str | None, description: str | None) -> FieldInfo:
    def explain(schema: dict[str, Any]) -> None:
        """The default in words instead of a number, where it follows the nominal body."""
        if held.follows is not None:
            schema["description"] += f"; default: {words(schema.pop('default'), held.follows)}"

    info = cast(FieldInfo, Field(default=default, alias=key, description=description, json_schema_extra=explain))
    info.metadata.append(held)
    return info


def scalar(unit: str, **declaration: Unpack[Declaration]) -> Any:
    """One number, fixed or drawn."""
    return _field(DeclaredQuantity, unit, declaration, shape="scalar")


def vector(unit: str, named: tuple[str, ...] = (), **declaration: Unpack[Declaration]) -> Any:
    """Three numbers x, y, z, fixed or drawn; the range holds for each. named: names of the components, for a mapping."""
    return _field(DeclaredQuantity, unit, declaration, shape="vector", notation=VectorNotation(named))


def attitude(**declaration: Unpack[Declaration]) -> Any:
    """MRP with a norm of at most 1, fixed or drawn, or a fixed attitude in another notation."""
    notation = VectorNotation(attitude=True)
    return _field(DeclaredQuantity, "1", declaration, shape="vector", largest_norm=1.0, notation=notation)


def channels(unit: str, **declaration: Unpack[Declaration]) -> Any:
    """Six numbers fx, fy, fz, tx, ty, tz, fixed or drawn, or for a fault a number per thruster; the range holds for each."""
    return _field(DeclaredQuantity, unit, declaration, shape="channels")


def number(unit: str, **declaration: Unpack[Declaration]) -> Any:
    """One number that is the same in every sample; with `default=None` it may be left out."""
    return _field(DeclaredNumber, unit, declaration)


def series(
    *columns: str, optional: tuple[str, ...] = (), others: bool = False, default: Any = PydanticUndefined, doc: str
) -> Any:
    """The columns of the CSV file that the key `csv` names; with `default=None` it may be left out. optional: may be missing;
    others: any further ones may be there."""
    info = cast(FieldInfo, Field(default=default, alias="csv", description=doc))
    info.metadata.append(DeclaredSeries(columns, optional, others, default is None))
    return info


def count(
    *, default: Any = PydanticUndefined, at_least: int = 0, at_most: int = 2**63 - 1, example: int | None = None, doc: str
) -> Any:
    """A whole number. example: a value for the manual."""
    examples = None if example is None else [example]
    return Field(default=default, strict=True, ge=at_least, le=at_most, examples=examples, description=doc)


def flag(*, default: Any = PydanticUndefined, doc: str) -> Any:
    """true or false."""
    return Field(default=default, strict=True, description=doc)


def option(*, key: str | None = None, default: Any = PydanticUndefined, example: Any = None, doc: str) -> Any:
    """One word out of the field's `Literal`, or something else that its annotation reads. key: if it is not the attribute's name.
    example: a value for the manual."""
    return Field(default=default, alias=key, examples=None if example is None else [example], description=doc)


def part(*, default: Any = PydanticUndefined, example: Any = None, doc: str) -> Any:
    """A nested model or a list of them; the default is what a campaign would say. example: a value for the manual."""
    return option(default=default, example=example, doc=doc)


def with_defaults(model: type[M], **defaults: float) -> type[M]:
    """The model with other defaults, each by the name of its field and in the unit of its key."""
    fields: dict[str, Any] = {}
    for name, default in defaults.items():
        known = model.model_fields[name]
        held = declared(known)
        assert held is not None, f"{model.__name__}.{name} is a number"
        fields[name] = (known.annotation, _info(held, default, known.alias, known.description))
    return create_model(model.__name__, __base__=model, __module__=model.__module__, **fields)


def validate(
    model: type[M], raw: Mapping[str, Any], place: Place, source: Source, names: tuple[str, ...] = CHANNELS
) -> tuple[M | None, list[Finding]]:
    """(model, findings) of the values at a place of a campaign; the model is None if there are any. names: of the actuators."""
    try:
        return model.model_validate(dict(raw), context={"actuators": names}), []
    except ValidationError as error:
        below = (problem.below(place) for problem in problems(error))
        return None, [source.finding(p.place, p.message, p.accepted, p.at_key) for p in below]
