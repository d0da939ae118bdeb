"""Which engine flies a campaign."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from threading import Lock
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import numpy as np

from rvjax.campaign.actuators import Thrusters
from rvjax.campaign.plain_values import Place
from rvjax.components.registry import FAMILY_OF, foreign
from rvjax.errors import CampaignError
from rvjax.simulation import user_checks
from rvjax.simulation.engines.interface import Engine
from rvjax.simulation.engines.llvm.engine import FLIGHT, LlvmEngine
from rvjax.simulation.engines.llvm.from_jaxpr import scalarised
from rvjax.simulation.engines.llvm.program import UnsupportedError
from rvjax.simulation.engines.xla import XlaEngine

if TYPE_CHECKING:
    from rvjax.simulation.problem import Problem

KEPT = 8
"""Engines that a process keeps: those used last."""


class Choice(NamedTuple):
    """The engine that flies. reason: why it is not `llvm`, empty where it is, or where the campaign asks for another. place: of
    the component that keeps `llvm` from flying, () where it is the device."""

    engine: Engine
    reason: str = ""
    place: Place = ()


_choices: OrderedDict[Any, Choice] = OrderedDict()
_choosing = Lock()


def choice_of(problem: Problem) -> Choice:
    """The engine of a problem, in a configured process. Problems of the same structure share it, so a process that flies a
    campaign again with other numbers does not trace and compile again.

    Errors: CampaignError where the campaign asks for an engine that cannot fly it.
    """
    with _choosing:
        key = (problem.structure, problem.spec.engine)
        if key not in _choices:
            _choices[key] = _chosen(problem)
        _choices.move_to_end(key)
        while len(_choices) > KEPT:
            _choices.popitem(last=False)
        return _choices[key]


def engine_of(problem: Problem) -> Engine:
    """The engine of a problem, as `choice_of`."""
    return choice_of(problem).engine


def _chosen(problem: Problem) -> Choice:
    wanted = problem.spec.engine
    if wanted == "xla":
        return Choice(XlaEngine(problem.loop, problem.metrics))
    reason, place = _in_the_way(engine := LlvmEngine(problem.loop, problem.metrics), problem)
    if not reason:
        return Choice(engine)
    if wanted == "llvm":
        accepted = "accepted: auto or xla"
        raise CampaignError([problem.spec.source.finding(("engine",), f"llvm cannot fly this campaign: {reason}", accepted)])
    return Choice(XlaEngine(problem.loop, problem.metrics), reason, place)


def _in_the_way(engine: LlvmEngine, problem: Problem) -> tuple[str, Place]:
    """Why the engine `llvm` cannot fly a problem, empty where it can; and the place of the component whose fault it is."""
    if (device := jax.local_devices()[0]).platform != "cpu":
        return f"the device is {device.device_kind}", ()
    if not any(foreign(problem.spec)):
        return "", ()  # tests/engines/test_components.py tries every component of this package
    from rvjax.simulation.draws import Draws

    flight = engine.flight(Draws.of(problem, np.arange(1, dtype=np.int64))[1])
    try:
        for name in FLIGHT:
            flight.traced(name)
    except UnsupportedError as error:
        return next(_components_in_the_way(problem), (f"it has no rule for JAX's {error}", ("engine",)))
    return "", ()


def _components_in_the_way(problem: Problem) -> Iterator[tuple[str, Place]]:
    """Each component that the engine `llvm` cannot fly, with the reason."""
    layout = problem.spec.actuators.geometry if isinstance(problem.spec.actuators, Thrusters) else None
    parts = (problem.controller, problem.guidance, *problem.actuation, *problem.faults, *problem.disturbances, *problem.effects)
    for part in (*parts, *problem.navigation, *problem.chosen):
        if part.component is None or part.parameters is None:
            continue
        family = FAMILY_OF[str(part.place[0])]
        function = user_checks.traced(family, part.component.build(part.parameters), layout)
        numbers = user_checks.numbers(user_checks.own_quantities(part.parameters), part.component.noisy)
        try:
            scalarised(function, numbers, user_checks.ARGUMENTS, step=False)
        except UnsupportedError as error:
            yield f"the component at {'.'.join(map(str, part.place))} uses JAX's {error}, for which it has no rule", part.place
