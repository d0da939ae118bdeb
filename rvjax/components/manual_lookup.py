"""What `rvjax explain NAME` shows: every page under a name, with examples; and every name that has a page.

A name is a component, a family, a metric, a distribution, a chapter of the model, or a key of the campaign file: its path from
any section on (`pursuer.mass_kg`, `gains.k1`), its last part (`mass_kg`), that part without a unit (`mass`), or the name of its
draws.
"""

from __future__ import annotations

import difflib
import inspect
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from rvjax.campaign import Model, Spec, option
from rvjax.campaign.actuators import Thrusters
from rvjax.campaign.distribution_notation import forms
from rvjax.campaign.formula import BOOLEAN, PREDICATE, TEMPORAL, WINDOW
from rvjax.campaign.plain_values import is_mapping
from rvjax.campaign.python_files import is_python_file
from rvjax.campaign.quantity import COMPONENTS
from rvjax.campaign.tuning import Tuning
from rvjax.campaign.tuning_parameters import FORMS
from rvjax.columns import DRAW, METRIC
from rvjax.components import manual
from rvjax.components.manual import CHAPTERS, PACKAGE, Page
from rvjax.components.manual_examples import Example, example, mappings, values
from rvjax.components.manual_keys import Key, Trail, flat, key_of, models_in, names_of, path_of, trails
from rvjax.components.registry import FAMILIES, FAMILY_OF, choosable, component
from rvjax.errors import UsageError

CAMPAIGN_FILE, FAMILY = "campaign file", "family"

SECTIONS: Mapping[str, str] = {**FAMILY_OF, "tune.method": "searches"}
"""Path of a key of the campaign file → the family that its components come from."""

_FIRST = {family: next(iter(choosable(family))) for family in FAMILIES} | {"saturations": "hard-clip"}
"""Family → the member in an example of a section."""

_BESIDES: Mapping[tuple[str, str], Mapping[str, Any]] = {
    ("actuators", "thrusters"): {"faults": []},
    ("sampler", "latin-hypercube"): {"require": []},
    ("sampler", "sobol"): {"require": []},
    ("sampler", "grid"): {"samples": 3, "require": []},
    ("sampler", "plan"): {"samples": 2, "require": []},
    ("sampler", "points"): {"samples": 2, "require": []},
}
"""(section, component) → other sections that must change with it: channels of faults, the number of samples, verdicts."""

_AT_A_PORT: Mapping[str, Any] = {"port_m": [5, 0, 0]}
_IN_FRONT: Mapping[str, Any] = {"frame": "port", "position_m": [20, 0, 0]}
_WITH: Mapping[tuple[str, str], Mapping[str, Mapping[str, Any]]] = {
    ("target", "hull"): {
        "target": _AT_A_PORT,
        "pursuer": {"mass_kg": 100, "inertia_kgm2": {"principal": [22, 20, 23]}, "hull": {"radius_m": 0.7}},
        "start": _IN_FRONT,
    },
    ("pursuer", "hull"): {"target": {**_AT_A_PORT, "hull": {"radius_m": 1.6}}, "start": _IN_FRONT},
    ("target", "keep_out"): {"target": _AT_A_PORT, "start": _IN_FRONT},
}
"""(section, key) → what else a campaign says where it has the key: the hull of the other spacecraft, a docking axis, a start
outside of the hulls and the zone."""


_AROUND: Mapping[str, type[Model]] = {"tune": Tuning, "actuators": Thrusters}
"""Section → the model that holds its component."""


class Chosen(Model):
    """The keys of every component, next to its parameters."""

    use: str = option(doc="name of the component, see `rvjax list`")
    name: str | None = option(default=None, example="second", doc="name in draws and reports; by default that of the component")


def pages_called(name: str) -> list[Page]:
    """Every page under a name, or of the components in a Python file. Errors: UsageError with the nearest names; CampaignError of
    a file."""
    if is_python_file(name):
        return manual.file_pages(name)
    known = index()
    for spelling in _spellings(name):
        if spelling in known:
            return [page for make in known[spelling] for page in make()]
    nearest = ", ".join(difflib.get_close_matches(name, known, n=3))
    advice = f"did you mean {nearest}?" if nearest else "see `rvjax list`, or `rvjax explain campaign` for the campaign file"
    raise UsageError(f"{name}: no component, key of the campaign file or topic has this name; {advice}")


