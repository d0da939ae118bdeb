"""A campaign file, parsed once into something that cannot be wrong: frozen, in SI, free of JAX."""

from __future__ import annotations

from rvjax.spec.choice import Choice
from rvjax.spec.fields import Model, channels, count, flag, number, option, part, retuned, scalar, series, validate, vector
from rvjax.spec.keep import Keep
from rvjax.spec.model import Spec, load, parse
from rvjax.spec.quantity import Quantity
from rvjax.spec.requirement import Requirement
from rvjax.spec.schema import schema
from rvjax.spec.series import Series
from rvjax.spec.source import Source

__all__ = [
    "Choice",
    "Keep",
    "Model",
    "Quantity",
    "Requirement",
    "Series",
    "Source",
    "Spec",
    "channels",
    "count",
    "flag",
    "load",
    "number",
    "option",
    "parse",
    "part",
    "retuned",
    "scalar",
    "schema",
    "series",
    "validate",
    "vector",
]
