"""`rvjax explain`: every key of the campaign file has a page, every example is a campaign, every proposal is a name, units stand
once and in a column for themselves."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from rvjax.campaign.units import UNITS
from rvjax.components import manual_lookup
from rvjax.components.manual import campaign_schema, component_pages
from rvjax.components.manual_examples import Example
from rvjax.components.manual_lookup import SECTIONS, pages_called
from tests.program import Run

STARTER = files("rvjax.cli").joinpath("starter.yaml").read_text(encoding="utf-8")
SCHEMA = campaign_schema()
JOINED = ("faults", "disturbances", "navigation", "baselines")
"""Sections with lists, whose examples are validated together."""

ASKED = (
    *("controller", "controllers", "inertia", "inertia_kgm2", "thrusters", "horizon", "horizon.step_s", "capture", "require"),
    *("keep", "navigation", "faults", "samplers", "sampler", "pursuer", "pursuer.mass_kg", "mass_kg", "mass", "metrics"),
    *("searches", "method", "tune.method", "distributions", "always", "signal", "log", "kappa", "weights", "use", "name"),
    *("controller.gains.k1", "gains.k1", "k1", "faults.bias.share", "require.0.metric"),
    *("target.rate_rad_s", "start.rho_m.x", "draw.pursuer.mass_kg", "metric.settling_time_s"),
)


def keys_of(schema: Mapping[str, Any], path: str = "") -> Iterator[str]:
    """The path of every key that a JSON Schema describes, in lists and in each form too, without those of distributions."""
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        if name not in ("Distribution", "JointDistribution", "Formula", "State", "Margin"):
            yield from keys_of(SCHEMA["$defs"][name], path)
        return
    for form in (*schema.get("anyOf", ()), *schema.get("oneOf", ())):
        yield from keys_of(form, path)
    for inner in ("items", "additionalProperties"):
        if isinstance(schema.get(inner), dict):
            yield from keys_of(schema[inner], path)
    for key, value in schema.get("properties", {}).items():
        yield path + key
        yield from keys_of(value, f"{path}{key}.")


VALUES = re.compile(
    r"(force|torque|values|weights|column|interpolate|(sigma|attitude_mrp)\.(rotation|quaternion.*|yaw_pitch_roll_deg)"
    r"|inertia_kgm2\.(matrix|products\..*)|omega_deg_s|rate_rad_s)$|tune\.parameters\.|levels\."
)
"""Words inside a value."""

KEYS = sorted({path for path in keys_of(SCHEMA) if not VALUES.search(path)})


def test_the_schema_is_walked() -> None:
    """Kills: a walk that finds nothing, so that the next test passes for nothing."""
    assert len(KEYS) > 150
    some = {"pursuer.mass_kg", "require.where.below", "actuators.thrusters.at_m", "faults.schedule.count", "tune.race.hard"}
    assert some <= set(KEYS)


@pytest.mark.parametrize("section", sorted({key.partition(".")[0] for key in KEYS}))
def test_every_key_has_a_page(section: str) -> None:
    """By its path and by its last name, with unit, default, range and meaning, and with an example in which it stands.
    Kills: a form or a list that is not walked, a component's key without a section, an example of another key."""
    for path in (key for key in KEYS if key.partition(".")[0] == section):
        pages = pages_called(path)
        last = path.rpartition(".")[2]
        assert any(page.name in (path, section) or path in SECTIONS for page in pages), path
        assert {page.name for page in pages} <= {page.name for page in pages_called(last)} or section == "baselines", path
        for page in pages:
            assert page.keys or page.members or page.text, path
            assert all(key.default and key.accepted and key.meaning for key in page.keys), (path, page.keys)
        assert any(re.search(rf"\b{last}:", example.yaml) for page in pages for example in page.examples), path


def examples() -> list[Example]:
    """Every example of every page, once."""
    pages = (page for name in manual_lookup.index() for page in pages_called(name))
    return list({f"{example.yaml}{example.files}": example for page in pages for example in page.examples}.values())


def without(campaign: str, text: str) -> str:
    """The campaign without the sections of this text."""
    for section in re.findall(r"^(\w+):", text, re.MULTILINE):
        campaign = re.sub(rf"^{section}:.*\n(?:[ #-].*\n|\n)*", "", campaign, flags=re.MULTILINE)
    return campaign


PLAIN = without(STARTER, "start:\nguidance:\ncorridor:\n") + "start: {rho_m: {box: 20}}\n"
PLAIN = re.sub(r".*(hull|keep_out|corridor_violation).*\n", "", PLAIN)
"""The campaign of `rvjax init` without hulls, zone, corridor and guidance, which need keys of several sections."""


def pasted(text: str) -> str:
    """PLAIN with these sections instead of those of the same name."""
    return f"{without(PLAIN, text)}\n{text}"


