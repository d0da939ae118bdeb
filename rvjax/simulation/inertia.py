"""Bodies: the inertia about the centre of mass, from the quantities of a campaign.

    J_O = T diag(J₁, J₂, J₃) Tᵀ  or  [Jxx Jxy Jxz; …],      J_C = J_O − m (|c|² I − c cᵀ)

O: reference point of the body, C: its centre of mass, c: from O to C, m: mass. Without its propellant of mass p at r (from O) the
body has the inertia J_C − m p/(m − p) (|r − c|² I − (r − c)(r − c)ᵀ).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign import Quantity, Spec
from rvjax.campaign.inertia import MatrixInertia, PrincipalInertia
from rvjax.campaign.inertia_validity import about_centre, physical
from rvjax.elementary import tan
from rvjax.physics.vectors import Symmetric, Vector, rotation

Values = NDArray[np.float64]
Parts = Callable[[str, Quantity], tuple[Values, ...]]
"""The components of a quantity, each of shape (samples,), by its name."""


@dataclass(frozen=True)
class Body:
    """path: name of its inertia. mass_and_centre: quantities by name, empty if the centre of mass is the reference point.
    emptied: mass, centre of mass, propellant and tank by name, empty without propellant."""

    path: str
    inertia: PrincipalInertia | MatrixInertia
    mass_and_centre: Mapping[str, Quantity]
    emptied: Mapping[str, Quantity] = field(default_factory=dict[str, Quantity])

    @property
    def quantities(self) -> dict[str, Quantity]:
        """The quantities that determine J_C, with and without propellant, by name."""
        return {**self.inertia.quantities(self.path), **self.mass_and_centre, **self.emptied}

    def entries(self, parts: Parts) -> tuple[Any, ...]:
        """J_C."""
        entries = self._about_reference(parts)
        if self.mass_and_centre:
            (mass,), centre = (parts(name, quantity) for name, quantity in self.mass_and_centre.items())
            entries = about_centre(entries, mass, (centre[0], centre[1], centre[2]))
        return entries

    def drawn(self, parts: Parts) -> Symmetric:
        """J_C of every sample."""
        return Symmetric(*self.entries(parts))

    def exists(self, parts: Parts) -> NDArray[np.bool_]:
        """(samples,) whether J_C is physical, with an empty tank too."""
        entries: Any = self.entries(parts)
        if not self.emptied:
            return physical(entries)
        (m,), c, (p,), r = (parts(name, quantity) for name, quantity in self.emptied.items())
        x, y, z = (a - b for a, b in zip(r, c, strict=True))
        return physical(entries) & physical(about_centre(entries, m * p / (m - p), (x, y, z)))

    def _about_reference(self, parts: Parts) -> Any:
        """J_O."""
        inertia, name = self.inertia, self.path
        if isinstance(inertia, MatrixInertia):
            return (*parts(f"{name}.moments", inertia.moments), *parts(f"{name}.products", inertia.products))
        moments = parts(f"{name}.principal", inertia.principal)
        sigma = self._turn(inertia, parts)
        if sigma is None:
            return (*moments, *(np.zeros_like(moments[0]),) * 3)
        turn = rotation(sigma)
        rows = [turn.a, turn.b, turn.c]

        def entry(i: int, j: int) -> Values:
            x, y, z = (m * p * q for m, p, q in zip(moments, rows[i].parts(), rows[j].parts(), strict=True))
            return x + y + z

        return tuple(entry(i, j) for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)))

    def _turn(self, inertia: PrincipalInertia, parts: Parts) -> Vector | None:
        """MRP of the principal axes; None if they are the body axes."""
        if inertia.attitude is not None:
            return Vector(*parts(f"{self.path}.rotation", inertia.attitude))
        if inertia.axis is None:
            return None
        (tilt,) = parts(f"{self.path}.tilt_rad", inertia.tilt_rad)
        return Vector(*parts(f"{self.path}.axis", inertia.axis)) * tan(0.25 * tilt)


def bodies(spec: Spec) -> tuple[Body, Body]:
    """The pursuer and the target."""
    pursuer = spec.pursuer
    mass_and_centre = {"pursuer.mass_kg": pursuer.mass_kg, "pursuer.centre_of_mass_m": pursuer.centre_of_mass_m}
    moved = pursuer.centre_of_mass_m.largest_norm > 0.0
    emptied: dict[str, Quantity] = {}
    if (propellant := pursuer.propellant) is not None:
        tank = {"pursuer.propellant.mass_kg": propellant.mass_kg, "pursuer.propellant.tank_m": propellant.tank_m}
        emptied = {**mass_and_centre, **tank}
    return (
        Body("pursuer.inertia_kgm2", pursuer.inertia_kgm2, mass_and_centre if moved else {}, emptied),
        Body("target.inertia_kgm2", spec.target.inertia_kgm2, {}),
    )
