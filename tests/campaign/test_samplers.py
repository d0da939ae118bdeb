"""Samplers: what each promises of its samples, and that none moves a number that is not its own.

False alarms: each comparison with a sampling distribution is at 1e-6, on fixed seeds.
"""

from __future__ import annotations

from collections import Counter
from itertools import permutations, product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from rvjax.analysis.verdicts import Tallies, tallies
from rvjax.campaign import Requirement
from rvjax.components import samplers
from rvjax.components.registry import component, members
from rvjax.components.samplers.interface import of_stratum
from rvjax.components.samplers.latin_hypercube import LatinHypercube, permuted
from rvjax.components.samplers.sobol import Sobol
from rvjax.errors import CampaignError, UsageError
from rvjax.execution.identity import PLAN, identity
from rvjax.execution.run import _same_plan
from rvjax.run_folder import RunDescription, RunFolder
from rvjax.simulation.batch import LANES
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem, load
from rvjax.stats.sampling_design import Exploration, Independent, Observed
from tests.short import CAMPAIGN

ALPHA = 1e-6
NONE = "require=[]"
GOLDEN = {
    "pursuer.mass_kg": ["0x1.4263bb5c94bbfp+6", "0x1.83e52c9412924p+6"],
    "start.rho_m.x": ["-0x1.260bca6bb74aep+3", "-0x1.0add4fdbb8890p+3"],
    "start.omega_rad_s.z": ["0x1.630aab51fa7f5p-9", "-0x1.ace57140ec9b7p-9"],
    "actuators.spread.upper.fx": ["0x1.ec669eaae8af4p-1", "0x1.e5fb891dd22bcp-1"],
    "actuators.spread.lower.tz": ["0x1.dcf52a278b54fp-1", "0x1.1672757c7a3f8p+0"],
    "faults.effectiveness.onset_s.fy": ["0x1.b0f19e69f5fc3p+6", "0x1.2bcfcb10080eep+7"],
    "faults.effectiveness.remaining.tx": ["0x1.54b742b67e280p-1", "0x1.171d9a6ace666p-1"],
    "faults.bias.share.fz": ["0x1.7e31a2643878ep-5", "-0x1.32b90e0bfef80p-5"],
}
"""What samples 0 and 417 drew."""

MASS, RHO = "pursuer.mass_kg", "start.rho_m.x"
MORE = ("start.nu_m_s={ball: 0.2}", "disturbances=[{use: constant, force_N: {box: 1}}, {use: gravity-gradient}]")


def problem(sampler: str, samples: int, *overrides: str) -> Problem:
    return load(CAMPAIGN, [NONE, f"samples={samples}", f"sampler={sampler}", *overrides])


def drawn(campaign: Problem, samples: np.ndarray | None = None) -> dict[str, np.ndarray]:
    numbers = np.arange(campaign.spec.samples) if samples is None else samples
    return Draws.of(campaign, numbers)[0].values


# --- Monte Carlo -----------------------------------------------------------------------------------------------------


def test_monte_carlo_is_the_default() -> None:
    """Written out or not: the same numbers and the same fingerprint."""
    plain, said = load(CAMPAIGN), load(CAMPAIGN, ["sampler={use: monte-carlo}"])
    assert plain.fingerprint == said.fingerprint
    before, after = drawn(plain, np.arange(50)), drawn(said, np.arange(50))
    assert all(np.array_equal(values, after[name]) for name, values in before.items())


def test_draws_are_the_very_same_numbers_as_ever() -> None:
    """Samples 0 and 417 of the quickstart campaign as they were drawn before there were samplers, correlations and rejections;
    uniform laws bit for bit. Kills a stream with another name."""
    found = drawn(load(CAMPAIGN), np.array([0, 417]))
    for name, values in GOLDEN.items():
        assert [value.hex() for value in found[name].tolist()] == values, name


# --- Latin hypercube -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 2, 3, 5, 64, 97, 416, 1000, 4097])
def test_one_sample_in_each_stratum(count: int) -> None:
    """Of each component of each variable. Kills: rounding into the next stratum, a permutation that is none, one number twice."""
    points = LatinHypercube(7, count).at(np.arange(count))
    for name in ("a", "b.x", "c"):
        u = points.uniforms(name, 3)
        for column in u.T:
            assert sorted(np.floor(column * count)) == list(range(count))
        if count > 64:
            assert len({tuple(np.argsort(column)) for column in u.T}) == 3


