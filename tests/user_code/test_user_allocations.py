"""Allocations of a user: what they compute, mistakes, identity."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd
import pytest
from scipy.optimize import linprog, lsq_linear

from rvjax.campaign.actuators import Thrusters
from rvjax.campaign.thruster_layout import Layout
from rvjax.cli.templates import allocation as template
from rvjax.components import Allocation, number, scalar
from rvjax.components import Parameters as Model
from rvjax.execution.identity import identity
from rvjax.execution.replay import replay
from rvjax.execution.run import run
from rvjax.notebook import Campaign
from rvjax.physics.vectors import Channels
from rvjax.run_folder import RunFolder
from rvjax.simulation.problem import load
from rvjax.testing import check_component
from tests.program import Run

pytestmark = pytest.mark.usefixtures("bare")

CAMPAIGN = """rvjax: 1
name: mine
samples: 8
horizon: {duration_s: 4, step_s: 0.1}
target: {rate_deg_s: [0.2, -0.3, 0.1], port_m: [5, 0, 0]}
pursuer: {mass_kg: {uniform: [90, 110]}, inertia_kgm2: {principal: [22, 20, 23]}}
start: {rho_m: {box: 5}, sigma: {box: 0.2}}
actuators:
  use: thrusters
  layout: pinwheel-12
  size_m: 0.7
  max_N: 2
  allocation: ALLOCATION
capture: {window_s: 1}
controller: {use: pd-plus}
"""

MINE = '''"""The pseudo-inverse, written again."""
import jax.numpy as jnp
import numpy as np

from rvjax.components import Allocation, Parameters, number, option


class Centre(Parameters):
    """The centre."""

    centre: float = number("1", default=0.5, at_least=0.0, at_most=1.0, doc="share without a command")


def shares(wrench, thrusters, parameters):
    weight = np.diag(2.0 / (thrusters.upper + thrusters.lower))
    inverse = np.linalg.pinv(weight @ thrusters.matrix @ np.diag(thrusters.most)) @ weight
    middle = parameters.centre * np.ones(len(thrusters.most))
    opened = middle + inverse @ (wrench - thrusters.matrix @ (thrusters.most * middle))
    return opened


ALLOCATION = Allocation(Centre, shares)
'''
RETURN = "    return opened\n"


def project(folder: Path, allocation: str = "./mine.py", mine: str = MINE) -> Path:
    """A campaign with an allocation, and a user's file."""
    (folder / "mine.py").write_text(mine)
    campaign = folder / "mine.yaml"
    campaign.write_text(CAMPAIGN.replace("ALLOCATION", allocation))
    return campaign


def frame(folder: Path) -> pd.DataFrame:
    """The samples table."""
    return RunFolder.open(folder).samples().frame


# --- what it computes -------------------------------------------------------------------------------------------------


def test_an_allocation_of_a_user_flies_like_ours(tmp_path: Path) -> None:
    """The pseudo-inverse written again: the same flights to rounding, and the same shares by its name alone. Kills: a parameter
    that is lost, shares that are taken for thrusts, a wrench in another order."""
    campaign = project(tmp_path)
    mine, ours = (
        frame(run(campaign, tmp_path / name, [f"actuators.allocation={{use: {use}, centre: 0.1}}"], progress=False))
        for name, use in (("mine", "./mine.py"), ("ours", "pseudo-inverse"))
    )
    assert list(mine.columns) == list(ours.columns)
    for name in (name for name in mine.columns if name.startswith("metric.")):
        np.testing.assert_allclose(mine[name], ours[name], rtol=1e-9, atol=1e-9, err_msg=name)
    wrench = Channels.of((0.3, -0.2, 0.1, 0.05, 0.1, -0.2))
    shares: dict[str, np.ndarray] = {}
    for said in ("./mine.py", "pseudo-inverse", "{use: pseudo-inverse, centre: 0.1}"):
        gear = load(campaign, [f"actuators.allocation={said}"]).loop.gear
        assert gear is not None
        shares[said] = np.array(gear.allocation.at(wrench).parts())
    mine_alone, ours_alone, other = shares.values()
    np.testing.assert_allclose(mine_alone, ours_alone, rtol=1e-5)
    assert np.abs(ours_alone - other).max() > 0.1


