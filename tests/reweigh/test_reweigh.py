"""`rvjax reweigh`: a run of real flights under other laws, against a fresh run of these laws, and what is refused."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import numpy as np
import pytest

from rvjax.execution.reweigh import reweigh
from rvjax.execution.run import run
from rvjax.run_folder import RunFolder
from rvjax.stats import clopper_pearson
from rvjax.stats.random_streams import uniforms
from tests.program import Run
from tests.reweigh.conftest import CAMPAIGN

REMAINING = "faults.effectiveness.remaining={uniform: [0.2, 0.6]}"
TILTED = "faults.effectiveness.remaining={triangular: [0, 0, 1]}"
SPEED = "start.nu_m_s={ball: 0.18}"


def test_a_narrower_uniform_keeps_the_samples_inside(folder: Path) -> None:
    """Kills: thinning by chance of a plain subset, intervals with the number of all samples, the wrong draw."""
    frame = RunFolder.open(folder).samples().frame
    found = reweigh(folder, [REMAINING])
    x = frame["draw.faults.effectiveness.remaining.fx"].to_numpy()
    inside = (x >= 0.2) & (x <= 0.6)
    assert found.kept == np.count_nonzero(inside)
    good = (frame["metric.delta_v_m_s"] < 0.5).to_numpy()
    exact = clopper_pearson(int(np.count_nonzero(good & inside)), found.kept)
    share = found.shares[1].thinned
    assert share is not None
    assert (share.value, share.low, share.high) == (exact.value, exact.low, exact.high)
    of_class = found.shares[2].thinned
    assert of_class is not None
    assert of_class.n == np.count_nonzero(inside & (x < 0.5))


def test_thinning_is_that_of_the_named_stream(folder: Path) -> None:
    """Kills: v from the stream of the draws or from the position in the table, weights of another law. f' = 2 (1 − x), W = 2."""
    frame = RunFolder.open(folder).samples().frame
    x = frame["draw.faults.effectiveness.remaining.fx"].to_numpy()
    v = uniforms(5, "reweigh.thin", frame["sample"].to_numpy())[:, 0]
    assert reweigh(folder, [TILTED]).kept == np.count_nonzero(v < 1.0 - x)


def test_a_fresh_run_agrees(folder: Path, tmp_path: Path) -> None:
    """Kills: a weight of the wrong direction, a joint law without its volume. The command that the message proposes, flown: its
    shares and those of the reweighed run, each at 99.999 %, overlap, exact and nominal; and the laws make a difference."""
    overrides = [TILTED, SPEED]
    found = reweigh(folder, overrides, 0.99999)
    words = shlex.split(found.fresh)
    sets = [words[k + 1] for k, word in enumerate(words) if word == "--set"]
    fresh = run(words[2], tmp_path / "fresh", [*sets, "seed=77"], progress=False)
    frame = RunFolder.open(fresh).samples().frame
    good = int(np.count_nonzero(frame["metric.delta_v_m_s"] < 0.5))
    theirs = clopper_pearson(good, len(frame), 0.99999)
    for ours in (found.shares[1].thinned, found.shares[1].weighted):
        assert ours is not None
        assert max(ours.low, theirs.low) <= min(ours.high, theirs.high)
    assert abs(found.shares[1].flown.value - theirs.value) > 0.02


def test_what_lies_beyond_widens_the_interval(folder: Path) -> None:
    """Kills: laws that reach farther taken as if they did not."""
    inside = reweigh(folder, ["actuators.spread={uniform: [0.9, 1.1]}", REMAINING])
    found = reweigh(folder, ["faults.effectiveness.onset_s={uniform: [2, 8.1]}", REMAINING])
    assert inside.law.beyond == 0.0
    assert found.law.beyond == pytest.approx(0.1 / 6.1)
    a, b = inside.shares[1].thinned, found.shares[1].thinned
    assert a is not None
    assert b is not None
    assert b.high - b.low > (a.high - a.low) * (1 - found.law.beyond) + 0.9 * found.law.beyond


REFUSED = {
    "horizon.step_s=0.05": ("step_s", "horizon: --set {}: horizon differs from the run in more than the law of a draw"),
    "seed=9": ("seed", "seed: --set {}: seed differs from the run in more than the law of a draw"),
    "controller={use: lqr-kalman, period_s: 1}": ("controller", "controller differs from the run in more than the law of a draw"),
    "start.rho_m.0={uniform: [1, 3]}": ("2, 0, 0]", "start.rho_m.x was fixed in the run, so no flight has another value"),
    "navigation.0.position_m=0.002": ("position_m", "is the size of noise in flight, so no flight has another value"),
    "faults.effectiveness.onset_s=5": (
        "onset_s",
        "onset_s.fx would be fixed; accepted: a law with a density",
    ),
    "pursuer.mass_kg={truncated_normal: [100, 4, 70, 130]}": ("mass_kg", "pursuer.mass_kg is correlated with others"),
    "faults.some.onset_s={uniform: [2, 7]}": ("onset_s", "belongs to a fault with a schedule"),
    "faults.effectiveness.remaining={choice: [0.2, 0.4]}": ("remaining", "a law with steps and another one have no ratio"),
    "actuators.spread={table: {csv: spread.csv, column: s}}": ("spread", "Empirical has no density; accepted: two laws with"),
    "start.nu_m_s={direction: 0.1}": ("nu_m_s", "a joint law and another one have no ratio"),
    "faults.effectiveness.onset_s={uniform: [2, 9]}": ("onset_s", "14.3 % of the draws would be where the run has none"),
    "faults.effectiveness.remaining={uniform: [0.1, 0.12]}": ("remaining", "samples are kept, fewer than 59; the weights have"),
    "name=other": ("name", "no law of a draw changes; accepted: another law of a draw"),
}
"""By argument: the text of the campaign where the message points, and what it says."""


