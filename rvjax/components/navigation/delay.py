"""Delay of what is measured, by whole steps.

    measured(t) = motion(t_{k−n})   for t in step k

What is measured at the beginning of a step is there n steps later and stands for one step; before the flight everything stood as
at t = 0. What stands before the delay in the campaign is delayed with it, what stands behind it is not.
"""

from __future__ import annotations

from functools import partial

from rvjax.campaign import Model, count
from rvjax.components.navigation.interface import NavigationError
from rvjax.components.registry import Component
from rvjax.physics.state import Motion, Numbers, Tick
from rvjax.physics.vectors import Scalar

MOST_STEPS = 64
"""Every step of delay is twelve more numbers that each sample carries."""


class Parameters(Model):
    """How long the delay is."""

    steps: int = count(at_least=1, at_most=MOST_STEPS, doc="delay n in steps of the integration")


Past = tuple[Motion, ...]
"""The motion at the beginnings of this step and of the n steps before it, the latest first."""


def start(steps: int, motion: Motion, numbers: Numbers) -> Past:
    """As at t = 0."""
    del numbers
    return (motion,) * (steps + 1)


def keep(tick: Tick, motion: Motion, memory: Past, numbers: Numbers) -> Past:
    """The beginning of this step in front, the oldest forgotten."""
    del tick, numbers
    return (motion, *memory[:-1])


def see(t: Scalar, motion: Motion, memory: Past, numbers: Numbers) -> Motion:
    """The oldest."""
    del t, motion, numbers
    return memory[-1]


def build(parameters: Parameters) -> NavigationError:
    """With so many steps."""
    return NavigationError(see, partial(start, parameters.steps), keep)


COMPONENT = Component(Parameters, build)