def test_strata_are_of_the_seed_and_the_name() -> None:
    """Kills a permutation that is the same in every campaign: its strata, not only the places inside them."""
    strata = [
        np.floor(LatinHypercube(seed, 400).at(np.arange(400)).uniforms(name, 1) * 400)
        for seed, name in ((1, "a"), (2, "a"), (1, "b"))
    ]
    assert all((one != strata[0]).mean() > 0.9 for one in strata[1:])


def test_strata_of_a_billion_samples_are_found_without_the_others() -> None:
    """Kills a permutation that has to be made: a thousand samples of 10⁹, all in different strata."""
    samples = np.random.default_rng(2).choice(10**9, 1000, replace=False)
    strata = permuted("name", samples.astype(np.uint64), 10**9)
    assert strata.max() < 10**9
    assert len(set(strata.tolist())) == 1000
    u = LatinHypercube(7, 10**9).at(samples).uniforms("name", 1)[:, 0]
    assert stats.kstest(u, "uniform").pvalue > ALPHA


def test_a_number_stays_in_its_stratum_whatever_rounding_does() -> None:
    """At both ends of strata of 10⁹. Kills (k + v)/n without a guard, which rounds up into the next stratum."""
    stratum = np.repeat([0.0, 1.0, 333_333_333.0, 999_999_999.0], 2)
    inside = np.tile([2.0**-54, 1.0 - 2.0**-53], 4)
    u = of_stratum(stratum, inside, 1e9)
    assert (u > 0.0).all()
    assert (u < 1.0).all()
    np.testing.assert_array_equal(np.floor(u * 1e9), stratum)


def test_permutations_are_all_alike() -> None:
    """χ² of the 24 orders of 4 over 1,440 names, and of where the first of 97 goes over 1,940 names. Kills a weak network."""
    orders = Counter(tuple(permuted(f"n{index}", np.arange(4, dtype=np.uint64), 4).tolist()) for index in range(1440))
    assert set(orders) == set(permutations(range(4)))
    assert stats.chisquare(list(orders.values())).pvalue > ALPHA
    places = np.array([permuted(f"n{index}", np.zeros(1, dtype=np.uint64), 97)[0] for index in range(1940)])
    assert stats.chisquare(np.bincount(places.astype(int), minlength=97)).pvalue > ALPHA


def test_variables_of_a_hypercube_are_not_related() -> None:
    """Rank correlation of 4,000 strata of neighbours in a key, and of a permutation with the order of the samples."""
    numbers = np.arange(4000, dtype=np.uint64)
    columns = [numbers.astype(float), *(permuted(f"1:x:{index}", numbers, 4000).astype(float) for index in range(3))]
    r = np.corrcoef(columns)[np.triu_indices(4, 1)]
    assert np.abs(r).max() < stats.norm.isf(ALPHA / 2) / np.sqrt(4000)


# --- Sobol -----------------------------------------------------------------------------------------------------------


def test_points_are_a_net() -> None:
    """Of the first 2¹⁰ samples, one is in each of 2¹⁰ intervals of every variable, and in each elementary interval of the first
    two dimensions, whatever its sides. Kills: points that are scattered (jitter in the place of digits), a block off by one."""
    campaign = problem("{use: sobol}", 1024)
    plan, points = campaign.dispersions.sampler, campaign.dispersions.at(np.arange(1024))[0]
    assert isinstance(plan, Sobol)
    first = [next(name for name, place in plan.first.items() if place == dimension) for dimension in (0, 1)]
    assert first == sorted(plan.first)[:2]
    for name in plan.first:
        for column in points.uniforms(name, campaign.dispersions.variables[name].law.uniforms).T:
            assert sorted(np.floor(column * 1024)) == list(range(1024)), name
    x, y = (points.uniforms(name, 1)[:, 0] for name in first)
    for power in range(11):
        cells = np.floor(x * 2**power) * 2 ** (10 - power) + np.floor(y * 2 ** (10 - power))
        assert sorted(cells) == list(range(1024)), power
    far = campaign.dispersions.at(np.arange(5 * 1024, 6 * 1024))[0]  # any later block of 2¹⁰ is a net too
    assert sorted(np.floor(far.uniforms(first[1], 1)[:, 0] * 1024)) == list(range(1024))