def test_its_thrusts_are_in_the_trace(tmp_path: Path) -> None:
    """f = x f_max, with the drawn f_max: the shares are constants here. Kills: the nominal thrusts behind the allocation."""
    given = np.linspace(-0.2, 1.3, 12)
    mine = MINE.replace(RETURN, f"    return jnp.array({given.tolist()})\n")
    campaign = project(tmp_path, mine=mine)
    campaign.write_text(campaign.read_text().replace("max_N: 2\n", "max_N: 2\n  spread: {uniform: [0.9, 1.1]}\n"))
    folder = run(campaign, tmp_path / "run", ["audit.allow=[start, actuators.spread]"], progress=False)
    trace, _, row = replay(folder, 3)
    for index, share in enumerate(np.clip(given, 0.0, 1.0), start=1):
        most = 2.0 * row[f"draw.actuators.spread.t{index}"]
        np.testing.assert_allclose(trace[f"thrust_t{index}_N"], share * most, rtol=1e-12)


def at(allocation: Allocation, layout: Layout, **said: Any) -> Callable[[Any], np.ndarray]:
    """(6,) wrench → (n,) shares of an allocation."""
    built = allocation.component.build(allocation.parameters.model_validate(said))(layout)
    compiled = jax.jit(lambda w: jnp.stack(built.at(Channels.of(tuple(w))).parts()))
    return lambda w: np.array(compiled(jnp.asarray(w)))


UNEVEN = Thrusters.model_validate(
    {
        "use": "thrusters",
        "thrusters": [
            {"at_m": at, "along": along, "max_N": 1.0 + 0.1 * index}
            for index, (at, along) in enumerate(
                (place, way)
                for s in (-0.5, 0.5)
                for place, way in (
                    ([0, s, 0.5], [1, 0, 0]), ([0, s, -0.5], [-1, 0, 0]), ([0, s, -0.4], [1, 0, 0]), ([0, s, 0.4], [-1, 0, 0]),
                    ([0.5, 0, s], [0, 1, 0]), ([-0.5, 0, s], [0, -1, 0]), ([-0.4, 0, s], [0, 1, 0]), ([0.4, 0, s], [0, -1, 0]),
                    ([s, 0.5, 0], [0, 0, 1]), ([s, -0.5, 0], [0, 0, -1]), ([s, -0.4, 0], [0, 0, 1]), ([s, 0.4, 0], [0, 0, -1]),
                )
            )
        ],
    }
)  # fmt: skip
"""24 thrusters, each of another strength."""


def test_a_user_gets_the_nominal_thrusters() -> None:
    """B by cross products, the limits by linear programs of SciPy. Kills: upper and lower limits that are swapped, a transposed
    matrix, places from another point."""
    seen: list[Any] = []

    def shares(wrench: Any, thrusters: Any, parameters: Any) -> Any:
        seen.append(thrusters)
        return jnp.zeros(len(thrusters.most)) + wrench[0]

    assert at(Allocation(Model, shares), UNEVEN.geometry)(np.full(6, 0.25)).tolist() == [0.25] * 24
    matrix, most, upper, lower = seen[0]
    columns = [[*thruster.along, *np.cross(thruster.at_m, thruster.along)] for thruster in UNEVEN.thrusters]
    np.testing.assert_allclose(matrix, np.transpose(columns), atol=1e-15)
    np.testing.assert_array_equal(most, [thruster.max_N for thruster in UNEVEN.thrusters])
    for sign, limits in ((1.0, upper), (-1.0, lower)):
        for channel, limit in enumerate(limits):
            rest = np.delete(np.transpose(columns), channel, axis=0)
            cost_of = -sign * np.transpose(columns)[channel]
            best = linprog(cost_of, A_eq=rest, b_eq=np.zeros(5), bounds=[(0.0, f) for f in most])
            np.testing.assert_allclose(limit, -best.fun, rtol=1e-6)
    assert np.abs(upper - lower).max() > 0.05


