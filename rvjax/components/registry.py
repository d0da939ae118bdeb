"""Families of components: what there is under which name.

A family is a package whose `MEMBERS` is a literal table from the name in a campaign to the module that holds the component as
`COMPONENT`. Other installed packages add members through entry points of the group `rvjax.<family>`. A name that two of them
claim is an error that names both.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, Generic, TypeVar

from rvjax.campaign import Model
from rvjax.errors import UsageError

FAMILIES = ("controllers", "disturbances", "faults", "metrics", "navigation", "samplers", "searches")

FAMILY_OF = {
    "controller": "controllers",
    "baselines": "controllers",
    "faults": "faults",
    "disturbances": "disturbances",
    "navigation": "navigation",
    "sampler": "samplers",
}
"""Section of the campaign file → the family that its components come from."""

_PACKAGES = {"searches": "search_methods"}
"""Family → package in `rvjax.components`, where the two differ."""

P = TypeVar("P", bound=Model)


@dataclass(frozen=True)
class Component(Generic[P]):
    """parameters: what a campaign may say. build(parameters) → the function or functions that fly.

    noisy: its numbers hold `noise` as well, the key of a random stream of its own for every sample (`rvjax.physics.noise`).
    """

    parameters: type[P]
    build: Callable[[P], Any]
    noisy: bool = False


@cache
def members(family: str) -> Mapping[str, str]:
    """Name → where it comes from, in the order of the table; members of other packages after our own.

    Looked up once: going through all installed packages for each component of a long file takes seconds.
    Errors: UsageError if two packages claim one name.
    """
    table = dict(import_module(f"rvjax.components.{_PACKAGES.get(family, family)}").MEMBERS)
    for entry in entry_points(group=f"rvjax.{family}"):
        if entry.name in table:
            both = f"{table[entry.name]} and {entry.value}"
            raise UsageError(f"two components claim the name {entry.name!r} in rvjax.{family}: {both}")
        table[entry.name] = entry.value
    return table


def module_of(family: str, name: str) -> Any:
    """The module of a member; its docstring is the member's manual page."""
    return import_module(members(family)[name].partition(":")[0])


def component(family: str, name: str) -> Any:
    """The member `name`, which must exist: a `Component`, in the family of metrics a `Metric`."""
    return module_of(family, name).COMPONENT
