"""What a refusal proposes is accepted: each message is provoked, and what it proposes is tried.

A row of the tables: what is refused, the words of the message with a group for each proposal, and where the proposal is put. A group
that holds a list is tried name by name.
"""

# ruff: noqa: E501 (a row of a table is a line)

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from decimal import Decimal
from itertools import chain
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rvjax.campaign.plain_values import exact, shortest
from rvjax.components.disturbances.table import WRENCH
from rvjax.errors import CampaignError
from rvjax.search.tuning.tune import prepare
from rvjax.simulation.problem import load
from tests.program import Run
from tests.validated import validated

CAMPAIGN = """\
rvjax: 1
name: proposals
samples: 40
horizon: {duration_s: 60, step_s: 0.1}
target: {port_m: [5, 0, 0]}
pursuer: {mass_kg: {uniform: [90, 110]}, inertia_kgm2: {principal: [{uniform: [19, 21]}, 20, 21]}}
start: {rho_m: {ball: 2}, nu_m_s: {box: 0.01}}
actuators: {upper: 4, lower: 3}
faults: [{use: effectiveness, onset_s: 0.5, remaining: {uniform: [0.5, 1]}}]
disturbances: [{use: plume-pulse, force_N: 1, first_s: 1, width_s: 1.1, edge_s: 0.2, period_s: 20}]
controller: {use: command-filtered, gains: {k1: {uniform: [0.2, 0.3]}}}
baselines: [{use: pd-plus, name: other}]
capture: {window_s: 0.5}
"""
LIST = r"((?:[\w.-]+, )*[\w.-]+)"
THRUSTERS = "actuators={use: thrusters, layout: cube-24, size_m: 1.1, max_N: 3"

NORMAL = "start.rho_m=[{normal: [1, 0.123456789]}, {normal: [2, 1]}, 0]"
OPEN_NORMAL = NORMAL.replace("{", "{{").replace("}", "}}")
FILES = {
    "masses.csv": "mass_kg,other\n90,1\n110,2\n",
    "sep.csv": "sep=x\nmass_kg;other\n90;1\n95;2\n",
    "sep;.csv": "sep=;\nmass_kg;other\n90;1\n95;2\n",
    **{f"{name}.csv": f"t_s,{name}\n0,0.1\n9,0.2\n" for name in WRENCH},
}
"""CSV files beside the campaign; for each proposal about a file that file as it was proposed."""

Row = tuple[str, str, str]

