"""What `rvjax init` writes: a starter campaign, and Python files with components that it flies."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path

from rvjax.campaign.python_files import short_name
from rvjax.components.manual import campaign_schema
from rvjax.errors import UsageError
from rvjax.run_folder import atomic_files

CAMPAIGN = "campaign.yaml"
SCHEMA = "campaign.schema.json"


@dataclass(frozen=True)
class Template:
    """A component's file. section: of the campaign; entry: what the campaign says of it, with FILE; before: the line of the
    starter campaign that the section's entry stands in front of; ends: the last line of what it replaces, or empty; with_it: what
    else changes in the starter campaign, old text → new text."""

    section: str
    entry: str
    before: str
    ends: str = ""
    with_it: Mapping[str, str] = field(default_factory=dict[str, str])


CONTROLLER = Template("controller", "controller: {use: ./FILE}", "controller:\n", "  gains: {k1: 0.1, v_max_m_s: 0.6}\n")
TEMPLATES: Mapping[str, Template] = {
    "controller": CONTROLLER,
    "discrete-controller": CONTROLLER,
    "actuator": Template("actuation", "actuation: [{use: ./FILE}]\n", "capture:"),
    "allocation": Template(
        "actuators",
        "actuators: {use: thrusters, layout: cube-24, size_m: 1, max_N: 1.2, allocation: ./FILE, "
        "spread: {uniform: [0.9, 1.1]}}\n",
        "actuators:",
        "  spread: {uniform: [0.9, 1.1]}\n\n",
        {"channels: [fx, ty]": "channels: [t1, t8]"},
    ),
    "effect": Template("effects", "effects: [{use: ./FILE}]\n", "capture:"),
    "fault": Template("faults", "  - {use: ./FILE, onset_s: {uniform: [30, 150]}}", "\ncontroller:"),
    "disturbance": Template("disturbances", "  - {use: ./FILE}", "\nfaults:"),
    "navigation": Template("navigation", "navigation: [{use: ./FILE}]\n", "capture:"),
    "guidance": Template("guidance", "guidance: {use: ./FILE}", "guidance:", "then down the axis\n"),
    "metric": Template("metrics", "metrics: [{use: ./FILE}]\n", "capture:"),
}
"""Option of `rvjax init` → what it writes; the file is the template of that name."""


def write(folder: Path, components: Mapping[str, Path]) -> tuple[list[Path], list[str]]:
    """Writes the components' files, and the campaign with its schema where there is no campaign yet.

    components: option → name of the file. Returns the paths, and what a campaign that is there needs for the components.
    Errors: UsageError where a file is there already or cannot be written; nothing is written then.
    """
    campaign, schema = folder / CAMPAIGN, folder / SCHEMA
    atomic_files.check_folder(folder)
    atomic_files.check_file(schema)
    texts: dict[Path, str] = {}
    for option, file in components.items():
        texts[folder / _named(option, file)] = _text(f"templates/{option.replace('-', '_')}.py")
    entries = {option: TEMPLATES[option].entry.replace("FILE", str(file)) for option, file in components.items()}
    begun = bool(components) and campaign.exists()
    if not begun:
        texts[campaign] = _campaign(entries)
    if there := [path for path in texts if path.exists()]:
        raise UsageError(f"{there[0]}: is there already; accepted: a folder without it")
    try:
        for path, text in texts.items():
            with path.open("x", encoding="utf-8") as file:
                file.write(text)
        if not begun:
            schema.write_text(json.dumps(campaign_schema(), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    except OSError as error:
        raise UsageError(f"{error.filename}: cannot be written ({error.strerror}); accepted: a folder that can") from error
    wanted = [_alone(TEMPLATES[option].section, entry) for option, entry in entries.items()] if begun else []
    return [*([] if begun else [campaign, schema]), *(path for path in texts if path != campaign)], wanted


def _alone(section: str, entry: str) -> str:
    """The entry of a component below the key of its section."""
    return f"{section}:\n{entry}" if entry.lstrip().startswith("-") else entry.strip()


def _named(option: str, file: Path) -> Path:
    """The name of a component's file. UsageError where it is no plain name of a Python file."""
    if file.suffix != ".py" or len(file.parts) != 1 or not short_name(file.name)[:1].isalpha():
        example = f"my_{option.replace('-', '_')}.py"
        raise UsageError(f"--{option} {file}: accepted: the plain name of a Python file, such as {example}")
    return file


def _campaign(entries: Mapping[str, str]) -> str:
    """The starter campaign with the entries of components."""
    text = _text("starter.yaml")
    for option, entry in entries.items():
        template = TEMPLATES[option]
        at = text.index(template.before)
        end = text.index(template.ends) + len(template.ends) if template.ends else at
        text = f"{text[:at]}{entry}\n{text[end:]}"
        for old, new in template.with_it.items():
            text = text.replace(old, new)
    return text


def _text(name: str) -> str:
    return files("rvjax.cli").joinpath(name).read_text(encoding="utf-8")
