"""From a campaign file to a problem: components, requirements, and what no file may say."""

from __future__ import annotations

import time
from copy import deepcopy
from pathlib import Path

import pytest

from rvjax.errors import CampaignError
from rvjax.simulation.problem import NEVER, Problem, load
from tests.short import CAMPAIGN
from tests.spec.corpus import bad_files, check_refused
from tests.validated import validated

BAD = bad_files(Path(__file__).parent / "bad")


@pytest.mark.parametrize("path", BAD, ids=[path.stem for path in BAD])
def test_bad_file(path: Path) -> None:
    check_refused(path, validated)


def test_a_step_twice_as_long_is_another_program_where_something_has_a_period(tmp_path: Path) -> None:
    """A discrete-time controller acts every n steps, and n is compiled. Kills: a program that is shared with the campaign of
    another step."""
    path = tmp_path / "campaign.yaml"
    path.write_text((Path(__file__).parent / "bad" / "metric-without-a-radius.yaml").read_text().partition("metrics:")[0])
    same, other = (load(path, [f"horizon.step_s={h}"]).structure for h in (0.05, 0.1))
    assert same == other
    path.write_text(path.read_text().replace("pd-plus", "lqr-kalman"))
    assert load(path, ["horizon.step_s=0.05"]).structure != load(path, ["horizon.step_s=0.1"]).structure


def test_mistakes_of_the_file_and_of_its_components_come_together(tmp_path: Path) -> None:
    """Kills: stopping at the first half of the validation."""
    text = (
        CAMPAIGN.read_text().replace("samples: 512", "samples: 0").replace("remaining:", "remains:").replace("captured", "caught")
    )
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(CampaignError) as caught:
        load(path)
    found = [finding.path for finding in caught.value.findings]
    assert {"samples", "faults.0.remains", "faults.0.remaining", "require.0.metric"} <= set(found)
    assert len(found) == len(set(caught.value.findings))


def test_a_fault_on_some_channels_never_begins_on_the_others() -> None:
    problem = load(CAMPAIGN, ["faults.effectiveness.channels=[fx, tz]"])
    onset = problem.faults[0].quantities["onset_s"]
    assert [part is NEVER for part in onset.parts] == [False, True, True, True, True, False]


def same(a: Problem, b: Problem) -> bool:
    return a.fingerprint == b.fingerprint


@pytest.mark.parametrize(
    ("change", "equal"),
    [
        ("samples=7", True),
        ("require=[]", True),
        ("description=other", True),
        ("controller.gains.k1=0.1", True),  # the default, written out
        ("controller={use: saturated-adaptive, shaped: true}", True),
        ("controller.gains.k1=0.101", False),
        ("controller.nussbaum=none", False),
        ("faults.bias.channels=[fx]", False),
        ("faults.bias.share={uniform: [-0.05, 0.051]}", False),
        ("saturation.use=erf", False),
        ("seed=1", False),
        ("precision=float32", False),
        ("horizon.step_s=0.1", False),
        ("capture.position_m=0.02", False),
    ],
)
def test_the_fingerprint_is_what_decides_the_flights(change: str, equal: bool) -> None:
    """Kills: a setting that changes a number but not the identity of a run, and the other way round."""
    assert same(load(CAMPAIGN), load(CAMPAIGN, [change])) is equal


def test_very_many_wrong_names_take_a_bounded_time() -> None:
    """Each is a finding, the first few with a suggestion. Kills a comparison of every wrong name with every draw."""
    names = ", ".join(f"pursuer.mas_{index}" for index in range(4000))
    start = time.process_time()
    with pytest.raises(CampaignError) as caught:
        load(CAMPAIGN, [f"epistemic=[{names}]"])
    assert len(caught.value.findings) == 4000
    assert 0 < str(caught.value).count("did you mean") <= 20
    assert time.process_time() - start < 5.0
    levels = ", ".join(f"a{index}: 10000" for index in range(2000))
    with pytest.raises(CampaignError, match="fewer levels: more than 1,000,000,000 samples"):
        load(CAMPAIGN, ["require=[]", f"sampler={{use: grid, levels: {{{levels}}}}}"])


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"controller.gains.k1": 0.0612345678901234, "pursuer.mass_kg": 105},
        {"controller.nussbaum": "none", "horizon.step_s": 0.1, "faults.bias.onset_s": 12},
        {"disturbances.0.force_N": 1e-7, "samples": 7},
    ],
)
def test_a_problem_with_other_values_is_the_one_that_set_gives(values: dict[str, float | str]) -> None:
    """Kills: a number that loses a digit on its way, a value that is put somewhere else, a campaign that is changed in place."""
    problem = load(CAMPAIGN)
    before = deepcopy(problem.spec.source.value)
    changed = problem.with_values(values)
    written = load(CAMPAIGN, [f"{place}={value}" for place, value in values.items()])
    assert changed.spec == written.spec
    assert (changed.fingerprint, changed.structure) == (written.fingerprint, written.structure)
    assert changed.dispersions.columns == written.dispersions.columns
    assert changed.controller == written.controller
    assert changed.spec.source == written.spec.source
    assert problem.spec.source.value == before


@pytest.mark.parametrize(
    "values",
    [{"controller.gains.k1": -1.0}, {"pursuer.mass": 3}, {"samples": 0.5}, {"controller.nussbaum": "x", "horizon.step_s": 7.0}],
)
def test_values_are_refused_as_set_refuses_them(values: dict[str, float | str]) -> None:
    """Kills: a range that is not checked for values that come as numbers."""
    with pytest.raises(CampaignError) as expected:
        load(CAMPAIGN, [f"{place}={value}" for place, value in values.items()])
    with pytest.raises(CampaignError) as refused:
        load(CAMPAIGN).with_values(values)
    assert refused.value.findings == expected.value.findings


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1e101])
def test_a_value_that_is_no_usable_number_is_refused(value: float) -> None:
    with pytest.raises(CampaignError, match="not finite or too large"):
        load(CAMPAIGN).with_values({"pursuer.mass_kg": value})


def test_other_values_read_no_file_again(tmp_path: Path) -> None:
    """Kills: a CSV file that is read once per candidate, or is still copied into the run folder when nothing names it."""
    path, table = tmp_path / "campaign.yaml", tmp_path / "masses.csv"
    path.write_text(CAMPAIGN.read_text())
    table.write_text("mass\n99\n100\n101\n")
    problem = load(path, ["pursuer.mass_kg={table: {csv: masses.csv, column: mass}}"])
    table.unlink()
    kept = problem.with_values({"controller.gains.k1": 0.1})
    assert kept.spec.source.inputs == {"masses.csv": b"mass\n99\n100\n101\n"}
    assert kept.spec.pursuer == problem.spec.pursuer
    assert problem.with_values({"pursuer.mass_kg": 100}).spec.source.inputs == {}
