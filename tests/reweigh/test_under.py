"""Requirements under laws that a campaign names before it flies: the samples they count, their risk, and what is refused."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy import stats

from rvjax.analysis.verdicts import Verdict, judge_all, judge_folder
from rvjax.analysis.verdicts.compliance import RequirementEvaluator
from rvjax.analysis.verdicts.share_tally import ShareTally
from rvjax.campaign import Requirement
from rvjax.campaign.distributions import Pick, Poisson, TruncatedNormal, Uniform
from rvjax.campaign.distributions.bounded import Beta, Triangular
from rvjax.campaign.distributions.joint import Ball, Direction, VonMisesFisher
from rvjax.execution.identity import identity
from rvjax.execution.run import run
from rvjax.run_folder import RunFolder
from rvjax.simulation.problem import load
from rvjax.stats import clopper_pearson_lower
from rvjax.stats.densities import ratio
from rvjax.stats.other_laws import Change, OtherLaw
from rvjax.stats.random_streams import uniforms
from rvjax.stats.sampling_design import Independent
from tests.program import Run
from tests.reweigh.conftest import flown

CAMPAIGN = """rvjax: 1
name: under
samples: 1248
seed: 5
horizon: {duration_s: 20, step_s: 0.1}
target: {port_m: [5, 0, 0]}
pursuer: {mass_kg: {truncated_normal: [100, 5, 70, 130]}, inertia_kgm2: {principal: [22, 20, {uniform: [19, 24]}]}}
start: {rho_m: [2, 0, 0], nu_m_s: {ball: 0.2}, sigma: {uniform: [-0.05, 0.05]}}
actuators: {upper: {force: 4, torque: 0.8}, lower: {force: 3, torque: 0.6}}
faults: [{use: effectiveness, channels: [fx], onset_s: {uniform: [2, 8]}, remaining: {uniform: [0, 1]}}]
controller: {use: pd-plus, gains: {k_rho: 0.05, k_nu: 0.5}}
capture: {position_m: 4.6, attitude_mrp: 0.5, window_s: 2}
laws:
  tilted: {faults.effectiveness.remaining: {triangular: [0, 1, 1]}, faults.effectiveness.onset_s: {uniform: [3, 6]}}
  slow: {start.nu_m_s: {ball: 0.18}}
require:
  - {metric: delta_v_m_s, below: 0.5, at_least: 0.5, under: tilted}
  - {metric: delta_v_m_s, below: 0.5, at_least: 0.5, under: tilted, where: {pursuer.mass_kg: {below: 100}}}
  - {metric: delta_v_m_s, below: 0.5, at_least: 0.5, under: tilted, method: sequential}
  - {metric: delta_v_m_s, below: 0.5, at_least: 0.5, under: tilted, method: sprt, expected: 0.75}
  - {metric: delta_v_m_s, below: 0.8, mean: true, range: [0, 9], under: tilted}
  - {metric: delta_v_m_s, below: 0.7, quantile: 0.5, under: slow}
  - {metric: delta_v_m_s, below: 0.5, at_least: 0.5}
"""

X, T = "draw.faults.effectiveness.remaining.fx", "draw.faults.effectiveness.onset_s.fx"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return flown(tmp_path_factory, "under", CAMPAIGN)


@pytest.fixture(scope="module")
def frame(folder: Path) -> pd.DataFrame:
    return RunFolder.open(folder).samples().frame


@pytest.fixture(scope="module")
def verdicts(folder: Path) -> tuple[Verdict, ...]:
    return judge_folder(folder)


@pytest.fixture(scope="module")
def kept(frame: pd.DataFrame) -> NDArray[np.bool_]:
    """By the densities themselves: f'/f = 2 x of the first draw, 6/3 inside [3, 6] of the second, so W = 4."""
    x, t = frame[X].to_numpy(), frame[T].to_numpy()
    w = 2.0 * x * np.where((t >= 3.0) & (t <= 6.0), 2.0, 0.0)
    return uniforms(5, "reweigh.thin", frame["sample"].to_numpy())[:, 0] < w / 4.0


def test_a_verdict_counts_the_kept_samples(frame: pd.DataFrame, verdicts: tuple[Verdict, ...], kept: NDArray[np.bool_]) -> None:
    """Every method counts just the samples that brute force keeps. Kills: a mask that is ignored, that of another stream, W of
    the sample, `where` instead of `under`, a sequential look at all samples."""
    good = frame["metric.delta_v_m_s"].to_numpy() < 0.5
    light = frame["draw.pursuer.mass_kg"].to_numpy() < 100.0
    fixed, of_class, sequential, sprt, mean, slow, all_samples = verdicts
    assert 60 < np.count_nonzero(kept) < 500
    chosen = RequirementEvaluator(fixed.requirement).chosen
    assert np.concatenate([chosen(frame.iloc[:416]), chosen(frame.iloc[416:])]).tolist() == kept.tolist()
    assert (fixed.n, fixed.successes) == (np.count_nonzero(kept), np.count_nonzero(kept & good))
    assert fixed.low_bound == clopper_pearson_lower(fixed.successes, fixed.n, 0.95)
    assert (of_class.n, of_class.successes) == (np.count_nonzero(kept & light), np.count_nonzero(kept & light & good))
    assert mean.estimate.value == pytest.approx(float(frame["metric.delta_v_m_s"].to_numpy()[kept].mean()), rel=1e-12)
    for tested in (sequential, sprt):
        assert tested.evidence is not None
        looks = tested.evidence.samples
        assert looks.tolist() == np.cumsum(kept)[np.arange(415, 1248, 416)].tolist()[: len(looks)]
        assert tested.evidence.failures.tolist() == np.cumsum(kept & ~good)[np.arange(415, 1248, 416)].tolist()[: len(looks)]
    speed = np.linalg.norm([frame[f"draw.start.nu_m_s.{axis}"] for axis in "xyz"], axis=0)
    assert slow.n == np.count_nonzero(speed <= 0.18)
    assert all_samples.n == 1248


