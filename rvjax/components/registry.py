"""Registry of the components, by family and name.

A family is a package. Its table `MEMBERS` maps each name in a campaign to a module, which holds the component as `COMPONENT`.
Other installed packages add members through entry points of the group `rvjax.<family>`. Two components with the same name are an
error.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, ClassVar, Generic, TypeVar

from rvjax.campaign import Model, Spec
from rvjax.campaign.problems import Problem
from rvjax.campaign.python_files import PythonFile
from rvjax.components import installed_code, user_code
from rvjax.components.effect import Neutral
from rvjax.components.forms.form import note_origin
from rvjax.components.user_mistakes import UserMistake, given_by
from rvjax.errors import CampaignError, Finding, UsageError

FAMILIES = (
    *("actuators", "allocations", "controllers", "disturbances", "effects", "faults", "guidance"),
    *("metrics", "navigation", "samplers", "saturations", "searches"),
)

FAMILY_OF = {
    "controller": "controllers",
    "baselines": "controllers",
    "actuation": "actuators",
    "faults": "faults",
    "disturbances": "disturbances",
    "effects": "effects",
    "navigation": "navigation",
    "guidance": "guidance",
    "metrics": "metrics",
    "saturation": "saturations",
    "actuators.allocation": "allocations",
    "sampler": "samplers",
}
"""Section of the campaign file → the family that its components come from."""

_PACKAGES = {"searches": "search_methods"}
"""Family → package in `rvjax.components`, where the names differ."""

ANY = "any family"
"""The family of a component that does not say it."""

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
    coarse(parameters, campaign): what of it the steps of the integration cannot follow. unfit(parameters, campaign): why the
    campaign is refused with it. All without a flight.
    """

    family: ClassVar[str] = ANY

    parameters: type[P]
    build: Callable[[P], Any]
    noisy: bool = False
    neutral: Neutral = ()
    silent: Callable[[P, Spec], Iterable[Problem]] = _no_problems
    coarse: Callable[[P, Spec], Iterable[Problem]] = _no_problems
    unfit: Callable[[P, Spec], Iterable[Problem]] = _no_problems

    def __post_init__(self) -> None:
        note_origin(self)


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


def foreign(spec: Spec) -> Iterator[PythonFile | str]:
    """What of a campaign's components is not of this package: each file of a user, and the module of each installed one."""
    uses = [(FAMILY_OF.get(choice.section, ""), choice.use) for choice in spec.components]
    for family, use in (*uses, *(("metrics", name) for name in members("metrics"))):
        if isinstance(use, PythonFile):
            yield use
        elif family and not (origin := members(family)[use].partition(":")[0]).startswith("rvjax."):
            yield origin


def module_of(family: str, name: str) -> Any:
    """The module of a member. Its docstring is the manual page."""
    if isinstance(name, PythonFile):
        return user_code.module_of(name)
    origin = members(family)[name].partition(":")[0]
    return import_module(origin) if origin.startswith("rvjax.") else installed_code.imported(origin)


def component(family: str, name: str) -> Any:
    """The member `name`, which must exist: a `Metric` in the family of metrics, else a `Component`."""
    if isinstance(name, PythonFile):
        return _of_file(family, name)
    origin = members(family)[name]
    return member_of(module_of(family, name), origin.partition(":")[2], family, origin)


def _of_file(family: str, file: PythonFile) -> Any:
    """The component of a family in a user's file. CampaignError with the file and the line where there is none."""
    module = user_code.module_of(file)
    try:
        value = _object_of(module, file.member, family, file.file)
        if not hasattr(value, "component") and not isinstance(value, Component):
            name = next(name for name, held in vars(module).items() if held is value)
            raise UsageError(f"{file.file}: {name} has no parameters; accepted: {_EXAMPLES[family]}")
    except UsageError as error:
        path = file.path(file.file)
        found, _, accepted = str(error).removeprefix(f"{file.file}: ").partition("; ")
        raise CampaignError([Finding(f"{path}:1", "", found, accepted)]) from None
    if not isinstance(value, Component):
        return user_code.guarded(file, family, value.component)
    made: Component[Any] = value

    def build(parameters: Any) -> Any:
        with given_by(made.build):
            return _of_interface(made.build(parameters), made.build.__name__, family)

    return user_code.guarded(file, family, replace(made, build=build))


def _of_interface(built: Any, name: str, family: str) -> Any:
    """What a component built, whose results are checked. UserMistake where it is not of the family. name: of what built it."""
    kind = family_built(built)
    if (kind == ANY and not callable(built)) or (kind not in (family, ANY) and family != ANY):
        accepted = f"accepted: {_INTERFACES.get(family, 'what an interface of rvjax.components says')}"
        raise UserMistake(f"{name} returns {'None' if built is None else f'a {type(built).__name__}'}", accepted)
    return import_module("rvjax.components.forms.member_results").checked(built)  # imports JAX, which few commands need


