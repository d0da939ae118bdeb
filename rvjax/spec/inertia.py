"""Inertia of a body, in one of two forms, physical in every possible draw.

    principal   J = T diag(J₁, J₂, J₃) Tᵀ, T a rotation by `tilt` about a drawn axis
    matrix      J = [Jxx Jxy Jxz; Jxy Jyy Jyz; Jxz Jyz Jzz]

A mass distribution exists exactly if J is positive definite and ½ tr(J) I − J is positive semidefinite (the triangle
inequality of the principal moments; P. Wensing, S. Kim, J.-J. Slotine, "Linear matrix inequalities for physically
consistent inertial parameter identification", IEEE RA-L, 2018). Both sets are convex, so all draws are inside if the
corners of the box of their supports are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, ValidationInfo, field_validator

from rvjax.spec.distributions import Direction
from rvjax.spec.fields import Model, scalar, vector
from rvjax.spec.problem import Problem, refuse
from rvjax.spec.quantity import Quantity
from rvjax.spec.values import describe, is_mapping

SLACK = 1e-12
"""Of the triangle inequality, relative to the trace: a flat body meets it with equality."""


class PrincipalInertia(Model):
    """J = T diag(J₁, J₂, J₃) Tᵀ; the axis of T is drawn uniformly over all directions."""

    principal: Quantity = vector("kg·m²", above=0.0, doc="principal moments of inertia")
    tilt_rad: Quantity = scalar(
        "rad", key="tilt_deg", default=0.0, at_least=0.0, doc="angle between the principal axes and the body axes"
    )

    @property
    def axis(self) -> Quantity | None:
        """Of the tilt; None where there is no tilt."""
        tilted = not self.tilt_rad.is_fixed or self.tilt_rad.parts[0].high
        return Quantity("vector", (), Direction(1.0), "1", "axis of the tilt of the principal axes") if tilted else None

    def _quantities(self, prefix: str) -> Iterator[tuple[str, Quantity]]:
        yield from super()._quantities(prefix)
        if self.axis is not None:
            yield f"{prefix}axis", self.axis

    @field_validator("principal")
    @classmethod
    def _physical(cls, principal: Quantity) -> Quantity:
        _check_corners(principal)
        return principal


class MatrixInertia(Model):
    """J = [Jxx Jxy Jxz; Jxy Jyy Jyz; Jxz Jyz Jzz], entries as they stand in J: Jxy = −∫xy dm."""

    moments: Quantity = vector("kg·m²", above=0.0, doc="Jxx, Jyy, Jzz")
    products: Quantity = vector("kg·m²", default=0.0, doc="Jyz, Jxz, Jxy, as they stand in J")

    @field_validator("moments")
    @classmethod
    def _moments_physical(cls, moments: Quantity) -> Quantity:
        _check_corners(moments)
        return moments

    @field_validator("products")
    @classmethod
    def _physical(cls, products: Quantity, info: ValidationInfo) -> Quantity:
        if "moments" in info.data:
            _check_corners(info.data["moments"], products)
        return products


def _form(raw: Any) -> Any:
    """The model that the keys of an inertia belong to."""
    if isinstance(raw, Model):
        return raw
    forms = {"principal": PrincipalInertia, "moments": MatrixInertia}
    chosen = [form for key, form in forms.items() if is_mapping(raw) and key in raw]
    if len(chosen) != 1:
        accepted = "accepted: principal (with tilt_deg), or moments (with products)"
        refuse(Problem(f"found {describe(raw)}", accepted))
    return chosen[0].model_validate(raw)


Inertia = Annotated[PrincipalInertia | MatrixInertia, BeforeValidator(_form)]


def matrix(moments: tuple[float, ...], products: tuple[float, ...]) -> NDArray[np.float64]:
    """(3, 3) symmetric J from Jxx, Jyy, Jzz and Jyz, Jxz, Jxy."""
    (xx, yy, zz), (yz, xz, xy) = moments, products
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _check_corners(moments: Quantity, products: Quantity | None = None) -> None:
    """Refuse if J is not physical at a corner of the box of supports."""
    supports = moments.supports + (products.supports if products else ((0.0, 0.0),) * 3)
    if not all(map(math.isfinite, (end for support in supports for end in support))):
        refuse(Problem("a distribution without ends", "accepted: one with ends, such as truncated_normal or uniform"))
    for corner in product(*(sorted(set(support)) for support in supports)):
        inertia = matrix(corner[:3], corner[3:])
        least, _, most = np.linalg.eigvalsh(inertia)
        entries = ", ".join(f"{entry:g}" for entry in corner[: 6 if products else 3])
        if least <= 0.0:
            refuse(Problem(f"the draw {entries} is not positive definite", "accepted: smaller products of inertia"))
        if 2.0 * most - np.trace(inertia) > SLACK * np.trace(inertia):
            found = f"the draw {entries} breaks the triangle inequality of the principal moments"
            refuse(Problem(found, "accepted: none above the sum of the others, in every draw"))
