"""Layouts of thrusters: where they sit, which way they push, and which wrenches they can give together.

    w = B f,  0 ≤ f ≤ f_max,      B = [d₁ … d_N; r₁×d₁ … r_N×d_N]

    symbol   meaning                                                          unit
    r        place of a thruster, from the reference point, in P              m
    d        direction of its force on the spacecraft, in P, |d| = 1          1
    f        thrust                                                           N
    w        force, and torque about the reference point, in P                N, N·m

cube-24       Edge a. At each corner (a/2)(s₁, s₂, s₃), s = ±1, three thrusters, one along each axis, which push inwards:
              d = −s₁ eₓ, −s₂ e_y, −s₃ e_z (the plumes go outwards). Alone on a channel they give 4 f_max, and 8 (a/2) f_max.
pinwheel-12   Edge a. In the middle of each of the twelve edges of a cube one thruster that pushes inwards, so that turning the
              cube by x → y → z maps each thruster to another: r = (a/2)(−s eₓ + o e_y), d = s eₓ for s, o = ±1, and in turn for y
              and z. Each axis has four of them, which give its force and one torque: 2 f_max and 2 (a/2) f_max. Twelve are
              hardly more than needed: the loss of any thruster loses a force.

The attainable wrenches are a zonotope. It must hold the origin inside, not on its surface: then any wrench, if only it is small
enough, can be given although no thruster pulls. The limit of a channel is the largest wrench on it with the other five zero (a
linear program); it may be different on either side. M. Bodson, "Evaluation of optimization methods for control allocation",
J. Guidance, Control, and Dynamics, 2002.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign.linear_program import reach
from rvjax.columns import CHANNELS

Values = NDArray[np.float64]
Triple = tuple[float, float, float]

FEWEST, MOST = 7, 64
"""Thrusters in a layout: six that only push cannot push in every direction."""

ROUNDING = 1e-9
"""A limit below this share of what all thrusters of a channel have together is none, and so is a singular value."""


@dataclass(frozen=True)
class Layout:
    """at, along, most: place [m], direction and largest thrust [N] of each thruster, in the order of their names."""

    at: tuple[Triple, ...]
    along: tuple[Triple, ...]
    most: tuple[float, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """t1, t2, …"""
        return thruster_names(len(self.most))

    @property
    def entries(self) -> list[dict[str, Any]]:
        """The thrusters as a campaign lists them."""
        rows = zip(self.at, self.along, self.most, strict=True)
        return [{"at_m": list(at), "along": list(along), "max_N": most} for at, along, most in rows]

    @property
    def matrix(self) -> Values:
        """(6, N) B."""
        along = np.array(self.along)
        return np.vstack([along.T, np.cross(np.array(self.at), along).T])

    def without(self, index: int) -> Layout:
        """The layout after the loss of a thruster."""
        return replace(self, most=(*self.most[:index], 0.0, *self.most[index + 1 :]))


@dataclass(frozen=True)
class Margin:
    """What remains without a thruster. share: smallest remaining share of the twelve limits; channel: of that limit, as +fx."""

    lost: str
    rank: int
    share: float
    channel: str


def thruster_names(count: int) -> tuple[str, ...]:
    """t1, t2, …"""
    return tuple(f"t{index + 1}" for index in range(count))


def cube(size: float, most: float) -> Layout:
    """cube-24, of the edge `size` [m], each with the thrust `most` [N]."""
    corners = list(itertools.product((1.0, -1.0), repeat=3))
    at = [_triple(np.array(corner) * size / 2) for corner in corners for _ in range(3)]
    along = [_triple(-np.eye(3)[axis] * corner[axis]) for corner in corners for axis in range(3)]
    return Layout(tuple(at), tuple(along), (most,) * 24)


def pinwheel(size: float, most: float) -> Layout:
    """pinwheel-12, of the edge `size` [m], each with the thrust `most` [N]."""
    at, along = list[Triple](), list[Triple]()
    for axis, push, side in itertools.product(range(3), (1.0, -1.0), (1.0, -1.0)):
        direction, across = np.eye(3)[axis], np.eye(3)[(axis + 1) % 3]
        at.append(_triple((side * across - push * direction) * size / 2))
        along.append(_triple(push * direction))
    return Layout(tuple(at), tuple(along), (most,) * 12)


LAYOUTS = {"cube-24": cube, "pinwheel-12": pinwheel}


def rank(layout: Layout) -> int:
    """Of B, over the thrusters that are not lost; rows scaled, so that metres and newtons do not matter."""
    return int(np.linalg.matrix_rank(_scaled(layout), tol=ROUNDING))


@cache
def limits(layout: Layout) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """(upper, lower): the largest w₊ and w₋ with ± w on one channel, zero on the five others, for each channel [N, N·m].

    Zero where there is none: then the layout cannot be controlled.
    """
    scale = _scale(layout)
    sides = [_reach(layout, channel, sign) * float(scale[channel]) for sign in (1.0, -1.0) for channel in range(6)]
    return tuple(sides[:6]), tuple(sides[6:])


@cache
def margins(layout: Layout) -> tuple[Margin, ...]:
    """The margin after the loss of each single thruster."""
    healthy = [*limits(layout)[0], *limits(layout)[1]]
    sides = [f"{sign}{channel}" for sign in "+-" for channel in CHANNELS]
    result = list[Margin]()
    for index, name in enumerate(layout.names):
        rest = layout.without(index)
        left = [*limits(rest)[0], *limits(rest)[1]]
        shares = [(min(now / before, 1.0), side) for now, before, side in zip(left, healthy, sides, strict=True)]
        share, side = min(shares, key=lambda pair: round(pair[0], 9))  # the first of equal shares, despite rounding
        result.append(Margin(name, rank(rest), share, side))
    return tuple(result)


def _reach(layout: Layout, channel: int, sign: float) -> float:
    """max λ with A x = ± λ e, 0 ≤ x ≤ 1, in the scale of the channel; 0 within rounding of 0."""
    far = reach(_scaled(layout).tolist(), [sign if index == channel else 0.0 for index in range(6)])
    return far if far > ROUNDING else 0.0


def _scaled(layout: Layout) -> Values:
    """A = diag(1/c) B diag(f_max)."""
    return layout.matrix * np.array(layout.most) / _scale(layout)[:, None]


def _scale(layout: Layout) -> Values:
    """c = |B| f_max; 1 where nothing acts on a channel."""
    scale = np.array([math.fsum(row) for row in np.abs(layout.matrix) * np.array(layout.most)])
    return np.where(scale > 0.0, scale, 1.0)


def _triple(values: Values) -> Triple:
    x, y, z = (float(value) + 0.0 for value in values)  # no −0
    return x, y, z
