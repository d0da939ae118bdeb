"""Inertia of a body about its reference point, in several forms.

    {principal: [J₁, J₂, J₃], tilt_deg: a}               J = T diag(J₁, J₂, J₃) Tᵀ, T a rotation by a about a drawn axis
    {principal: [J₁, J₂, J₃], rotation: uniform}         the same, T any rotation, all equally likely
    {moments: [Jxx, Jyy, Jzz], products: {xy: Jxy, xz: Jxz, yz: Jyz}}
    {moments: [Jxx, Jyy, Jzz], products: [Jyz, Jxz, Jxy]}
    {matrix: [[Jxx, Jxy, Jxz], [Jxy, Jyy, Jyz], [Jxz, Jyz, Jzz]]}

Moments Jxx = ∫(y² + z²) dm. Products are entries of J, with their sign in J: Jxy = −∫xy dm, Jxz = −∫xz dm, Jyz = −∫yz dm. A
source that defines products with a plus sign, Ixy = +∫xy dm, needs the opposite sign here. The list of products has the order yz,
xz, xy (each stands where its missing axis x, y, z would); many other programs write xy, xz, yz. A mapping or a matrix leaves no
doubt.

It is physical in every possible draw: the set of physical inertias is convex, so all draws are inside if the corners of the box
of their supports are. With `reject: true` the laws may reach beyond it; unphysical draws are rejected and redrawn.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import product
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, ValidationError, ValidationInfo, field_validator, model_validator

from rvjax.campaign.distributions import Attitude, Direction
from rvjax.campaign.fields import Model, flag, option, scalar, vector
from rvjax.campaign.inertia_validity import about_centre, definite, physical, triangle
from rvjax.campaign.json_forms import distribution
from rvjax.campaign.plain_values import Place, describe, exact, is_list, is_mapping, is_number
from rvjax.campaign.problems import Problem, problems, refuse, unexpected
from rvjax.campaign.quantity import Quantity

INSTEAD = "or reject: true, which redraws unphysical inertias"
PRODUCTS = {"yz": (1, 2), "xz": (0, 2), "xy": (0, 1)}
"""Row and column in J of each product, in the order of the list of products."""

ORDER = "products are [Jyz, Jxz, Jxy] with Jxy = -∫xy dm, or {xy: …, xz: …, yz: …}"
FORMS = "principal (with tilt_deg or rotation), moments (with products), or matrix"


class PrincipalInertia(Model):
    """J = T diag(J₁, J₂, J₃) Tᵀ; the axis of T is drawn uniformly over all directions, or T over all rotations."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"principal": [22, 20, 23]},
        {"principal": [22, 20, 23], "tilt_deg": 3},
        {"principal": [22, 20, 23], "rotation": "uniform"},
    )

    REJECTS: ClassVar[bool] = False

    principal: Quantity = vector("kg·m²", above=0.0, doc="principal moments of inertia")
    tilt_rad: Quantity = scalar(
        "rad", key="tilt_deg", default=0.0, at_least=0.0, doc="angle between the principal axes and the body axes"
    )
    rotation: Literal["uniform"] | None = option(default=None, doc="uniform: the principal axes point anywhere")
    reject: bool = flag(default=False, doc="unphysical inertias are rejected and redrawn")

    @property
    def axis(self) -> Quantity | None:
        """Of the tilt; None where there is no tilt."""
        tilted = not self.tilt_rad.is_fixed or self.tilt_rad.parts[0].high
        return Quantity("vector", (), Direction(1.0), "1", "axis of the tilt of the principal axes") if tilted else None

    @property
    def attitude(self) -> Quantity | None:
        """MRP of the principal axes where these point anywhere; else None."""
        return Quantity("vector", (), Attitude(), "1", "attitude of the principal axes, MRP") if self.rotation else None

    def _quantities(self, prefix: str) -> Iterator[tuple[str, Quantity]]:
        yield from super()._quantities(prefix)
        turns = {"axis": self.axis, "rotation": self.attitude}
        yield from ((prefix + name, quantity) for name, quantity in turns.items() if quantity is not None)

    @field_validator("principal")
    @classmethod
    def _physical(cls, principal: Quantity) -> Quantity:
        if not cls.REJECTS:
            _check_corners(principal)
        return principal

    @model_validator(mode="after")
    def _one_turn(self) -> Self:
        if self.rotation and self.axis is not None:
            refuse(Problem("both rotation and tilt_deg", "accepted: either rotation or tilt_deg", ("rotation",), at_key=True))
        return self

    @property
    def entries(self) -> tuple[Quantity, Quantity | None]:
        """Moments and products of J before it is turned; None: there are none."""
        return self.principal, None


