"""What a good campaign becomes: SI, defaults, quantities, overrides, fingerprint, schema."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from pydantic import ValidationError

from rvjax.campaign import (
    Model,
    Quantity,
    Requirement,
    Spec,
    channels,
    count,
    flag,
    load,
    number,
    option,
    parse,
    part,
    scalar,
    schema,
    validate,
    vector,
    with_defaults,
)
from rvjax.campaign.distributions import Ball, Fixed, HalfNormal, Normal, Uniform
from rvjax.campaign.inertia import matrix
from rvjax.campaign.overrides import override
from rvjax.campaign.source import read, read_text

DEGREE = math.pi / 180.0


def test_everything_is_in_si(good: Path) -> None:
    """Kills a factor that is left out or turned round (deg, km)."""
    spec = load(good)
    assert spec.target.orbit.semi_major_axis_m.parts == (Fixed(6_878_000.0),)
    assert spec.target.rate_rad_s.parts == tuple(Fixed(rate * DEGREE) for rate in (0.23, -0.34, 0.17))
    assert spec.target.rate_rad_s.unit == "rad/s"
    assert spec.corridor.half_angle_rad == 10.0 * DEGREE
    assert spec.pursuer.inertia_kgm2.tilt_rad.parts == (HalfNormal(3.0 * DEGREE),)


def test_a_text_that_is_read_twice_gives_two_documents() -> None:
    """Kills: a value that is shared, so that an override changes what the next reader gets; places of another file."""
    text = "a: {b: [1, 2]}\n"
    first, second = read_text(text, "x.yaml"), read_text(text, "y.yaml")
    first.value["a"]["b"].append(3)
    assert second.value == read_text(text, "x.yaml").value == {"a": {"b": [1, 2]}}
    assert (first.marks["a", "b"], second.marks["a", "b"]) == ("x.yaml:1:8", "y.yaml:1:8")
    assert second.key_marks["a",] == "y.yaml:1:1"


def test_defaults_and_forms(good: Path) -> None:
    spec = load(good)
    assert (spec.capture.position_m, spec.capture.attitude_mrp, spec.capture.window_s) == (0.01, 0.002, 60.0)
    assert spec.saturation.use == "smooth-tanh"
    assert spec.horizon.steps == 6000
    assert [part.low for part in spec.actuators.upper.parts] == [4.0, 4.0, 4.0, 0.8, 0.8, 0.8]
    assert spec.start.rho_m.parts == (Uniform(-20.0, 20.0),) * 3
    assert spec.target.inertia_kgm2.principal.parts == (Fixed(500.0), Fixed(550.0), Fixed(600.0))
    assert spec.require == (Requirement(metric="captured", at_least=0.9),)


def test_quantities_have_the_names_of_the_draws(good: Path) -> None:
    drawn = {name for name, quantity in load(good).quantities().items() if not quantity.is_fixed}
    assert drawn == {
        "pursuer.mass_kg",
        "pursuer.inertia_kgm2.tilt_rad",
        "pursuer.inertia_kgm2.axis",
        "start.rho_m",
        "start.sigma",
        "start.nu_m_s",
        "start.omega_rad_s",
        "actuators.spread.upper",
        "actuators.spread.lower",
    }
    assert load(good).quantities()["actuators.spread.lower"].parts == (Uniform(0.9, 1.1),) * 6


def test_components_keep_what_was_written(good: Path) -> None:
    spec = load(good, ["faults=[{use: bias}, {use: bias, name: drift}, {use: bias, size: 1}]"])
    assert [fault.name for fault in spec.faults] == ["bias", "drift", "bias-2"]
    assert [fault.prefix for fault in spec.faults] == ["faults.bias", "faults.drift", "faults.bias-2"]
    assert (spec.faults[2].path, dict(spec.faults[2].parameters)) == (("faults", 2), {"size": 1})
    assert (spec.controller.prefix, spec.controller.path) == ("controller", ("controller",))


@pytest.mark.parametrize(
    ("assignment", "attribute", "expected"),
    [
        ("samples=10", lambda spec: spec.samples, 10),
        ("pursuer.mass_kg=120", lambda spec: spec.pursuer.mass_kg.parts, (Fixed(120.0),)),
        ("pursuer.mass_kg.uniform.1=130", lambda spec: spec.pursuer.mass_kg.parts, (Uniform(80.0, 130.0),)),
        ("capture.window_s=30", lambda spec: spec.capture.window_s, 30.0),
        ("start.rho_m={ball: 5}", lambda spec: spec.start.rho_m.joint, Ball(5.0)),
        ("faults.0.onset_s={uniform: [30, 60]}", lambda spec: spec.faults[0].parameters["onset_s"], {"uniform": [30, 60]}),
        ("faults.effectiveness.remaining=0", lambda spec: spec.faults[0].parameters["remaining"], 0),
        ("faults=[]", lambda spec: spec.faults, ()),
    ],
)
def test_overrides(good: Path, assignment: str, attribute: Any, expected: object) -> None:
    assert attribute(load(good, [assignment])) == expected


@pytest.mark.parametrize(
    ("assignment", "message"),
    [
        ("samples", "--set samples: no place or no value; accepted: place=value, such as pursuer.mass_kg=120"),
        ("pursuer.mass_kg=-5", "--set pursuer.mass_kg=-5: pursuer.mass_kg: -5 kg; accepted: above 0 kg"),
        ("samles=5", "--set samles=5: samles: unknown key; did you mean samples?"),
        ("samples=[", "--set samples=[: samples: this is not YAML"),
        ("faults.1.onset_s=3", "--set faults.1.onset_s=3: faults.1: there is no 1 here; accepted: 0, effectiveness"),
        ("samples.low=3", "--set samples.low=3: samples.low: there is no low here; accepted: samples"),
        ("target.port_m.1=x", "--set target.port_m.1=x: target.port_m.1: found the text 'x'; accepted: a number in m"),
    ],
)
def test_overrides_that_cannot_be(good: Path, assignment: str, message: str) -> None:
    """Reported at the argument, also where the file is fine; kills marks that still point into the file."""
    spec, findings, _ = parse(good, [assignment])
    assert spec is None
    assert [str(finding).startswith(message) for finding in findings] == [True], [str(finding) for finding in findings]


def test_overrides_take_the_place_of_all_that_stood_there(good: Path) -> None:
    """Kills places of the file that stay behind, and a source that is changed by its overrides."""
    assert [str(finding) for finding in parse(good, ["horizon={}"])[1]] == [
        "--set horizon={}: horizon.duration_s: missing; accepted: duration of a flight [s]",
        "--set horizon={}: horizon.step_s: missing; accepted: "
        "step of the integration; the duration is a whole number of steps [s]",
    ]
    source = read(good)
    assert override(source, ["horizon.step_s=1"]).value != source.value == read(good).value


def _fingerprint(text: str, tmp_path: Path) -> str:
    path = tmp_path / "campaign.yaml"
    path.write_text(text)
    return load(path).fingerprint()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("samples: 100", "samples: 200"),
        ("name: docking", "name: other\ndescription: text"),
        ("seed: 7\n", "seed: 7\nkeep: {worst: 20, failed: true, percentiles: true, all: true}\n"),
        ("  - {metric: captured, at_least: 0.9}", "  - {metric: captured, at_least: 0.8}"),
        ("seed: 7\nprecision: float64", "precision: float64\nseed: 7"),
        ("seed: 7\n", "seed: 7\ncapture: {window_s: 60.0}\nsaturation: {use: smooth-tanh}\n"),
        ("port_m: [5, 0, 0]", "port_m: [5.0, 0, 0.0]\n  attitude_mrp: 0"),
        ("sigma: {box: 0.25}", "sigma: {uniform: [-0.25, 0.25]}"),
    ],
)
def test_fingerprint_stays(old: str, new: str, good: Path, tmp_path: Path) -> None:
    text = good.read_text()
    assert old in text
    assert _fingerprint(text.replace(old, new), tmp_path) == load(good).fingerprint()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("seed: 7", "seed: 8"),
        ("float64", "float32"),
        ("step_s: 0.05", "step_s: 0.1"),
        ("[80, 120]", "[80, 121]"),
        ("mass_kg: {uniform", "mass_kg: {log_uniform"),
        ("port_m: [5, 0, 0]", "port_m: [0, 5, 0]"),
        ("rho_m: {box: 20}", "rho_m: {ball: 20}"),
        ("channels: all", "channels: [fx]"),
        ("remaining: {uniform: [0.5, 1]}", "remaining: {uniform: [0.6, 1]}"),
        ("{use: pd-plus}", "{use: pd-plus, gains: {k: 1}}"),
        ("{use: constant,", "{use: constant, name: push,"),
        ("seed: 7\n", "seed: 7\ncapture: {window_s: 61}\n"),
    ],
)
def test_fingerprint_changes(old: str, new: str, good: Path, tmp_path: Path) -> None:
    """Kills a part that is left out of the identity."""
    text = good.read_text()
    assert old in text
    assert _fingerprint(text.replace(old, new), tmp_path) != load(good).fingerprint()


def test_fingerprint_knows_joint_distributions_and_read_parameters(good: Path) -> None:
    """Kills a joint distribution that is left out, a seed rounded to 53 bits, and defaults that count only where written."""
    assert load(good, [f"seed={2**53}"]).fingerprint() != load(good, [f"seed={2**53 + 1}"]).fingerprint()
    assert load(good, ["start.rho_m={ball: 20}"]).fingerprint() != load(good, ["start.rho_m={ball: 21}"]).fingerprint()
    short, full = load(good), load(good, ["controller={use: pd-plus, k1: 0.06}"])
    read_parameters = [{spec.controller.path: Gains.model_validate(dict(spec.controller.parameters))} for spec in (short, full)]
    assert short.fingerprint() != full.fingerprint()
    assert short.fingerprint(read_parameters[0]) == full.fingerprint(read_parameters[1])


class Gains(Model):
    """Gains for the tests."""

    k1: Quantity = scalar("1/s", default=0.06, above=0.0, doc="position gain")


class Parameters(Model):
    """Every kind of field that a component may declare."""

    force_N: Quantity = vector("N", doc="amplitude")
    rate_rad_s: Quantity = scalar("rad/s", key="rate_deg_s", default=1.0, above=0.0, doc="rate")
    remaining: Quantity = channels("1", default=1.0, at_least=0.0, at_most=1.0, doc="effectiveness")
    delay_s: float = number("s", default=0.0, at_least=0.0, doc="delay")
    order: int = count(default=2, at_least=1, at_most=4, doc="order")
    shaped: bool = flag(default=True, doc="shaped or not")
    kind: Literal["a", "b"] = option(default="a", doc="which")
    gains: Gains = part(default={}, doc="gains")


SOURCE = read_text("faults:\n  - use: x\n    force_N: 1\n    rate_deg_s: -1\n    shaped: 1\n    shapd: true\n", "f.yaml")


def test_parameters_of_a_component() -> None:
    parameters, findings = validate(Parameters, {"force_N": [1, {"normal": [0, 1]}, 0], "rate_deg_s": 2}, (), SOURCE)
    assert findings == []
    assert parameters is not None
    assert parameters.force_N.parts == (Fixed(1.0), Normal(0.0, 1.0), Fixed(0.0))
    assert parameters.rate_rad_s.parts == (Fixed(2.0 * DEGREE),)
    assert parameters.gains.k1.parts == (Fixed(0.06),)
    names = parameters.quantities("faults.x")
    assert list(names) == ["faults.x.force_N", "faults.x.rate_rad_s", "faults.x.remaining", "faults.x.gains.k1"]
    with pytest.raises(ValidationError, match="frozen"):
        parameters.order = 3


def test_another_default_changes_nothing_else() -> None:
    """The range, the unit, the key and the meaning stay. Kills: a default in another unit, a field without its range."""
    other = with_defaults(Parameters, rate_rad_s=3.0)
    parameters = other.model_validate({"force_N": 1})
    assert parameters.rate_rad_s.parts == (Fixed(3.0 * DEGREE),)
    assert list(other.keys()) == list(Parameters.keys())
    assert other.keys()["rate_deg_s"].description == Parameters.keys()["rate_deg_s"].description
    assert Parameters.model_validate({"force_N": 1}).rate_rad_s.parts == (Fixed(DEGREE),)
    with pytest.raises(ValidationError, match="-1"):
        other.model_validate({"force_N": 1, "rate_deg_s": -1})
    with pytest.raises(KeyError):
        with_defaults(Parameters, rate=1.0)


def test_findings_about_a_component_are_where_it_stands() -> None:
    assert SOURCE.value is not None
    raw = {key: value for key, value in SOURCE.value["faults"][0].items() if key != "use"}
    parameters, findings = validate(Parameters, raw, ("faults", 0), SOURCE)
    assert parameters is None
    assert sorted(map(str, findings)) == [
        "f.yaml:4:17: faults.0.rate_deg_s: -1 deg/s; accepted: above 0 deg/s",
        "f.yaml:5:13: faults.0.shaped: found 1; accepted: true or false",
        "f.yaml:6:5: faults.0.shapd: unknown key; did you mean shaped?",
    ]
    assert str(SOURCE.finding(("faults", 0, "use"), "no such component")) == "f.yaml:2:10: faults.0.use: no such component"


def test_ranges_hold_for_the_whole_support() -> None:
    """Kills a range that is compared with one end of a distribution only."""
    _, findings = validate(Parameters, {"force_N": 0, "remaining": {"uniform": [0.5, 1.5]}}, (), SOURCE)
    assert [finding.found for finding in findings] == ["uniform reaches from 0.5 to 1.5"]


class Guesses(Model):
    """Two stems, one inside the other."""

    mass_kg: Quantity = scalar("kg", default=1.0, doc="mass")
    mass_guess_kg: Quantity = scalar("kg", default=1.0, doc="guess")


def test_another_unit_is_told_by_the_longest_stem() -> None:
    _, findings = validate(Guesses, {"mass_guess_g": 1}, (), SOURCE)
    assert [finding.accepted for finding in findings] == ["accepted: mass_guess_kg (kilograms)"]


@pytest.mark.parametrize(("unit", "key"), [("rad/s", None), ("m", "speed_km"), ("m/s", "velocity_m_s")])
def test_names_keys_and_units_must_agree(unit: str, key: str | None) -> None:
    given = {} if key is None else {"key": key}
    with pytest.raises(TypeError, match="disagree"):
        type("Wrong", (Model,), {"__annotations__": {"speed_m_s": Quantity}, "speed_m_s": scalar(unit, **given, doc="")})


def test_a_draw_has_one_uniform_number_for_each_part() -> None:
    spec_part = Parameters.model_validate(
        {"force_N": {"uniform": [0, 1]}, "remaining": {"force": 1, "torque": {"uniform": [0, 1]}}}
    )
    assert spec_part.force_N.parts == (Uniform(0.0, 1.0),) * 3
    assert [part.uniforms for part in spec_part.remaining.parts] == [0, 0, 0, 1, 1, 1]
    np.testing.assert_array_equal(spec_part.remaining.supports, [(1, 1)] * 3 + [(0, 1)] * 3)


def test_inertia_that_is_flat_in_some_draw_is_a_body(good: Path) -> None:
    """Equality in the triangle inequality is accepted. Kills a strict comparison."""
    assert load(good, ["pursuer.inertia_kgm2={principal: [10, 10, 20]}"])
    assert load(good, ["pursuer.inertia_kgm2={moments: [10, 10, 20]}"])


def test_products_of_inertia_stand_where_they_belong(good: Path) -> None:
    """Jyz, Jxz, Jxy: 5 kg·m² is possible as Jxy of this body and not as Jyz. Kills another order."""
    assert matrix((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)).tolist() == [[1.0, 6.0, 5.0], [6.0, 2.0, 4.0], [5.0, 4.0, 3.0]]
    assert load(good, ["pursuer.inertia_kgm2={moments: [10, 10.5, 20], products: [0, 0, 5]}"])
    spec, findings, _ = parse(good, ["pursuer.inertia_kgm2={moments: [10, 10.5, 20], products: [5, 0, 0]}"])
    assert spec is None
    assert "breaks the triangle inequality" in str(findings[0])


def test_equal_campaigns_are_equal(good: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy.yaml"
    copy.write_text("# a comment\n" + good.read_text())
    assert load(copy) == load(good)
    assert load(good, ["seed=8"]) != load(good)


def _accepts(schema_of: Any, value: Any, defs: dict[str, Any]) -> bool:
    """The few words of JSON Schema that are used here, read literally."""
    types = {
        "object": dict,
        "array": list,
        "string": str,
        "number": (int, float),
        "integer": int,
        "boolean": bool,
        "null": type(None),
    }
    if "$ref" in schema_of:
        return _accepts(defs[schema_of["$ref"].removeprefix("#/$defs/")], value, defs)
    if "anyOf" in schema_of and not any(_accepts(item, value, defs) for item in schema_of["anyOf"]):
        return False
    if "pattern" in schema_of and isinstance(value, str) and re.search(schema_of["pattern"], value) is None:
        return False
    if "oneOf" in schema_of and sum(_accepts(item, value, defs) for item in schema_of["oneOf"]) != 1:
        return False
    kind = schema_of.get("type")
    if kind and (not isinstance(value, types[kind]) or (isinstance(value, bool) and kind != "boolean")):
        return False
    if value != schema_of.get("const", value) or value not in schema_of.get("enum", [value]):
        return False
    if isinstance(value, dict):
        known = schema_of.get("properties", {})
        return (
            set(schema_of.get("required", [])) <= value.keys()
            and (schema_of.get("additionalProperties", True) or value.keys() <= known.keys())
            and all(_accepts(known[key], item, defs) for key, item in value.items() if key in known)
        )
    if isinstance(value, list):
        low, high = schema_of.get("minItems", 0), schema_of.get("maxItems", len(value))
        return low <= len(value) <= high and all(_accepts(schema_of.get("items", {}), item, defs) for item in value)
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return (
            value >= schema_of.get("minimum", value)
            and value <= schema_of.get("maximum", value)
            and value > schema_of.get("exclusiveMinimum", -math.inf)
            and value < schema_of.get("exclusiveMaximum", math.inf)
        )
    return True


def test_schema_accepts_the_good_and_refuses_the_bad(good: Path) -> None:
    whole = schema({"faults": {"effectiveness": Parameters}, "controller": {"pd-plus": Gains}})
    assert whole["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    defs = whole["$defs"]
    faults = "faults=[{use: effectiveness, force_N: {ball: 1}, gains: {k1: {uniform: [0, 1]}}}]"
    about = "start.rho_m={von_mises_fisher: {mean: [1, 0, 0], kappa: 10, radius: 5}}"
    others = (
        "start.sigma={rotation: uniform}",
        "pursuer.mass_kg={beta: [2, 5, 80, 120]}",
        "pursuer.inertia_kgm2.tilt_deg={weibull: [3, 2]}",
    )
    value = parse(good, [faults, about, *others])[2].value
    assert value is not None
    assert _accepts(whole, value, defs)
    for change in (
        {"samples": 0},
        {"sampels": 5},
        {"precision": "double"},
        {"pursuer": {**value["pursuer"], "mass_kg": {"unifrom": [1, 2]}}},
        {"pursuer": {**value["pursuer"], "mass_kg": -1}},
        {"start": {**value["start"], "rho_m": [1, 2]}},
        {"start": {**value["start"], "rho_m": {"rotation": "uniform"}}},
        {"start": {**value["start"], "rho_m": {"von_mises_fisher": {"mean": [1, 0, 0], "kappa": 10}}}},
        {"faults": [{"use": "effectiveness"}]},
        {"faults": [{"use": "unknown", "force_N": 1}]},
        {"controller": {"use": "pd-plus", "k2": 1}},
    ):
        assert not _accepts(whole, {**value, **change}, defs), change


def test_schema_tells_units_and_defaults() -> None:
    orbit = schema()["$defs"]["Orbit"]["properties"]["semi_major_axis_km"]
    assert orbit["description"] == "semi-major axis [km]"
    assert orbit["default"] == 6878.0
    assert orbit["anyOf"][0] == {"type": "number", "exclusiveMinimum": 0.0}
    assert set(schema()["properties"]) == set(Spec.model_fields)