NUMBERS: tuple[Row, ...] = (
    ("horizon.step_s=0.00833333", r"such as (\S+) s", "horizon.step_s={}"),
    ("horizon={duration_s: 1.1, step_s: 0.3333}", r"such as (\S+) s", "horizon={{duration_s: 1.1, step_s: {}}}"),
    ("horizon={duration_s: 7.7, step_s: 0.123456789}", r"such as (\S+) s", "horizon={{duration_s: 7.7, step_s: {}}}"),
    ("horizon.step_s=1234567", r"at most (\S+) s", "horizon.step_s={}"),
    ("horizon.step_s=1e-9", r"such as steps of (\S+) s", "horizon.step_s={}"),
    ("horizon={duration_s: 7.000000007, step_s: 1e-12}", r"such as steps of (\S+) s", "horizon={{duration_s: 7.000000007, step_s: {}}}"),
    ("horizon.control_period_s=0.25", r"such as (\S+) s", "horizon.control_period_s={}"),
    ("horizon.control_period_s=0.01", r"such as (\S+) s", "horizon.control_period_s={}"),
    ("capture={window_s: 61}", r"at most (\S+) s", "capture={{window_s: {}}}"),
    ("target={port_m: [5, 0, 0], attitude_mrp: [1.0000001, 0, 0]}", r"at most (\S+) in", "target.attitude_mrp=[{}, 0, 0]"),
    ("pursuer.mass_kg=-1", r"above (\S+) kg", "pursuer.mass_kg=1{}"),
    ("faults.0.onset_s=60", r"below (\S+) s", "faults.0.onset_s=0.99999{}"),
    ("faults.0.remaining=1.00000001", r"at most (\S+)", "faults.0.remaining={}"),
    ("disturbances.0.period_s=1.2345678", r"at least (\S+) s in", "disturbances.0.period_s={}"),
    ("sampler={use: grid, levels: {pursuer.mass_kg: [89.9999999]}}", r"accepted: (\S+) to", "sampler={{use: grid, levels: {{pursuer.mass_kg: [{}]}}}} samples=1"),
    ("sampler={use: grid, levels: {pursuer.mass_kg: 50, start.nu_m_s.x: 50}}", r"samples of a grid; accepted: ([\d,]+), the", "sampler={{use: grid, levels: {{pursuer.mass_kg: 50, start.nu_m_s.x: 50}}}} samples={}"),
    ("sampler={use: grid, levels: {pursuer.mass_kg: 0}}", r"1 to ([\d,]+), or", "sampler={{use: grid, levels: {{pursuer.mass_kg: {0}}}}} samples={0}"),
    ("require=[{metric: captured, at_least: 0.12345678, method: sprt, expected: 0.1}]", r"above the required (\S+)", "require=[{{metric: captured, at_least: 0.12345678, method: sprt, expected: {}1}}] samples=900000000"),
    ("require=[{metric: delta_v_m_s, mean: true, below: 3, range: [0, 1.2345678]}]", r"range of (\S+) to", "require=[{{metric: delta_v_m_s, mean: true, below: {}.00001, range: [0, 1.2345678]}}]"),
    ("require=[{metric: captured, mean: true}]", r"has no mean; accepted: metric, (at_least)", "require=[{{metric: captured, {}: 0.5}}]"),
    ("margins={m: {always: {signal: position_error_m, below: 9, to_s: 60.1}}}", r"at most (\S+) s", "margins={{m: {{always: {{signal: position_error_m, below: 9, to_s: {}}}}}}}"),
    (f"{THRUSTERS}, least_margin: 0.9999999}}", r"at most (\S+), the share", f"{THRUSTERS.replace('{', '{{')}, least_margin: {{}}}}}}"),
    ("samples=0", r"at least (\d+)", "samples={}"),
    ("samples=9999999999", r"at most (\d+)", "samples={}"),
    ("keep={worst: 99999}", r"at most (\d+)", "keep={{worst: {}}}"),
    ("pursuer.mass_kg=1e301", r"at most (\S+)", "controller.gains.c_force=1"),
    ("controller={use: command-filtered, gains: {k1: 0.25000001, filter_rad_s: 0.2}}", r"above k1, (\S+) rad", "controller={{use: command-filtered, gains: {{k1: 0.25000001, filter_rad_s: {}1}}}}"),
    ("controller={use: saturated-adaptive, gains: {mass_min_kg: 20.0000001, mass_guess_kg: 20}}", r"from (\S+) to", "controller={{use: saturated-adaptive, gains: {{mass_min_kg: 20.0000001, mass_guess_kg: {}}}}}"),
    ("disturbances=[{use: plume-pulse, force_N: 1, first_s: 1.01, width_s: 0.001, edge_s: 0.001}]", r"a pulse of (\S+) s \(half", "disturbances=[{{use: plume-pulse, force_N: 1, first_s: 1.01, width_s: {}, edge_s: 0.001}}]"),
    ("faults=[{use: stuck, onset_s: 0.51, share: 1, duration_s: 0.01}]", r"accepted: (\S+) s \(half", "faults=[{{use: stuck, onset_s: 0.51, share: 1, duration_s: {}}}]"),
    (f"{NORMAL} correlate=[{{variables: [start.rho_m.x, start.rho_m.y], covariance: [[0.02, 0], [0, 1]]}}]", r"accepted: (\S+), the square", f"{OPEN_NORMAL} correlate=[{{{{variables: [start.rho_m.x, start.rho_m.y], covariance: [[{{}}, 0], [0, 1]]}}}}]"),
    (f"{NORMAL} correlate=[{{variables: [start.rho_m.x, start.rho_m.y], covariance: [[0.015241578750190521, 1], [1, 1]]}}]", r"from \S+ to (\S+)", f"{OPEN_NORMAL} correlate=[{{{{variables: [start.rho_m.x, start.rho_m.y], covariance: [[0.015241578750190521, {{0}}], [{{0}}, 1]]}}}}]"),
    ("controller={use: saturated-adaptive, gains: {mass_max_kg: 299.9999999, mass_guess_kg: 300}}", r"from \S+ to (\S+)", "controller={{use: saturated-adaptive, gains: {{mass_max_kg: 299.9999999, mass_guess_kg: {}}}}}"),
)  # fmt: skip