def test_scrambling_is_of_the_seed() -> None:
    """The digits of the sequence, not only the places between them."""
    one, other = (drawn(problem("{use: sobol}", 16, f"seed={seed}"))[MASS] for seed in (1, 2))
    assert np.abs(one - other).min() > 1e-4
    more = drawn(problem("{use: sobol}", 16, "seed=1", *MORE))[MASS]
    assert not np.array_equal(one, more)  # documented: another variable is another plan


# --- grid and plan ---------------------------------------------------------------------------------------------------


def test_a_grid_is_every_combination() -> None:
    """Once each, the last name from sample to sample; the other draws are those of Monte Carlo. Kills: levels at the ends (i/n),
    values of one draw under another's name."""
    campaign = problem(f"{{use: grid, levels: {{{RHO}: [-10, 20, 3], {MASS}: 4}}}}", 12)
    values, plain = drawn(campaign), drawn(problem("{use: monte-carlo}", 12))
    masses = [85.0, 95.0, 105.0, 115.0]
    assert list(zip(values[MASS].tolist(), values[RHO].tolist(), strict=True)) == [
        (pytest.approx(mass), rho) for mass, rho in product(masses, [-10.0, 20.0, 3.0])
    ]
    for name in values.keys() - {MASS, RHO}:
        np.testing.assert_array_equal(values[name], plain[name])


def plan(folder: Path, text: str) -> Path:
    """The quickstart campaign beside a plan."""
    (folder / "plan.csv").write_text(text)
    path = folder / "campaign.yaml"
    path.write_text(CAMPAIGN.read_text())
    return path


def test_a_plan_is_flown_row_by_row(tmp_path: Path) -> None:
    """Bit for bit, in SI, with and without `draw.`; a vector of a joint law whole; the other draws are those of Monte Carlo."""
    table = pd.DataFrame(
        {
            f"draw.{MASS}": [80.0, 95.1, 120.0],
            "start.rho_m.z": [0.1 + 0.2, 3.0, 4.0],
            "start.rho_m.x": [3.0, 0.0, 0.0],
            "start.rho_m.y": [0.0, 4.0, -3.0],
        }
    )
    path = plan(tmp_path, table.to_csv(index=False))
    ball = ("start.rho_m={ball: 5}", "samples=3", NONE)
    values = drawn(load(path, [*ball, "sampler={use: plan, csv: plan.csv}"]))
    for name in table:
        assert values[name.removeprefix("draw.")].tolist() == table[name].tolist()
    again = drawn(load(path, [*ball, "sampler={use: plan, csv: plan.csv}"]), np.array([2, 0]))
    assert again[MASS].tolist() == [120.0, 80.0]
    plain = drawn(load(path, ball), np.arange(3))
    for name in values.keys() - {name.removeprefix("draw.") for name in table}:
        np.testing.assert_array_equal(values[name], plain[name])


def test_the_draws_of_a_run_are_a_plan(tmp_path: Path) -> None:
    """Every column of a samples table, given back as a plan, draws the same samples."""
    before = drawn(load(CAMPAIGN, ["samples=7", NONE]), np.arange(7))
    path = plan(tmp_path, pd.DataFrame({f"draw.{name}": values for name, values in before.items()}).to_csv(index=False))
    after = drawn(load(path, ["samples=7", NONE, "sampler={use: plan, csv: plan.csv}"]))
    for name, values in before.items():
        np.testing.assert_array_equal(after[name], values, err_msg=name)