@pytest.mark.parametrize(("wrench", "shares"), [((2.0, -0.5, 0, 0, 0, 0), (1.0, 0.0)), ((0.4, 0.7, 0, 0, 0, 0), (0.4, 0.7))])
def test_shares_are_clipped(wrench: tuple[float, ...], shares: tuple[float, float]) -> None:
    """Below 0 counts as 0, above 1 as 1. Kills: a thruster that pulls, one that gives more than it can."""
    given = at(Allocation(Model, lambda w, thrusters, parameters: jnp.resize(w, len(thrusters.most))), UNEVEN.geometry)(wrench)
    np.testing.assert_allclose(given[:2], shares)
    assert given.min() >= 0.0
    assert given.max() <= 1.0


def test_the_example_of_the_page_solves_its_problem() -> None:
    """With many steps, against SciPy's bounded least squares. Kills: a step that is too long, a weight of the wrench that is left
    out, thrusts in place of shares."""
    layout, rng, effort = UNEVEN.geometry, np.random.default_rng(5), 0.05
    b, most = np.transpose([[*d, *np.cross(r, d)] for r, d in zip(layout.at, layout.along, strict=True)]), np.array(layout.most)
    seen: list[Any] = []
    at(Allocation(Model, lambda w, thrusters, _: seen.append(thrusters) or jnp.zeros(24)), layout)(np.zeros(6))
    weight = 2.0 / (seen[0].upper + seen[0].lower)
    solve = at(template.ALLOCATION, layout, steps=3000, effort=effort)
    a = weight[:, None] * b * most
    for wrench in rng.uniform(-0.8, 0.8, (8, 6)) / weight:
        rows, wanted = np.vstack([a, np.sqrt(effort) * np.eye(24)]), np.append(weight * wrench, np.zeros(24))
        np.testing.assert_allclose(solve(wrench), lsq_linear(rows, wanted, (0, 1), tol=1e-13).x, atol=1e-6)


# --- mistakes ---------------------------------------------------------------------------------------------------------


FAMILY = "from rvjax.components import Saturation\nSATURATION = Saturation(lambda v, up, low: v)"
DRAWN = "centre: float = __import__('rvjax.components', fromlist='x').scalar("
MISTAKES: Mapping[str, tuple[str, str, str, str]] = {
    "wrong shape": (
        RETURN,
        "    return opened[:6]\n",
        "def shares",
        "the result of shares has the shape (6,); accepted: real numbers of shape (12,)",
    ),
    "another layout": (
        RETURN,
        "    return jnp.zeros(24)\n",
        "def shares",
        "has the shape (24,); accepted: real numbers of shape (12,)",
    ),
    "none": (RETURN, "    opened\n", "def shares", "the result of shares is None; accepted: real numbers of shape (12,)"),
    "boolean": (RETURN, "    return opened > 0.5\n", "def shares", "the result of shares has the type bool"),
    "python if": (RETURN, "    if wrench[0] > 0: pass\n" + RETURN, "if wrench", "a Python if"),
    "numpy": (RETURN, "    return np.clip(np.sin(wrench[0]), 0, 1) + opened\n", "np.sin", "NumPy on a number of the flight"),
    "an unknown field": (RETURN, "    return thrusters.mosst\n", "mosst", "there is no mosst here; did you mean most?"),
    "an unknown parameter": (RETURN, "    return opened * parameters.center\n", "center", "has no attribute 'center'"),
    "two arguments": ("thrusters, parameters)", "thrusters)", "def shares", "shares() takes 2 positional arguments but 3"),
    "chance": (RETURN, "    return opened * np.random.rand()\n", "", "two traces are different programs"),
    "no allocation": (
        "ALLOCATION =",
        "_HIDDEN =",
        "",
        "no component of allocations; accepted: ALLOCATION = Allocation(Parameters, shares)",
    ),
    "another family": (
        "ALLOCATION = Allocation(Centre, shares)",
        FAMILY,
        "",
        "no component of allocations (SATURATION is one of saturations)",
    ),
    "no function": ("(Centre, shares)", "(Centre, 3)", "ALLOCATION =", "Allocation: shares is found 3; accepted: a function"),
    "no model": ("(Centre, shares)", "(dict, shares)", "ALLOCATION =", "accepted: a class that inherits from Parameters"),
    "a drawn number": (
        "centre: float = number(",
        DRAWN,
        "ALLOCATION =",
        "centre may be drawn, and an allocation is the same in every sample",
    ),
    "raises": (RETURN, "    raise ValueError('not today')\n", "not today", "shares: ValueError: not today"),
}


