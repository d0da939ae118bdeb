"""Which component a campaign uses, with parameters that are read later, by the component's own model."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from pydantic import GetJsonSchemaHandler, ValidationInfo
from pydantic_core import core_schema

from rvjax.campaign.plain_values import Place, describe, is_list, is_mapping
from rvjax.campaign.problems import Problem, refuse

NAME = re.compile(r"[a-z][a-z0-9-]{0,63}")
NAME_WORDS = "accepted: small letters, digits and hyphens, the first a letter, at most 64"
KEYS = ("use", "name")
"""What a campaign says of a component beside its parameters."""


@dataclass(frozen=True)
class Choice:
    """One component: `{use: …, name: optional, …parameters}`.

    use: which component; name: its own, unique in its list; path: its place in the campaign; parameters: as written there.
    """

    use: str
    name: str
    path: Place
    parameters: Mapping[str, Any]

    @property
    def prefix(self) -> str:
        """Of the names of its quantities: `controller`; `faults.effectiveness`, wherever in its list it stands."""
        field, *index = self.path
        return f"{field}.{self.name}" if index else str(field)


def entry_names(entries: Sequence[Any]) -> list[str]:
    """Each entry's own name, or else its `use`, numbered from the second of a kind on; "" if it has neither."""
    given = [_text(entry, "name") for entry in entries]
    numbers: dict[str, int] = {}
    names: list[str] = []
    for own, entry in zip(given, entries, strict=True):
        use = _text(entry, "use")
        numbers[use] = numbers.get(use, 0) + (not own)
        names.append(own or (use if numbers[use] == 1 else use and f"{use}-{numbers[use]}"))
    return names


def _text(entry: Any, key: str) -> str:
    value = entry.get(key, "") if is_mapping(entry) else ""
    return value if isinstance(value, str) else ""


class OneChoice:
    """Reads one component."""

    def read(self, raw: Any, info: ValidationInfo) -> Any:
        """The choice, or every problem at once."""
        problems: list[Problem] = []
        choice = self.entry(raw, (str(info.field_name),), entry_names([raw])[0], problems)
        return refuse(*problems) if problems else choice

    def entry(self, raw: Any, path: Place, name: str, problems: list[Problem]) -> Choice | None:
        """One choice at its path; places of problems are relative to the field, which is the first step of the path."""
        below = path[1:]
        if not is_mapping(raw):
            problems.append(Problem(f"found {describe(raw)}", "accepted: a mapping with use and parameters", below))
            return None
        if "use" not in raw:
            accepted = "accepted: the name of a component, see `rvjax list`"
            problems.append(Problem("missing", accepted, (*below, "use"), at_key=True))
        wrong = [key for key in KEYS if key in raw and not NAME.fullmatch(_text(raw, key))]
        problems += [Problem(f"found {describe(raw[key])}", NAME_WORDS, (*below, key)) for key in wrong]
        parameters = {key: value for key, value in raw.items() if key not in KEYS}
        return Choice(_text(raw, "use"), name, path, MappingProxyType(parameters))

    def json_schema(self) -> dict[str, Any]:
        """What the field accepts, as JSON Schema; parameters are the component's own."""
        name = {"type": "string", "pattern": f"^{NAME.pattern}$"}
        return {"type": "object", "properties": {"use": name, "name": name}, "required": ["use"]}

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.with_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return self.json_schema()


class ListOfChoices(OneChoice):
    """Reads a list of components with different names."""

    def read(self, raw: Any, info: ValidationInfo) -> Any:
        """The choices, or every problem at once."""
        if not is_list(raw):
            refuse(Problem(f"found {describe(raw)}", "accepted: a list of mappings, each with use"))
        problems: list[Problem] = []
        names = entry_names(raw)
        choices = tuple(self.entry(item, (str(info.field_name), index), names[index], problems) for index, item in enumerate(raw))
        first: dict[str, int] = {}
        for index, name in enumerate(names):
            if name and first.setdefault(name, index) != index:
                found, accepted = f"the name {name} stands twice", f"the first is entry {first[name]}"
                problems.append(Problem(found, accepted, (index, "name")))
        return refuse(*problems) if problems else choices

    def json_schema(self) -> dict[str, Any]:
        """A list of what one component accepts."""
        return {"type": "array", "items": super().json_schema()}
