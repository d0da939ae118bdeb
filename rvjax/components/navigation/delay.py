"""Delay of the measurement by whole steps.

    measured(t) = motion(t_{k−n})   for t in step k

The measurement at the beginning of a step is available n steps later and is held for a step (`rvjax.physics.delay_line`). Before
the flight the motion is that at t = 0. Errors listed before the delay in the campaign are delayed too, those after it are not.
"""

from __future__ import annotations

from functools import partial

from rvjax.campaign import Model, count
from rvjax.components.navigation.interface import NavigationError
from rvjax.components.registry import Component
from rvjax.physics.delay_line import MOST_STEPS, delayed, filled, pushed
from rvjax.physics.state import Motion, Numbers, Tick
from rvjax.physics.vectors import Scalar

Line = tuple[Motion, ...]


class Parameters(Model):
    """Length of the delay."""

    steps: int = count(at_least=1, at_most=MOST_STEPS, doc="delay n in integration steps")


def start(steps: int, motion: Motion, numbers: Numbers) -> Line:
    """The motion at t = 0 in every place."""
    del numbers
    return filled(steps, motion)


def keep(tick: Tick, motion: Motion, memory: Line, numbers: Numbers) -> Line:
    """Adds the motion at the beginning of this step."""
    del tick, numbers
    return pushed(memory, motion)


def see(t: Scalar, motion: Motion, memory: Line, numbers: Numbers) -> Motion:
    """The delayed motion."""
    del t, motion, numbers
    return delayed(memory)


def build(parameters: Parameters) -> NavigationError:
    """A delay of n steps."""
    return NavigationError(see, partial(start, parameters.steps), keep)


COMPONENT = Component(Parameters, build)
