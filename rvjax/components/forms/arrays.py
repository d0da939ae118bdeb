"""Plain arrays for the functions of a user, and back.

    Vector ↔ (3,)      Channels ↔ (6,)      Symmetric ↔ (3, 3)      Thrusts ↔ (n,)      a number ↔ ()

What a user's function returns is checked when it is traced: kind, shape and type. Vectors of this package are accepted as they
are.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import jax
import jax.numpy as jnp

from rvjax.components.user_mistakes import UserMistake
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels, Scalar, Symmetric, Thrusts, Vector, rotation

_KINDS = (Vector, Channels, Symmetric, Thrusts)


def array(value: Any) -> Any:
    """A vector, channels, a symmetric matrix or thrusts as an array; anything else is not changed."""
    if isinstance(value, Symmetric):
        v = value
        return jnp.stack([jnp.stack(row) for row in ((v.xx, v.xy, v.xz), (v.xy, v.yy, v.yz), (v.xz, v.yz, v.zz))])
    return jnp.stack(value.parts()) if isinstance(value, _KINDS) else value


def arrays(tree: Any) -> Any:
    """The tree with arrays instead of vectors."""
    if isinstance(tree, Numbers):
        return Numbers({name: array(value) for name, value in tree.items()})
    return jax.tree.map(array, tree, is_leaf=lambda x: isinstance(x, _KINDS))


def rotation_matrix(sigma: Any) -> Any:
    """(3, 3) R(σ) = I − 4(1−σᵀσ)/(1+σᵀσ)² σ^× + 8/(1+σᵀσ)² (σ^×)², from the target's frame T to the pursuer's frame P.

    sigma: (3,) modified Rodrigues parameters of P with respect to T.
    """
    rows = rotation(vector(sigma, "sigma"))
    return jnp.stack([array(row) for row in (rows.a, rows.b, rows.c)])


def number(value: Any, what: str) -> Scalar:
    """A real number."""
    return _checked(value, what, ()) if not isinstance(value, _KINDS) else _refuse(value, what, "a number")


def vector(value: Any, what: str) -> Vector:
    """A vector of three numbers."""
    if isinstance(value, Vector):
        return value
    parts = _checked(value, what, (3,))
    return Vector(parts[0], parts[1], parts[2])


def like(example: Any, value: Any, what: str) -> Any:
    """A value of the kind of the example: Channels or Thrusts."""
    if isinstance(value, type(example)):
        return value
    count = len(example.parts())
    parts = _checked(value, what, (count,))
    return example.like(tuple(parts[i] for i in range(count)))


def tree_like(example: Any, value: Any, what: str) -> Any:
    """A tree with the structure, shapes and kind of numbers of the example."""
    wanted, given = jax.tree.structure(example), jax.tree.structure(value)
    if wanted != given:
        raise UserMistake(f"{what} is {_short(given)}", f"accepted: the structure of the state, {_short(wanted)}")
    leaves = [_checked(b, f"{what}, entry {i}", jnp.shape(a)) for i, (a, b) in enumerate(_pairs(example, value), start=1)]
    return jax.tree.unflatten(wanted, leaves)


def state(value: Any, what: str) -> Any:
    """A state: any tree of real numbers and arrays."""
    if value is None:
        raise UserMistake(
            f"{what} is None", "accepted: numbers and arrays, in tuples, named tuples or mappings; () without a state"
        )
    leaves = [_checked(leaf, f"{what}, entry {i}", None) for i, leaf in enumerate(jax.tree.leaves(value), start=1)]
    return jax.tree.unflatten(jax.tree.structure(value), [leaf * 1.0 for leaf in leaves])


def signals(given: Any, declared: Mapping[str, Any] | None, what: str) -> dict[str, Any]:
    """The signals by name, as numbers, vectors, channels or symmetric matrices; those that are declared and no others."""
    if not isinstance(given, Mapping):
        raise UserMistake(f"{what} are {kind(given)}", "accepted: a mapping of names to values")
    if declared is not None and (missing := [name for name in declared if name not in given]):
        raise UserMistake(f"the declared signal {missing[0]} is not given", "accepted: every declared signal at every instant")
    if declared is not None and (extra := [name for name in given if name not in declared]):
        raise UserMistake(f"the signal {extra[0]} is not declared", f"accepted: {', '.join(declared) or 'none'}")
    return {str(name): _signal(value, f"the signal {name}") for name, value in given.items()}


def _signal(value: Any, what: str) -> Any:
    if isinstance(value, _KINDS):
        return value
    shape = jnp.shape(_checked(value, what, None))
    if shape == ():
        return jnp.asarray(value)
    if shape == (3,):
        return vector(value, what)
    if shape == (6,):
        return like(Channels.pair(0.0, 0.0), value, what)
    if shape == (3, 3):
        v = jnp.asarray(value)
        return Symmetric(v[0, 0], v[1, 1], v[2, 2], v[1, 2], v[0, 2], v[0, 1])
    raise UserMistake(f"{what} has the shape {shape}", "accepted: (), (3,), (6,) or (3, 3)")


def _checked(value: Any, what: str, shape: tuple[int, ...] | None) -> Any:
    """An array of real numbers of this shape; any shape with None."""
    accepted = "real numbers" if shape is None else "a real number" if shape == () else f"real numbers of shape {shape}"
    given = _as_array(value)
    if given is None:
        return _refuse(value, what, accepted)
    if not (jnp.issubdtype(given.dtype, jnp.floating) or jnp.issubdtype(given.dtype, jnp.integer)):
        raise UserMistake(f"{what} has the type {given.dtype}", f"accepted: {accepted}")
    if shape is not None and given.shape != shape:
        raise UserMistake(f"{what} has the shape {given.shape}", f"accepted: {accepted}")
    return given


def _as_array(value: Any) -> Any:
    """The value as an array; None where it is none."""
    try:
        return None if value is None else jnp.asarray(value)
    except (TypeError, ValueError):
        return None


def _refuse(value: Any, what: str, accepted: str) -> Any:
    raise UserMistake(f"{what} is {kind(value)}", f"accepted: {accepted}")


def kind(value: Any) -> str:
    """`None`, or `a tuple`."""
    return "None" if value is None else f"a {type(value).__name__}"


def _short(structure: Any) -> str:
    return str(structure).removeprefix("PyTreeDef(").removesuffix(")")


def _pairs(first: Any, second: Any) -> list[tuple[Any, Any]]:
    return list(zip(jax.tree.leaves(first), jax.tree.leaves(second), strict=True))
