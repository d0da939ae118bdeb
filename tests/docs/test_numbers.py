"""Numbers in the documents: each stands once in the code, and the documents repeat it."""

from __future__ import annotations

import inspect
import math
import re
import shlex
from pathlib import Path

import pytest

from benchmarks import fair
from rvjax.analysis import baseline, run_totals
from rvjax.campaign import Spec, load, named_files, thruster_layout
from rvjax.campaign.trace_retention import TRACE_ROWS, Keep
from rvjax.components.controllers.saturated_adaptive import Gains
from rvjax.components.metrics import saturation
from rvjax.components.registry import FAMILIES, members
from rvjax.errors import CampaignError, FolderError, IncompleteError
from rvjax.execution import chunks
from rvjax.execution.executors import dask_client
from rvjax.physics import delay_line
from rvjax.report.sections.adaptation import RUNAWAY
from rvjax.search.worst_case import find_worst_case
from rvjax.simulation.batch import LANES
from rvjax.simulation.rejection_sampling import LEAST_ACCEPTED
from rvjax.stats import quantile_sketch
from tests.mutants.table import MUTANTS
from tests.program import Run

ROOT = Path(__file__).parents[2]
WORDS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven")


def campaign(name: str) -> Spec:
    return load(ROOT / "campaigns" / f"{name}.yaml")


def words(document: str) -> str:
    """The text of a document in one line."""
    return " ".join((ROOT / document).read_text(encoding="utf-8").split())


BAKEOFF = campaign("bakeoff")
KINDS = {BAKEOFF.controller.use, *(choice.use for choice in BAKEOFF.baselines)}
ABLATIONS = [choice for choice in BAKEOFF.baselines if choice.use == BAKEOFF.controller.use]
MOST_KEPT = next(bound.le for bound in Keep.model_fields["worst"].metadata if hasattr(bound, "le"))
PERCENTILES = [f"{100 * percentile:g}" for percentile in run_totals.PERCENTILES]

CLAIMS = [
    ("README.md", f"{WORDS[len(members('controllers')) - 1].capitalize()} other controllers"),
    ("docs/shipped.md", f"{campaign('quickstart').samples} flights"),
    ("docs/shipped.md", f"{campaign('docking-faulted').samples:,} flights each"),
    ("docs/shipped.md", f"{campaign('docking-nominal').samples:,} flights each"),
    (
        "docs/shipped.md",
        f"{WORDS[len(KINDS)]} controllers and {WORDS[len(ABLATIONS)]} ablations on the same {BAKEOFF.samples:,} draws",
    ),
    ("docs/shipped.md", f"{WORDS[len(list((ROOT / 'campaigns' / 'ci').glob('*.yaml')))]} campaigns that watch"),
    ("CHANGELOG.md", f"chunks of {LANES} lanes"),
    ("CHANGELOG.md", f"above {2 * quantile_sketch.EXACT:,} samples"),
    ("CHANGELOG.md", f"|χ| ≥ {RUNAWAY:g}"),
    ("docs/architecture.md", f"A chunk of {LANES} samples"),
    ("docs/campaigns.md", f"| `worst: {Keep().worst}` | this many of the worst samples, up to {MOST_KEPT:,}:"),
    ("docs/campaigns.md", f"the samples at {', '.join(PERCENTILES[:-1])} and {PERCENTILES[-1]} % of the settling time"),
    ("docs/campaigns.md", f"among the first {run_totals.HEAD * LANES:,} |"),
    ("docs/campaigns.md", f"first {chunks.ENVELOPE_CHUNKS * LANES:,} samples ({WORDS[chunks.ENVELOPE_CHUNKS]} chunks)"),
    ("docs/campaigns.md", f"at {chunks.ENVELOPE_INSTANTS + 1} instants"),
    ("docs/campaigns.md", f"all files together may have {named_files.MOST_BYTES // 2**20} MiB"),
    ("docs/campaigns.md", f"{thruster_layout.FEWEST} to {thruster_layout.MOST} thrusters"),
    ("docs/campaigns.md", f"fewer than 1 in {1 / LEAST_ACCEPTED:g} draws is physical"),
    ("docs/ci.md", f"the first {baseline.MOST:,} samples"),
    ("docs/ci.md", f"{WORDS[len(baseline.METRICS)]} metrics"),
    ("docs/ci.md", f"on the {campaign('ci/docking').samples} common draws"),
    ("docs/architecture.md", f"a trace of at most {TRACE_ROWS + 1} rows"),
    ("docs/campaigns.md", f"at most {TRACE_ROWS + 1} rows: a flight of more than {TRACE_ROWS} steps is thinned"),
    ("docs/campaigns.md", f"the kept flights, at most {TRACE_ROWS + 1} instants of each"),
    ("docs/glossary.md", f"A kept trace has at most {TRACE_ROWS + 1} instants"),
    ("rvjax/cli/starter.yaml", f"flights to keep, up to {TRACE_ROWS + 1} instants of each"),
    ("rvjax/campaign/trace_retention.py", f"traces of at most {TRACE_ROWS + 1} rows"),
    ("docs/cluster.md", f"A chunk of {LANES} samples"),
    ("docs/cluster.md", f"raises an error {WORDS[dask_client.RETRIES + 1]} times"),
    ("docs/controllers.md", f"flies {1 + fair.WIDE + fair.NEAR} candidates on {LANES} samples"),
    ("docs/controllers.md", f"`rvjax run campaigns/bakeoff.yaml` (4 minutes on two cores): {BAKEOFF.samples:,} draws"),
    ("docs/glossary.md", f"The {LANES} consecutive samples"),
    ("docs/glossary.md", f"at {100 * saturation.THRESHOLD:g} % of its limit or more"),
    ("docs/glossary.md", f"|χ| reaches {RUNAWAY:g} or more"),
    ("docs/model.md", f"clipped to {Gains.model_fields['clip_share'].default:g} of the nominal limits"),
    ("docs/model.md", f"n ≤ {delay_line.MOST_STEPS} |"),
    ("docs/model.md", f"none of the {campaign('navigation').samples} samples of `campaigns/navigation.yaml`"),
    ("docs/performance.md", f"a chunk of {LANES} samples costs"),
    ("docs/reliability.md", f"A chunk is {LANES} samples"),
    ("docs/reliability.md", f"{quantile_sketch.EXACT:,} exact values at either end"),
    ("docs/reliability.md", f"the first {run_totals.HEAD} chunks in full"),
    (
        "docs/tuning.md",
        f"`--flights N` | up to N flights; default {inspect.signature(find_worst_case).parameters['flights'].default:,} |",
    ),
    ("docs/verdicts.md", f"after every chunk of {LANES} samples"),
    ("docs/verification.md", f"{len(MUTANTS)} mutants:"),
    (
        "docs/verification.md",
        f"{campaign('nussbaum-runaway').samples:,} samples, {campaign('nussbaum-runaway').horizon.duration_s:g} s",
    ),
    ("docs/verification.md", f"of {campaign('envelope').samples:,} captured"),
    ("docs/verification.md", f"the default step of {campaign('docking-faulted').horizon.step_s:g} s"),
    ("docs/verification.md", f"flies a chunk of {LANES} lanes"),
    *((f"docs/{name}.md", f"chunk of {LANES} samples") for name in ("comparing", "verdicts")),
]


