"""`python -m benchmarks.peers`: rvjax, NumPy and an independent integration fly the same job; the table says what came."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchmarks.peers import HERE, PEERS, Peer, __main__, job, table
from benchmarks.peers.with_numpy import distances
from rvjax.simulation import jax_config
from rvjax.simulation.batch import Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load
from rvjax.simulation.tables import trace_tables

Array = NDArray[np.float64]
SAMPLES = 3
DRAWS = ("pursuer.mass_kg", *(f"start.{what}.{axis}" for what in ("position_m", "velocity_m_s") for axis in "xyz"))


@pytest.fixture(scope="module")
def flown() -> tuple[Array, Array]:
    """Drawn values of some samples of the campaign, and their final distances in rvjax."""
    problem = load(HERE / "hold.yaml", [f"samples={SAMPLES}"])
    jax_config.configure(problem.spec.precision)
    flyer = Flyer.of(problem)
    draws, drawn = Draws.of(problem, np.arange(flyer.lanes(SAMPLES)) % SAMPLES)
    record = flyer.fly(drawn, problem.spec.horizon.steps, 600, trace=range(SAMPLES))
    frames, _ = trace_tables(record.steps, {}, measured=False, means=record.means)
    ends = [np.linalg.norm(frame[["rho_x_m", "rho_y_m", "rho_z_m"]].to_numpy()[-1]) for frame in frames]
    return np.stack([draws.values[name][:SAMPLES] for name in DRAWS], axis=1), np.array(ends)


@pytest.fixture(scope="module")
def truth(flown: tuple[Array, Array]) -> Array:
    """Final distances of a target and all pursuers in inertial space, by DOP853, with separate constants."""
    mu, axis = 3.986004418e14, 6878137.0
    n = np.sqrt(mu / axis**3)
    draws, _ = flown
    count = len(draws)

    def frame(r: Array, v: Array) -> Array:
        h = np.cross(r, v)
        return np.stack([r / np.linalg.norm(r), np.cross(h, r) / np.linalg.norm(np.cross(h, r)), h / np.linalg.norm(h)])

    def relative(bodies: Array) -> tuple[Array, Array]:
        axes, (target, *pursuers) = frame(bodies[0, :3], bodies[0, 3:]), bodies
        apart = (np.array(pursuers) - target) @ np.kron(np.eye(2), axes.T)
        return apart[:, :3] - [0.0, -100.0, 0.0], apart[:, 3:] - np.cross([0.0, 0.0, n], apart[:, :3])

    def rate(t: float, flat: Array, force: Array) -> Array:
        bodies = flat.reshape(count + 1, 6)
        pull = -mu * bodies[:, :3] / np.linalg.norm(bodies[:, :3], axis=1, keepdims=True) ** 3
        pull[1:] += force / draws[:, :1] @ frame(bodies[0, :3], bodies[0, 3:])
        return np.concatenate([bodies[:, 3:], pull], axis=1).ravel()

    place = draws[:, 1:4] + [axis, -100.0, 0.0]
    speed = draws[:, 4:] + np.cross([0.0, 0.0, n], place)
    bodies = np.concatenate([[[axis, 0.0, 0.0, 0.0, n * axis, 0.0]], np.concatenate([place, speed], axis=1)])
    for _ in range(600):
        position, velocity = relative(bodies)
        force = np.clip(-0.09 * position - 5.0 * velocity, -0.5, 0.5)
        came = solve_ivp(rate, (0.0, 0.5), bodies.ravel(), method="DOP853", rtol=1e-13, atol=1e-9, args=(force,))
        bodies = came.y[:, -1].reshape(count + 1, 6)
    return np.linalg.norm(relative(bodies)[0], axis=1)


def test_rvjax_flies_the_job(flown: tuple[Array, Array], truth: Array) -> None:
    """Kills: another gain, limit, orbit, hold point or frame in the campaign; a law on the inertial velocity."""
    assert truth.min() > 1e-3
    np.testing.assert_allclose(flown[1], truth, atol=2e-7)


def test_numpy_flies_the_job(flown: tuple[Array, Array], truth: Array) -> None:
    """Kills: a wrong term of the motion or constant of the job, which every script of a peer reads."""
    np.testing.assert_allclose(distances(flown[0]), truth, atol=2e-7)


def test_the_tube_is_that_of_the_requirement() -> None:
    """Kills: shares of two different tubes in one table."""
    (requirement,) = load(HERE / "hold.yaml").spec.require
    assert (requirement.metric, requirement.below) == ("final_position_error_m", job.TUBE)


def test_draws_keep_their_digits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a file of six digits; columns in another order; a result that loses its interval."""
    draws = np.random.default_rng(0).normal(size=(2, 7)) / 3.0
    job.save(draws, tmp_path / "draws.csv")
    assert (tmp_path / "draws.csv").read_text().startswith("mass,x,y,z,vx,vy,vz\n")
    monkeypatch.setattr(sys, "argv", ["x", str(tmp_path / "draws.csv"), str(tmp_path / "came.json"), "2"])
    job.main(lambda given, cores: job.Result(given.ravel().tolist(), str(cores), (0.1, 0.2)))
    came = job.Result(**json.loads((tmp_path / "came.json").read_text()))
    assert came.distances == draws.ravel().tolist()
    assert (came.version, list(came.interval or ())) == ("2", [0.1, 0.2])


