"""Components of a user in flight: not finite at once and later, on arrays and on vectors, in discrete time, in every family."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from rvjax.execution.audit import prove
from rvjax.execution.replay import replay
from rvjax.execution.run import run
from rvjax.run_folder import RunFolder
from rvjax.simulation.batch import Flyer
from rvjax.simulation.problem import load
from tests.program import Run
from tests.user_code.mistakes import FORCE, LAW
from tests.user_code.test_user_mistakes import CAMPAIGN, project

TEMPLATES = Path(__file__).parents[2] / "rvjax" / "cli" / "templates"
pytestmark = pytest.mark.usefixtures("bare")


def frame(folder: Path) -> pd.DataFrame:
    """The samples table."""
    return RunFolder.open(folder).samples().frame


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (FORCE, FORCE + "    force = force * jnp.nan\n", "the command of the controller is not finite"),
        ("return jnp.zeros(3)", "return jnp.zeros(3) / 0.0", "the state of the controller at t = 0 is not finite"),
        ("{\"integral\": integral}", "{\"integral\": jnp.log(-1.0 - measured.t) + integral}", "the signal integral"),
    ],
)  # fmt: skip
def test_nan_at_once_is_called_by_its_name(tmp_path: Path, rvjax: Run, old: str, new: str, words: str) -> None:
    """Exit code 2, the file, no folder. Kills: a message that blames a draw of the campaign."""
    law = LAW.replace(old, new)
    if "signal" in words:  # a signal that is not finite disturbs no flight by itself
        law = law.replace(FORCE, FORCE + "    force = force + 0.0 * jnp.log(-1.0 - measured.t)\n")
    code, _, err = rvjax("run", project(tmp_path, law), "--out", tmp_path / "run", "--quiet")
    assert code == 2
    assert words in err
    assert "law.py:1" in err
    assert "from the first step on" in err
    assert "mass_kg" not in err
    assert not (tmp_path / "run").exists()


def test_nan_later_is_an_outcome(tmp_path: Path) -> None:
    """From 3.5 s on in every flight: outcome and time are in the table. Kills: an audit that blames the draws."""
    law = LAW.replace(FORCE, FORCE + "    force = jnp.where(measured.t > 3.45, jnp.nan, force)\n")
    table = frame(run(project(tmp_path, law), tmp_path / "run", progress=False))
    assert set(table["outcome"]) == {"not_finite"}
    np.testing.assert_allclose(table["outcome_time_s"], 3.5)


CHANGES = {
    "return jnp.zeros(3)": "return Vector(0.0, 0.0, 0.0)",
    "import numpy as np\n": "from rvjax.physics.vectors import Vector\n",
    'error")})': 'error")}, vectors=True)',
    "gains.kp * measured.rho + gains.kd * measured.nu": "measured.rho * gains.kp + measured.nu * gains.kd",
    "-3.0 * measured.sigma - 15.0 * measured.omega": "measured.sigma * -3.0 - measured.omega * 15.0",
}
VECTORS = functools.reduce(lambda law, change: law.replace(*change), CHANGES.items(), LAW)


def test_arrays_and_vectors_fly_alike(tmp_path: Path) -> None:
    """The same law in both forms: outcomes equal, all numbers to 1e-10. Kills: a wrong order of the components, a transposed
    matrix."""
    tables = []
    for name, law in (("arrays", LAW), ("vectors", VECTORS)):
        (tmp_path / name).mkdir()
        folder = run(project(tmp_path / name, law), tmp_path / name / "run", progress=False)
        tables.append(frame(folder))
        trace, columns, _ = replay(folder, 2)
        assert columns["ctl.integral_x"].unit == "m·s"
        np.testing.assert_allclose(trace["ctl.integral_y"].iloc[-1], np.trapezoid(trace["rho_y_m"], trace["t_s"]), rtol=2e-3)
    first, second = tables
    assert first["outcome"].equals(second["outcome"])
    for name in first.columns:
        if name.startswith("metric."):
            np.testing.assert_allclose(first[name], second[name], rtol=1e-10, atol=1e-10, err_msg=name)


SAMPLED = """
from rvjax.components import Command, DiscreteController, Parameters, Signal, scalar
import jax.numpy as jnp


class Gains(Parameters):
    kp: float = scalar("1/s²", default=0.01, above=0.0, doc="gain")


def start(measured, gains):
    return {"count": jnp.zeros(()), "last": measured.rho}


def update(measured, state, gains):
    force = -100.0 * gains.kp * (measured.rho + 20.0 * (measured.rho - state["last"]))
    new = {"count": state["count"] + 1.0, "last": measured.rho}
    return Command(force, -3.0 * measured.sigma - 15.0 * measured.omega, signals={"count": new["count"]}), new


