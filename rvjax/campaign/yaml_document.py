"""YAML 1.2 text as plain values with their places; every finding at once.

Only mappings with text keys, lists, text, numbers, true, false and null pass: no tags, no anchors, no aliases. The
limits hold while the text is parsed: measured, the worst text of 128 KiB takes about a second.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import ruamel.yaml.events
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from rvjax.campaign.plain_values import Place, describe, dotted, exact, shorten
from rvjax.errors import Finding

MOST_NODES = 5_000
MOST_DEPTH = 32
MOST_DIGITS = 40
LARGEST = 1e100
"""Of a number; beyond it, sums and units would overflow."""

_EVENTS: Any = ruamel.yaml.events  # the package has no types
_INTEGER = re.compile(r"[-+]?[0-9]+")
_OTHER_BASE = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
NOT_PRINTABLE = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_WORDS = {"": None, "~": None} | {
    word: value
    for text, value in (("null", None), ("true", True), ("false", False))
    for word in (text, text.title(), text.upper())
}


class _Abandoned(Exception):
    """Reading ends here; the finding is already kept."""


@dataclass
class Document:
    """One YAML value of any kind, where it and its keys stand (`name:line:column`), and what is wrong with it."""

    name: str
    value: Any = None
    marks: dict[Place, str] = field(default_factory=dict[Place, str])
    key_marks: dict[Place, str] = field(default_factory=dict[Place, str])
    findings: list[Finding] = field(default_factory=list[Finding])


def parse(text: str, name: str) -> Document:
    """The document in a text; its value is None where the text could not be parsed to the end."""
    return deepcopy(_parsed(text, name))


@lru_cache(maxsize=64)
def _parsed(text: str, name: str) -> Document:
    """The document, for readers that copy it: a run reads its campaign several times."""
    document = Document(name)
    reading = _Reading(document, _events(text))
    try:
        document.value = reading.document()
    except _Abandoned:
        pass
    except YAMLError as error:
        details: Any = error
        mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
        problem = f"{details.context or ''} {details.problem}".strip() if mark else str(error)
        where = reading.where(mark) if mark else f"{name}:1:1"
        document.findings.append(Finding(where, "", f"this is not YAML: {problem}", "accepted: YAML 1.2"))
    return document


def _events(text: str) -> Iterator[Any]:
    """The parser's events; whatever it stumbles over in a hostile text, such as an escape beyond Unicode, is a YAMLError."""
    try:
        yield from YAML(typ="safe", pure=True).parse(text)  # pyright: ignore[reportUnknownMemberType]
    except YAMLError:
        raise
    except Exception as error:
        raise YAMLError(f"{type(error).__name__}: {error}") from error


@dataclass
class _Reading:
    """Turns the parser's events into a document."""

    into: Document
    events: Iterator[Any]
    nodes: int = 0

    def document(self) -> Any:
        """The value of the first document; a second document is refused."""
        value: Any = None
        starts = (event for event in self.events if isinstance(event, _EVENTS.DocumentStartEvent))
        for number, start in enumerate(starts):
            if number:
                self.refuse(start, (), "a second document", "accepted: a single document in a file")
                break
            value = self.node(next(self.events), ())
        return value

    def where(self, mark: Any) -> str:
        """`name:line:column`, counted from 1."""
        return f"{self.into.name}:{mark.line + 1}:{mark.column + 1}"

    def refuse(self, event: Any, place: Place, message: str, accepted: str) -> None:
        """Keep a finding about what starts with this event."""
        self.into.findings.append(Finding(self.where(event.start_mark), dotted(place), message, accepted))

    def node(self, event: Any, place: Place) -> Any:
        """The value that starts with this event."""
        self.nodes += 1
        if self.nodes > MOST_NODES:
            self.refuse(event, (), f"more than {MOST_NODES:,} values", "accepted: a smaller file")
            raise _Abandoned
        if len(place) > MOST_DEPTH:
            self.refuse(event, (), f"nested deeper than {MOST_DEPTH} levels", "accepted: a flatter file")
            raise _Abandoned
        self.into.marks[place] = self.where(event.start_mark)
        if isinstance(event, _EVENTS.AliasEvent):
            return self.refuse(event, place, f"the alias *{shorten(event.anchor)}", "accepted: the value itself")
        if event.anchor is not None:
            self.refuse(event, place, f"the anchor &{shorten(event.anchor)}", "accepted: the value without it")
        if event.ctag is not None:
            self.refuse(event, place, f"the tag {shorten(str(event.ctag))}", "accepted: the value without it")
        if isinstance(event, _EVENTS.ScalarEvent):
            return self.scalar(event, place)
        if isinstance(event, _EVENTS.SequenceStartEvent):
            items = enumerate(self.until(_EVENTS.SequenceEndEvent))
            return [self.node(item, (*place, index)) for index, item in items]
        return self.mapping(place)

    def until(self, end: type[Any]) -> Iterator[Any]:
        """The events that start the entries of a list or mapping."""
        for event in self.events:
            if isinstance(event, end):
                return
            yield event

    def mapping(self, place: Place) -> dict[str, Any]:
        """A mapping; of a key that occurs twice, the first value."""
        value: dict[str, Any] = {}
        for event in self.until(_EVENTS.MappingEndEvent):
            known = len(self.into.findings)
            key: Any = self.node(event, (*place, "?"))
            if not isinstance(key, str):
                if len(self.into.findings) == known:
                    self.refuse(event, place, f"a key that is {describe(key)}", "accepted: text")
                self.node(next(self.events), (*place, "?"))
            elif key in value:
                first = self.into.key_marks[(*place, key)]
                self.refuse(event, (*place, key), "the key occurs twice", f"the first is at {first}")
                self.node(next(self.events), (*place, "?"))
            else:
                self.into.key_marks[(*place, key)] = self.where(event.start_mark)
                value[key] = self.node(next(self.events), (*place, key))
                if value[key] is None and len(self.into.findings) == known:  # nothing stands there
                    self.into.marks[(*place, key)] = self.where(event.start_mark)
        return value

    def scalar(self, event: Any, place: Place) -> Any:
        """The core schema of YAML 1.2: quoted is text; plain is null, true, false, a number, or else text."""
        text: str = event.value
        if strange := NOT_PRINTABLE.search(text):  # only an escape in quotes can contain it
            return self.refuse(event, place, f"character U+{ord(strange[0]):04X}", "accepted: printable text")
        if not event.implicit[0]:
            return text
        if text in _WORDS:
            return _WORDS[text]
        if NOT_FINITE.fullmatch(text):
            return self.refuse(event, place, f"{text} is not a finite number", "accepted: a finite number")
        if not (other_base := _OTHER_BASE.fullmatch(text)) and not FLOAT.fullmatch(text):
            return text
        if len(text) > MOST_DIGITS:
            return self.refuse(event, place, f"a number of {len(text)} characters", f"accepted: at most {MOST_DIGITS}")
        number = int(text, 0) if other_base else int(text) if _INTEGER.fullmatch(text) else float(text)
        if abs(number) > LARGEST:
            return self.refuse(event, place, f"{text} is too large", f"accepted: at most {exact(LARGEST)}")
        return number
