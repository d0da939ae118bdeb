"""Allocations: how a commanded wrench becomes thrusts. A file per member; `build(parameters)` gives a function of the nominal
thrusters (`rvjax.campaign.thruster_layout.Layout`) → `rvjax.physics.thruster_allocation.Allocation`. The parameters are fixed
numbers: constants of the compiled program."""

from __future__ import annotations

MEMBERS = {
    "bounded-least-squares": "rvjax.components.allocations.bounded_least_squares",
    "pseudo-inverse": "rvjax.components.allocations.pseudo_inverse",
}