CONTROLLER = DiscreteController(Gains, start, update, signals={"count": Signal("1", "instants")}, period_s=0.5)
"""


def test_a_discrete_controller_acts_at_its_instants(tmp_path: Path) -> None:
    """Its command changes at t = 0, 0.5 s, 1 s, … and nowhere else; its state is updated once at each. The difference equation is
    computed again from the trace. Kills: an update in every stage or step, a command that is a period late, a state that is
    integrated."""
    folder = run(project(tmp_path, SAMPLED), tmp_path / "run", progress=False)
    trace, _, _ = replay(folder, 1)
    steps = np.arange(len(trace))
    np.testing.assert_array_equal(trace["ctl.count"], steps // 5 + 1)
    command = trace[[f"ctl.v_f{axis}" for axis in "xyz"]].to_numpy()
    rho = trace[[f"rho_{axis}_m" for axis in "xyz"]].to_numpy()
    instants = steps[::5]
    before = np.vstack([rho[:1], rho[instants[:-1]]])
    expected = -100.0 * 0.01 * (rho[instants] + 20.0 * (rho[instants] - before))
    np.testing.assert_allclose(command[instants], expected, rtol=1e-12)
    for offset in range(5):
        held = command[instants[:-1] + offset]
        np.testing.assert_array_equal(held, command[instants[:-1]])


@pytest.mark.parametrize(
    ("period", "code", "words"),
    [("0.25", 2, "0.25 s is 2.5 steps; accepted: a whole number of steps"), ("0.3", 0, ""), ("null", 2, "without a period")],
)
def test_the_period_is_a_whole_number_of_steps(tmp_path: Path, rvjax: Run, period: str, code: int, words: str) -> None:
    """That of the controller, or that of the campaign. Kills: a period that is rounded."""
    own = "" if period == "null" else f", period_s: {period}"
    campaign = project(tmp_path, SAMPLED.replace(", period_s=0.5)", ")") if period == "null" else SAMPLED)
    campaign.write_text(campaign.read_text().replace("gains: {}", f"gains: {{}}{own}"))
    given, _, err = rvjax("validate", campaign)
    assert given == code
    assert words in err
    if period == "null":
        problem = load(campaign, ["horizon.control_period_s=0.4"])
        assert problem.loop.sampling == 4


EVERYTHING = """
faults: [{use: ./fault.py, onset_s: {uniform: [1, 2]}, width: {uniform: [0.1, 0.3]}}]
disturbances: [{use: ./disturbance.py, push_N: {uniform: [0.1, 0.2]}}]
navigation: [{use: ./navigation.py, share: {uniform: [0.001, 0.01]}}]
metrics: [{use: ./metric.py, radius_m: {uniform: [1, 2]}}, {use: ./metric.py, name: large, radius_m: 9}]
require: [{metric: large_ball_time_s, below: 100, at_least: 0.5}]
"""


def test_every_family_flies_a_file(tmp_path: Path, rvjax: Run) -> None:
    """The files that `rvjax init` writes, with drawn numbers: each draw acts (the audit refuses otherwise) and is in the table;
    two uses of a metric have their columns. Kills: numbers of another component, a metric that is not folded."""
    for name in ("fault", "disturbance", "navigation", "metric", "controller"):
        (tmp_path / f"{name}.py").write_text((TEMPLATES / f"{name}.py").read_text())
    campaign = tmp_path / "all.yaml"
    campaign.write_text(CAMPAIGN.replace("USE", "./controller.py").replace("GAINS", "{}") + EVERYTHING)
    code, _, err = rvjax("run", campaign, "--out", tmp_path / "run", "--quiet")
    assert code in (0, 3), err
    table = frame(tmp_path / "run")
    drawn = ("faults.fault.width.fx", "disturbances.disturbance.push_N", "navigation.navigation.share", "metrics.metric.radius_m")
    assert {f"draw.{name}" for name in drawn} <= set(table.columns)
    trace, _, _ = replay(tmp_path / "run", 0)
    s = trace[[f"sigma_{axis}" for axis in "xyz"]].to_numpy()
    rho = trace[[f"rho_{axis}_m" for axis in "xyz"]].to_numpy()
    place = np.array([_rotation(a).T @ b + [5.0, 0.0, 0.0] for a, b in zip(s, rho, strict=True)])
    distance = np.linalg.norm(place, axis=1)
    np.testing.assert_allclose(table["metric.ball_clearance_m"][0], distance.min() - table["draw.metrics.metric.radius_m"][0])
    weights = np.full(len(trace), 0.1)
    weights[[0, -1]] = 0.05
    np.testing.assert_allclose(table["metric.large_ball_time_s"][0], weights[distance < 9.0].sum())
    push = np.linalg.norm(trace[[f"dist_f{axis}" for axis in "xyz"]].to_numpy(), axis=1)
    np.testing.assert_allclose(push, table["draw.disturbances.disturbance.push_N"][0], rtol=1e-12)


def _rotation(sigma: np.ndarray) -> np.ndarray:
    """R(σ), by SciPy's quaternions: from T to P."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_mrp(np.array(sigma)).as_matrix().T


def test_a_gain_of_an_estimate_acts(tmp_path: Path) -> None:
    """A discrete-time law may estimate what no command depends on: a drawn gain of it is not called dead. Kills: an audit that
    does not see the state of a discrete-time controller."""
    law = (TEMPLATES / "discrete_controller.py").read_text()
    law = law.replace("return measured.omega\n", "return measured.omega, measured.rho\n").replace(
        "    rate = 0.5 * rate",
        "    rate, place = rate\n    place = place + gains.kf * (measured.rho - place)\n    rate = 0.5 * rate",
    )
    law = law.replace("torque), rate", "torque), (rate, place)").replace(
        "    kw: float", '    kf: float = scalar("1", default=0.1, above=0.0, doc="filter gain")\n    kw: float'
    )
    problem = load(project(tmp_path, law, gains="{kf: {uniform: [0.1, 0.2]}}"))
    assert "state.1" in prove(problem, Flyer.of(problem)).moved["controller.gains.kf"]
