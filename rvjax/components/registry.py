"""Registry of the components, by family and name.

A family is a package. Its table `MEMBERS` maps each name in a campaign to a module, which holds the component as `COMPONENT`.
Other installed packages add members through entry points of the group `rvjax.<family>`. Two components with the same name are an
error.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, Generic, TypeVar

from rvjax.campaign import Model, Spec
from rvjax.campaign.problems import Problem
from rvjax.components.effect import Neutral
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
"""Family → package in `rvjax.components`, where the names differ."""

P = TypeVar("P", bound=Model)


def _no_problems(parameters: Model, spec: Spec) -> Iterable[Problem]:
    """The default of the checks of a component."""
    del parameters, spec
    return ()


@dataclass(frozen=True)
class Component(Generic[P]):
    """parameters: the model of its section in a campaign. build(parameters) → the functions that a flight calls.

    noisy: its numbers also hold `noise`, the key of a random stream that is different in every sample (`rvjax.physics.noise`).
    neutral: the values with which it does nothing. silent(parameters, campaign): why else it does nothing in any sample.
    coarse(parameters, campaign): what of it the steps of the integration cannot follow. Both without a flight.
    """

    parameters: type[P]
    build: Callable[[P], Any]
    noisy: bool = False
    neutral: Neutral = ()
    silent: Callable[[P, Spec], Iterable[Problem]] = _no_problems
    coarse: Callable[[P, Spec], Iterable[Problem]] = _no_problems


@cache
def members(family: str) -> Mapping[str, str]:
    """Name → module, in the order of the table; members from other packages come last.

    Cached: searching all installed packages for each component of a long campaign takes seconds.
    Errors: UsageError if two components have the same name.
    """
    table = dict(import_module(f"rvjax.components.{_PACKAGES.get(family, family)}").MEMBERS)
    for entry in entry_points(group=f"rvjax.{family}"):
        if entry.name in table:
            both = f"{table[entry.name]} and {entry.value}"
            raise UsageError(f"two components have the name {entry.name!r} in rvjax.{family}: {both}")
        table[entry.name] = entry.value
    return table


def module_of(family: str, name: str) -> Any:
    """The module of a member. Its docstring is the manual page."""
    return import_module(members(family)[name].partition(":")[0])


def component(family: str, name: str) -> Any:
    """The member `name`, which must exist: a `Metric` in the family of metrics, else a `Component`."""
    return module_of(family, name).COMPONENT