NAMES: tuple[Row, ...] = (
    ("correlate=[{variables: [nothing, pursuer.mass_kg], rank: [[1, 0.5], [0.5, 1]]}]", rf"such as {LIST}", "correlate=[{{variables: [{}, pursuer.inertia_kgm2.principal.x], rank: [[1, 0.5], [0.5, 1]]}}]"),
    ("correlate=[{variables: [start.rho_m.z, start.nu_m_s.w], rank: [[1, 0.5], [0.5, 1]]}]", r"did you mean (\S+)\?", "correlate=[{{variables: [{}, pursuer.mass_kg], rank: [[1, 0.5], [0.5, 1]]}}]"),
    ("epistemic=[pursuer.mas]", r"did you mean (\S+)\?", "epistemic=[{}]"),
    ("epistemic=[zzz]", rf"such as {LIST}", "epistemic=[{}]"),
    ("sampler={use: grid, levels: {zzz: 2}}", rf"such as {LIST}", "sampler={{use: grid, levels: {{{}: 40}}}}"),
    ("sampler={use: monte-calro}", r"did you mean (\S+)\?", "sampler={{use: {}}}"),
    ("controller={use: pd-puls}", r"did you mean (\S+)\?", "controller={{use: {}}}"),
    ("controller={use: zzz}", rf"accepted: {LIST}", "controller={{use: {}}} correlate=[]"),
    ("saturation={use: zzz}", rf"accepted: {LIST}", "saturation={{use: {}}}"),
    ("pursuer.mass=100", r"accepted: (\S+) \(", "pursuer.{}=100"),
    ("pursuer.mass_g=100", r"accepted: (\S+) \(", "pursuer.{}=100"),
    ("controler=1", r"did you mean (\S+)\?", "{}={{use: pd-plus}}"),
    ("require=[{metric: delta_v, below: 3, at_least: 0.5}]", r"did you mean (\S+)\?", "require=[{{metric: {}, below: 3, at_least: 0.5}}]"),
    ("require=[{metric: zzz, below: 3, at_least: 0.5}]", rf"accepted: captured, {LIST}", "require=[{{metric: {}, below: 3, at_least: 0.5}}]"),
    ("require=[{metric: captured, at_least: 0.5, where: {pursuer.mas_kg: {below: 100}}}]", r"did you mean (\S+)\?", "require=[{{metric: captured, at_least: 0.5, where: {{{}: {{below: 100}}}}}}]"),
    ("require=[{metric: captured, at_least: 0.5, where: 3}]", r"such as (\{.*\})", "require=[{{metric: captured, at_least: 0.5, where: {}}}]"),
    ("margins={m: 3}", r"such as (\{.*\})", "margins={{m: {}}}"),
    ("margins={m: {always: {signal: 3, below: 2}}}", r"such as (\w+)", "margins={{m: {{always: {{signal: {}, below: 2}}}}}}"),
    ("margins={m: {always: {signal: zzz, below: 2}}}", rf"such as {LIST}", "margins={{m: {{always: {{signal: {}, below: 2}}}}}}"),
    ("faults.0.schedule={groups: 3}", r"such as (\[\[.*\]\])", "faults.0.schedule={{groups: {}}}"),
    ("faults.0.channels=[fw]", rf"list out of {LIST}, each", "faults.0.channels=[{}]"),
    ("faults.9.onset_s=3", rf"accepted: {LIST}", "faults.{}.onset_s=3"),
    ("zzz", r"such as (\S+)", "{}"),
    ("pursuer.mass_kg={table: {csv: masses.csv, column: mas_kg}}", r"did you mean (\S+)\?", "pursuer.mass_kg={{table: {{csv: masses.csv, column: {}}}}}"),
    ("pursuer.mass_kg={table: {csv: masses.csv, column: zzz}}", rf"accepted: {LIST}", "pursuer.mass_kg={{table: {{csv: masses.csv, column: {}}}}}"),
    ("disturbances=[{use: table, csv: masses.csv}]", rf"mass_kg; accepted: t_s, {LIST}", "disturbances=[{{use: table, csv: {}.csv}}]"),
    ("pursuer.mass_kg={table: {csv: sep.csv, column: mass_kg}}", r"such as sep=(\S)", "pursuer.mass_kg={{table: {{csv: 'sep{}.csv', column: mass_kg}}}}"),
    (f"{THRUSTERS.replace('cube-24', 'cube-42')}}}", r"accepted: '([\w-]+)' or", "actuators={{use: thrusters, layout: {}, size_m: 1.1, max_N: 3}}"),
    (f"{THRUSTERS.replace('cube-24', 'cube-42')}}}", r"or '([\w-]+)'", "actuators={{use: thrusters, layout: {}, size_m: 1.1, max_N: 3}}"),
    (f"{THRUSTERS}, allocation: zzz}}", rf"accepted: {LIST}", f"{THRUSTERS.replace('{', '{{')}, allocation: {{}}}}}}"),
    (f"{THRUSTERS}, allocation: {{use: pseudo-inverze}}}}", r"did you mean (\S+?)[?]", f"{THRUSTERS.replace('{', '{{')}, allocation: {{{{use: {{}}}}}}}}}}"),
    (f"{THRUSTERS}, centre: 0.4}}", r"accepted: (allocation: \{.*\})", f"{THRUSTERS.replace('{', '{{')}, {{}}}}}}"),
    (f"{THRUSTERS}}} faults.0.channels=[zzz]", r"out of (\w+) to", f"{THRUSTERS.replace('{', '{{')}}}}} faults.0.channels=[{{}}]"),
    (f"{THRUSTERS}}} faults.0.channels=[zzz]", r"out of \w+ to (\w+)", f"{THRUSTERS.replace('{', '{{')}}}}} faults.0.channels=[{{}}]"),
)  # fmt: skip

