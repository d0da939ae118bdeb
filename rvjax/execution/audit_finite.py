"""What is not a finite number at the beginning of a flight, where no flight of the audit is finite."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import jax
import numpy as np

from rvjax.campaign.plain_values import Place
from rvjax.campaign.python_files import PythonFile
from rvjax.campaign.short_choices import ALLOCATION
from rvjax.errors import CampaignError, Finding
from rvjax.physics.state import Step, Tick
from rvjax.simulation import closed_loop, jax_config
from rvjax.simulation.closed_loop import Drawn, Held
from rvjax.simulation.flight import Carry
from rvjax.simulation.problem import Problem

ACCEPTED = "accepted: finite numbers; look at divisions by 0, roots and logarithms of what may be 0 or negative"


def refuse_lost(problem: Problem, drawn: Drawn, carry: Carry) -> None:
    """CampaignError that names the component, where every flight has stopped being finite. drawn: numbers of the lanes."""
    lost = np.asarray(carry.lost_s)
    if not np.all(np.isfinite(lost)):
        return
    when = "from the first step on" if np.min(lost) <= problem.spec.horizon.step_s else f"by t = {np.max(lost):g} s at the latest"
    place, what = next(_at_the_start(problem, drawn), (("controller",), "the state of every flight"))
    raise CampaignError([_finding(problem, place, f"{what} is not finite, in every flight, {when}")])


def _at_the_start(problem: Problem, drawn: Drawn) -> Iterator[tuple[Place, str]]:
    """(place of a component, what it gives) of everything that is not finite in the first lane at t = 0, in causal order."""
    first = jax.tree.map(lambda x: np.asarray(x, dtype=jax_config.precision())[0], drawn)

    def begin(numbers: Drawn) -> tuple[Any, Any, Step, Held]:
        y, held = closed_loop.start(problem.loop, numbers)
        h = numbers.context.step_s
        _, step, held = closed_loop.evaluate(problem.loop, numbers, h * 0.0, y, held, Tick(0, h * 0.0, h))
        opened = problem.loop.gear.allocation.at(step.commanded) if problem.loop.gear is not None else ()
        return y.control, opened, step, held

    control, opened, step, held = jax.tree.map(np.asarray, jax.jit(begin)(first))
    for index, _ in enumerate(problem.spec.navigation):
        if not _finite(step.measured):
            yield ("navigation", index), "the measured motion"
    if not _finite(step.path):
        yield ("guidance",), "the reference point"
    if not _finite(control):
        yield ("controller",), "the state of the controller at t = 0"
    for name, value in step.report.signals.items():
        if not _finite(value):
            yield ("controller",), f"the signal {name} of the controller"
    if not _finite((step.command, held.control)):
        yield ("controller",), "the command of the controller"
    if not _finite(opened):
        yield ALLOCATION, "the result of the allocation"
    for index, _ in enumerate(problem.spec.faults):
        if not _finite(step.applied):
            yield ("faults", index), "the wrench behind the faults"
    for index, _ in enumerate(problem.spec.disturbances):
        if not _finite(step.disturbance):
            yield ("disturbances", index), "the disturbance"


def _finite(tree: Any) -> bool:
    return all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(tree))


def _finding(problem: Problem, place: Place, what: str) -> Finding:
    """The finding, at the component's file where it is a user's."""
    spec = problem.spec
    choice = next((choice for choice in spec.components if choice.path == place), spec.controller)
    if isinstance(choice.use, PythonFile):
        return Finding(f"{choice.use.path(choice.use.file)}:1", "", what, ACCEPTED)
    return spec.source.finding(place, what, ACCEPTED)