def _spellings(name: str) -> Iterator[str]:
    """The name itself; without the prefix of a table's column; without places in lists and components of vectors."""
    yield name
    plain = name.removeprefix(DRAW).removeprefix(METRIC)
    yield plain
    parts = [part for part in plain.split(".") if not part.isdecimal()]
    yield ".".join(parts)
    while len(parts) > 1 and any(parts[-1] in names for names in COMPONENTS.values()):
        parts.pop()
        yield ".".join(parts)


@cache
def index() -> Mapping[str, list[Any]]:
    """Name → functions that make its pages, in the order in which they are shown."""
    found: dict[str, dict[Any, Any]] = {}

    def add(name: str, key: Any, make: Any) -> None:
        found.setdefault(name, {}).setdefault(key, make)

    for name in CHAPTERS:
        add(name, ("chapter", name), lambda name=name: [manual.chapter(name)])
    for path, family in SECTIONS.items():
        for name in dict.fromkeys((path, path.rpartition(".")[2], family)):
            add(name, ("family", family), lambda path=path, family=family: family_pages(path, family))
    for name in ("metrics", "distributions"):
        add(name, ("family", name), lambda name=name: family_pages("", name))
    for page in manual.component_pages():
        for name in {page.name, *manual.metric_names([page])}:
            add(name, (page.family, page.name), lambda page=page: [with_example(page)])
    for name in forms():
        add(name, ("distribution", name), lambda name=name: [manual.distribution(name)])
    add("campaign", "campaign", lambda: [_of_model("campaign", Spec, ())])
    for path, group in _grouped().items():
        for _, member, names in group:
            for name in names:
                only = member if member in name.split(".") else ""
                add(name, ("key", path, only), lambda path=path, only=only: key_pages(path, only))
    for word, name in _words():
        add(word, ("chapter", name), lambda name=name: [manual.chapter(name)])
    for law, (notation, _) in forms().items():
        for word in re.findall(r"(\w+):", notation):
            add(word, ("distribution", law), lambda law=law: [manual.distribution(law)])
    return {name: list(makers.values()) for name, makers in found.items()}


def _words() -> Iterator[tuple[str, str]]:
    """(word inside a formula, a range of a tuning or a start, chapter that defines it)."""
    for word in ("start", "frame", "relative_to", "lvlh"):
        yield word, "frames"
    for word in (*TEMPORAL, *BOOLEAN, *WINDOW, *PREDICATE, "hold", "reach"):
        yield word, "margins"
    for word in re.findall(r"{(\w+):", FORMS):
        yield word, "parameters"


@cache
def _grouped() -> Mapping[str, list[tuple[Trail, str, set[str]]]]:
    """Path of a key → (trail, component or "", names) of each key with this path."""
    groups: dict[str, list[tuple[Trail, str, set[str]]]] = {}
    for trail in trails(Spec):
        if path_of(trail) not in SECTIONS:
            groups.setdefault(path_of(trail), []).append((trail, "", names_of(trail)))
    for section, family in SECTIONS.items():
        for trail in trails(Chosen):
            names = {f"{section}.{path_of(trail)}", *(names_of(trail) if section != "baselines" else ())}
            groups.setdefault(f"{section}.{path_of(trail)}", []).append((trail, "", names))
        for member, known in choosable(family).items():
            for trail in trails(known.parameters):
                names = set() if section == "baselines" else names_of(trail)
                whole = {name for name in names_of(trail) if name.count(".") == len(trail) - 1}
                starts = (section, f"{section}.{member}", *([member] if section != "baselines" else []))
                names |= {f"{start}.{name}" for name in whole for start in starts}
                groups.setdefault(f"{section}.{path_of(trail)}", []).append((trail, member, names))
    return groups


def with_example(page: Page) -> Page:
    """The page of a component with an example of its section."""
    section = next((path for path, family in SECTIONS.items() if family == page.family), None)
    standard = page.family == "metrics" and page.name not in choosable("metrics")
    return page if section is None or standard else replace(page, examples=(_chosen(section, page.name, ()),))


