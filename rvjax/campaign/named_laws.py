"""The section `laws`: other laws of some draws, named before the flights, under which requirements may be judged.

    laws:
      heavy: {pursuer.mass_kg: {uniform: [100, 120]}}

Each law says, for places of the campaign as in `--set`, what stands there instead. What that may be is known where the campaign
is loaded a second time with these values (`rvjax.simulation.named_laws`).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from pydantic_core import core_schema

from rvjax.campaign.choice import NAME, NAME_WORDS
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.plain_values import is_mapping
from rvjax.campaign.problems import Problem, refuse, unexpected

LAWS = "laws"

A_LAW = "accepted: places and their laws, such as {pursuer.mass_kg: {uniform: [90, 110]}}"

NO_LAWS = "accepted: the name of a law in the section laws"

Values = Mapping[str, Any]
"""What a law puts at places of the campaign."""


def unknown(names: Sequence[str | None], laws: Collection[str] | None) -> list[Problem]:
    """A problem for each requirement that is judged under an unknown law. names: of each requirement, None without a law; laws:
    known names, None where the section is wrong."""
    if laws is None:
        return []
    return [
        Problem(f"{name} is no law of this campaign", did_you_mean(name, laws) if laws else NO_LAWS, (index, "under"))
        for index, name in enumerate(names)
        if name is not None and name not in laws
    ]


class NamedLaws:
    """Reads the section."""

    def read(self, raw: Any) -> Mapping[str, Values]:
        """The values of each law by its name, or every problem at once."""
        if not is_mapping(raw):
            refuse(unexpected(raw, "accepted: a mapping of names, such as {heavy: {pursuer.mass_kg: {uniform: [100, 120]}}}"))
        wrong: list[Problem] = []
        for name, values in raw.items():
            if not NAME.fullmatch(name):
                wrong.append(unexpected(name, NAME_WORDS, (name,), at_key=True))
            elif not is_mapping(values) or not values:
                wrong.append(unexpected(values, A_LAW, (name,)))
        return refuse(*wrong) if wrong else {name: dict(values) for name, values in raw.items()}

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        law = {"type": "object", "minProperties": 1}
        return {"type": "object", "propertyNames": {"pattern": f"^{NAME.pattern}$"}, "additionalProperties": law}