@pytest.mark.parametrize("said", ["./mine.py", "{use: ./mine.py, centre: 0.4}"])
@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_has_its_line_and_words(name: str, said: str, tmp_path: Path, rvjax: Run) -> None:
    """Kills: a traceback, a message without the line of the user, a check with other thrusters than the campaign's."""
    old, new, place, words = MISTAKES[name]
    assert MINE.count(old) == 1
    mine = f"{MINE.replace(old, new)}# {said}\n"  # a process executes the same text once
    code, out, err = rvjax("validate", project(tmp_path, said, mine))
    assert code == 2, out + err
    line = next((i for i, text in enumerate(mine.splitlines(), start=1) if place and place in text), 1)
    assert words in err
    assert f"mine.py:{line}: " in err
    assert "Traceback" not in err
    assert "rvjax_user_" not in err
    assert len(err.splitlines()) == 1, err


@pytest.mark.parametrize(
    ("said", "where", "words"),
    [
        ("./nomine.py", "13:15: actuators.allocation: ", "nomine.py cannot be read: No such file"),
        ("./mine", "13:15: actuators.allocation: ", "does not end in .py"),
        ("{use: ./nomine.py}", "13:21: actuators.allocation.use: ", "nomine.py cannot be read: No such file"),
        ("./mine.py:OTHER", "", "there is no OTHER; accepted: ALLOCATION"),
        ("{use: ./mine.py, centre: 2}", "13:40: actuators.allocation.centre: ", "accepted: a number at least 0 and at most 1"),
        ("{use: ./mine.py, center: 0.4}", "13:32: actuators.allocation.center: ", "unknown key; did you mean centre?"),
        ("mine", "13:15: actuators.allocation: ", "or ./FILE.py with an allocation, such as `rvjax init --allocation FILE.py`"),
        ("Mine", "13:15: actuators.allocation: ", "accepted: small letters"),
        ("[pseudo-inverse]", "13:15: actuators.allocation: ", "the name of a component, or a mapping with use and parameters"),
    ],
)
def test_a_mistake_in_the_campaign_has_its_place(said: str, where: str, words: str, tmp_path: Path, rvjax: Run) -> None:
    """Kills: a place below a name that stands alone."""
    campaign = project(tmp_path, said)
    code, _, err = rvjax("validate", campaign)
    assert code == 2
    place = f"{campaign}:{where}" if where else f"{tmp_path / 'mine.py'}:1: "
    assert any(line.startswith(place) and words in line for line in err.splitlines()), err


def test_every_mistake_is_named_at_once(tmp_path: Path, rvjax: Run) -> None:
    """An unknown layout hides no unknown allocation, and no file is tried on thrusters that are not known. Kills: an allocation
    that is checked with an example of thrusters."""
    campaign = project(tmp_path, "zzz")
    campaign.write_text(campaign.read_text().replace("pinwheel-12", "pinwheel-13"))
    _, _, err = rvjax("validate", campaign)
    assert "actuators.layout" in err
    assert "actuators.allocation: the text 'zzz' is not known here" in err
    campaign = project(tmp_path, mine=MINE.replace(RETURN, "    return opened * jnp.ones(12)\n"))
    assert rvjax("validate", campaign)[0] == 0
    campaign.write_text(campaign.read_text().replace("pinwheel-12", "pinwheel-13"))
    _, _, err = rvjax("validate", campaign)
    assert "mine.py" not in err
    assert len(err.splitlines()) == 1


