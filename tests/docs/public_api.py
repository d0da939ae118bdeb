"""What users build on, as items with facts: Python names and parameters, commands and options, keys of a campaign; and what a
change of them means.

    place of an item    python rvjax.Run.export(sample), cli rvjax export --to, key campaign.horizon.duration_s
    facts               type: accepted or given, alternatives; required, default, kind and position of a parameter, bounds

`docs/python.md` and the schema are checked elsewhere; this tells whether a change breaks somebody.
"""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any, get_args, get_type_hints

from typer.main import get_command

import rvjax
import rvjax.components
import rvjax.testing
from rvjax.cli import COMMANDS
from rvjax.cli._app import program
from rvjax.components.manual import campaign_schema

Facts = dict[str, Any]
Items = dict[str, Facts]

POSITIONAL, NAMED = "positional", "by name"
LISTED = ("Distribution", "JointDistribution", "Formula")
"""Definitions of the schema that stand at many places: a type, with its keys once."""

LEAST, MOST = ("minimum", "exclusiveMinimum", "minItems", "minLength"), ("maximum", "exclusiveMaximum", "maxItems", "maxLength")


def items() -> Items:
    """All of them."""
    return {**_python(), **_commands(), **_keys()}


def written(known: Items) -> str:
    """A line for each item, sorted."""
    return "".join(f"{place} {json.dumps(facts, ensure_ascii=False)}\n" for place, facts in sorted(known.items()))


def read(text: str) -> Items:
    parts = [line.partition(" {") for line in text.splitlines()]
    return {place: json.loads("{" + facts) for place, _, facts in parts}


# Python


def _python() -> Items:
    found: Items = {}
    for module in (rvjax, rvjax.components, rvjax.testing):
        for name in module.__all__:
            _name(f"python {module.__name__}.{name}", getattr(module, name), found)
    return found


def _name(place: str, value: Any, found: Items) -> None:
    if inspect.isclass(value):
        found[place] = {"kind": "class"}
        _signature(place, value, found)
        for name, member in _members(value):
            _name(f"{place}.{name}", member, found)
    elif inspect.isroutine(value):
        given = inspect.signature(value).return_annotation
        found[place] = {"kind": "function", "gives": [] if given is inspect.Signature.empty else _alternatives(_annotated(given))}
        _signature(place, value, found)
    elif isinstance(value, property):
        given = getattr(value.fget, "__annotations__", {}).get("return", "")
        found[place] = {"kind": "attribute", "gives": _alternatives(_annotated(given))}
    else:
        found[place] = {"kind": "attribute", "gives": _alternatives(value) if isinstance(value, str) else []}


def _members(value: type) -> Iterator[tuple[str, Any]]:
    """Public, defined in this package: methods, properties, and fields by their annotation."""
    known: dict[str, Any] = {}
    for part in reversed([part for part in value.__mro__ if part.__module__.partition(".")[0] == "rvjax"]):
        known |= {name: _annotated(text) for name, text in inspect.get_annotations(part).items()}
        for name, member in vars(part).items():
            plain = member.__func__ if isinstance(member, staticmethod | classmethod) else member
            if isinstance(plain, cached_property):
                known[name] = property(plain.func)
            elif inspect.isroutine(plain) or isinstance(plain, property):
                known[name] = plain
    yield from ((name, member) for name, member in sorted(known.items()) if not name.startswith("_") and name != "model_config")


def _signature(place: str, value: Any, found: Items) -> None:
    try:
        parameters = [*inspect.signature(value).parameters.values()]
    except ValueError:
        return
    parameters = [part for part in parameters if part.name not in ("self", "cls")]
    for position, part in enumerate(parameters):
        if part.name.startswith("_"):
            continue
        facts: Facts = {"required": part.default is part.empty and part.kind not in (part.VAR_POSITIONAL, part.VAR_KEYWORD)}
        if part.annotation is not part.empty:
            facts["type"] = _alternatives(_annotated(part.annotation))
        if part.default is not part.empty:
            facts["default"] = _default(part.default)
        if part.kind in (part.POSITIONAL_ONLY, part.POSITIONAL_OR_KEYWORD):
            facts["position"] = position
        facts["kind"] = POSITIONAL if part.kind is part.POSITIONAL_ONLY else NAMED
        found[f"{place}({part.name})"] = facts