TUNE = "tune={parameters: {controller.gains.k1: {log: [0.03, 0.3]}}, objective: {metric: delta_v_m_s, mean: true}"
OPEN = TUNE.replace("{", "{{").replace("}", "}}")
TUNINGS: tuple[Row, ...] = (
    ("tune={parameters: 3, objective: {metric: delta_v_m_s, mean: true}}", r"such as (\{.*\})", "tune={{parameters: {}, objective: {{metric: delta_v_m_s, mean: true}}}}"),
    (f"{TUNE}, samples: 50, budget: {{flights: 40}}}}", r"at most (\d+) samples", f"{OPEN}, samples: {{}}, budget: {{{{flights: 40}}}}}}}}"),
    (f"{TUNE}, samples: 50, race: {{first: 60}}}}", r"at most the (\d+) samples", f"{OPEN}, samples: 50, race: {{{{first: {{}}}}}}}}}}"),
    (f"{TUNE}, method: {{use: cma-se}}}}", r"did you mean (\S+)\?", f"{OPEN}, method: {{{{use: {{}}}}}}}}}}"),
    (f"{TUNE}, method: {{use: zzz}}}}", rf"accepted: {LIST}", f"{OPEN}, method: {{{{use: {{}}}}}}, budget: {{{{candidates: 30}}}}}}}}"),
    (f"{TUNE}, method: {{use: grid, levels: 50}}, budget: {{candidates: 8}}}}", r"use levels: (\d+)", f"{OPEN}, method: {{{{use: grid, levels: {{}}}}}}, budget: {{{{candidates: 8}}}}}}}}"),
    (f"{TUNE}, method: {{use: grid, levels: 50}}, budget: {{candidates: 8}}}}", r"a budget of (\d+) cand", f"{OPEN}, method: {{{{use: grid, levels: 50}}}}, budget: {{{{candidates: {{}}}}}}}}}}"),
    (TUNE.replace("log: [0.03, 0.3]", "integer: [1, 20000]") + "}", r"less than (\d+) apart", TUNE.replace("log: [0.03, 0.3]", "integer: [1, 9]").replace("{", "{{").replace("}", "}}") + "}}"),
    (TUNE.replace("controller.gains.k1", "require.0") + "}", r"such as (\S+)", OPEN.replace("controller.gains.k1", "{}") + "}}"),
    (TUNE.replace("controller.gains.k1", "zzz") + "}", r"a place such as (\S+), or", OPEN.replace("controller.gains.k1", "{}") + "}}"),
)  # fmt: skip


NEXT = re.compile(r" (?=[\w.]+=)")
"""Between two overrides."""

LOOKED_AT = ("onset_s", "first_s")
"""Keys whose values `rvjax validate` looks at where they cannot act."""


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("proposals") / "proposals.yaml"
    path.write_text(CAMPAIGN)
    for name, content in FILES.items():
        (path.parent / name).write_text(content)
    return path


def proposals(message: str, words: str) -> list[tuple[str, ...]]:
    """What a message proposes: for each try the value of every group."""
    found = re.search(words, message)
    assert found, message
    first, *others = found.groups()
    several = first.split(", ") if re.fullmatch(LIST, first) and not re.fullmatch(r"[\d.,e-]+", first) else [first]
    return [(one, *others) for one in several]