def test_nan_is_called_by_its_name(tmp_path: Path, rvjax: Run) -> None:
    """From the first step on: exit code 2, the file, no folder, whether there are faults or not. Kills: a message that blames the
    controller or a fault."""
    for faults in ("", "faults: [{use: float, channels: [t1], onset_s: {uniform: [1, 2]}}]\n"):
        campaign = project(tmp_path, mine=MINE.replace(RETURN, "    return opened * jnp.nan\n"))
        campaign.write_text(campaign.read_text() + faults)
        code, _, err = rvjax("run", campaign, "--out", tmp_path / "run", "--quiet")
        assert code == 2
        assert (
            f"{tmp_path / 'mine.py'}:1: the result of the allocation is not finite, in every flight, from the first step on"
            in err
        )
        assert not (tmp_path / "run").exists()
    code, _, err = rvjax("check-component", tmp_path / "mine.py")
    assert code == 2
    assert "is not finite at 64 of 64 states" in err


# --- identity, manual, schema -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("said", ["./mine.py", "./mine.py:ALLOCATION", "{use: ./mine.py}"])
def test_the_code_is_part_of_the_run(said: str, tmp_path: Path, rvjax: Run) -> None:
    """Its helper, too. The folder keeps the files, and an edit is another run. Kills: a name alone that is not read, or is not
    recorded."""
    mine = MINE.replace("import numpy as np\n", "import numpy as np\nfrom helper import FACTOR\n")
    mine = mine.replace(RETURN, "    return opened * FACTOR\n")
    (tmp_path / "helper.py").write_text("FACTOR = 1.0\n")
    campaign = project(tmp_path, said, mine)
    before = load(campaign)
    assert set(identity(before)["components"]) == {"mine.py", "helper.py"}
    folder = run(campaign, tmp_path / "run", progress=False)
    assert (folder / "inputs" / "mine.py").read_text() == mine
    first = frame(folder)
    for name, old, new in (("helper.py", "1.0", "0.5"), ("mine.py", "0.5", "0.4")):
        text = (tmp_path / name).read_text()
        (tmp_path / name).write_text(text.replace(old, new))
        after = load(campaign)
        assert identity(after) != identity(before)
        assert after.structure != before.structure
        code, _, err = rvjax("run", campaign, "--out", folder, "--quiet")
        assert code == 5
        assert name in err
        (tmp_path / name).write_text(text)
    trace, _, _ = replay(folder, 0)
    assert len(trace) == 41
    assert first.equals(frame(run(folder / "campaign.yaml", tmp_path / "again", progress=False)))


def test_an_object_stands_for_its_file(tmp_path: Path) -> None:
    """Kills: a section inside of another that takes no component of a notebook."""
    campaign = project(tmp_path, "pseudo-inverse")
    changed = Campaign(campaign).with_({"actuators.allocation": (template.ALLOCATION, {"steps": 3})})
    choice = changed.problem.spec.actuators.allocation  # pyright: ignore
    assert (choice.name, dict(choice.parameters)) == ("allocation", {"steps": 3})
    assert set(identity(changed.problem)["components"]) == {"allocation.py"}


def test_the_check_and_the_page_of_a_file(tmp_path: Path, rvjax: Run) -> None:
    """Family, parameters with unit and default. Kills: the parameters of drawn numbers only."""
    project(tmp_path)
    (found,) = check_component(tmp_path / "mine.py")
    assert (found.family, found.parameters) == ("allocations", ("centre",))
    assert found.operations > 100
    code, out, _ = rvjax("explain", tmp_path / "mine.py")
    assert code == 0
    assert "The pseudo-inverse, written again." in out
    assert re.search(r"centre +1 +0\.5 +at least 0 and at most 1", out)


class Nested(Model):
    """A part with a number that may be drawn."""

    gain: float = scalar("1", default=1.0, doc="gain")


class Outer(Model):
    """A model with a part."""

    fine: float = number("1", default=1.0, doc="fine")
    part: Nested = Nested()


def test_numbers_inside_of_a_part_are_not_drawn_either() -> None:
    """Kills: a check of the first level."""
    with pytest.raises(TypeError, match=r"Allocation: part\.gain may be drawn"):
        Allocation(Outer, lambda wrench, thrusters, parameters: wrench)
