"""What a guidance asks of its campaign: short steps; of the target a docking axis, an orbit, a zone inside of the gate."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from rvjax.campaign import Model, Spec
from rvjax.campaign.plain_values import exact
from rvjax.components.guidance import corridor
from rvjax.components.guidance.interface import STEPS, Guidance, GuidanceParameters
from rvjax.errors import Finding
from rvjax.physics.vectors import Vector
from rvjax.simulation.closed_loop import Drawn


def findings(spec: Spec, model: Model, guidance: Any) -> Iterator[Finding]:
    """What is wrong with the guidance of a campaign. model: its parameters; guidance: what it builds, None without."""
    place, source = spec.guidance.path, spec.source
    if isinstance(model, GuidanceParameters) and model.time_constant_s.supports[0][0] < STEPS * spec.horizon.step_s:
        found = f"the reference point follows with {exact(model.time_constant_s.supports[0][0])} s, less than {STEPS:g} steps"
        accepted = f"accepted: at least {exact(STEPS * spec.horizon.step_s)} s in every sample, or a smaller horizon.step_s"
        yield source.finding((*place, "time_constant_s"), found, accepted)
    if not isinstance(guidance, Guidance):
        return
    for asking, need in guidance.needs:
        if need == "axis" and not spec.target.has_docking_axis:
            found = "there is no docking axis: target.port_m is 0 and there is no target.port_axis"
            yield source.finding(
                (*place, *asking), found, "accepted: another target.port_m, such as [5, 0, 0], or a target.port_axis"
            )
        if need == "orbit" and "orbit" not in spec.target.model_fields_set:
            found = "the frame is lvlh, but the campaign states no target.orbit"
            accepted = "accepted: a target.orbit, such as {semi_major_axis_km: 6878, eccentricity: 0}, or another frame"
            yield source.finding((*place, *asking), found, accepted)


def gate_in_the_zone(spec: Spec, model: Model | None, drawn: Drawn) -> Iterator[Finding]:
    """A reference point that goes round the target inside its keep-out zone, in the draws of the first samples."""
    zone = drawn.context.keep_out
    if not isinstance(model, corridor.Parameters) or not isinstance(zone, Vector):
        return
    gate = drawn.plant.port + drawn.context.axis * drawn.guidance.gate_m
    distance, reach = np.sqrt(sum(x * x for x in gate.parts())), np.max(zone.parts(), axis=0)
    if inside := int(np.count_nonzero(distance < reach)):
        worst = int(np.argmax(reach - distance))
        found = (
            f"the gate is {distance[worst]:.4g} m from the target's centre, but the keep-out zone reaches {reach[worst]:.4g} m, "
            f"in {inside} of the first {len(distance)} samples"
        )
        accepted = "accepted: a gate outside of the zone, on the sphere about the target on which the reference point goes round"
        yield spec.source.finding((*spec.guidance.path, "gate_m"), found, accepted)
