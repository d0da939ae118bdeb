"""Signal temporal logic on a whole trace, by its definition: formulas as a campaign says them, NumPy arrays, loops.

Imports nothing of what it checks.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Trace:
    """signals: by name, (steps,) each; t [s]; inside: whether both capture tubes hold, at each step."""

    signals: Mapping[str, NDArray[np.float64]]
    t: NDArray[np.float64]
    inside: NDArray[np.bool_]

    def window(self, said: Mapping[str, Any]) -> list[int]:
        """The steps between `from_s` and `to_s`."""
        first, last = said.get("from_s", 0.0), said.get("to_s", np.inf)
        return [k for k, t in enumerate(self.t) if first - 1e-9 <= t <= last + 1e-9]

    @property
    def settled(self) -> int:
        """The first step from which the tubes hold to the end; the number of steps where they do not."""
        return next(k for k in range(len(self.t) + 1) if self.inside[k:].all())


def state_margin(said: Mapping[str, Any], trace: Trace, k: int) -> float:
    """Robustness of a formula without temporal operators at a step."""
    if "all" in said:
        return min(state_margin(part, trace, k) for part in said["all"])
    if "any" in said:
        return max(state_margin(part, trace, k) for part in said["any"])
    if "not" in said:
        return -state_margin(said["not"], trace, k)
    value = float(trace.signals[said["signal"]][k])
    room = value - said["above"] if "above" in said else said["below"] - value
    return room / said.get("scale", 1.0)


def margin(said: Mapping[str, Any], trace: Trace) -> float:
    """Robustness of a formula of the whole trace."""
    ((word, below),) = said.items()
    if word == "all":
        return min(margin(part, trace) for part in below)
    if word == "any":
        return max(margin(part, trace) for part in below)
    if word == "not":
        return -margin(below, trace)
    if word == "until_settled":
        return min((state_margin(below, trace, k) for k in range(trace.settled)), default=np.inf)
    steps = trace.window(below)
    if word == "always":
        return min(state_margin(below, trace, k) for k in steps)
    if word == "eventually":
        return max(state_margin(below, trace, k) for k in steps)
    assert word == "until"
    hold = [state_margin(below["hold"], trace, k) for k in range(len(trace.t))]
    return max(min([state_margin(below["reach"], trace, k), *hold[:k]]) for k in steps)


def state_holds(said: Mapping[str, Any], trace: Trace, k: int) -> bool:
    """Whether a formula without temporal operators is true at a step."""
    if "all" in said:
        return all(state_holds(part, trace, k) for part in said["all"])
    if "any" in said:
        return any(state_holds(part, trace, k) for part in said["any"])
    if "not" in said:
        return not state_holds(said["not"], trace, k)
    value = trace.signals[said["signal"]][k]
    return bool(value > said["above"] if "above" in said else value < said["below"])


def holds(said: Mapping[str, Any], trace: Trace) -> bool:
    """Whether a formula is true of the whole trace."""
    ((word, below),) = said.items()
    if word == "all":
        return all(holds(part, trace) for part in below)
    if word == "any":
        return any(holds(part, trace) for part in below)
    if word == "not":
        return not holds(below, trace)
    if word == "until_settled":
        return all(state_holds(below, trace, k) for k in range(trace.settled))
    steps = trace.window(below)
    if word == "always":
        return all(state_holds(below, trace, k) for k in steps)
    if word == "eventually":
        return any(state_holds(below, trace, k) for k in steps)
    hold = [state_holds(below["hold"], trace, k) for k in range(len(trace.t))]
    return any(state_holds(below["reach"], trace, k) and all(hold[:k]) for k in steps)