def test_every_example_is_accepted_when_pasted(rvjax: Run, tmp_path: Path) -> None:
    """`rvjax validate` accepts the campaign of `rvjax init` with each of them. Kills: a value outside of its range, keys that
    do not go together, a component that needs a file, a number that YAML reads as text."""
    written: list[Path] = []
    entries: dict[str, list[Any]] = {section: [] for section in JOINED}
    for number, example in enumerate(examples()):
        section = example.yaml.partition(":")[0]
        for name, content in example.files.items():
            place = tmp_path / str(number) / name
            place.parent.mkdir()
            place.write_text(content)
        if section in JOINED and not example.files:
            for entry in YAML(typ="safe").load(example.yaml)[section]:
                entries[section].append(entry | {"name": f"e{number}"})
        else:
            written.append(tmp_path / str(number) / "campaign.yaml")
            written[-1].parent.mkdir(exist_ok=True)
            written[-1].write_text(pasted(example.yaml))
    for section, joined in entries.items():
        assert len(joined) > 10, section
        written.append(tmp_path / f"{section}.yaml")
        written[-1].write_text(pasted(f"{section}:\n" + "".join(f"- {json.dumps(entry)}\n" for entry in joined)))
    assert len(written) > 100
    code, _, err = rvjax("validate", *written)
    assert (code, err) == (0, "")


@pytest.mark.parametrize("name", ["target.hull", "pursuer.hull", "target.keep_out", "guidance.points"])
def test_examples_say_what_else_is_needed(rvjax: Run, tmp_path: Path, name: str) -> None:
    """A hull needs that of the other spacecraft and a start outside of both, a zone a docking axis, waypoints an end at the port.
    Kills: an example that shows its key alone."""
    path = tmp_path / "campaign.yaml"
    texts = [example.yaml for page in pages_called(name) for example in page.examples]
    assert texts
    for text in texts:
        path.write_text(pasted(text))
        code, _, err = rvjax("validate", path)
        assert (code, err) == (0, "")


def test_an_example_can_be_refused(rvjax: Run, tmp_path: Path) -> None:
    """Kills: a test of examples that would pass with wrong ones."""
    (tmp_path / "campaign.yaml").write_text(pasted("pursuer: {mass_kg: -1, inertia_kgm2: {principal: [1, 1, 1]}}\n"))
    assert rvjax("validate", tmp_path / "campaign.yaml")[0] != 0


@pytest.mark.parametrize("name", ASKED)
def test_names_that_users_ask_for(rvjax: Run, name: str) -> None:
    """Kills: a family under the name of its section that has no page, a draw's name as the report shows it."""
    code, out, err = rvjax("explain", name)
    assert (code, err) == (0, "")
    assert len(out.splitlines()) > 4


def test_every_name_that_can_be_proposed_has_a_page() -> None:
    """Kills: "controller: no such name; did you mean controller?"."""
    known = manual_lookup.index()
    assert {"controller", "mass_kg", "uniform", "settling_time_s", "dynamics", "thrusters"} <= known.keys()
    assert all(pages_called(name) for name in known)


@pytest.mark.parametrize(
    "wrong", ["controler", "efectiveness", "horizn", "mas_kg", "pursuer.mas", "saturation_dutty", "requires"]
)
def test_proposals_work(rvjax: Run, wrong: str) -> None:
    """Kills: a proposal that is refused when it is tried, and one that repeats the question."""
    code, _, err = rvjax("explain", wrong)
    assert code == 2
    proposed = err.partition("did you mean ")[2].strip().rstrip("?").split(", ")
    assert proposed != [""]
    assert wrong not in proposed
    assert {rvjax("explain", name)[0] for name in proposed} == {0}


def test_a_family_shows_its_members_and_the_keys_of_its_section(rvjax: Run) -> None:
    """Without the whole page of each. Kills: a list without the keys, the pages of all members one after the other."""
    _, out, _ = rvjax("explain", "faults")
    assert {"effectiveness", "drift", "onset_s", "schedule", "use", "name"} <= set(out.split())
    assert "e = 1: healthy" not in out
    _, out, _ = rvjax("explain", "faults", "--json")
    assert {"effectiveness", "bias"} <= {page["name"] for page in json.loads(out)["pages"]}


def test_a_name_of_several_things_lists_them(rvjax: Run) -> None:
    """Kills: only the first of them."""
    _, out, _ = rvjax("explain", "inertia_kgm2", "--json")
    assert {page["name"] for page in json.loads(out)["pages"]} == {"pursuer.inertia_kgm2", "target.inertia_kgm2"}
    _, out, _ = rvjax("explain", "share", "--json")
    meanings = {key["meaning"] for page in json.loads(out)["pages"] for key in page["keys"]}
    assert any("(bias)" in meaning for meaning in meanings)
    assert any("(stuck)" in meaning for meaning in meanings)
    _, out, _ = rvjax("explain", "bias", "--json")
    assert {page["family"] for page in json.loads(out)["pages"]} >= {"faults", "navigation"}