def test_points_draw_what_their_numbers_decide_again(tmp_path: Path) -> None:
    """Bit for bit, correlated draws and a body that is drawn again among them, which no plan of values could say. Kills: numbers
    in another order, a variable that keeps its own stream, one that is not given and loses it."""
    names = ("start.sigma.x", "pursuer.inertia_kgm2.principal.z", "start.rho_m")
    pair = f"correlate=[{{variables: [{MASS}, start.sigma.x], rank: [[1, 0.6], [0.6, 1]]}}]"
    flat = "pursuer.inertia_kgm2={principal: [10, 10, {uniform: [15, 25]}], reject: true}"
    others = (pair, flat, "start.rho_m={ball: 5}", NONE)
    before = load(CAMPAIGN, [*others, "samples=64"])
    values, points = drawn(before), before.dispersions.sampler.at(np.arange(64))
    kept = np.flatnonzero(values["pursuer.inertia_kgm2.rejected"] == 0)
    table = {names[0]: points.uniforms(names[0], 1)[kept, 0], names[1]: points.uniforms(names[1], 1)[kept, 0]}
    table |= {f"{names[2]}.{k}": points.uniforms(names[2], 3)[kept, k] for k in range(3)}
    table[MASS] = points.uniforms(MASS, 1)[kept, 0]
    path = plan(tmp_path, pd.DataFrame(table).to_csv(index=False))
    after = drawn(load(path, [*others, f"samples={len(kept)}", "sampler={use: points, csv: plan.csv}"]))
    given = [MASS, *names[:2], *(f"start.rho_m.{axis}" for axis in "xyz")]
    for name in given:
        np.testing.assert_array_equal(after[name], values[name][kept], err_msg=name)
    assert not after["pursuer.inertia_kgm2.rejected"].any()
    np.testing.assert_array_equal(
        after["start.sigma.y"], drawn(load(CAMPAIGN, [*others, f"samples={len(kept)}"]))["start.sigma.y"]
    )


@pytest.mark.parametrize(
    ("text", "samples", "words"),
    [
        (f"{MASS}\n0.5\n", 2, "2 samples; accepted: 1, a sample for each row of the table"),
        ("pursuer.mass\n0.5\n", 1, "pursuer.mass is not a column of any variable; did you mean pursuer.mass_kg?"),
        ("start.rho_m.0,start.rho_m.2\n0.5,0.5\n", 1, "start.rho_m.1 is missing"),
        (f"{MASS}\n0.5\n1.0\n", 2, "line 3, pursuer.mass_kg: 1; accepted: a number above 0 and below 1"),
    ],
)
def test_points_that_are_none(tmp_path: Path, text: str, samples: int, words: str) -> None:
    """Kills: a column that nothing reads, a law with half of its numbers, an end that no law reaches."""
    path = plan(tmp_path, text)
    with pytest.raises(CampaignError) as caught:
        load(path, [f"samples={samples}", "start.rho_m={ball: 5}", NONE, "sampler={use: points, csv: plan.csv}"])
    assert words in str(caught.value)


# --- all of them -----------------------------------------------------------------------------------------------------

WITHOUT_KEYS = [
    name
    for name in members("samplers")
    if not any(info.is_required() for info in component("samplers", name).parameters.keys().values())
]
ALL = {name: f"{{use: {name}}}" for name in WITHOUT_KEYS} | {"grid": f"{{use: grid, levels: {{{RHO}: 8, start.rho_m.y: 625}}}}"}
"""Every sampler that needs no further keys, and the grid. (The tables are tested by themselves above.)"""


@pytest.mark.parametrize("name", ALL)
def test_a_draw_depends_on_seed_name_and_sample_only(name: str) -> None:
    """Any samples in any order, with another variable beside them (but for Sobol), another order in the file; also the lanes
    behind the last sample, which are flown and dropped. Kills: numbers that depend on the chunk, a plan that ends too early."""
    campaign = problem(ALL[name], 5000)
    whole = drawn(campaign)
    some = np.array([4999, 3, 700, 3])
    for key, values in drawn(campaign, some).items():
        np.testing.assert_array_equal(values, whole[key][some], err_msg=key)
    beyond = drawn(campaign, np.arange(5000 - 10, 5000 - 10 + LANES))
    assert all(np.isfinite(values).all() for values in beyond.values())
    np.testing.assert_array_equal(beyond[MASS][:10], whole[MASS][-10:])
    if name != "sobol":
        more = drawn(problem(ALL[name], 5000, *MORE), some)
        for key in whole.keys() - {"start.nu_m_s.x", "start.nu_m_s.y", "start.nu_m_s.z"}:
            if not key.startswith("disturbances."):
                np.testing.assert_array_equal(more[key], whole[key][some], err_msg=key)
    other = drawn(problem(ALL[name], 5000, "seed=3"), some)
    assert not np.array_equal(other[MASS], whole[MASS][some])


