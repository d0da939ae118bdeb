"""Manual pages, read from the docstrings and parameters of the components and from the models of a campaign file."""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cache
from importlib import import_module
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from rvjax.campaign import Model, units
from rvjax.campaign.declarations import declared
from rvjax.campaign.distribution_notation import forms
from rvjax.campaign.json_schema import schema
from rvjax.campaign.python_files import PythonFile, read_file, short_name
from rvjax.campaign.reference_body import words
from rvjax.components import user_code
from rvjax.components.manual_examples import Example, mappings
from rvjax.components.manual_keys import Key, flat
from rvjax.components.registry import FAMILIES, FAMILY_OF, Component, choosable, component, family_of, members, module_of, sound

PACKAGE = "rvjax"

CHAPTERS = {
    "dynamics": "physics.dynamics",
    "propellant": "physics.propellant",
    "backstepping": "physics.backstepping",
    "nominal": "campaign.nominal_body",
    "plausibility": "simulation.plausibility",
    "augmented_system": "physics.augmented_system",
    "nussbaum": "physics.nussbaum",
    "control_direction": "physics.control_direction",
    "differentiator": "physics.differentiators",
    "saturation": "physics.saturation",
    "allocation": "physics.thruster_allocation",
    "layout": "campaign.thruster_layout",
    "closed_loop": "simulation.closed_loop",
    "flight": "simulation.flight",
    "rk4": "simulation.rk4",
    "mean_wrench": "simulation.mean_wrench",
    "streams": "stats.random_streams",
    "noise": "physics.noise",
    "margins": "simulation.temporal_margins",
    "signals": "simulation.signals",
    "attitude": "campaign.attitudes",
    "frames": "simulation.start_frames",
    "inertia": "campaign.inertia",
    "csv": "campaign.csv_text",
    "parameters": "campaign.tuning_parameters",
}
"""Name of a page → the module whose docstring it shows. These modules hold equations and belong to no family."""

_KINDS: Mapping[Any, str] = {bool: "true or false", int: "whole number", int | None: "whole number"}

Row = tuple[str, str, str, str]


@dataclass(frozen=True)
class Page:
    """A manual page.

    origin: module; text: equations, meaning, source; rows: the columns of a metric, or parameters as (key, unit in words or
    choices, default, meaning); keys: of a campaign file; members: (name, summary) of a family's members; examples: of campaigns.
    """

    family: str
    name: str
    origin: str
    text: str
    rows: tuple[Row, ...] = ()
    keys: tuple[Key, ...] = ()
    members: tuple[tuple[str, str], ...] = ()
    examples: tuple[Example, ...] = ()

    @property
    def summary(self) -> str:
        """The first line of the text."""
        return self.text.partition("\n")[0]

    @property
    def tables(self) -> list[tuple[tuple[str, ...], list[tuple[str, ...]]]]:
        """(headings, rows) of what is printed below the text: the columns of a metric, and the keys."""
        rows = [(key.path, key.unit, key.default, key.accepted, key.meaning) for key in self.keys]
        columns = [tuple(row) for row in self.rows] if self.family == "metrics" else []
        both = [
            (("column", "unit", "better", "meaning"), columns),
            (("key", "unit", "default", "range or choices", "meaning"), rows),
        ]
        return [(headings, table) for headings, table in both if table]

    def document(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


def components() -> Iterator[tuple[str, str, str]]:
    """(family, name, module) of every component that can be imported."""
    for family in FAMILIES:
        for name in sound(family):
            yield family, name, members(family)[name]


def page(family: str, name: str) -> Page:
    """The manual page of a component, without examples."""
    text, origin = inspect.getdoc(module_of(family, name)) or "", members(family)[name]
    return _page(family, name, origin, text, component(family, name))


def _page(family: str, name: str, origin: str, text: str, member: Any) -> Page:
    """The page of a member."""
    parameters = member.parameters if isinstance(member, Component) else None
    keys = tuple(flat(parameters)) if parameters is not None else ()
    if family != "metrics" and parameters is not None:
        return Page(family, name, origin, text, tuple(rows(parameters)), keys)
    metric: Any = member
    if isinstance(member, Component):
        metric = member.build(member.parameters.model_validate(next(mappings(member.parameters))))
    columns = ((column.name, column.unit, column.better, column.description) for column in metric.columns.values())
    return Page(family, name, origin, text, tuple(columns), keys)


def file_pages(path: str) -> list[Page]:
    """The pages of the components in a user's file, or of `FILE:NAME`. CampaignError where it cannot be executed."""
    file = read_file(path)
    module = user_code.module_of(file)
    held = {name: family_of(value) for name, value in vars(module).items() if family_of(value) in FAMILIES}
    pages: list[Page] = []
    for name, family in held.items():
        if file.member in ("", name):
            member = PythonFile(f"{file.file}:{name}", file.file, name, file.folder, file.sources)
            pages.append(_page(family, short_name(file.file), file.file, inspect.getdoc(module) or "", component(family, member)))
    return pages


def chapter(name: str) -> Page:
    """A page of `CHAPTERS`."""
    origin = f"{PACKAGE}.{CHAPTERS[name]}"
    return Page("chapter", name, origin, inspect.getdoc(import_module(origin)) or "")


def distribution(name: str) -> Page:
    """The page of a distribution."""
    notation, law = forms()[name]
    return Page("distribution", name, law.__module__, f"{notation}\n\n{inspect.getdoc(law) or ''}")


@cache
def component_pages() -> tuple[Page, ...]:
    """The page of every component."""
    return tuple(page(family, name) for family, name, _ in components())


def metric_names(pages: Iterable[Page]) -> set[str]:
    """Names of the columns on pages of metrics, with and without the channel: saturation_duty.fx and saturation_duty."""
    columns = {row[0] for page in pages if page.family == "metrics" for row in page.rows}
    return columns | {column.partition(".")[0] for column in columns}


def campaign_schema() -> dict[str, Any]:
    """The JSON Schema of a campaign file, with the parameters of every installed component."""
    families: dict[str, Mapping[str, type[Model]]] = {
        section: {name: member.parameters for name, member in choosable(family).items()} for section, family in FAMILY_OF.items()
    }
    return schema(families)


def rows(model: type[Model], prefix: str = "") -> Iterator[Row]:
    """(key, unit in words or choices, default, meaning) of the keys of a model: the rows of `rvjax explain --json`."""
    for key, info in model.keys().items():
        inner = info.annotation
        if inspect.isclass(inner) and issubclass(inner, Model):
            yield from rows(inner, f"{prefix}{key}.")
            continue
        yield f"{prefix}{key}", _accepted(key, info), _default(info), info.description or ""


def _default(info: FieldInfo) -> str:
    """The default as a campaign would say it, or in words where it follows the nominal body."""
    declaration = declared(info)
    if declaration is not None and declaration.follows is not None:
        return words(info.default, declaration.follows)
    return "required" if info.is_required() else json.dumps(info.default, ensure_ascii=False)


def _accepted(key: str, info: FieldInfo) -> str:
    """The unit of a number, or the words that an option accepts."""
    unit, declaration = units.split(key)[1], declared(info)
    if declaration and unit is units.NONE and declaration.symbol != unit.symbol:
        return declaration.symbol
    if declaration or unit is not units.NONE:
        return unit.name
    if get_origin(info.annotation) is Literal:
        return ", ".join(map(str, get_args(info.annotation)))
    return _KINDS.get(info.annotation, "")