@pytest.mark.parametrize("override", REFUSED)
def test_refusals_name_the_place_and_the_fresh_run(folder: Path, rvjax: Run, override: str) -> None:
    """Kills: each check by itself, a refusal without the argument, at another place, without the command for a fresh run, and
    with a command that is refused."""
    (folder / "spread.csv").write_text("s\n0.95\n1.05\n")
    code, _, said = rvjax("reweigh", folder, "--set", override)
    assert code == 2
    at, words = REFUSED[override]
    file, line, column, rest = said.splitlines()[0].split(":", 3)
    assert file == str(folder / "campaign.yaml")
    assert CAMPAIGN.split("\n")[int(line) - 1][int(column) - 1 :].startswith(at)
    assert f"--set {override}: " in rest
    assert words.format(override) in rest
    assert "; accepted: " in rest
    if override != "name=other":
        start = "; or a fresh run: rvjax run "
        assert start in rest
        _, _, *arguments = shlex.split(rest[rest.index(start) :].removeprefix("; or a fresh run: "))
        assert arguments[-1] == override or override in arguments
        code, _, refused = rvjax("validate", *arguments)
        assert (code, "error" in refused) == (0, False), refused


def test_the_command_shows_that_it_explores(folder: Path, rvjax: Run) -> None:
    """Kills: a verdict after the fact, numbers that differ between the table and the document."""
    code, told, _ = rvjax("reweigh", folder, "--set", REMAINING)
    assert code == 0
    assert "exploration: laws that are chosen after the flights give no verdict" in told
    assert "PASS" not in told
    assert "FAIL" not in told
    code, told, _ = rvjax("reweigh", folder, "--set", REMAINING, "--json")
    document = json.loads(told)
    found = reweigh(folder, [REMAINING])
    assert (document["status"], document["kept"]) == ("exploration", found.kept)
    assert document["shares"][1]["thinned"]["low"] == found.shares[1].thinned.low  # pyright: ignore[reportOptionalMemberAccess]


def test_samples_of_a_plan_are_refused(tmp_path: Path, rvjax: Run) -> None:
    """Kills: samples that fill a space taken for independent ones."""
    file = tmp_path / "plan.yaml"
    text = CAMPAIGN[: CAMPAIGN.index("require:")].replace("samples: 1248", "samples: 416")
    file.write_text(text + "sampler: {use: latin-hypercube}\n")
    folder = run(file, tmp_path / "run", progress=False)
    code, _, said = rvjax("reweigh", folder, "--set", REMAINING)
    assert code == 2
    assert "samples of latin-hypercube are not independent; accepted: a run with sampler: {use: monte-carlo}" in said
    code, _, said = rvjax("reweigh", folder, "--slopes")
    assert code == 2
    assert "samples of latin-hypercube are not independent; accepted: sampler: {use: monte-carlo}" in said


def test_a_run_that_stopped_when_it_was_decided(tmp_path: Path, rvjax: Run) -> None:
    """Kills: an exact interval of a number of samples that depends on what they showed."""
    file = tmp_path / "sequential.yaml"
    text = CAMPAIGN[: CAMPAIGN.index("require:")]
    file.write_text(text + "require: [{metric: delta_v_m_s, below: 9, at_least: 0.5, method: sequential}]\n")
    assert rvjax("check", file, "--out", tmp_path / "run", "-q")[0] == 0
    code, _, said = rvjax("reweigh", tmp_path / "run", "--set", REMAINING)
    assert code == 2
    assert f"{tmp_path / 'run' / 'campaign.yaml'}:3:10: samples: the run stopped after " in said
    assert "a fresh run: rvjax run " in said
    code, _, said = rvjax("reweigh", tmp_path / "run", "--slopes")
    assert code == 2
    assert "samples: the run stopped after " in said


def test_without_a_law(folder: Path, rvjax: Run) -> None:
    """Kills: a table of the run as it is."""
    code, _, said = rvjax("reweigh", folder)
    assert code == 2
    assert "no other law; accepted: --set PATH=LAW" in said


def test_what_follows_from_a_law_stays_as_flown(tmp_path: Path) -> None:
    """Kills: a controller that would assume another mass taken for the one that flew; a fresh run without its numbers."""
    file = tmp_path / "free.yaml"
    file.write_text(
        CAMPAIGN.replace(
            "correlate:\n  - {variables: [pursuer.mass_kg, pursuer.inertia_kgm2.principal.z], rank: [[1, 0.5], [0.5, 1]]}\n", ""
        ).replace("samples: 1248", "samples: 416")
    )
    folder = run(file, tmp_path / "run", progress=False)
    found = reweigh(folder, ["pursuer.mass_kg={truncated_normal: [98, 4.5, 70, 130]}"])
    assert any(item.startswith("controller.gains.mass_guess_kg=100") for item in found.pinned)
    assert all(shlex.quote(f"{item}") in found.fresh for item in found.pinned)