@pytest.mark.parametrize("name", ALL)
def test_correlated_draws_with_every_sampler(name: str) -> None:
    """The rank correlation of 5,000 draws, and the law of each: at most what independent draws may be off."""
    pair = f"correlate=[{{variables: [{MASS}, start.sigma.x], rank: [[1, 0.6], [0.6, 1]]}}]"
    values = drawn(problem(ALL[name], 5000, pair))
    found = stats.spearmanr(values[MASS], values["start.sigma.x"]).statistic
    assert abs(np.arctanh(found) - np.arctanh(0.6)) < stats.norm.isf(ALPHA / 2) * np.sqrt(1.18 / 4997)
    assert stats.kstest(values[MASS], stats.uniform(80, 40).cdf).pvalue > ALPHA


@pytest.mark.parametrize("name", ["latin-hypercube", "sobol"])
def test_draws_again_with_every_sampler(name: str) -> None:
    """Impossible bodies are drawn again from streams; where none was rejected, the plan's number stays."""
    flat = "pursuer.inertia_kgm2={principal: [10, 10, {uniform: [15, 25]}], reject: true}"
    campaign = problem(ALL[name], 4096, flat)
    values = drawn(campaign)
    first = campaign.dispersions.sampler.at(np.arange(4096)).uniforms("pursuer.inertia_kgm2.principal.z", 1)[:, 0]
    kept = values["pursuer.inertia_kgm2.rejected"] == 0
    assert kept.sum() == 2048
    np.testing.assert_array_equal(kept, first <= 0.5)
    assert values["pursuer.inertia_kgm2.principal.z"].max() <= 20.0


# --- what may be said ------------------------------------------------------------------------------------------------


def test_only_independent_samples_have_bounds() -> None:
    """By type: an exploration has nothing that a verdict is made of. Kills a plan that is judged like independent draws."""
    designs = {name: component("samplers", name).design for name in members("samplers")}
    assert [name for name, design in designs.items() if isinstance(design, Independent)] == ["monte-carlo"]
    assert all(isinstance(design, Exploration) for name, design in designs.items() if name != "monte-carlo")
    assert not hasattr(Exploration, "bounds")
    requirement = Requirement(metric="captured", at_least=0.9)
    forced = Tallies([requirement], Exploration())
    forced.add(pd.DataFrame({"sample": [0], "outcome": ["captured"]}), {})
    with pytest.raises(AttributeError, match="bounds"):
        forced.verdicts()
    with pytest.raises(UsageError, match="exploration: no verdicts"):
        tallies(Exploration(), [requirement])
    assert tallies(Exploration(), []).verdicts() == ()
    assert Exploration().quantile([1.0, 2.0, 3.0], 0.5, 0.95) == Observed(2.0, 3)
    assert Exploration().band(10, 0.95) is None
    assert samplers.sampling_design_of(problem("{use: sobol}", 8).spec) == Exploration()


def test_a_plan_is_of_a_number_of_samples(tmp_path: Path) -> None:
    """It is part of the identity, and going on with another number is refused in words; Monte Carlo and Sobol go on."""
    one, other = (identity(problem("{use: latin-hypercube}", samples)) for samples in (40, 80))
    assert one[PLAN] == {"use": "latin-hypercube", "samples": 40}
    assert one != other
    for name in ("monte-carlo", "sobol"):
        assert identity(problem(ALL[name], 40)) == identity(problem(ALL[name], 80))
    folder = tmp_path / "run"
    description = RunDescription(identity=one, provenance={}, campaign_text="rvjax: 1\n", samples=40, name="plan")
    RunFolder.create(folder, description).close()
    with pytest.raises(UsageError, match="40 samples of latin-hypercube, now 80: a plan cannot be extended"):
        _same_plan(RunFolder.open(folder), other)
    _same_plan(RunFolder.open(folder), one)