class MatrixInertia(Model):
    """J = [Jxx Jxy Jxz; Jxy Jyy Jyz; Jxz Jyz Jzz], entries as they stand in J: Jxy = −∫xy dm."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"moments": [22, 20, 23], "products": [0.1, -0.2, 0.3]},)

    REJECTS: ClassVar[bool] = False

    moments: Quantity = vector("kg·m²", above=0.0, doc="Jxx, Jyy, Jzz")
    products: Quantity = vector(
        "kg·m²",
        named=tuple(PRODUCTS),
        default=0.0,
        doc="[Jyz, Jxz, Jxy] or {xy: Jxy, xz: Jxz, yz: Jyz}, as they stand in J: Jxy = −∫xy dm",
    )
    reject: bool = flag(default=False, doc="unphysical inertias are rejected and redrawn")

    @field_validator("moments")
    @classmethod
    def _moments_physical(cls, moments: Quantity) -> Quantity:
        if not cls.REJECTS:
            _check_corners(moments)
        return moments

    @field_validator("products")
    @classmethod
    def _physical(cls, products: Quantity, info: ValidationInfo) -> Quantity:
        if "moments" in info.data and not cls.REJECTS:
            _check_corners(info.data["moments"], products)
        return products

    @property
    def entries(self) -> tuple[Quantity, Quantity | None]:
        """Moments and products of J."""
        return self.moments, self.products


class RejectingPrincipalInertia(PrincipalInertia):
    """J = T diag(J₁, J₂, J₃) Tᵀ; unphysical draws are rejected and redrawn."""

    REJECTS: ClassVar[bool] = True
    principal: Quantity = vector("kg·m²", doc="principal moments of inertia")


class RejectingMatrixInertia(MatrixInertia):
    """J = [Jxx Jxy Jxz; Jxy Jyy Jyz; Jxz Jyz Jzz]; unphysical draws are rejected and redrawn."""

    REJECTS: ClassVar[bool] = True
    moments: Quantity = vector("kg·m²", doc="Jxx, Jyy, Jzz")


def _form(raw: Any) -> Any:
    """The model that the keys of an inertia belong to."""
    if isinstance(raw, Model):
        return raw
    rejects = is_mapping(raw) and raw.get("reject") is True
    entries = RejectingMatrixInertia if rejects else MatrixInertia
    forms = {"principal": RejectingPrincipalInertia if rejects else PrincipalInertia, "moments": entries, "matrix": entries}
    chosen = [key for key in forms if is_mapping(raw) and key in raw]
    if len(chosen) != 1:
        refuse(unexpected(raw, f"accepted: {FORMS}"))
    return _of_matrix(raw, entries) if chosen == ["matrix"] else forms[chosen[0]].model_validate(raw)


def _of_matrix(raw: dict[str, Any], form: type[Model]) -> Any:
    """The model of `{matrix: [[…], […], […]]}`; problems stand at the entries of the matrix."""
    rows, names = raw["matrix"], "xyz"
    if not is_list(rows) or len(rows) != 3 or not all(is_list(row) and len(row) == 3 for row in rows):
        accepted = "accepted: [[Jxx, Jxy, Jxz], [Jxy, Jyy, Jyz], [Jxz, Jyz, Jzz]]"
        refuse(unexpected(rows, accepted, ("matrix",)))
    for i, j in PRODUCTS.values():
        if rows[i][j] != rows[j][i]:
            upper, lower = (f"J{names[a]}{names[b]} {_brief(rows[a][b])}" for a, b in ((i, j), (j, i)))
            refuse(Problem(f"{upper} differs from {lower}", "accepted: a symmetric matrix", ("matrix", j, i)))
    if "products" in raw:
        refuse(Problem("both matrix and products", "accepted: one of them", ("products",), at_key=True))
    given = {key: value for key, value in raw.items() if key != "matrix"}
    given |= {"moments": [rows[k][k] for k in range(3)], "products": [rows[i][j] for i, j in PRODUCTS.values()]}
    places = {("moments", k): (k, k) for k in range(3)} | {("products", k): at for k, at in enumerate(PRODUCTS.values())}
    try:
        return form.model_validate(given)
    except ValidationError as error:
        refuse(*(replace(problem, place=_in_matrix(problem.place, places)) for problem in problems(error)))


def _in_matrix(place: Place, places: Mapping[Place, tuple[int, int]]) -> Place:
    """Where something stands in the matrix that stands at a place of moments and products."""
    if place[:2] in places:
        return ("matrix", *places[place[:2]], *place[2:])
    return ("matrix",) if place[:1] in (("moments",), ("products",)) else place


def _brief(value: object) -> str:
    return f"{value:g}" if is_number(value) else describe(value)


class _WithMatrix:
    """Adds the form `matrix` to the JSON Schema of the others."""

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        others = handler(schema)
        entry = {"anyOf": [{"type": "number"}, distribution()]}
        row = {"type": "array", "items": entry, "minItems": 3, "maxItems": 3}
        keys = {"matrix": {"type": "array", "items": row, "minItems": 3, "maxItems": 3}, "reject": {"type": "boolean"}}
        matrix = {"type": "object", "properties": keys, "required": ["matrix"], "additionalProperties": False}
        return {**others, "anyOf": [*others["anyOf"], {"description": "the symmetric matrix J [kg·m²]", **matrix}]}


Inertia = Annotated[
    PrincipalInertia | MatrixInertia | RejectingPrincipalInertia | RejectingMatrixInertia,
    BeforeValidator(_form),
    _WithMatrix(),
]


def check_centre(inertia: PrincipalInertia | MatrixInertia, mass: Quantity, centre: Quantity) -> None:
    """Refuse if J about the centre of mass is not physical in some draw.

    With Σ = ½ tr(J) I − J the condition is Σ_C = Σ_O − m c cᵀ ≥ 0. For given m it is convex in Σ_O and c together, and it gets
    harder as m grows: the corners at the largest m tell. Where the principal axes or c may point anywhere, m |c|² must not be
    above the least eigenvalue of Σ_O.
    """
    if inertia.REJECTS or not centre.largest_norm:
        return
    heaviest = mass.supports[0][1]
    accepted = f"accepted: a centre of mass nearer to the reference point, {INSTEAD} (in inertia_kgm2)"
    if not math.isfinite(heaviest) or not math.isfinite(centre.largest_norm):
        refuse(Problem("mass or centre of mass is unbounded", f"accepted: bounded distributions, {INSTEAD} (in inertia_kgm2)"))
    free = centre.joint is not None or (isinstance(inertia, PrincipalInertia) and (inertia.axis or inertia.attitude))
    if free:
        least = float(np.linalg.eigvalsh(sigmas(inertia)).min())
        if heaviest * centre.largest_norm**2 > least:
            reached, allowed = exact(heaviest * centre.largest_norm**2), exact(max(least, 0.0))
            message = f"m |c|^2 reaches {reached} kg·m², the body allows {allowed} kg·m²"
            refuse(Problem(message, accepted))
        return
    box = corners(*inertia.entries, centre)
    moved = about_centre(_entries(box), heaviest, tuple(box[-3:]))
    wrong = np.flatnonzero(~physical(moved))
    if wrong.size:
        at = ", ".join(exact(entry) for entry in box[-3:, wrong[0]])
        refuse(Problem(f"the draw {at} with {exact(heaviest)} kg leaves an unphysical inertia", accepted))


def sigmas(inertia: PrincipalInertia | MatrixInertia) -> NDArray[np.float64]:
    """(n, 3, 3) Σ = ½ tr(J) I − J at every corner of the box of supports, before J is turned."""
    full = [matrix(tuple(corner[:3]), tuple(corner[3:])) for corner in corners(*inertia.entries).T]
    return np.array([0.5 * np.trace(j) * np.eye(3) - j for j in full])


def matrix(moments: tuple[float, ...], products: tuple[float, ...]) -> NDArray[np.float64]:
    """(3, 3) symmetric J from Jxx, Jyy, Jzz and Jyz, Jxz, Jxy."""
    (xx, yy, zz), (yz, xz, xy) = moments, products
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def corners(*quantities: Quantity | None) -> NDArray[np.float64]:
    """Every corner of the box of supports, in columns; the components of the quantities in rows, of None three zeros."""
    none = ((0.0, 0.0),) * 3
    boxes = [none if quantity is None else quantity.supports for quantity in quantities]
    return np.array(list(product(*(sorted(set(support)) for box in boxes for support in box)))).T


def _entries(box: NDArray[np.float64]) -> Any:
    return tuple(box[:6])


def _check_corners(moments: Quantity, products: Quantity | None = None) -> None:
    """Refuse if J is not physical at a corner of the box of supports."""
    given = [quantity for quantity in (moments, products) if quantity is not None]
    if not all(math.isfinite(end) for quantity in given for support in quantity.supports for end in support):
        refuse(
            Problem(
                "the distribution is unbounded",
                f"accepted: a bounded distribution, such as truncated_normal or uniform, {INSTEAD}",
            )
        )
    box = corners(moments, products)
    for holds, message, accepted in (
        (definite, "is not positive definite", "accepted: smaller products of inertia"),
        (triangle, "breaks the triangle inequality of the principal moments", "accepted: none above the sum of the others"),
    ):
        order = "" if products is None else f"; {ORDER}"
        wrong = np.flatnonzero(~holds(_entries(box)))
        if wrong.size:
            entries = ", ".join(exact(entry) for entry in box[: 3 * len(given), wrong[0]])
            refuse(Problem(f"the draw {entries} {message}", f"{accepted}, in every draw, {INSTEAD}{order}"))
