"""Allocations: the ways in which a campaign says them, in the identity, the manual and the schema."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest

from rvjax.analysis.compare import _differing
from rvjax.campaign.export import campaign_text
from rvjax.components import registry
from rvjax.components.manual import campaign_schema
from rvjax.components.registry import component
from rvjax.components.settings import setting
from rvjax.execution.identity import identity
from rvjax.simulation.cost import cost
from rvjax.simulation.engines.choice import engine_of
from rvjax.simulation.problem import load
from tests.program import Run
from tests.user_code.test_user_allocations import MINE, project

SAME = ("pseudo-inverse", "{use: pseudo-inverse}", "{use: pseudo-inverse, centre: 0.5}", '"pseudo-inverse"')


def test_a_name_alone_is_the_same_campaign(tmp_path: Path) -> None:
    """Every way to say it has one fingerprint and one structure, another centre has others. Kills: parameters that are no part of
    the identity, a compiled program that is shared by two centres."""
    known = [load(project(tmp_path, said)) for said in SAME]
    assert len({(problem.fingerprint, problem.structure) for problem in known}) == 1
    assert len({problem.fingerprint for problem in map(load, [project(tmp_path, "bounded-least-squares")])}) == 1
    other = load(project(tmp_path, "{use: pseudo-inverse, centre: 0.3}"))
    assert other.fingerprint != known[0].fingerprint
    assert other.structure != known[0].structure
    assert engine_of(other) is not engine_of(known[0])
    assert engine_of(known[1]) is engine_of(known[0])
    assert cost(load(project(tmp_path, "{use: bounded-least-squares}"))).seconds > cost(known[0]).seconds


def test_the_default_is_the_bounded_problem(tmp_path: Path) -> None:
    """Kills: another default, a default without its parameters."""
    campaign = project(tmp_path, "bounded-least-squares")
    with_it = load(campaign)
    campaign.write_text(campaign.read_text().replace("  allocation: bounded-least-squares\n", ""))
    without = load(campaign)
    assert (with_it.fingerprint, with_it.structure) == (without.fingerprint, without.structure)
    assert setting(without.spec, "actuators.allocation") == "bounded-least-squares"


@pytest.mark.parametrize("said", SAME)
def test_a_parameter_of_a_name_alone_can_be_set(tmp_path: Path, said: str) -> None:
    """By `--set`, as a tuning sets it, and in the campaign that a tuning writes. Kills: a place that only the long form has."""
    campaign, place = project(tmp_path, said), "actuators.allocation.centre"
    wanted = load(project(tmp_path, "{use: pseudo-inverse, centre: 0.3}")).fingerprint
    campaign = project(tmp_path, said)
    problem = load(campaign)
    assert setting(problem.spec, place) == 0.5
    assert load(campaign, [f"{place}=0.3"]).fingerprint == wanted
    assert problem.with_values({place: 0.3}).fingerprint == wanted
    written = tmp_path / "written.yaml"
    written.write_text(campaign_text(problem.spec, [f"{place}=0.3"], (), "-tuned", "comment"))
    assert load(written).fingerprint == wanted
    assert load(campaign).fingerprint == problem.fingerprint  # its source is as it was


def test_a_comparison_lists_what_differs(tmp_path: Path) -> None:
    """Kills: a difference between two ways to say the same, a centre that is not named."""
    specs = [load(project(tmp_path, said)).spec for said in (*SAME[:3], "{use: pseudo-inverse, centre: 0.3}")]
    assert _differing(specs[0], specs[1]) == _differing(specs[1], specs[2]) == _differing(specs[2], specs[0]) == ()
    assert _differing(specs[0], specs[3]) == ("actuators.allocation.centre: A has the default 0.5, B has 0.3",)


def test_both_places_of_the_centre(tmp_path: Path, rvjax: Run) -> None:
    """The old one is refused with the new one, once. Kills: a key that is dropped."""
    campaign = project(tmp_path, "pseudo-inverse\n  centre: 0.4")
    code, _, err = rvjax("validate", campaign)
    assert code == 2
    assert f"{campaign}:14:3: actuators.centre: unknown key; accepted: allocation: {{use: pseudo-inverse, centre: 0.5}}" in err
    assert len(err.splitlines()) == 1


def test_the_code_of_an_installed_allocation_is_part_of_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From the entry points of `rvjax.allocations`. Kills: a section inside of another whose packages are not recorded."""
    (tmp_path / "opening.py").write_text(MINE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "opening", raising=False)
    entry = EntryPoint("mine", "opening:ALLOCATION", "rvjax.allocations")
    monkeypatch.setattr(registry, "entry_points", lambda group: [entry] if group == entry.group else [])
    registry.members.cache_clear()
    try:
        assert list(identity(load(project(tmp_path, "mine")))["components"]) == ["opening"]
        assert identity(load(project(tmp_path, "pseudo-inverse")))["components"] == {}
    finally:
        registry.members.cache_clear()


