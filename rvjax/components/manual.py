"""Manual pages and the JSON Schema of a campaign file, read from the docstrings and parameters of the components."""

from __future__ import annotations

import difflib
import inspect
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from rvjax.campaign import Model, Spec, units
from rvjax.campaign.distribution_notation import forms
from rvjax.campaign.fields import declared
from rvjax.campaign.json_schema import schema
from rvjax.campaign.reference_body import words
from rvjax.components.registry import FAMILIES, FAMILY_OF, Component, component, members, module_of
from rvjax.errors import UsageError
from rvjax.physics import saturation
from rvjax.physics.saturation import SATURATIONS

PACKAGE = "rvjax"

CHAPTERS = {
    "dynamics": "physics.dynamics",
    "backstepping": "physics.backstepping",
    "nominal": "campaign.nominal_body",
    "plausibility": "simulation.plausibility",
    "nussbaum": "physics.nussbaum",
    "differentiator": "physics.differentiators",
    "saturation": "physics.saturation",
    "allocation": "physics.thruster_allocation",
    "layout": "campaign.thruster_layout",
    "closed_loop": "simulation.closed_loop",
    "flight": "simulation.flight",
    "rk4": "simulation.rk4",
    "streams": "stats.random_streams",
    "noise": "physics.noise",
    "margins": "simulation.temporal_margins",
    "signals": "simulation.signals",
    "attitude": "campaign.attitudes",
    "inertia": "campaign.inertia",
    "csv": "campaign.csv_text",
}
"""Name of a page → the module whose docstring it shows. These modules hold equations and belong to no family."""

_KINDS: Mapping[Any, str] = {bool: "true or false", int: "whole number", int | None: "whole number"}


@dataclass(frozen=True)
class Page:
    """A manual page. origin: module; text: equations, meaning, source; rows: cells below `headings`."""

    family: str
    name: str
    origin: str
    text: str
    rows: tuple[tuple[str, str, str, str], ...]

    @property
    def summary(self) -> str:
        """The first line of the text."""
        return self.text.partition("\n")[0]

    @property
    def headings(self) -> tuple[str, str, str, str]:
        """Headings of the rows: the columns of a metric, or the parameters of anything else."""
        return ("column", "unit", "better", "meaning") if self.family == "metrics" else ("key", "accepted", "default", "meaning")


def components() -> Iterator[tuple[str, str, str]]:
    """(family, name, module) of every component."""
    for family in FAMILIES:
        for name, origin in members(family).items():
            yield family, name, origin
    for name in SATURATIONS:
        yield "saturation", name, saturation.__name__


def page(family: str, name: str) -> Page:
    """The manual page of a component."""
    if family == "saturation":
        return Page(family, name, saturation.__name__, inspect.getdoc(SATURATIONS[name]) or "", ())
    module = module_of(family, name)
    member = component(family, name)
    if isinstance(member, Component):
        rows = tuple(_rows(member.parameters))
    else:
        rows = tuple((column.name, column.unit, column.better, column.description) for column in member.columns.values())
    return Page(family, name, members(family)[name], inspect.getdoc(module) or "", rows)


def pages_called(name: str) -> list[Page]:
    """Every page under a name: a component, a metric, a chapter of the model, a distribution, a section of the campaign file.

    Errors: UsageError with the nearest names.
    """
    all_pages = [page(family, member) for family, member, _ in components()]
    pages = [member for member in all_pages if name in (member.name, member.family)]
    pages += [member for member in all_pages if member not in pages and name in _metric_names(member)]
    if name in CHAPTERS:
        origin = f"{PACKAGE}.{CHAPTERS[name]}"
        pages.insert(0, Page("chapter", name, origin, inspect.getdoc(import_module(origin)) or "", ()))
    distributions = forms()
    if name in distributions:
        notation, distribution = distributions[name]
        text = f"{notation}\n\n{inspect.getdoc(distribution) or ''}"
        pages.append(Page("distribution", name, distribution.__module__, text, ()))
    sections = {"campaign": Spec, **{key: info.annotation for key, info in Spec.keys().items()}}
    section = sections.get(name)
    for model in (section, *get_args(section)):  # a section with several forms has a page for each form
        if inspect.isclass(model) and issubclass(model, Model):
            pages.append(Page("campaign file", name, PACKAGE, inspect.getdoc(model) or "", tuple(_rows(model))))
    if not pages:
        names = {member.name for member in all_pages} | sections.keys() | distributions.keys() | CHAPTERS.keys()
        nearest = ", ".join(difflib.get_close_matches(name, names.union(*map(_metric_names, all_pages)), n=3))
        advice = f"did you mean {nearest}?" if nearest else "see `rvjax list`"
        raise UsageError(f"{name}: no component or topic has this name; {advice}")
    return pages


def campaign_schema() -> dict[str, Any]:
    """The JSON Schema of a campaign file, with the parameters of every installed component."""
    families: dict[str, Mapping[str, type[Model]]] = {
        section: {name: component(family, name).parameters for name in members(family)} for section, family in FAMILY_OF.items()
    }
    return schema(families | {"saturation": dict.fromkeys(SATURATIONS, Model)})


def _metric_names(page: Page) -> set[str]:
    """Names of the columns on a metric's page, with and without the channel: saturation_duty.fx and saturation_duty."""
    columns = {row[0] for row in page.rows} if page.family == "metrics" else set[str]()
    return columns | {column.partition(".")[0] for column in columns}


def _rows(model: type[Model], prefix: str = "") -> Iterator[tuple[str, str, str, str]]:
    for key, info in model.keys().items():
        inner = info.annotation
        if inspect.isclass(inner) and issubclass(inner, Model):
            yield from _rows(inner, f"{prefix}{key}.")
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