def family_pages(section: str, family: str) -> list[Page]:
    """A page with the members of a family and the keys that they share, then the page of each member."""
    if family == "distributions":
        listed = [manual.distribution(name) for name in forms()]
        text = "Distributions of drawn numbers. A plain number is fixed."
        return [Page(FAMILY, family, PACKAGE, text, members=tuple((page.name, page.summary) for page in listed)), *listed]
    listed = [page for page in manual.component_pages() if page.family == family]
    summaries = tuple((page.name, page.summary) for page in listed)
    if not section:
        return [Page(FAMILY, family, PACKAGE, "Metrics of a flight, for `require` and `tune`.", members=summaries), *listed]
    shared = [key for key in listed[0].keys if all(key in page.keys for page in listed)]
    keys = (*flat(Chosen), *shared)
    *_, last = next(trail for trail in trails(Spec) if path_of(trail) == section)
    whole = replace(key_of((last,)), path=section, accepted=f"use: {', '.join(page.name for page in listed)}")
    text = f"{(last.info.description or '').capitalize()}. `rvjax explain NAME` has the parameters of a member."
    examples = (_section(section.split(".")),)
    return [Page(FAMILY, section, PACKAGE, text, (), (whole, *keys), summaries, examples), *map(with_example, listed)]


def key_pages(path: str, only: str = "") -> list[Page]:
    """The pages of the keys with a path: for a part of the campaign a page for each form, with its keys; else a row for the
    key, or for each group of components whose keys differ. only: the component to which the key belongs."""
    group = [entry for entry in _grouped()[path] if only in ("", entry[1])]
    trail, member, _ = group[0]
    if inner := models_in(trail[-1].info.annotation):
        return [_of_model(path, model, trail, member) for model in inner]
    said: dict[Key, list[str]] = {}
    for other, use, _ in group:
        said.setdefault(key_of(other, path), []).append(use)
    keys = (replace(key, meaning=f"{key.meaning} ({', '.join(uses)})") if len(said) > 1 else key for key, uses in said.items())
    users = ", ".join(dict.fromkeys(use for _, use, _ in group if use))
    text = f"A key of {users}." if users else "A key of the campaign file."
    return [Page(CAMPAIGN_FILE, path, PACKAGE, text, (), tuple(keys), examples=(_example(path, trail, member),))]


def _of_model(path: str, model: type[Model], trail: Trail, member: str = "") -> Page:
    """The page of a part of the campaign."""
    text, rows = inspect.getdoc(model) or "", tuple(manual.rows(model))
    examples = (_example(path, trail, member, model),) if trail else ()
    return Page(CAMPAIGN_FILE, path, PACKAGE, text, rows, tuple(flat(model)), examples=examples)


def _example(path: str, trail: Trail, member: str, form: type[Model] | None = None) -> Example:
    """The section that shows a key. form: of the key's value, where it is a part of the campaign."""
    keys = [step.key for step in trail]
    if form is not None:
        keys.append(next(iter(form.keys())))
    section = next((name for name in SECTIONS if path.startswith(f"{name}.")), "")
    if not section:
        return _section(keys)
    if trail[0].model is Chosen:
        return _chosen(section, _FIRST[SECTIONS[section]], (), {"name": "second"} if keys == ["name"] else {})
    return _chosen(section, member, keys)


def _chosen(section: str, member: str, keys: Sequence[str], more: Mapping[str, Any] | None = None) -> Example:
    """A section with a component that shows one of its parameters."""
    parameters = next(mappings(component(SECTIONS[section], member).parameters, keys))
    another = {"name": "second"} if section == "baselines" else {}
    chosen = {"use": member, **another, **(more or {}), **parameters}
    *outer, key = section.split(".")
    if outer:
        around = next(mappings(_AROUND[outer[0]]))
        return _besides(outer[0], around | {key: chosen})
    several = isinstance(next(values(Spec, key)), list)
    return _besides(key, [chosen] if several else chosen)


def _section(keys: Sequence[str]) -> Example:
    """A section that shows the key at the end of a trail."""
    return _besides(keys[0], next(values(Spec, keys[0], keys[1:])))


def _besides(section: str, value: Any) -> Example:
    """A section, with others that must change with it."""
    said: Mapping[str, Any] = value if is_mapping(value) else {}
    sections: dict[str, Any] = {section: value, **_BESIDES.get((section, str(said.get("use", ""))), {})}
    for key in said:
        for other, keys in _WITH.get((section, key), {}).items():
            sections[other] = {**keys, **sections.get(other, {})}
    return example(sections)
