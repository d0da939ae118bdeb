"""Grid: every combination of the levels of some draws; all other draws by their own streams.

    levels: {pursuer.mass_kg: 5, start.rho_m.x: [-20, 0, 20]}

A number n of levels is n equally probable ones, x_i = F⁻¹((i + ½)/n); a list is its own values, in the unit of the draw. There
are as many samples as combinations; the name that comes last changes from sample to sample. Samples are not independent: the plan
is for exploration, and no verdict is issued on it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic_core import core_schema

from rvjax.campaign import Model, option
from rvjax.campaign.distributions import Distribution
from rvjax.campaign.plain_values import describe, is_list, is_mapping, is_number
from rvjax.campaign.problems import Problem, refuse
from rvjax.components.samplers.interface import PLACE, Samples, Sampling, Scheme, Setting, Streams, Values
from rvjax.stats.sampling_design import Exploration

MOST_LEVELS = 10_000
MOST_SAMPLES = 10**9
SHOWN = 8
"""Numbers of levels that a message tells."""

Levels = Mapping[str, int | tuple[float, ...]]


class ReadLevels:
    """Reads the levels of each draw."""

    def read(self, raw: Any) -> Levels:
        """By name, in rising order, or every problem at once."""
        if not is_mapping(raw) or not raw:
            refuse(Problem(f"found {describe(raw)}", "accepted: a mapping from names of draws to levels"))
        accepted = f"accepted: a number of levels, 1 to {MOST_LEVELS:,}, or a list of values that differ"
        wrong = [Problem(f"found {describe(given)}", accepted, (name,)) for name, given in raw.items() if not self._is(given)]
        if wrong:
            refuse(*wrong)
        return {name: tuple(map(float, given)) if is_list(given) else int(given) for name, given in sorted(raw.items())}

    def _is(self, given: Any) -> bool:
        if is_list(given):
            return 0 < len(given) <= MOST_LEVELS and all(map(is_number, given)) and len(set(given)) == len(given)
        return isinstance(given, int) and not isinstance(given, bool) and 1 <= given <= MOST_LEVELS

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        count = {"type": "integer", "minimum": 1, "maximum": MOST_LEVELS}
        values = {"type": "array", "items": {"type": "number"}, "minItems": 1}
        return {"type": "object", "additionalProperties": {"anyOf": [count, values]}, "minProperties": 1}


class Parameters(Model):
    """Levels of a full factorial plan."""

    levels: Annotated[Levels, ReadLevels()] = option(doc="of each draw, a number of levels or a list of values in SI")


@dataclass(frozen=True)
class Grid:
    """values: of each draw, in the order of the names."""

    seed: int
    values: Mapping[str, Values]

    def at(self, samples: Samples) -> Streams:
        """The points of some samples."""
        found: dict[str, Values] = {}
        rest = samples
        for name, values in reversed(list(self.values.items())):
            rest, level = np.divmod(rest, len(values))
            found[name] = values[level]
        return Streams(self.seed, samples, found)


def _count(given: int | tuple[float, ...]) -> int:
    return given if isinstance(given, int) else len(given)


def _values(given: int | tuple[float, ...], law: Any) -> Values:
    return law.ppf((np.arange(given) + 0.5) / given) if isinstance(given, int) else np.array(given)


def scheme(parameters: Parameters) -> Scheme:
    """What the levels make."""
    levels = parameters.levels

    def wrong(setting: Setting) -> Iterable[Problem]:
        for name, given in levels.items():
            place = (*PLACE, "levels", name)
            if found := setting.names.scalar(name):
                yield Problem(*found, place, at_key=True)
                continue
            if not isinstance(given, int):
                yield from outside(setting.names.drawn[name].law, given, place)
        product = math.prod(map(_count, levels.values()))
        if product != setting.samples:
            counts = " · ".join(str(_count(given)) for given in list(levels.values())[:SHOWN]) + " · …" * (len(levels) > SHOWN)
            whole = f"{product:,}" if product <= MOST_SAMPLES else f"fewer levels: more than {MOST_SAMPLES:,} samples"
            accepted = f"accepted: {whole}, the combinations of the levels ({counts})"
            yield Problem(f"{setting.samples:,} samples of a grid", accepted, ("samples",))

    def make(setting: Setting) -> Grid:
        return Grid(setting.seed, {name: _values(given, setting.names.drawn[name].law) for name, given in levels.items()})

    return Scheme(make, wrong, tuple(levels), extends=False)


def outside(law: Any, values: tuple[float, ...], place: tuple[str | int, ...]) -> Iterable[Problem]:
    """The values that are outside the support of a law."""
    scalar: Distribution = law
    for index, value in enumerate(values):
        if not scalar.low <= value <= scalar.high:
            accepted = f"accepted: {scalar.low:g} to {scalar.high:g}, in the unit of the draw"
            yield Problem(f"{value:g} is outside what is drawn", accepted, (*place, index))


COMPONENT = Sampling(Parameters, scheme, basis=Exploration())