_INTERFACES = {
    "controllers": "a Controller or DiscreteController of rvjax.components.controllers.interface",
    "actuators": "an Actuator of rvjax.components.actuators.interface",
    "effects": "an Effect of rvjax.components.effects.interface",
    "faults": "a Fault of rvjax.components.faults.interface",
    "disturbances": "a Disturbance of rvjax.components.disturbances.interface",
    "navigation": "a NavigationError of rvjax.components.navigation.interface",
    "guidance": "a Guidance of rvjax.components.guidance.interface",
    "saturations": "a function",
}
"""What `build` gives, by family."""


def standard_metrics(given: Callable[[str], bool] = lambda place: False) -> tuple[Any, ...]:
    """The metrics without parameters, which are on in every campaign that has what they need. given: whether a campaign has a
    place."""
    metrics = (metric for metric in sound(family="metrics").values() if not isinstance(metric, Component))
    return tuple(metric for metric in metrics if all(map(given, metric.needs)))


def choosable(family: str) -> dict[str, Component[Any]]:
    """Name → component of every member that a campaign can choose: of the metrics only those with parameters."""
    return {name: member for name, member in sound(family).items() if isinstance(member, Component)}


def sound(family: str) -> dict[str, Any]:
    """Name → component of every member that can be imported: a broken package of somebody breaks nothing else."""
    return _tried(family)[0]


def broken(family: str) -> dict[str, str]:
    """Name → message of every member that cannot be used."""
    return _tried(family)[1]


def _tried(family: str) -> tuple[dict[str, Any], dict[str, str]]:
    """(name → component of those that can be used, name → message of those that cannot)."""
    usable: dict[str, Any] = {}
    wrong: dict[str, str] = {}
    for name in members(family):
        try:
            usable[name] = component(family, name)
        except UsageError as error:
            wrong[name] = str(error)
    return usable, wrong


def member_of(module: Any, member: str, family: str, origin: str) -> Any:
    """The component of a family in a module: the object `member`, or else `COMPONENT`, or else the only one of the family.

    Errors: UsageError where there is none, or several, or where the object is a component of another family.
    """
    value = _object_of(module, member, family, origin)
    return value.component if hasattr(value, "component") else value


def _object_of(module: Any, member: str, family: str, origin: str) -> Any:
    """As `member_of`, in the form that the module has."""
    held = {name: family_of(value) for name, value in vars(module).items() if family_of(value) and not name.startswith("_")}
    fitting = [name for name, known in held.items() if known == family or (known == ANY and name in (member, "COMPONENT"))]
    choices = f"accepted: {', '.join(fitting) or _EXAMPLES.get(family, 'COMPONENT = Component(…)')}"
    names = [member] if member else ["COMPONENT"] if "COMPONENT" in fitting else fitting
    if member and member not in vars(module):
        raise UsageError(f"{origin}: there is no {member}; {choices}")
    if not names:
        others = ", ".join(f"{name} is one of {known}" for name, known in held.items())
        raise UsageError(f"{origin}: no component of {family}{f' ({others})' if others else ''}; {choices}")
    if len(names) > 1:
        raise UsageError(f"{origin}: {len(names)} components of {family}; accepted: {origin}:{f' or {origin}:'.join(names)}")
    if names[0] not in fitting:
        what = f"one of {held[names[0]]}" if names[0] in held else f"a {type(vars(module)[names[0]]).__name__}"
        raise UsageError(f"{origin}: {names[0]} is {what}, not of {family}; {choices}")
    return vars(module)[names[0]]


_EXAMPLES = {
    "controllers": "CONTROLLER = Controller(Gains, start, respond)",
    "actuators": "ACTUATOR = Actuator(Parameters, drive)",
    "effects": "EFFECT = Effect(Parameters, start, wrench, rate)",
    "faults": "FAULT = Fault(Parameters, failed)",
    "disturbances": "DISTURBANCE = Disturbance(Parameters, push)",
    "navigation": "NAVIGATION = NavigationError(Parameters, see)",
    "guidance": "GUIDANCE = Guidance(Parameters, course)",
    "metrics": "METRIC = Metric(Parameters, columns, start, update)",
    "saturations": "SATURATION = Saturation(limited)",
    "allocations": "ALLOCATION = Allocation(Parameters, shares)",
}
"""What a user's file says, by family."""


def family_built(built: Any) -> str:
    """The family of what a component builds, by the interface that it has; ANY where this does not say it."""
    package = type(built).__module__.removeprefix("rvjax.components.").removesuffix(".interface")
    return package if package in FAMILIES else ANY


def family_of(value: Any) -> str:
    """The family of a component; ANY where it does not say, "" where it is no component."""
    family = "" if isinstance(value, type) else getattr(value, "family", "")
    return family if isinstance(family, str) and family in (*FAMILIES, ANY) else ""
