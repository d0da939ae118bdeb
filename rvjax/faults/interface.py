"""What every fault says: on which channels, and from when on."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

from rvjax.columns import CHANNELS
from rvjax.spec import Model, Quantity, channels, option
from rvjax.spec.problem import Problem, refuse
from rvjax.spec.values import describe, is_list


def _selected(given: Any) -> tuple[str, ...]:
    names = CHANNELS if given == "all" else given
    if is_list(names) and names:
        strange = [name for name in names if name not in CHANNELS]
        repeated = [name for name in CHANNELS if names.count(name) > 1]
        found = f"found {describe(strange[0])}" if strange else f"{repeated[0]} stands twice" if repeated else ""
    else:
        found = "" if names is CHANNELS else f"found {describe(given)}"
    if found:
        refuse(Problem(found, f"accepted: all, or a list out of {', '.join(CHANNELS)}, each once"))
    return tuple(names)


_SCHEMA = {"anyOf": [{"const": "all"}, {"type": "array", "items": {"enum": list(CHANNELS)}, "minItems": 1, "uniqueItems": True}]}


class FaultParameters(Model):
    """Onset of a fault, and the channels it acts on; on the others it never begins."""

    onset_s: Quantity = channels("s", at_least=0.0, doc="time t_f at which the fault begins")
    channels: Annotated[tuple[str, ...], BeforeValidator(_selected), WithJsonSchema(_SCHEMA)] = option(
        default="all", doc="which channels: all, or a list of them"
    )