def test_the_sentence_says_so_everywhere(folder: Path, verdicts: tuple[Verdict, ...], rvjax: Run, tmp_path: Path) -> None:
    """Terminal, report, JUnit and JSON. Kills: n of all samples, a verdict that hides its law, the kept of the class."""
    start = f"under tilted ({verdicts[0].n} kept of 1,248 samples): delta_v_m_s below 0.5 m/s in {verdicts[0].successes}"
    assert verdicts[0].text.startswith(f"{verdicts[0].verdict}: {start}")
    assert verdicts[1].text.split(": ", 1)[1].startswith(f"under tilted ({verdicts[0].n} kept of 1,248 samples): ")
    assert verdicts[4].text.split(": ", 1)[1].startswith(f"under tilted ({verdicts[0].n} kept of 1,248 samples): mean of")
    assert "under" not in verdicts[6].text
    _, told, _ = rvjax("check", folder, "--junit-xml", tmp_path / "junit.xml", "--json")
    document = json.loads(told)["verdicts"]
    assert document[0]["under"] == {"law": "tilted", "kept": verdicts[0].n, "flown": 1248}
    assert document[0]["requirement"]["under"] == "tilted"
    assert "under" not in document[6]
    assert f'name="kept" value="{verdicts[0].n}"' in (tmp_path / "junit.xml").read_text()
    assert start in (tmp_path / "junit.xml").read_text()
    assert start in (folder / "report.html").read_text()
    assert ", under tilted: " in (folder / "report.html").read_text()


def test_a_resumed_run_is_an_undisturbed_one(folder: Path, verdicts: tuple[Verdict, ...], tmp_path: Path) -> None:
    """A lost chunk is flown again. Kills: v by the position in a table."""
    shutil.copytree(folder, tmp_path / "run")
    next((tmp_path / "run" / "samples").glob("*1*")).unlink()
    again = run(folder.parent / "under.yaml", tmp_path / "run", progress=False)
    assert [verdict.text for verdict in judge_folder(again)] == [verdict.text for verdict in verdicts]


CHANGED = {
    "another law": ("slow: {start.nu_m_s: {ball: 0.18}}", "slow: {start.nu_m_s: {ball: 0.17}}"),
    "a further law": ("  slow:", "  thick: {pursuer.mass_kg: {truncated_normal: [101, 4, 70, 130]}}\n  slow:"),
}


@pytest.mark.parametrize("change", CHANGED)
def test_a_law_that_comes_later_is_another_run(folder: Path, rvjax: Run, tmp_path: Path, change: str) -> None:
    """Kills: a verdict under a law that was chosen after the flights."""
    (tmp_path / "under.yaml").write_text(CAMPAIGN.replace(*CHANGED[change]))
    assert identity(load(tmp_path / "under.yaml")) != identity(load(folder.parent / "under.yaml"))
    code, _, said = rvjax("run", tmp_path / "under.yaml", "--out", folder)
    assert code == 5
    assert "belongs to another run" in said
    assert "laws." in said


def test_a_baseline_is_of_the_kept_samples(folder: Path, rvjax: Run, tmp_path: Path, kept: NDArray[np.bool_]) -> None:
    """Kills: a baseline that counts samples of other laws, and titles that two requirements share."""
    assert rvjax("check", folder, "--write-baseline", tmp_path / "b.json", "-q")[0] == 0
    marks = json.loads((tmp_path / "b.json").read_text())["requirements"]
    under, plain = (marks[next(name for name in marks if name.startswith(number))] for number in ("1.", "6."))
    assert [mark == "1" for mark in under] == [mark == "1" or not inside for mark, inside in zip(plain, kept, strict=True)]
    assert rvjax("check", folder, "--against", tmp_path / "b.json")[0] == 0
    assert any("under tilted" in name for name in marks)


