"""Grid: every combination of the levels of some draws; all other draws are random.

    levels: {pursuer.mass_kg: 5, start.rho_m.x: [-20, 0, 20]}

A number n means n equally probable levels, x_i = F⁻¹((i + ½)/n); a list holds the values, in the unit of the draw. The number
of samples must equal the number of combinations; the last name changes from sample to sample. Samples are not independent, so
this design is for exploration and gives no verdict.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic_core import core_schema

from rvjax.campaign import Model, option
from rvjax.campaign.distributions import Distribution
from rvjax.campaign.plain_values import describe, exact, is_list, is_mapping, is_number
from rvjax.campaign.problems import Problem, refuse
from rvjax.components.samplers.interface import PLACE, Samples, Sampling, Scheme, Setting, Streams, Values
from rvjax.stats.sampling_design import Exploration

MOST_LEVELS = 10_000
MOST_SAMPLES = 10**9
SHOWN = 8
"""Numbers of levels shown in a message."""

Levels = Mapping[str, int | tuple[float, ...]]


class ReadLevels:
    """Reads the levels of each draw."""

    def read(self, raw: Any) -> Levels:
        """The levels by name, sorted. Reports every problem at once."""
        if not is_mapping(raw) or not raw:
            refuse(Problem(f"found {describe(raw)}", "accepted: a mapping from names of draws to levels"))
        accepted = f"accepted: a number of levels, 1 to {MOST_LEVELS}, or a list of different values"
        wrong = [
            Problem(f"found {describe(levels)}", accepted, (name,)) for name, levels in raw.items() if not self._valid(levels)
        ]
        if wrong:
            refuse(*wrong)
        return {name: tuple(map(float, levels)) if is_list(levels) else int(levels) for name, levels in sorted(raw.items())}

    def _valid(self, levels: Any) -> bool:
        if is_list(levels):
            return 0 < len(levels) <= MOST_LEVELS and all(map(is_number, levels)) and len(set(levels)) == len(levels)
        return isinstance(levels, int) and not isinstance(levels, bool) and 1 <= levels <= MOST_LEVELS

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        count = {"type": "integer", "minimum": 1, "maximum": MOST_LEVELS}
        values = {"type": "array", "items": {"type": "number"}, "minItems": 1}
        return {"type": "object", "additionalProperties": {"anyOf": [count, values]}, "minProperties": 1}


class Parameters(Model):
    """Levels of a full factorial design."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"levels": {"pursuer.mass_kg": 3}},)

    levels: Annotated[Levels, ReadLevels()] = option(doc="number of levels, or list of values in SI, of each draw")


@dataclass(frozen=True)
class Grid:
    """A full factorial design. values: levels of each draw, sorted by name."""

    seed: int
    values: Mapping[str, Values]

    def at(self, samples: Samples) -> Streams:
        """The points of some samples."""
        chosen: dict[str, Values] = {}
        rest = samples
        for name, values in reversed(list(self.values.items())):
            rest, level = np.divmod(rest, len(values))
            chosen[name] = values[level]
        return Streams(self.seed, samples, chosen)


def _count(levels: int | tuple[float, ...]) -> int:
    return levels if isinstance(levels, int) else len(levels)


def _values(levels: int | tuple[float, ...], law: Any) -> Values:
    return law.ppf((np.arange(levels) + 0.5) / levels) if isinstance(levels, int) else np.array(levels)


def scheme(parameters: Parameters) -> Scheme:
    """The grid of these levels."""
    levels = parameters.levels

    def problems(setting: Setting) -> Iterable[Problem]:
        for name, values in levels.items():
            place = (*PLACE, "levels", name)
            if wrong := setting.names.scalar(name):
                yield Problem(*wrong, place, at_key=True)
            elif not isinstance(values, int):
                yield from outside(setting.names.drawn[name].law, values, place)
        product = math.prod(map(_count, levels.values()))
        if product != setting.samples:
            counts = " · ".join(str(_count(values)) for values in list(levels.values())[:SHOWN]) + " · …" * (len(levels) > SHOWN)
            whole = str(product) if product <= MOST_SAMPLES else f"fewer levels: more than {MOST_SAMPLES:,} samples"
            accepted = f"accepted: {whole}, the combinations of the levels ({counts})"
            yield Problem(f"{setting.samples:,} samples of a grid", accepted, ("samples",))

    def make(setting: Setting) -> Grid:
        return Grid(setting.seed, {name: _values(values, setting.names.drawn[name].law) for name, values in levels.items()})

    return Scheme(make, problems, tuple(levels), extends=False)


def outside(law: Any, values: tuple[float, ...], place: tuple[str | int, ...]) -> Iterable[Problem]:
    """The values outside the support of a distribution."""
    scalar: Distribution = law
    for index, value in enumerate(values):
        if not scalar.low <= value <= scalar.high:
            accepted = f"accepted: {exact(scalar.low)} to {exact(scalar.high)}, in the unit of the draw"
            yield Problem(f"{exact(value)} is outside the distribution", accepted, (*place, index))


COMPONENT = Sampling(Parameters, scheme, design=Exploration())
