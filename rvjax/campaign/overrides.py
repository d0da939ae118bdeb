"""`--set place=value`: another value at a place of a campaign, as YAML text or as a value. Findings name the argument."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from rvjax.campaign.choice import entry_names
from rvjax.campaign.plain_values import Place, dotted, exact, is_list, is_mapping, shorten
from rvjax.campaign.short_choices import SHORT
from rvjax.campaign.source import Source
from rvjax.campaign.yaml_document import LARGEST, Document, parse
from rvjax.errors import Finding


def override(source: Source, assignments: Sequence[str]) -> Source:
    """The source with every assignment made, in their order; findings are added for those that cannot be made."""
    if source.value is None:
        return source
    changed = _copy(source)
    findings = [finding for assignment in assignments for finding in _assign(changed, assignment)]
    return replace(changed, findings=(*source.findings, *findings))


def replace_values(source: Source, values: Mapping[str, float | str]) -> Source:
    """The source with these values at their places. The same as `override` with `place=value`, but no text is parsed."""
    changed = _copy(source)
    findings: list[Finding] = []
    for path, value in values.items():
        label = _label(f"{path}={value}")
        if isinstance(value, str) or abs(value) <= LARGEST:
            findings += _put(changed, path, Document(label, value, {(): label}))
        else:
            findings.append(Finding(label, path, f"{value} is not finite or too large", f"accepted: at most {exact(LARGEST)}"))
    return replace(changed, findings=(*source.findings, *findings))


def replaced_by(source: Source, section: Place) -> Source:
    """The source with the values of a mapping in it, each at the place that its key says. They keep their positions there."""
    changed = _copy(source)
    given: Any = source.value
    for step in section:
        given = given[step]
    findings: list[Finding] = []
    for path, value in given.items():
        place = (*section, path)
        marks, key_marks = (
            {at[len(place) :]: mark for at, mark in of.items() if at[: len(place)] == place}
            for of in (source.marks, source.key_marks)
        )
        document = Document(source.where(place, key=True), _copied(value), marks, key_marks)
        findings += _put(changed, path, document, keep=True)
    return replace(changed, findings=(*source.findings, *findings))


def value_at(values: Any, path: str) -> tuple[bool, Any]:
    """(whether there is a value at a place of a campaign, the value)."""
    value: Any = values
    for step in path.split("."):
        key: Any = _key(value, step)
        if key is None or (is_mapping(value) and step not in value):
            return False, None
        value = value[key]
    return True, value


def place_of(values: Any, path: str) -> Place:
    """The place that a path means, as far as it leads in a campaign."""
    held, place = values, list[str | int]()
    for step in path.split("."):
        key: Any = _key(held, step)
        if key is None or (is_mapping(held) and step not in held):
            break
        place.append(key)
        held = held[key]
    return tuple(place)


def _assign(source: Source, assignment: str) -> list[Finding]:
    """Make an assignment in place, or say why it cannot be made."""
    label = _label(assignment)
    path, equals, text = assignment.partition("=")
    if not equals or not path:
        return [Finding(label, "", "no place or no value", "accepted: place=value, such as pursuer.mass_kg=120")]
    given = parse(text, label)
    if given.findings:
        return [replace(finding, where=label, path=path) for finding in given.findings]
    return _put(source, path, given)


def _label(assignment: str) -> str:
    return f"--set {shorten(' '.join(assignment.split()), 100)}"


def _copy(source: Source) -> Source:
    """A source that can be changed in place."""
    return replace(source, value=_copied(source.value), marks=dict(source.marks), key_marks=dict(source.key_marks))


def _copied(value: Any) -> Any:
    if is_mapping(value):
        return {key: _copied(item) for key, item in value.items()}
    return [_copied(item) for item in value] if is_list(value) else value


def _put(source: Source, path: str, given: Document, keep: bool = False) -> list[Finding]:
    """Put a document at a path, in place; every value in it is marked with the document's name, or keeps its marks. A finding
    where there is no such place."""
    label = given.name
    held: Any = source.value
    place: Place = ()
    steps = path.split(".")
    for left, step in enumerate(steps, start=1 - len(steps)):
        key = _key(held, step)
        if key is None:
            message, accepted = f"there is no {step} here", f"accepted: {', '.join(_steps(held)) or dotted(place)}"
            return [Finding(label, dotted((*place, step)), message, accepted)]
        place = (*place, key)
        if left and place in SHORT and isinstance(held.get(key), str):
            held[key] = {"use": held[key]}  # a parameter of a component whose name stands alone
        if not left:
            held[key] = given.value
        else:
            held = held.setdefault(step, {}) if is_mapping(held) else held[int(key)]
    for marks in (source.marks, source.key_marks):
        for old in [old for old in marks if old[: len(place)] == place]:
            del marks[old]
    source.marks.update({(*place, *below): mark if keep else label for below, mark in given.marks.items()})
    source.key_marks.update({(*place, *below): mark if keep else label for below, mark in given.key_marks.items()})
    return []


def _key(held: Any, step: str) -> str | int | None:
    """The key or index that a step means in what it leads into; None if it leads nowhere."""
    if is_mapping(held):
        return step
    steps = _steps(held)
    return steps.index(step) % len(held) if step in steps else None


def _steps(held: Any) -> list[str]:
    """What leads into a list: the index of each entry, then the name of each."""
    return [*map(str, range(len(held))), *entry_names(held)] if is_list(held) else []
