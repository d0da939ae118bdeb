"""Variables: what a campaign draws, by the names of the streams that it is drawn from.

Each component of a quantity has its stream; the components of a joint distribution share the stream of the quantity.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from rvjax.campaign.distributions import Distribution, JointDistribution
from rvjax.campaign.quantity import Quantity


@dataclass(frozen=True)
class Variable:
    """name: of the stream; draws: names of its numbers, three for a joint law; unit: SI."""

    name: str
    draws: tuple[str, ...]
    law: Distribution | JointDistribution
    unit: str
    doc: str


def variables(quantities: Mapping[str, Quantity]) -> dict[str, Variable]:
    """Every variable of some quantities, by the name of its stream, in the order of the names."""
    unsorted = [variable for name, quantity in quantities.items() for variable in _of(name, quantity)]
    return {variable.name: variable for variable in sorted(unsorted, key=lambda variable: variable.name)}


def _of(name: str, quantity: Quantity) -> Iterator[Variable]:
    names = quantity.names(name)
    if quantity.joint is not None:
        yield Variable(name, names, quantity.joint, quantity.unit, quantity.doc)
    for component, part in zip(names, quantity.parts, strict=False):
        if part.uniforms:
            yield Variable(component, (component,), part, quantity.unit, quantity.doc)