def test_reweigh_shows_a_named_law(folder: Path, verdicts: tuple[Verdict, ...], rvjax: Run) -> None:
    """Kills: two thinnings of one sample, a named law shown as an exploration."""
    code, told, _ = rvjax("reweigh", folder, "--law", "tilted", "--json")
    assert code == 0
    document = json.loads(told)
    assert (document["status"], document["law"], document["kept"]) == ("named before flying", "tilted", verdicts[0].n)
    assert document["shares"][1]["thinned"]["value"] == verdicts[0].estimate.value
    assert document["shares"][1]["flown"]["n"] == 1248
    code, _, said = rvjax("reweigh", folder, "--law", "tiltet")
    assert code == 2
    assert "--law tiltet: no law that the campaign named before it flew; did you mean tilted?" in said
    assert rvjax("reweigh", folder, "--law", "tilted", "--set", "seed=1")[0] == 2


def test_validate_says_how_many_are_kept(folder: Path, rvjax: Run) -> None:
    """1/W of the samples: 1248/4 and 1248 · 0.9³. Kills: the share of the sample, the wrong law."""
    code, told, _ = rvjax("validate", folder.parent / "under.yaml")
    assert code == 0
    assert "under tilted: about 312 of 1,248 samples are kept" in told
    assert "under slow: about 910 of 1,248 samples are kept" in told


def requirement(law: OtherLaw, **said: Any) -> Requirement:
    return Requirement(metric="m", under="other", confidence=0.95, **said).judged_under({"other": law})


TILT = Change(("x",), Uniform(0.0, 1.0), Triangular(0.0, 1.0, 1.0), *ratio(Uniform(0.0, 1.0), Triangular(0.0, 1.0, 1.0)))


def test_the_risk_of_a_false_pass_is_the_stated_one() -> None:
    """x uniform, failing iff x > 0.8; under f' = 2 x the share that complies is 0.64, and 0.645 is required. PASS in at most 5 %
    of 400 repeats, but for chance of 1e-6; among all samples 0.8 comply, so that a mask that is ignored passes always. With 0.5
    required nearly all pass."""
    rng, wrong, right, n = np.random.default_rng(7), 0, 0, 500
    for repeat in range(400):
        x = rng.random(n)
        frame = pd.DataFrame({"sample": np.arange(n), "outcome": "captured", "draw.x": x, "metric.m": x})
        law = OtherLaw((TILT,), repeat)
        needs = [requirement(law, below=0.8, at_least=share) for share in (0.645, 0.5)]
        high, low = judge_all(needs, frame, Independent())
        wrong, right = wrong + (high.verdict == "PASS"), right + (low.verdict == "PASS")
    assert 0 < wrong <= int(stats.binom.ppf(1.0 - 1e-6, 400, 0.05))
    assert right > 380


def test_a_sequential_false_pass_is_as_rare() -> None:
    """Looks after every 100 samples of up to 1,000; Ville's bound holds for the kept ones. Kills: looks at other samples."""
    rng, wrong = np.random.default_rng(8), 0
    for repeat in range(150):
        x = rng.random(1000)
        frame = pd.DataFrame({"sample": np.arange(1000), "outcome": "captured", "draw.x": x, "metric.m": x})
        need = requirement(OtherLaw((TILT,), repeat), below=0.8, at_least=0.645, method="sequential")
        tally = ShareTally(need, Independent())
        tally.add(frame, {}, range(0, 1000, 100))
        wrong += tally.verdict().verdict == "PASS"
    assert wrong <= int(stats.binom.ppf(1.0 - 1e-6, 150, 0.05))


def test_without_its_law_a_requirement_is_not_judged(frame: pd.DataFrame) -> None:
    """Kills: `under` that is silently ignored where nobody has looked the law up."""
    lost = Requirement(metric="delta_v_m_s", below=1.0, at_least=0.5, under="tilted")
    with pytest.raises(Exception, match="under tilted: the law is not known here"):
        RequirementEvaluator(lost).chosen(frame)


LAWS: list[tuple[Any, Any]] = [
    (Uniform(0.0, 2.0), Triangular(0.5, 1.0, 2.0)),
    (TruncatedNormal(0.0, 1.0, -3.0, 3.0), TruncatedNormal(0.1, 0.8, -3.0, 3.0)),
    (Beta(1.0, 1.0, 0.0, 1.0), Beta(2.0, 2.0, 0.0, 1.0)),
    (Pick.of([1.0, 2.0, 3.0]), Pick.of([1.0, 2.0], [1.0, 3.0])),
    (Poisson(3.0), Poisson(2.5)),
    (Ball(1.0), Ball(0.5)),
    (Direction(1.0), VonMisesFisher((0.0, 0.0, 1.0), 2.0, 1.0)),
]


@pytest.mark.parametrize("pair", LAWS, ids=lambda pair: f"{type(pair[0]).__name__}-{type(pair[1]).__name__}")
def test_a_folder_gives_the_laws_back(pair: tuple[Any, Any]) -> None:
    """Through the JSON of a manifest. Kills: rounded numbers, lists for tuples, old and new exchanged."""
    old, new = pair
    draws = ("x.x", "x.y", "x.z") if old.uniforms > 1 or isinstance(old, (Ball, Direction)) else ("x",)
    law = OtherLaw((Change(draws, old, new, *ratio(old, new)),), 3)
    assert OtherLaw.of(json.loads(json.dumps(law.laws())), 3) == law
