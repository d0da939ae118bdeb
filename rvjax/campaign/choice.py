"""Which component a campaign uses. Its parameters are read later, by the component's model."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from pydantic import GetJsonSchemaHandler, ValidationInfo
from pydantic_core import core_schema

from rvjax.campaign.plain_values import Place, dotted, is_list, is_mapping
from rvjax.campaign.problems import Problem, refuse, unexpected
from rvjax.campaign.python_files import is_python_file, short_name
from rvjax.campaign.short_choices import SHORT

NAME = re.compile(r"[a-z][a-z0-9-]{0,63}")
NAME_WORDS = "accepted: small letters, digits and hyphens, the first a letter, at most 64 characters"
KEYS = ("use", "name")
"""The keys of a component that are not parameters."""


@dataclass(frozen=True)
class Choice:
    """A component: `{use: …, name: optional, …parameters}`.

    use: the component; name: unique in its list; path: its place in the campaign; parameters: as written in the campaign.
    """

    use: str
    name: str
    path: Place
    parameters: Mapping[str, Any]

    @property
    def section(self) -> str:
        """The section of the campaign that it stands in: `controller`, `faults`, `actuators.allocation`."""
        return dotted(tuple(step for step in self.path if isinstance(step, str)))

    @property
    def prefix(self) -> str:
        """Prefix of the names of its quantities: `controller`, or `faults.effectiveness` whatever its position in the list."""
        return f"{self.section}.{self.name}" if isinstance(self.path[-1], int) else self.section


def entry_names(entries: Sequence[Any]) -> list[str]:
    """The `name` of each entry, or else its `use`, numbered from the second of a kind on; "" if it has neither."""
    numbers: dict[str, int] = {}
    names: list[str] = []
    for entry in entries:
        name, use = _text(entry, "name"), _component_name(_text(entry, "use"))
        numbers[use] = numbers.get(use, 0) + (not name)
        names.append(name or (use if numbers[use] == 1 else use and f"{use}-{numbers[use]}"))
    return names


def _text(entry: Any, key: str) -> str:
    value = entry.get(key, "") if is_mapping(entry) else ""
    return value if isinstance(value, str) else ""


def _component_name(use: str) -> str:
    return short_name(use) if is_python_file(use) else use


@dataclass(frozen=True)
class OneChoice:
    """Reads a component. place: of its field where that is not at the top of the campaign."""

    place: Place = ()

    @property
    def short(self) -> bool:
        """Whether the name of the component may stand alone."""
        return self.place in SHORT

    def read(self, raw: Any, info: ValidationInfo) -> Any:
        """The choice, or every problem at once."""
        problems: list[Problem] = []
        alone = self.short and isinstance(raw, str)
        entry: Any = {"use": raw} if alone else raw
        choice = self.entry(entry, self.place or (str(info.field_name),), entry_names([entry])[0], problems)
        return refuse(*(replace(problem, place=()) if alone else problem for problem in problems)) if problems else choice

    def entry(self, raw: Any, path: Place, name: str, problems: list[Problem]) -> Choice | None:
        """The choice at a path. Places of problems are relative to the field."""
        below = path[len(self.place) or 1 :]
        if not is_mapping(raw):
            words = "the name of a component, or a mapping" if self.short else "a mapping"
            problems.append(unexpected(raw, f"accepted: {words} with use and parameters", below))
            return None
        if "use" not in raw:
            accepted = "accepted: the name of a component, see `rvjax list`"
            problems.append(Problem("missing", accepted, (*below, "use"), at_key=True))
        wrong = [key for key in KEYS if key in raw and not (NAME.fullmatch(_text(raw, key)) or self._file(raw, key))]
        if name and "name" not in raw and not NAME.fullmatch(name) and not wrong:
            problems.append(Problem(f"a component called {name}", f"a name with `name:`; {NAME_WORDS}", (*below, "use")))
        problems += [unexpected(raw[key], NAME_WORDS, (*below, key)) for key in wrong]
        parameters = {key: value for key, value in raw.items() if key not in KEYS}
        return Choice(_text(raw, "use"), name, path, MappingProxyType(parameters))

    @staticmethod
    def _file(raw: Mapping[str, Any], key: str) -> bool:
        return key == "use" and is_python_file(_text(raw, key))

    def json_schema(self) -> dict[str, Any]:
        """What the field accepts, as JSON Schema, without the parameters."""
        name = {"type": "string", "pattern": f"^{NAME.pattern}$"}
        use = {"type": "string"}
        mapping: dict[str, Any] = {"type": "object", "properties": {"use": use, "name": name}, "required": ["use"]}
        return {"anyOf": [use, mapping]} if self.short else mapping

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.with_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return self.json_schema()


class ListOfChoices(OneChoice):
    """Reads a list of components with different names."""

    def read(self, raw: Any, info: ValidationInfo) -> Any:
        """The choices, or every problem at once."""
        if not is_list(raw):
            refuse(unexpected(raw, "accepted: a list of mappings, each with use"))
        problems: list[Problem] = []
        names = entry_names(raw)
        choices = tuple(self.entry(item, (str(info.field_name), index), names[index], problems) for index, item in enumerate(raw))
        first: dict[str, int] = {}
        for index, name in enumerate(names):
            if name and first.setdefault(name, index) != index:
                message, accepted = f"the name {name} is used twice", f"entry {first[name]} has it already"
                problems.append(Problem(message, accepted, (index, "name")))
        return refuse(*problems) if problems else choices

    def json_schema(self) -> dict[str, Any]:
        """A list of components, as JSON Schema."""
        return {"type": "array", "items": super().json_schema()}
