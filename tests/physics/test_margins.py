"""Temporal margins, folded step by step, against signal temporal logic by its definition on whole traces."""

from __future__ import annotations

import json
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from rvjax.campaign.formula import Formula, Reader
from rvjax.columns import CHANNELS, Column
from rvjax.components.metrics.interface import MetricContext
from rvjax.execution.replay import trace as flown_again
from rvjax.physics.vectors import Vector
from rvjax.simulation import tables
from rvjax.simulation.batch import LANES, Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem, load
from rvjax.simulation.signals import Signal, derived, recorded
from rvjax.simulation.temporal_margins import margins_metric
from tests.oracles.absolute import columns
from tests.oracles.stl import Trace, holds, margin, state_margin
from tests.short import CAMPAIGN, SHORT

Array = NDArray[np.float64]
Said = dict[str, Any]

NAMES = ("a", "b", "c")
SIGNALS = {
    name: Signal(Column(name, "m", name), lambda step, place=place: step.values[place]) for place, name in enumerate(NAMES)
}
STEP_S, STEPS = 0.1, 24
T = np.arange(STEPS + 1) * STEP_S
DURATION_S = STEPS * STEP_S
FORMULAS, ROUNDS, SAMPLES = 12, 3, 64
"""Of random pairs of formula and trace: 12 structures in each of 3 programs, 5 with --long, each with 64 traces and sets of
numbers."""


def state(generator: np.random.Generator, depth: int = 2) -> Said:
    """A random formula without temporal operators, its numbers not yet chosen."""
    word = str(generator.choice(["signal", "all", "any", "not"])) if depth else "signal"
    if word == "not":
        return {"not": state(generator, depth - 1)}
    if word != "signal":
        return {word: [state(generator, depth - 1) for _ in range(generator.integers(1, 4))]}
    scale = {"scale": 1.0} if generator.random() < 0.4 else {}
    return {"signal": str(generator.choice(NAMES)), str(generator.choice(["below", "above"])): 0.0, **scale}


def formula(generator: np.random.Generator, depth: int = 2) -> Said:
    """A random formula of a whole flight, its numbers not yet chosen."""
    words = ["always", "eventually", "until_settled", "until"] + (["all", "any", "not"] if depth else [])
    word = str(generator.choice(words))
    if word == "not":
        return {"not": formula(generator, depth - 1)}
    if word in ("all", "any"):
        return {word: [formula(generator, depth - 1) for _ in range(generator.integers(1, 4))]}
    if word == "until_settled":
        return {word: state(generator)}
    window: Said = dict.fromkeys(["from_s", "to_s"][: generator.integers(0, 3)], 0.0)
    inner = {"hold": state(generator), "reach": state(generator)} if word == "until" else state(generator)
    return {word: inner | window}


def numbered(said: Any, generator: np.random.Generator) -> Any:
    """The same structure with random thresholds, scales and windows, whose ends are steps or lie between two."""
    if isinstance(said, list):
        return [numbered(part, generator) for part in said]
    if not isinstance(said, dict):
        return said
    found = {key: numbered(value, generator) for key, value in said.items()}
    for key in {"below", "above"} & said.keys():
        found[key] = float(generator.normal())
    if "scale" in said:
        found["scale"] = float(generator.uniform(0.2, 5.0))
    first, last = sorted(generator.integers(0, STEPS + 1, 2))
    between = generator.uniform(0.0, 0.9, 2) * (generator.random(2) < 0.5)
    if "from_s" in said:
        found["from_s"] = max(float(first - between[0]) * STEP_S, 0.0)
    if "to_s" in said:
        found["to_s"] = min(float(last + between[1]) * STEP_S, DURATION_S)
    return found


def read(said: Mapping[str, Said]) -> dict[str, Formula]:
    """As a campaign is read."""
    reader = Reader((DURATION_S, STEP_S))
    found = reader.margins(dict(said))
    assert not reader.problems
    return found