@pytest.mark.parametrize(("document", "claim"), CLAIMS)
def test_a_number_in_a_document_is_that_of_the_code(document: str, claim: str) -> None:
    assert claim in words(document)


def test_every_tuning_has_the_budget_of_the_page() -> None:
    budgets = {
        load(path).tune.budget.candidates for path in (ROOT / "campaigns" / "tuning").glob("*.yaml") if path.stem != "bakeoff"
    }
    assert budgets == {200}
    assert "with 200 candidates each" in words("docs/tuning.md")


@pytest.mark.parametrize(
    ("name", "family", "without"),
    [
        ("faults", "faults", {"reversed"}),
        ("navigation", "navigation", {"update-rate", "dropouts", "outage", "target-knowledge", "target-noise"}),
        ("disturbances", "disturbances", {"constant", "sinusoid"}),
    ],
)
def test_the_example_campaigns_contain_what_the_readme_says(name: str, family: str, without: set[str]) -> None:
    """Kills: "all disturbances" for a campaign that leaves some out."""
    used = {choice.use for choice in getattr(campaign(name), family)}
    assert set(members(family)) - used == without
    assert all(f"`{left_out}`" in words("docs/shipped.md") for left_out in without)


def test_exit_codes() -> None:
    table = dict(re.findall(r"^\| (\d) \| (.*) \|$", (ROOT / "docs" / "tour.md").read_text(encoding="utf-8"), re.MULTILINE))
    assert "campaign is wrong" in table[str(CampaignError.exit_code)]
    assert table[str(IncompleteError.exit_code)] == "incomplete"
    assert "run folder" in table[str(FolderError.exit_code)]


def test_the_output_of_plan(rvjax: Run) -> None:
    """docs/comparing.md shows what the command prints."""
    page = (ROOT / "docs" / "comparing.md").read_text(encoding="utf-8")
    shown = re.search(r"`rvjax (plan [^`]+)`:\n\n```text\n(.*?)```", page, re.DOTALL)
    assert shown is not None
    code, printed, _ = rvjax(*shlex.split(shown[1]))
    assert code == 0
    assert printed.split() == shown[2].split()


@pytest.mark.parametrize(
    ("samples", "share", "risk"), [(299, 0.99, 0.05), (59, 0.95, 0.05), (852, 0.9973, 0.1), (1705, 0.99865, 0.1)]
)
def test_samples_without_a_failure(samples: int, share: float, risk: float) -> None:
    """The smallest n with shareⁿ ≤ risk, as docs/verdicts.md has it."""
    assert samples == math.ceil(math.log(risk) / math.log(share))
    assert re.search(rf"\b{samples:,}\b", words("docs/verdicts.md"))


@pytest.mark.parametrize("family", FAMILIES)
def test_every_member_is_documented(family: str) -> None:
    """A page of docs/ has the name of every member. Members of the family of metrics are groups of columns, without a name."""
    texts = "".join(words(f"docs/{page}.md") for page in ("campaigns", "controllers", "model", "tuning"))
    assert family == "metrics" or [name for name in members(family) if not re.search(rf"[`\s]{name}[`,\s:}}]", texts)] == []