def _annotated(annotation: Any) -> str:
    """As text, without what a validator adds to the type."""
    plain = annotation.__origin__ if hasattr(annotation, "__metadata__") else annotation
    return plain if isinstance(plain, str) else inspect.formatannotation(plain)


def _default(value: Any) -> str:
    return repr(value) if isinstance(value, int | float | str | tuple | None) else f"a {type(value).__name__}"


def _alternatives(annotation: str) -> list[str]:
    """The parts of a union, and the words of a Literal."""
    parts, depth, begin = [], 0, 0
    for place, letter in enumerate(annotation + "|"):
        depth += (letter in "[(") - (letter in "])")
        if letter == "|" and not depth:
            parts.append(annotation[begin:place].strip())
            begin = place + 1
    words: set[str] = set()
    for part in parts:
        literal = re.fullmatch(r"(?:typing\.)?Literal\[(.*)\]", part)
        words |= set(literal[1].split(", ") if literal else [part])
    return sorted(words)


# the command line


def _commands() -> Items:
    group: Any = get_command(program())
    found: Items = {}
    for name in COMMANDS:
        found[f"cli rvjax {name}"] = {"kind": "command"}
        command = group.commands[name]
        hints = get_type_hints(inspect.unwrap(command.callback), include_extras=True)
        for part in command.params:
            option = part.param_type_name == "option"
            facts: Facts = {"required": bool(part.required), **_taken(hints[part.name])}
            if isinstance(part.default, int | float | str | list | tuple):
                facts["default"] = str(part.default)
            for word in [*part.opts, *part.secondary_opts] if option else [part.metavar or part.name.upper()]:
                found[f"cli rvjax {name} {word}"] = facts
    return found


def _taken(hint: Any) -> Facts:
    """What an option or argument takes: the type of its annotation, and the bounds that are written beside it."""
    kind, *more = get_args(hint)
    words = re.sub(r"^(?:typing\.)?Optional\[(.*)\]$", r"\1", inspect.formatannotation(kind))
    facts: Facts = {"type": [part for part in _alternatives(words) if part != "None"]}
    for info in more:
        bounds = {"minimum": getattr(info, "min", None), "maximum": getattr(info, "max", None)}
        facts |= {bound: value for bound, value in bounds.items() if value is not None}
    return facts


# keys of a campaign


def _keys() -> Items:
    schema: dict[str, Any] = json.loads(json.dumps(campaign_schema()))
    found: Items = {}
    _key(schema["$defs"], schema, "key campaign", False, found, ())
    for name in LISTED:
        _key(schema["$defs"], schema["$defs"][name], f"key {name}", False, found, (name,))
    return found


def _key(defs: Mapping[str, Any], node: Any, place: str, required: bool, found: Items, within: tuple[str, ...]) -> None:
    """The key at a place and all below it. Where variants of a value have a key in common, it accepts what any of them does."""
    facts: Facts = {"required": required, "type": []}
    if "default" in node:
        facts["default"] = json.dumps(node["default"], ensure_ascii=False)
    below: list[tuple[Any, tuple[str, ...]]] = []
    for variant, inside in _variants(defs, node, within):
        facts["type"] += _types(variant)
        facts |= {bound: variant[bound] for bound in (*LEAST, *MOST) if bound in variant}
        below.append((variant, inside))
    facts["type"] = sorted(set(facts["type"]))
    if (other := found.get(place)) is not None:
        facts["type"] = sorted({*facts["type"], *other["type"]})
        facts["required"] = required and other["required"]
        facts = {name: value for name, value in facts.items() if name in ("type", "required") or other.get(name) == value}
    found[place] = facts
    for variant, inside in below:
        used = variant.get("properties", {}).get("use", {}).get("const")
        here = place if used is None else f"{place}({used})"
        if used is not None:
            found[here] = {"required": False}
        for name, part in variant.get("properties", {}).items():
            if name != "use" or used is None:
                _key(defs, part, f"{here}.{name}", name in variant.get("required", ()), found, inside)
        if isinstance(variant.get("items"), dict):
            _key(defs, variant["items"], f"{here}[]", False, found, inside)


