"""Fault severity of a channel: the share of its effectiveness that faults have taken, and not given back, by the end of a flight.

    1 − ∏ (remaining effectiveness)      over the faults that begin before the end and last until it

    effectiveness   e
    incipient       1 − Δ, its final loss, however slowly it grows
    float, stuck    0, because the output does not follow the command
    reversed        0, because what is left pushes the wrong way
    others          1: bias and drift add to the command; lag and delay only slow it down

A fault that ends before the flight counts as 1. An intermittent fault counts with what remains while it acts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from pydantic import ValidationError

from rvjax.campaign import Model, Quantity, channels
from rvjax.campaign.actuators import AnyActuators, Thrusters
from rvjax.columns import CHANNELS, draw_column

if TYPE_CHECKING:
    from rvjax.campaign import Spec
    from rvjax.campaign.choice import Choice

_LOSSES = {"effectiveness": "remaining", "incipient": "loss", "float": "", "reversed": "", "stuck": ""}
"""The quantity of each fault that determines what remains."""


class _Written(Model):
    """What severity needs of the parameters of a fault."""

    onset_s: Quantity | None = channels("s", default=None, doc="onset")
    duration_s: Quantity | None = channels("s", default=None, doc="duration")
    remaining: Quantity | None = channels("1", default=None, doc="effectiveness")
    loss: Quantity | None = channels("1", default=None, doc="final loss")


def severity(spec: Spec, head: pd.DataFrame, channel: str) -> NDArray[np.float64] | None:
    """(n,) severity of the samples of a table; None if no fault takes effectiveness from the channel.

    With thrusters, faults act on thrusters, so a channel has no severity.
    """
    if isinstance(spec.actuators, Thrusters):
        return None
    remaining = [_remaining(fault, head, channel, spec.horizon.duration_s) for fault in spec.faults if _affects(fault, channel)]
    return 1 - np.prod(remaining, axis=0) if remaining else None


def _affects(fault: Choice, channel: str) -> bool:
    listed = fault.parameters.get("channels", "all")
    return fault.use in _LOSSES and (listed == "all" or channel in listed)


def _remaining(fault: Choice, head: pd.DataFrame, channel: str, end_s: float) -> NDArray[np.float64]:
    """(n,) what a fault leaves of the effectiveness of a channel at the end of the flight."""
    fixed = _fixed(fault.parameters, channel)

    def value(name: str, otherwise: float) -> Any:
        column = draw_column(f"{fault.prefix}.{name}.{channel}")
        return head[column].to_numpy(dtype=float) if column in head else fixed.get(name, otherwise)

    onset, duration = value("onset_s", 0.0), value("duration_s", np.inf)
    name = _LOSSES[fault.use]
    left = 0.0 if not name else value(name, 1.0) if name == "remaining" else 1.0 - value(name, 0.0)
    return np.where((onset < end_s) & (onset + duration >= end_s), left, np.ones(len(head)))


def times(fault: Choice, row: Mapping[str, Any], actuators: AnyActuators) -> list[tuple[str, float, float]]:
    """(actuator, onset, duration) in s of every actuator of a sample that a fault affects; an infinite onset: it never begins.

    An intermittent fault counts as a whole.
    """
    known = actuators.geometry.names if isinstance(actuators, Thrusters) else CHANNELS
    listed = fault.parameters.get("channels", "all")
    found: list[tuple[str, float, float]] = []
    for name in (name for name in known if listed == "all" or name in listed):
        fixed = _fixed(fault.parameters, name, known)
        onset, duration = (
            float(row.get(draw_column(f"{fault.prefix}.{part}.{name}"), fixed.get(part, math.inf)))
            for part in ("onset_s", "duration_s")
        )
        found.append((name, onset, duration))
    return found


def _fixed(parameters: Mapping[str, Any], channel: str, actuators: Sequence[str] = CHANNELS) -> dict[str, float]:
    """The fixed numbers of an actuator, by name. Drawn ones are columns of the table."""
    known = {key: value for key, value in parameters.items() if key in _Written.model_fields}
    try:
        written = _Written.model_validate(known, context={"actuators": tuple(actuators)})
    except ValidationError:  # a distribution that names a file: its draws are columns
        return {}
    place, names = actuators.index(channel), ("onset_s", "duration_s", "remaining", "loss")
    given = {name: quantity for name in names if isinstance(quantity := getattr(written, name), Quantity)}
    return {name: quantity.supports[place][0] for name, quantity in given.items()}