def test_the_manual_has_the_family(rvjax: Run) -> None:
    """`list` and `explain`, with an example that has the thrusters around it. Kills: the section of a tuning around it."""
    assert re.search(r"allocations +description", rvjax("list")[1])
    _, out, _ = rvjax("explain", "allocations")
    assert {"bounded-least-squares", "pseudo-inverse"} <= set(out.split())
    _, out, _ = rvjax("explain", "pseudo-inverse")
    assert "allocation: {use: pseudo-inverse}" in out
    assert "layout: cube-24" in out
    assert "tune" not in out
    assert component("allocations", "pseudo-inverse").parameters().centre == 0.5


def accepts(schema: Mapping[str, Any], value: Any) -> bool:
    """The words of JSON Schema that stand here, read literally."""
    if "anyOf" in schema and not any(accepts(form, value) for form in schema["anyOf"]):
        return False
    if "oneOf" in schema and sum(accepts(form, value) for form in schema["oneOf"]) != 1:
        return False
    kinds: Mapping[str, Any] = {"object": dict, "string": str, "number": (int, float)}
    if "type" in schema and not isinstance(value, kinds[schema["type"]]):
        return False
    if "pattern" in schema and re.search(schema["pattern"], value) is None:
        return False
    if value != schema.get("const", value) or value not in schema.get("enum", [value]):
        return False
    if isinstance(value, dict):
        known = schema.get("properties", {})
        inside = all(accepts(known[key], item) for key, item in value.items() if key in known)
        extra = schema.get("additionalProperties", True) or value.keys() <= known.keys()
        return inside and extra and set(schema.get("required", [])) <= value.keys()
    return not isinstance(value, float) or schema.get("minimum", value) <= value <= schema.get("maximum", value)


@pytest.fixture(scope="module")
def shown_by_editors() -> dict[str, Any]:
    """The JSON Schema of a campaign, made once."""
    return campaign_schema()


@pytest.mark.parametrize(
    ("value", "accepted"),
    [
        ("pseudo-inverse", True),
        ("bounded-least-squares", True),
        ("./mine.py", True),
        ("laws/mine.py:NAME", True),
        ({"use": "pseudo-inverse", "centre": 0.4}, True),
        ({"use": "./mine.py", "anything": 3}, True),
        ("pseudo_inverse", False),
        ("./mine.txt", False),
        ({"use": "pseudo-inverse", "centre": 1.4}, False),
        ({"use": "bounded-least-squares", "centre": 0.4}, False),
        ({"centre": 0.4}, False),
        (3.0, False),
    ],
)
def test_editors_accept_what_a_campaign_may_say(shown_by_editors: dict[str, Any], value: Any, accepted: bool) -> None:
    """Kills: a red line under a name that stands alone, a schema that accepts any text."""
    assert accepts(shown_by_editors["$defs"]["Thrusters"]["properties"]["allocation"], value) is accepted