def traces(generator: np.random.Generator, count: int) -> list[Trace]:
    """Random signals; tubes that are entered for good at some step, at once or never, and at times only for a while before."""
    made: list[Trace] = []
    for _ in range(count):
        signals = {name: np.cumsum(generator.normal(size=STEPS + 1)) * 0.5 for name in NAMES}
        steps = np.arange(STEPS + 1)
        settled = generator.choice([0, STEPS + 1, *range(STEPS + 1)])
        inside = (steps >= settled) | ((generator.random(STEPS + 1) < 0.3) & (steps != settled - 1))
        made.append(Trace(signals, T, inside))
    return made


def fold(said: list[Mapping[str, Said]], made: list[Trace]) -> dict[str, Array]:
    """(samples,) margins by name, of one trace and one set of numbers for each sample; the structures are the same."""
    all_of_them = [margins_metric(read(one), SIGNALS, STEP_S) for one in said]
    metric = all_of_them[0].metric
    zero = jnp.zeros(())
    context = MetricContext(*(zero + 1.0,) * 4, zero, zero, Vector(zero, zero, zero), zero + STEP_S)

    def flight(numbers: tuple[Any, ...], values: Any, outside: Any) -> Mapping[str, Any]:
        own = context._replace(margins=numbers)

        def step(acc: Any, now: Any) -> tuple[Any, None]:
            t, values, (rho, sigma) = now
            motion = SimpleNamespace(rho=Vector(rho, zero, zero), sigma=Vector(zero, sigma, zero))
            return metric.update(acc, SimpleNamespace(t=t, values=values, motion=motion), zero, own), None  # pyright: ignore

        acc, _ = jax.lax.scan(step, metric.start(own), (jnp.asarray(T), values, outside))
        return metric.finish(acc, own)

    numbers = tuple(np.array([one.numbers for one in all_of_them]).T)
    values = np.array([np.stack([one.signals[name] for name in NAMES], axis=-1) for one in made])
    # outside by one tube alone, by the other alone, or by both
    which = np.arange(STEPS + 1) % 3
    outside = np.array([np.stack([2.0 * (~one.inside & (which != k)) for k in (0, 1)], axis=-1) for one in made])
    found = jax.jit(jax.vmap(flight))(numbers, values, outside)
    return {name.removeprefix("margin."): np.asarray(x) for name, x in found.items()}


@pytest.fixture(scope="module")
def pairs(request: pytest.FixtureRequest) -> list[tuple[Said, Trace, float]]:
    """(formula, trace, margin by the fold) of thousands of random pairs."""
    rounds = 5 if request.config.getoption("--long") else ROUNDS
    found: list[tuple[Said, Trace, float]] = []
    for seed in range(rounds):
        generator = np.random.default_rng(seed)
        bare = {f"m{index}": formula(generator) for index in range(FORMULAS)}
        said = [{name: numbered(one, generator) for name, one in bare.items()} for _ in range(SAMPLES)]
        made = traces(generator, SAMPLES)
        values = fold(said, made)
        found += [(said[i][name], made[i], float(values[name][i])) for name in bare for i in range(SAMPLES)]
    return found


def test_folds_are_the_definition_on_random_traces(pairs: list[tuple[Said, Trace, float]]) -> None:
    """Kills: min for max, a window off by a step at either end, T off by a step, hold asked for at the step of reach, a tube left
    out, a sign, a scale that multiplies, the numbers of one operator taken for those of another."""
    assert len(pairs) >= FORMULAS * ROUNDS * SAMPLES >= 2000
    wrong = [(said, found) for said, trace, found in pairs if found != pytest.approx(margin(said, trace), rel=1e-13, abs=0.0)]
    assert not wrong, wrong[0]
    assert {word for said, _, _ in pairs for word in said} == {
        *("all", "any", "not", "always", "eventually", "until_settled", "until")
    }


def test_a_margin_is_above_zero_where_the_formula_is_true(pairs: list[tuple[Said, Trace, float]]) -> None:
    """Soundness, against true and false by definition; each is met often. Kills: an operator that is another one's."""
    true = [holds(said, trace) for said, trace, _ in pairs]
    assert all((found > 0.0) is so and found != 0.0 for (_, _, found), so in zip(pairs, true, strict=True))
    assert 0.25 < np.mean(true) < 0.75


