"""Which inertia a body can have.

A mass distribution with the inertia J about its centre of mass exists exactly if J is positive definite and ½ tr(J) I − J is
positive semidefinite (the triangle inequality of the principal moments; P. Wensing, S. Kim, J.-J. Slotine, "Linear matrix
inequalities for physically consistent inertial parameter identification", IEEE RA-L, 2018). Both by Sylvester's criterion, in
plain arithmetic, so that a draw is accepted or rejected alike on every machine.

Entries are in the order xx, yy, zz, yz, xz, xy, each a number or an array of any shape.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

SLACK = 1e-12
"""Of the triangle inequality, relative to the trace: a flat body meets it with equality."""

Entries = tuple[Any, Any, Any, Any, Any, Any]


def definite(entries: Entries) -> NDArray[np.bool_]:
    """A > 0: its three leading minors are above 0."""
    xx, yy, zz, yz, xz, xy = entries
    plane = xx * yy - xy * xy
    whole = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    return (np.asarray(xx) > 0.0) & (plane > 0.0) & (whole > 0.0)


def triangle(entries: Entries) -> NDArray[np.bool_]:
    """½ tr(J) I − J ≥ 0, up to SLACK: no principal moment is larger than the sum of the others."""
    xx, yy, zz, yz, xz, xy = entries
    half = 0.5 * (1.0 + SLACK) * (xx + yy + zz)
    return definite((half - xx, half - yy, half - zz, -yz, -xz, -xy))


def physical(entries: Entries) -> NDArray[np.bool_]:
    """Whether a body with this inertia about its centre of mass exists."""
    return definite(entries) & triangle(entries)


def about_centre(entries: Entries, mass: Any, centre: tuple[Any, Any, Any]) -> Entries:
    """J_C = J_O − m (|c|² I − c cᵀ): from the reference point O to the centre of mass C, c from O to C (Steiner)."""
    xx, yy, zz, yz, xz, xy = entries
    x, y, z = centre
    return (
        xx - mass * (y * y + z * z),
        yy - mass * (x * x + z * z),
        zz - mass * (x * x + y * y),
        yz + mass * y * z,
        xz + mass * x * z,
        xy + mass * x * y,
    )