def _variants(defs: Mapping[str, Any], node: Any, within: tuple[str, ...]) -> Iterator[tuple[Any, tuple[str, ...]]]:
    """The alternatives of a value, without references, each with the definitions that it stands in."""
    if "$ref" in node:
        name = node["$ref"].rpartition("/")[2]
        if name in LISTED or name in within:
            yield {"type": name}, within
        else:
            yield from _variants(defs, defs[name], (*within, name))
    elif choice := node.get("anyOf") or node.get("oneOf"):
        for part in choice:
            yield from _variants(defs, {key: node[key] for key in ("type",) if key in node} | part, within)
    else:
        yield node, within


def _types(variant: Any) -> list[str]:
    if "const" in variant or "enum" in variant:
        return [json.dumps(value) for value in variant.get("enum", [variant.get("const")])]
    kinds = variant.get("type", "anything")
    return kinds if isinstance(kinds, list) else [kinds]


# changes


def changes(old: Items, new: Items) -> list[tuple[bool, str]]:
    """Whether it breaks what users have, and a sentence; for each change. Below what comes or goes as a whole nothing is said."""
    gone, come = old.keys() - new.keys(), new.keys() - old.keys()
    found: list[tuple[bool, str]] = []
    for place in sorted(gone):
        if parent(place) not in gone:
            alike = [other for other in sorted(come) if parent(other) == parent(place) and new[other] == old[place]]
            come -= {*alike[:1]}
            found.append((True, f"{place}: removed" + (f"; renamed to {alike[0]}?" if alike else "")))
    for place in sorted(come):
        if parent(place) in come:
            continue
        needed = bool(new[place].get("required")) and parent(place) in old
        found.append((needed, f"{place}: new" + (" and required" if needed else "")))
    for place in sorted(old.keys() & new.keys()):
        found += [(breaks, f"{place}: {words}") for breaks, words in _differences(old[place], new[place])]
    return found


def parent(place: str) -> str:
    """What an item is a part of."""
    found = re.fullmatch(r"(.*)(\([^()]*\)|\[\]|\.[^.()\[\] ]+| [^ ]+)", place)
    return found[1] if found else ""


def _differences(old: Facts, new: Facts) -> Iterator[tuple[bool, str]]:
    for fact in sorted(old.keys() | new.keys()):
        a, b = old.get(fact), new.get(fact)
        if a == b:
            continue
        if fact == "required":
            yield bool(b), "required now" if b else "may be left out now"
        elif fact == "type":
            before, after = {*(a or [])}, {*(b or [])}
            lost, more = (", ".join(sorted(part)) for part in (before - after, after - before))
            yield bool(lost), f"narrower, no longer {lost}" if lost else f"also {more}"
        elif fact == "gives":
            more = sorted({*(b or [])} - {*(a or [])})
            yield bool(more), f"may give {', '.join(more)} now" if more else "gives fewer kinds of values"
        elif fact in (*LEAST, *MOST):
            narrower = b is not None and (a is None or (b > a if fact in LEAST else b < a))
            yield narrower, f"{fact} {a} → {b}"
        elif fact == "position":
            yield a is not None, f"position {a} → {b}" if a is not None else "may be given by position now"
        elif fact == "kind":
            yield (a, b) != (POSITIONAL, NAMED), f"{a} → {b}"
        elif not (fact == "default" and a is None):
            yield True, f"{fact} {a} → {b}"
        else:
            yield False, f"{fact} {b}, was required"