@pytest.mark.parametrize(("refused", "words", "again"), [*NUMBERS, *NAMES, *TUNINGS], ids=lambda text: str(text)[:60])
def test_a_campaign_accepts_what_its_refusal_proposes(refused: str, words: str, again: str, campaign: Path) -> None:
    """Kills: a number rounded to six digits, thousands with commas, the name of a draw that is not scalar, a signal that a baseline
    has not, a bound that is itself refused."""
    read = prepare if "tune=" in refused else validated if any(key in refused for key in LOOKED_AT) else load
    with pytest.raises(CampaignError) as caught:
        read(campaign, NEXT.split(refused))
    for values in proposals(str(caught.value), words):
        read(campaign, NEXT.split(again.format(*values)))


ARGUMENTS: tuple[tuple[Sequence[str], str, Sequence[str]], ...] = (
    (("explain", "pd-puls"), r"did you mean ([\w-]+)", ("explain", "{}")),
    (("plan",), r"or (--at-least) SHARE", ("plan", "{}", "0.9")),
    (("plan", "--at-least", "0.9", "--confidence", "0.4"), r"at least (\S+), below", ("plan", "--at-least", "0.9", "--confidence", "{}")),
    (("plan", "--at-least", "0.9", "--power", "0.4"), r"at least (\S+), below", ("plan", "--at-least", "0.9", "--power", "{}")),
    (("plan", "--at-least", "0.12345678", "--true", "0.1"), r"above the (\S+) that", ("plan", "--at-least", "0.12345678", "--true", "{}1")),
    (("plan", "--at-least", "0.12345678", "--expected", "0.1"), r"above the (\S+) that", ("plan", "--at-least", "0.12345678", "--expected", "{}1")),
    (("plan", "--at-most", "0.12345678", "--true", "0.2"), r"below the (\S+) that", ("plan", "--at-most", "0.12345678", "--true", "{}e-1")),
    (("validate", "FILE", "--set", "zzz"), r"such as (\S+)", ("validate", "FILE", "--set", "{}")),
    (("check", "DIR", "--samples", "3"), r", (--quiet)", ("check", "DIR", "{}")),
    (("compare", "DIR", "DIR", "--margin", "2"), r"as (\S+)", ("compare", "DIR", "DIR", "--margin", "{}")),
    (("compare", "DIR", "DIR", "--confidence", "2"), r"as (\S+)", ("compare", "DIR", "DIR", "--confidence", "{}")),
    (("compare", "DIR", "DIR", "--metric", "zzz"), r"as (\S+)", ("compare", "DIR", "DIR", "--metric", "{}")),
    (("compare", "DIR", "DIR", "--metric", "delta_v_m_s:2"), r"as (\S+)", ("compare", "DIR", "DIR", "--metric", "delta_v_m_s:{}")),
    (("compare", "DIR", "DIR", "--metric", "zzz:0.5"), r"accepted: ([\w.]+)", ("compare", "DIR", "DIR", "--metric", "{}:0.5")),
    (("compare", "DIR", "elsewhere"), r"written by `rvjax (run)`", ("{}", "--help")),
)  # fmt: skip


@pytest.mark.parametrize(("refused", "words", "again"), ARGUMENTS, ids=lambda part: " ".join(part)[:40])
def test_a_command_accepts_what_its_refusal_proposes(
    refused: Sequence[str], words: str, again: Sequence[str], campaign: Path, flown: Path, rvjax: Run
) -> None:
    """Kills: a bound that the command itself refuses."""
    paths = {"FILE": str(campaign), "DIR": str(flown)}
    code, _, said = rvjax(*(paths.get(part, part) for part in refused))
    assert code == 2, said
    for values in proposals(said, words):
        code, _, said = rvjax(*(paths.get(part, part.format(*values)) for part in again))
        assert code in ((0, 3) if "DIR" in refused else (0,)), said  # 3: a verdict on few samples


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_number_is_read_as_it_was(value: float) -> None:
    """Kills: six digits."""
    assert float(exact(value)) == value
    assert "," not in exact(value)


@given(st.floats(1e-6, 1e6), st.integers(1, 10**6))
def test_the_shortest_number(span: float, whole: int) -> None:
    """No shorter number is accepted. Kills: all digits where fewer do, a number that is not accepted."""

    def accepted(x: float) -> bool:
        return math.isclose(whole * x, span, rel_tol=1e-9)

    text = shortest(span / whole, accepted)
    assert accepted(float(text))
    digits = len(Decimal(text).normalize().as_tuple().digits)
    assert not any(accepted(float(f"{span / whole:.{n}g}")) for n in range(1, min(digits, 17)))


def test_the_catalogue_is_counted() -> None:
    """So many refusals are provoked."""
    assert len([*chain(NUMBERS, NAMES, TUNINGS)]) + len(ARGUMENTS) == 92
