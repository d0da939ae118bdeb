"""A campaign file, parsed once into something that cannot be wrong: frozen, in SI, free of JAX."""

from __future__ import annotations

from rvjax.campaign.choice import Choice
from rvjax.campaign.csv_columns import Series
from rvjax.campaign.fields import (
    Model,
    channels,
    count,
    flag,
    number,
    option,
    part,
    scalar,
    series,
    validate,
    vector,
    with_defaults,
)
from rvjax.campaign.json_schema import schema
from rvjax.campaign.model import Spec, load, parse, parse_with
from rvjax.campaign.quantity import Quantity
from rvjax.campaign.requirement import Requirement
from rvjax.campaign.source import Source
from rvjax.campaign.trace_retention import Keep

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
    "parse_with",
    "part",
    "scalar",
    "schema",
    "series",
    "validate",
    "vector",
    "with_defaults",
]
