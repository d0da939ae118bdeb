"""Manual pages of the components, and the JSON Schema of a campaign file: written where the component is, read here."""

from __future__ import annotations

import difflib
import inspect
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any, get_args

from rvjax.campaign import Model, Spec, units
from rvjax.campaign.distribution_notation import forms
from rvjax.campaign.json_schema import schema
from rvjax.components.registry import FAMILIES, FAMILY_OF, Component, component, members, module_of
from rvjax.errors import UsageError
from rvjax.physics import saturation
from rvjax.physics.saturation import SATURATIONS

HERE = "rvjax"

CHAPTERS = {
    "dynamics": "physics.dynamics",
    "backstepping": "physics.backstepping",
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
}
"""Name of a page → the module whose docstring it shows: modules with equations that belong to no family."""


@dataclass(frozen=True)
class Page:
    """text: equations, meaning, source. rows: (key, accepted, default, meaning) of the parameters, or columns of a metric."""

    family: str
    name: str
    origin: str
    text: str
    rows: tuple[tuple[str, str, str, str], ...]

    @property
    def summary(self) -> str:
        """The first line of the text."""
        return self.text.partition("\n")[0]


def components() -> Iterator[tuple[str, str, str]]:
    """(family, name, where it comes from) of every component."""
    for family in FAMILIES:
        for name, origin in members(family).items():
            yield family, name, origin
    for name in SATURATIONS:
        yield "saturation", name, saturation.__name__


def page(family: str, name: str) -> Page:
    """The manual page of one component."""
    if family == "saturation":
        return Page(family, name, saturation.__name__, inspect.getdoc(SATURATIONS[name]) or "", ())
    module = module_of(family, name)
    found = component(family, name)
    if isinstance(found, Component):
        rows = tuple(_rows(found.parameters))
    else:
        rows = tuple((column.name, column.unit, column.better, column.description) for column in found.columns.values())
    return Page(family, name, members(family)[name], inspect.getdoc(module) or "", rows)


def pages_called(name: str) -> list[Page]:
    """Every page under a name: a component, a metric, a chapter of the model, a distribution, a section of the campaign file.

    Errors: UsageError naming what is near.
    """
    pages = [page(family, known) for family, known, _ in components()]
    fields = {"campaign": Spec, **{key: info.annotation for key, info in Spec.keys().items()}}
    section = fields.get(name)
    found = [one for one in pages if name in (one.name, one.family)]
    found += [one for one in pages if one.family == "metrics" and one not in found and _gives(one, name)]
    if name in CHAPTERS:
        origin = f"{HERE}.{CHAPTERS[name]}"
        found.insert(0, Page("chapter", name, origin, inspect.getdoc(import_module(origin)) or "", ()))
    laws = forms()
    if name in laws:
        form, law = laws[name]
        found.append(Page("distribution", name, law.__module__, f"{form}\n\n{inspect.getdoc(law) or ''}", ()))
    for form in (section, *get_args(section)):  # the second of several forms, and so on, has a page of its own
        if inspect.isclass(form) and issubclass(form, Model):
            found.append(Page("campaign file", name, HERE, inspect.getdoc(form) or "", tuple(_rows(form))))
    if not found:
        known = {one.name for one in pages} | fields.keys() | laws.keys() | CHAPTERS.keys()
        known |= {row[0].partition(".")[0] for one in pages if one.family == "metrics" for row in one.rows}
        near = ", ".join(difflib.get_close_matches(name, known, n=3))
        raise UsageError(f"{name}: nothing is called so; {f'did you mean {near}?' if near else 'see `rvjax list`'}")
    return found


def campaign_schema() -> dict[str, Any]:
    """The JSON Schema of a campaign file, with the parameters of every component that is installed."""
    families: dict[str, Mapping[str, type[Model]]] = {
        section: {name: component(family, name).parameters for name in members(family)} for section, family in FAMILY_OF.items()
    }
    return schema(families | {"saturation": dict.fromkeys(SATURATIONS, Model)})


def _gives(one: Page, metric: str) -> bool:
    return any(metric in (row[0], row[0].partition(".")[0]) for row in one.rows)


def _rows(model: type[Model], prefix: str = "") -> Iterator[tuple[str, str, str, str]]:
    for key, info in model.keys().items():
        inner = info.annotation
        if inspect.isclass(inner) and issubclass(inner, Model):
            yield from _rows(inner, f"{prefix}{key}.")
            continue
        default = "required" if info.is_required() else json.dumps(info.default, ensure_ascii=False)
        yield f"{prefix}{key}", units.split(key)[1].name, default, info.description or ""