CODE = '''"""Two
lines."""

# a comment
A = 1  # counts


def f():
    """Not counted."""
    return [
        A,
    ]
'''


def test_lines_are_those_of_code(tmp_path: Path) -> None:
    """Kills: docstrings, comments or blank lines that count; a call over three lines that counts once."""
    (tmp_path / "a.py").write_text(CODE)
    (tmp_path / "a.yaml").write_text("# comment\na: 1\n\n  # more\nb: 2  # kept\n")
    assert [table.lines_of(tmp_path / name) for name in ("a.py", "a.yaml")] == [5, 2]


def test_a_row() -> None:
    """Kills: the mean instead of the median, a share of another tube, an interval where there is none."""
    result = job.Result([0.1, 0.6, 0.2, 0.5], "1.2", (0.25, 0.875), 3.14159, "PASS")
    measured = table.Measured("x", 12, [6.0, 1.0, 2.0], [9.0, 5.0, 1.0], [4.0, 2.0, 2.5], [7.0, 6.0, 8.0], result, 0.5, 1, 4.2e-9)
    cells = "x | 1.2 | 12 | 2.0 (1.0) | 5.0 (1.0) | 2.50 | 7.0 (6.0) | 3.14 | 2 of 4 | 25.0 to 87.5 % | PASS, 1 | 4e-09"
    assert table.row(measured) == f"| {cells} |"
    bare = measured._replace(result=job.Result([0.1], "1"), apart=0.0)
    assert table.row(bare).endswith("| 7.0 (6.0) |  | 1 of 1 | none | none, 1 | 0 |")
    names, rule = table.head().splitlines()
    assert names.count("|") == rule.count("|") == table.row(measured).count("|")


def run_with(monkeypatch: pytest.MonkeyPatch, moved: float, *arguments: str) -> int:
    """The command with flights that are made up: those of NumPy end `moved` farther away."""
    base = __main__.Ran(job.Result([0.1, 0.9], "0", (0.2, 0.3), 0.1, "PASS"), 2.0, 3.0, 0)
    monkeypatch.setattr(__main__, "by_rvjax", lambda *given: (base, np.ones((2, 7))))
    peer = __main__.Ran(job.Result([0.1, 0.9 + moved], "1"), 5.0, 4.0, 0)
    monkeypatch.setattr(__main__, "by_peer", lambda *given: peer)
    monkeypatch.setattr(sys, "argv", ["peers", *arguments])
    return __main__.main()


def test_flights_that_disagree_end_with_1(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Kills: a table without a check; times over those of the peer itself."""
    assert run_with(monkeypatch, 0.5e-9, "numpy") == 0
    assert "| numpy | 1 | " in (said := capsys.readouterr().out)
    assert "| 5.0 (5.0) | 5.0 (5.0) | 2.50 | 4.0 (4.0) |" in said
    assert run_with(monkeypatch, 1e-8, "numpy") == 1


def test_a_peer_that_is_not_there(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """Kills: a traceback, or a row, for a peer without its package or its Python."""
    monkeypatch.setitem(PEERS, "nowhere", Peer("nowhere_at_all", "pip install it", ("with_numpy.py",), 0.0))
    assert run_with(monkeypatch, 0.0, "nowhere", "numpy", "--python", f"numpy={tmp_path}/python") == 0
    said = capsys.readouterr().out
    assert "nowhere was not run: nowhere_at_all is not installed; accepted: pip install it" in said
    assert f"numpy was not run: {tmp_path}/python: No such file or directory" in said
    assert "| numpy |" not in said


@pytest.mark.parametrize(("arguments", "said"), [(("numpi",), "unknown: numpi"), ((), "accepted: names or --all")])
def test_a_wrong_name_ends_with_2(
    arguments: tuple[str, ...], said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Kills: a table of nothing, an exit code of success."""
    assert run_with(monkeypatch, 0.0, *arguments) == 2
    assert said in capsys.readouterr().err


def test_every_peer_has_its_script() -> None:
    """Kills: a script that was renamed; one that is too long to be read; a README that counts other files."""
    for name, peer in PEERS.items():
        assert f"with_{name}.py" in peer.files
        assert all(len((HERE / file).read_text().splitlines()) <= 150 for file in peer.files)