def test_a_share_of_time_counts_the_steps_of_its_window() -> None:
    """Kills: all steps for those of the window, a predicate that counts where it is false, an end that does not belong to it."""
    generator = np.random.default_rng(5)
    made = traces(generator, SAMPLES)
    said = [
        {"a": {"time_share": {**state(generator, 0), "from_s": 2 * STEP_S, "to_s": (STEPS - 3) * STEP_S}}} for _ in range(1)
    ] * SAMPLES
    found = fold(said, made)["a"]
    below = said[0]["a"]["time_share"]
    bare = {key: value for key, value in below.items() if not key.endswith("_s")}
    for trace, share in zip(made, found, strict=True):
        true = [state_margin(bare, trace, k) > 0 for k in trace.window(below)]
        assert len(true) == STEPS - 4
        assert share == pytest.approx(np.mean(true))
    assert 0 < found.mean() < 1


def test_not_always_is_eventually_not() -> None:
    """To the last bit, with any window. Kills: a negation that is lost, on either side of a temporal operator."""
    generator = np.random.default_rng(77)
    states = {f"m{index}": state(generator, 3) | {"from_s": 0.0, "to_s": 0.0} for index in range(FORMULAS)}
    numbers = [{name: numbered(one, generator) for name, one in states.items()} for _ in range(SAMPLES)]

    def inner(one: Said) -> Said:
        return {key: value for key, value in one.items() if key not in ("from_s", "to_s")}

    def window(one: Said) -> Said:
        return {key: one[key] for key in ("from_s", "to_s")}

    made = traces(generator, SAMPLES)
    outer = fold([{name: {"not": {"always": one}} for name, one in sample.items()} for sample in numbers], made)
    dual = [{name: {"eventually": {"not": inner(one), **window(one)}} for name, one in sample.items()} for sample in numbers]
    again = fold(dual, made)
    for name in states:
        np.testing.assert_array_equal(outer[name], again[name])


MARGINS: Said = {
    "gentle": {
        "all": [
            {"always": {"signal": "closing_speed_m_s", "below": 0.5, "scale": 0.1, "from_s": 3}},
            {"eventually": {"signal": "position_error_m", "below": 13, "scale": 2, "to_s": 6.04}},
            {"until_settled": {"signal": "attitude_error_deg", "below": 90, "scale": 5}},
        ]
    },
    "any": {
        "until": {
            "hold": {"signal": "speed_m_s", "above": 0.2, "scale": 1},
            "reach": {"signal": "rate_deg_s", "below": 0.4, "scale": 0.1},
            "to_s": 6,
        }
    },
    "worked": {"not": {"always": {"any": [{"signal": f"share_{name}", "below": 0.3} for name in (*CHANNELS, "any")]}}},
    "surface": {"eventually": {"all": [{"signal": "ctl.depth_fx", "below": 0.7}, {"signal": "ctl.depth_ty", "above": -0.2}]}},
    "seen": {"always": {"signal": "seen_rho_x_m", "above": -12.5}},
    "old": {"always": {"signal": "navigation.dropouts.age_s", "below": 0.25}},
    "clock": {"until_settled": {"signal": "t_s", "below": 0}},
}
FLIGHT = (
    *SHORT,
    "horizon={duration_s: 10, step_s: 0.1}",
    "controller={use: sliding-mode}",
    "navigation=[{use: noise, position_m: 0.05}, {use: dropouts, probability: 0.4}]",
    "capture={position_m: 17, attitude_mrp: 0.35, window_s: 5}",
)
OTHER = ("margins.gentle.all.1.eventually.to_s=3", "margins.any.until.reach.below=0.3", "margins.seen.always.above=-1.0")


def problem(*changes: str) -> Problem:

    return load(CAMPAIGN, [*FLIGHT, f"margins={json.dumps(MARGINS)}", *changes])


