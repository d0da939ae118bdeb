"""Probes of the audit: fixed inputs, each switched off in a flight that is otherwise the same.

    fault, channel of a fault               its onset never comes
    disturbance, navigation error           its numbers are those with which it does nothing

An input with draws needs no probe: moving its draws is the proof. A component without such numbers, such as gravity-gradient, has
no probe.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any, Literal, NamedTuple

import jax
import numpy as np
from numpy.typing import NDArray

from rvjax.campaign.draw_names import covers
from rvjax.campaign.plain_values import Place
from rvjax.components.faults.interface import FaultParameters
from rvjax.physics.state import Numbers
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.effect import allowed, silent
from rvjax.simulation.problem import NEVER, Part, Problem

Family = Literal["faults", "disturbances", "navigation"]


class Probe(NamedTuple):
    """name: of the input; place: in the campaign. part: number of the component in its family. channels: of a fault, those that
    are switched off."""

    name: str
    place: Place
    family: Family
    part: int
    channels: tuple[str, ...] = ()


def probes(problem: Problem, streams: Collection[str]) -> list[Probe]:
    """The probes of a problem. streams: names of its random streams."""
    known = {name for name, _ in silent(problem)}
    found = [
        *_of_faults(problem, streams),
        *_of_others("disturbances", problem.disturbances, streams),
        *_of_others("navigation", problem.navigation, streams),
    ]
    return [probe for probe in found if not any(covers(name, probe.name) or covers(probe.name, name) for name in known)]


def _of_faults(problem: Problem, streams: Collection[str]) -> Iterator[Probe]:
    """A probe for each channel in the list `channels` of a fault without draws; a single probe if the fault has no list."""
    for number, part in enumerate(problem.faults):
        parameters = part.parameters
        if not isinstance(parameters, FaultParameters):
            continue
        channels = parameters.channels
        if len(channels) == len(parameters.onset_s.components):
            if not any(covers(part.prefix, name) for name in streams):
                yield Probe(part.prefix, part.place, "faults", number, channels)
            continue
        for index, channel in enumerate(channels):
            if not any(f"{part.prefix}.{name}.{channel}" in streams for name in part.quantities):
                place = (*part.place, "channels", index)
                yield Probe(f"{part.prefix}.channels.{channel}", place, "faults", number, (channel,))


def _of_others(family: Family, parts: tuple[Part, ...], streams: Collection[str]) -> Iterator[Probe]:
    for number, part in enumerate(parts):
        neutral = part.component is not None and part.component.neutral
        if neutral and not any(covers(part.prefix, name) for name in streams):
            yield Probe(part.prefix, part.place, family, number)


def switched_off(problem: Problem, drawn: Drawn, off: list[tuple[Probe, NDArray[np.bool_]]]) -> Drawn:
    """The numbers of flights in which probes are switched off, each in some samples."""
    for probe, samples in off:
        values: list[Numbers] = list(getattr(drawn, probe.family))
        part: Part = getattr(problem, probe.family)[probe.part]
        numbers = values[probe.part]
        if probe.family == "faults":
            changed = _without_onset(numbers.onset_s, part, probe.channels, samples)
            values[probe.part] = Numbers({**numbers, "onset_s": changed})
        elif part.component is not None:
            fields = {name: value for name, value in part.component.neutral[0].items() if name in numbers}
            changed = {name: _replaced(numbers[name], value, samples) for name, value in fields.items()}
            values[probe.part] = Numbers({**numbers, **changed})
        drawn = drawn._replace(**{probe.family: tuple(values)})
    return drawn


def _without_onset(onset: Any, part: Part, channels: tuple[str, ...], samples: NDArray[np.bool_]) -> Any:
    names = part.quantities["onset_s"].components
    pairs = zip(names, onset.parts(), strict=True)
    return onset.like(tuple(_replaced(values, NEVER.value, samples) if name in channels else values for name, values in pairs))


def _replaced(tree: Any, value: float, samples: NDArray[np.bool_]) -> Any:
    return jax.tree.map(lambda leaf: np.where(samples, value, leaf), tree)


def permitted(problem: Problem, probes: list[Probe], idle: Collection[str]) -> dict[str, str]:
    """Fixed inputs without an effect that `audit.allow` permits, each with the reason."""
    reasons = {name: finding.found for name, finding in silent(problem)}
    reasons |= {probe.name: "it changed no number of a flight" for probe in probes if probe.name in idle}
    return {name: reason for name, reason in reasons.items() if allowed(problem, name)}
