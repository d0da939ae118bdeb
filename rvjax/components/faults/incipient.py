"""Incipient loss of effectiveness of an actuator channel: it grows gradually.

    u = (1 − Δ(1 − e^{−a (t − t_f)})) h       while the fault acts

Δ: final loss; a: growth rate, so 63 % of Δ are lost after 1/a. The usual incipient fault
profile (X. Zhang, M. Polycarpou, T. Parisini, "A robust detection and isolation scheme for abrupt and incipient faults in
nonlinear systems", IEEE Trans. Automatic Control, 2002).
"""

from __future__ import annotations

from rvjax.campaign import Quantity, channels
from rvjax.components.faults.interface import FaultParameters, fault
from rvjax.components.registry import Component
from rvjax.physics.elementary import exp
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels, Scalar, each


class Parameters(FaultParameters):
    """Final loss and growth rate, per channel."""

    loss: Quantity = channels("1", at_least=0.0, at_most=1.0, doc="final loss Δ of effectiveness")
    growth: Quantity = channels("1/s", above=0.0, doc="growth rate a")


def failed(u: Channels, since: Channels, memory: tuple[()], upper: Channels, numbers: Numbers) -> Channels:
    """(1 − Δ(1 − e^{−a (t − t_f)})) h."""
    del memory, upper

    def reduced(h: Scalar, s: Scalar, loss: Scalar, growth: Scalar) -> Scalar:
        return h * (1.0 - loss * (1.0 - exp(-growth * s)))

    return each(reduced, u, since, numbers.loss, numbers.growth)


COMPONENT = Component(Parameters, lambda parameters: fault(failed), neutral=({"loss": 0.0},))