def recomputed(table: pd.DataFrame, one: Problem, plant: Any) -> Trace:
    """The signals of a trace, with those that follow from its columns, by NumPy."""
    rho, nu, sigma, omega = (columns(table, name) for name in ("rho_*_m", "nu_*_m_s", "sigma_*", "omega_*_rad_s"))
    commanded = columns(table, "cmd_*", CHANNELS)
    limits = np.where(commanded >= 0, np.array(plant.upper.parts()), np.array(plant.lower.parts()))
    shares = np.abs(commanded) / limits
    distance = np.linalg.norm(rho, axis=1)
    more = {
        "position_error_m": distance,
        "attitude_error_deg": np.degrees(4 * np.arctan(np.linalg.norm(sigma, axis=1))),
        "speed_m_s": np.linalg.norm(nu, axis=1),
        "closing_speed_m_s": -np.sum(rho * nu, axis=1) / distance,
        "rate_deg_s": np.degrees(np.linalg.norm(omega, axis=1)),
        **{f"share_{name}": share for name, share in zip(CHANNELS, shares.T, strict=True)},
        "share_any": shares.max(axis=1),
    }
    capture = one.spec.capture
    inside = (distance <= capture.position_m) & (np.linalg.norm(sigma, axis=1) <= capture.attitude_mrp)
    signals = {str(name): table[name].to_numpy() for name in table} | more
    assert set(derived()) == set(more), "every signal has its definition here"
    return Trace(signals, table["t_s"].to_numpy(), inside)


def test_a_flight_has_the_margins_of_its_trace() -> None:
    """Also with other numbers in the same program, out of which the traces come again. Kills: a threshold, scale or window that
    is a constant of the program, a signal of another column, a limit of the wrong side, a fold that misses the last step."""
    one = problem()
    flyer = Flyer.of(one)
    seen: list[Array] = []
    for own in (one, problem(*OTHER)):
        assert set(own.metric_columns) >= {f"margin.{name}" for name in MARGINS}
        draws, drawn = Draws.of(own, np.arange(LANES))
        flown = flyer.fly(drawn, own.spec.horizon.steps, every=own.spec.horizon.steps)
        rows, meanings = tables.samples_table(own, draws, flown, slice(0, 40))
        assert meanings["metric.margin.seen"].unit == "m"
        assert meanings["metric.margin.seen"].better == "higher"
        kept = [0, 3, 7, 12]
        for sample, (table, _) in flown_again(own, flyer, kept, 1, rows).items():
            plant = jax.tree.map(lambda x, sample=sample: x[sample], drawn.plant)
            made = recomputed(table, own, plant)
            said = own.spec.source.value["margins"] if own.spec.source.value else {}
            for name in MARGINS:
                expected = margin(said[name], made)
                assert rows[f"metric.margin.{name}"][sample] == pytest.approx(expected, rel=1e-9, abs=1e-9), (name, sample)
        seen.append(rows[[f"metric.margin.{name}" for name in sorted(MARGINS)]].to_numpy())
    clock = seen[0][:, sorted(MARGINS).index("clock")]
    assert np.isinf(clock).any(), "settled at once"
    assert ((clock > -10.0) & (clock < 0.0)).any(), "settled on the way"
    assert (clock == -10.0).any(), "never settled"
    assert (seen[0] != seen[1]).any(axis=0).tolist() == [name in ("any", "gentle", "seen") for name in sorted(MARGINS)]


def test_the_closing_speed_is_the_rate_of_the_distance() -> None:
    """Along a straight line, by a difference of distances; 0 at the docking point. Kills: a sign, the whole speed for it."""
    get, e = derived()["closing_speed_m_s"].get, 1e-6
    rho, nu = np.array([3.0, -4.0, 1.0]), np.array([-0.3, 0.2, 0.5])
    expected = (np.linalg.norm(rho - e * nu) - np.linalg.norm(rho + e * nu)) / (2 * e)
    step: Any = SimpleNamespace(motion=SimpleNamespace(rho=Vector(*rho), nu=Vector(*nu)))
    assert float(get(step)) == pytest.approx(expected, rel=1e-8)
    still: Any = SimpleNamespace(motion=SimpleNamespace(rho=Vector(0.0, 0.0, 0.0), nu=Vector(*nu)))
    assert float(get(still)) == 0.0


def test_derived_signals_are_no_columns_of_a_trace() -> None:
    """One name, one meaning."""
    assert not set(derived()) & set(recorded({}, {}, True, 24))