@pytest.mark.parametrize("page", [page for page in component_pages() if page.keys], ids=lambda page: f"{page.family}-{page.name}")
def test_a_unit_stands_once_as_a_symbol(page: manual_lookup.Page) -> None:
    """In its column, and not in the meaning; choices are listed. Kills: "1/s [1/s]", "kilogram square metres", "no unit"."""
    words = {unit.name for unit in UNITS.values()} | {"no unit"}
    headings, rows = page.tables[-1]
    assert headings == ("key", "unit", "default", "range or choices", "meaning")
    for key, unit, default, accepted, meaning in rows:
        assert all((key, default, accepted, meaning)), key
        assert unit not in words
        assert not words & {accepted, meaning}
        if unit not in ("", "1", "s", "m"):
            assert f"[{unit}]" not in meaning
            assert not meaning.endswith(f" {unit}"), key
    for key, old in zip(page.keys, page.rows, strict=True) if page.family != "metrics" else ():
        assert (key.path, old[0]) == (old[0], key.path)


def test_symbols_and_choices() -> None:
    """Against the values by hand. Kills: a range of another key, a unit of the SI where the key has degrees."""
    rows = {key.path: (key.unit, key.default, key.accepted) for name in ("saturated-adaptive", "effectiveness", "sinusoid")
            for page in component_pages() if page.name == name for key in page.keys}  # fmt: skip
    assert rows["gains.k1"] == ("1/s", "0.1", "above 0, or drawn")
    assert rows["gains.inertia_guess_kgm2"] == ("kg·m²", "15", "above 0, or drawn")
    assert rows["gains.gamma_mass"][0] == "kg·s²/m²"
    assert rows["gains.gamma_bound"][0] == "N/m, N·m"
    assert rows["gains.clip_share"] == ("1", "0.95", "above 0 and at most 1, or drawn")
    assert rows["nussbaum"] == ("", "exp-cos", "exp-cos, quadratic-cos, none")
    assert rows["shaped"] == ("", "true", "true, false")
    assert rows["phase_deg"][:2] == ("deg", "{uniform: [0, 360]}")
    assert rows["remaining"][:2] == ("1", "required")
    (layout,) = pages_called("actuators.layout")
    assert layout.keys[0].accepted == "cube-24, pinwheel-12"
    (minutes,) = pages_called("tune.budget.minutes")
    assert minutes.keys[0].unit == "min"


def test_units_stand_once_in_the_schema() -> None:
    """The description of a key for an editor. Kills: "1/s [1/s]" there."""
    for text in re.findall(r'"description": "([^"]*)"', json.dumps(SCHEMA, ensure_ascii=False)):
        if match := re.search(r"^(.*) \[([^\]]*)\]$", text):
            assert not match[1].endswith((f", {match[2]}", f" [{match[2]}]")), text


@pytest.mark.parametrize("name", ["saturated-adaptive", "faults", "actuators", "require", "controllers", "k1", "settling_time_s"])
@pytest.mark.parametrize("columns", [60, 80])
def test_a_narrow_terminal_breaks_no_word(rvjax: Run, monkeypatch: pytest.MonkeyPatch, name: str, columns: int) -> None:
    """Kills: columns of three letters, a key that is cut, a table wider than the terminal."""
    monkeypatch.setenv("COLUMNS", str(columns))
    _, out, _ = rvjax("explain", name)
    words = set(re.split(r"\s+", out))
    for page in pages_called(name):
        if page.name in {member for other in pages_called(name) for member, _ in other.members}:
            continue
        for headings, rows in page.tables:
            for row in rows:
                assert set(row[0].split()) <= words
                assert {word for cell in row[1:] for word in cell.split() if len(word) <= 20} <= words, row
            printed = out[max(out.find(heading) for heading in headings) :]
            table = [line for line in printed.splitlines() if "─" in line]
            assert all(len(line) <= columns for line in table)


@pytest.mark.parametrize("name", ["effectiveness", "horizon", "settling_time_s", "dynamics", "uniform", "saturated-adaptive"])
def test_the_document_keeps_its_keys(rvjax: Run, name: str) -> None:
    """Programs that read `--json` find what they found before. Kills: a row of five cells, a unit as a symbol there."""
    _, out, _ = rvjax("explain", name, "--json")
    (page,) = json.loads(out)["pages"]
    assert {"family", "name", "origin", "text", "rows"} <= page.keys()
    assert all(len(row) == 4 for row in page["rows"])
    if name == "effectiveness":
        assert page["rows"][0] == ["onset_s", "seconds", "required", "time t_f at which the fault begins [s]"]
