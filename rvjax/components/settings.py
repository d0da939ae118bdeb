"""The value of a campaign at a place, given or by default: `controller.gains.k1` → 0.06."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rvjax.campaign import Model, Quantity, Spec
from rvjax.campaign.choice import Choice
from rvjax.campaign.declarations import declared
from rvjax.campaign.distributions import Fixed
from rvjax.campaign.nominal_body import NominalBody
from rvjax.campaign.overrides import value_at
from rvjax.campaign.plain_values import is_number
from rvjax.campaign.python_files import PythonFile
from rvjax.campaign.tuning_parameters import Value
from rvjax.components.registry import FAMILY_OF, component
from rvjax.errors import RvjaxError


def setting(spec: Spec, place: str) -> Value | None:
    """The value at a place, in the unit of the key; None if it is drawn, or if the campaign has no such key."""
    known, value = value_at(spec.source.value, place)
    if known:
        return value if isinstance(value, int | float | str) else None
    return default(spec, place, flies=True)


def default(spec: Spec, place: str, *, flies: bool = False) -> Value | None:
    """The default of a key that the campaign file does not have, in the unit of the key; None if there is none. flies: whether
    the code of a user may be executed for it; else the default of a parameter in a user's file is not known."""
    steps = place.split(".")
    for choice in spec.components:
        path = [str(part) for part in choice.path]
        if steps[: len(path)] == path and len(steps) > len(path) and choice.section in FAMILY_OF:
            if steps[len(path) :] == ["use"]:
                return choice.use
            if isinstance(choice.use, PythonFile) and not flies:
                return None
            try:
                parameters = component(FAMILY_OF[choice.section], choice.use).parameters
            except RvjaxError:  # of a package that is not installed here
                return None
            given = NominalBody.of(spec.pursuer).complete(parameters, choice.parameters)
            return _walk(parameters.model_validate(given), steps[len(path) :])
    return _walk(spec, steps)


def _walk(model: Any, steps: Sequence[str]) -> Value | None:
    for step in steps:
        names = {info.alias or name: name for name, info in type(model).model_fields.items()} if isinstance(model, Model) else {}
        if step not in names:
            return None
        holder, field = model, names[step]
        model = getattr(model, field)
        about = declared(type(holder).model_fields[field])
        factor = about.factor if about is not None else 1.0
        if isinstance(model, Quantity):
            return model.parts[0].low / factor if model.shape == "scalar" and isinstance(model.parts[0], Fixed) else None
        if is_number(model):
            return model / factor if about is not None else model
    if isinstance(model, Choice):
        return model.use
    return model if isinstance(model, str | bool) else None
