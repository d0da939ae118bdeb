"""Effect of a component, decided from its numbers without a flight.

RK4 evaluates a flight at the instants 0, h/2, h, 3h/2, … only. What lies between two of them does nothing, and what changes
within a step is seen with the weights of RK4: h/6 at the beginning, 4h/6 in the middle and h/6 at the end of a step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign import Model, Quantity, Spec
from rvjax.campaign.plain_values import exact

Values = NDArray[np.float64]

Neutral = tuple[Mapping[str, float], ...]
"""Sets of fields, by their names. A component does nothing if all fields of one set have these values, in SI."""


def zero(*fields: str) -> Mapping[str, float]:
    """These fields with the value 0."""
    return dict.fromkeys(fields, 0.0)


MOST_WINDOWS = 1_000_000
"""Windows of a recurring event that are looked at. An event with more of them counts as seen."""

AT_ONCE = 100_000
"""Steps that are summed at a time."""

LOST = 0.01
"""Part of an impulse, or of the largest wrench, whose loss is worth a warning."""


def rounding_s(spec: Spec) -> float:
    """Possible error of a time in the flight [s], by rounding."""
    return 4.0 * float(np.finfo(spec.precision).eps) * spec.horizon.duration_s


def seen(spec: Spec, first_s: float, length_s: float, period_s: float | None = None, end_s: float = np.inf) -> bool:
    """Whether an instant of the integration can lie in one of the windows [first + j period, first + j period + length], cut off
    at `end_s`. Rounding is in favour of yes."""
    room, half = rounding_s(spec), 0.5 * spec.horizon.step_s
    end = min(end_s, spec.horizon.duration_s)
    if first_s > end + room:
        return False
    windows = 1.0 if period_s is None else np.floor((end - first_s) / period_s) + 1.0
    if windows > MOST_WINDOWS:
        return True
    starts = np.maximum(first_s + np.arange(max(int(windows), 1)) * (period_s or 0.0), 0.0)
    instants = np.ceil((starts - room) / half) * half
    return bool(np.any((instants <= starts + length_s + room) & (instants <= end + room)))


def has(quantity: Quantity | None, value: float, component: int | None = None) -> bool:
    """Whether a quantity, or one component of it, has a value in every sample. A quantity that is left out has the value 0."""
    if quantity is None:
        return value == 0.0
    supports = quantity.supports if component is None else quantity.supports[component : component + 1]
    return all(low == high == value for low, high in supports)


def neutral_values(model: Model, neutral: Neutral) -> str:
    """Words on the first set of fields that have their neutral values in every sample; empty if there is none."""
    for fields in neutral:
        if all(has(getattr(model, name), value) for name, value in fields.items()):
            keys = [type(model).model_fields[name].alias or name for name in fields]
            (value,) = set(fields.values())
            absent = " or left out" if any(getattr(model, name) is None for name in fields) else ""
            listed = f"{', '.join(keys[:-1])} and {keys[-1]} are" if keys[1:] else f"{keys[0]} is"
            return f"{listed} {exact(value)}{absent} in every sample"
    return ""


def typical(quantity: Quantity) -> float:
    """The value of a scalar: its number if it is fixed, else its median."""
    return float(quantity.parts[0].ppf(np.array([0.5]))[0]) if quantity.parts[0].uniforms else quantity.parts[0].low


def impulse_of_steps(spec: Spec, value: Callable[[Values], Values]) -> float:
    """Σ h/6 (d(t_k) + 4 d(t_k + h/2) + d(t_k + h)) over the flight: the impulse of d as the steps see it."""
    h, total = spec.horizon.step_s, 0.0
    for first in range(0, spec.horizon.steps, AT_ONCE):
        t = np.arange(first, min(first + AT_ONCE, spec.horizon.steps), dtype=np.float64) * h
        total += h / 6.0 * float(np.sum(value(t) + 4.0 * value(t + 0.5 * h) + value(t + h)))
    return total
