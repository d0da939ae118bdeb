"""Margins of a campaign: names, units, identity, requirements, and that without them nothing is another one than before."""

from __future__ import annotations

import inspect
import json
import re
import textwrap
import time
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from ruamel.yaml import YAML

from rvjax.analysis import verdicts
from rvjax.campaign import Requirement
from rvjax.campaign.formula import MOST
from rvjax.columns import metric_and_channel
from rvjax.components.manual import campaign_schema
from rvjax.components.manual_lookup import pages_called
from rvjax.components.registry import standard_metrics
from rvjax.errors import CampaignError
from rvjax.report.number_format import label
from rvjax.simulation import temporal_margins
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem, load
from rvjax.stats.sampling_design import Independent
from tests.short import CAMPAIGN

ROOT = Path(__file__).parents[2]
SLOW = {"always": {"signal": "speed_m_s", "below": 1}}


def with_margins(said: Any, *more: str) -> Problem:
    return load(CAMPAIGN, [f"margins={json.dumps(said)}", *more])


def examples() -> list[Any]:
    """The margins in the manual page and in the documentation."""
    page = textwrap.dedent(re.findall(r"\n( +margins:\n(?: {5,}.*\n)+)", inspect.getdoc(temporal_margins) or "")[0])
    document = re.findall(r"```yaml\n(margins:.*?)```", (ROOT / "docs/campaigns.md").read_text(), re.DOTALL)[0]
    return [YAML(typ="safe").load(text) for text in (page, document)]


@pytest.mark.parametrize("said", examples(), ids=["manual", "document"])
def test_the_documented_margins_are_margins(said: Any) -> None:
    """Kills: an example that is refused."""
    require = json.dumps(said.get("require", []))
    problem = with_margins(said["margins"], f"require={require}")
    assert {name for name in problem.metric_columns if name.startswith("margin.")} == {f"margin.{one}" for one in said["margins"]}


def test_without_margins_nothing_is_another_one_than_before() -> None:
    """What is compiled, and the numbers that it gets. Kills: a fold or a number that is there although nothing asks for it."""
    problem = load(CAMPAIGN)
    assert problem.metrics == standard_metrics()
    assert problem.margins == Draws.of(problem, np.arange(2))[1].context.margins == ()
    assert with_margins({}).metrics == problem.metrics


def test_every_mistake_is_found_at_once(tmp_path: Path) -> None:
    """Beside mistakes elsewhere in the file, each once. Kills: names that are looked at only where nothing else is wrong."""
    text = CAMPAIGN.read_text().replace("samples: 512", "samples: 0") + (
        "margins:\n"
        "  a: {always: {signal: sped_m_s, below: 1, from_s: 400}}\n"
        "  b: {all: [{always: {signal: speed_m_s, below: 1}}, {eventually: {signal: rho_x_m}}]}\n"
        "  c: {always: {not: {signal: ctl.nothing, below: 1}}}\n"
        "  d: {any: [{always: {signal: speed_m_s, below: 1}}, {always: {signal: t_s, below: 9}}]}\n"
    )
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(CampaignError) as caught:
        load(path)
    found = [finding.path for finding in caught.value.findings]
    assert found == [
        "samples",
        "margins.a.always.signal",
        "margins.a.always.from_s",
        "margins.b.all.1.eventually",
        "margins.c.always.not.signal",
        "margins.d.any",
    ]


def test_a_margin_has_no_channels_whatever_it_is_called() -> None:
    """Kills: a margin called any, or as a channel, that is taken for a channel of another metric, or the other way round."""
    assert metric_and_channel("saturation_duty.any") == ("saturation_duty", "any")
    assert metric_and_channel("delta_v_m_s") == ("delta_v_m_s", "")
    assert metric_and_channel("margin.any") == ("margin.any", "")
    assert not any(name.startswith("margin") for name in load(CAMPAIGN).metric_columns)
    assert [label(name) for name in ("margin.any", "saturation_duty.any")] == ["margin any", "saturation duty, worst channel"]
    required = [{"metric": f"margin.{name}", "above": 0, "at_least": 0.9} for name in ("any", "fx")]
    problem = with_margins({"any": SLOW, "fx": SLOW}, f"require={json.dumps(required)}")
    assert [one.metric for one in problem.spec.require] == ["margin.any", "margin.fx"]


def test_a_margin_is_judged_by_its_own_column() -> None:
    """A flight that ended not finite is a failure. Kills: the first margin for any, NaN as a success, 0 as one."""
    values = {"a": [1.0] * 8, "any": [1.0, 2.0, np.inf, 0.0, -1.0, np.nan, 3.0, -np.inf]}
    frame = pd.DataFrame(
        {f"metric.margin.{name}": own for name, own in values.items()} | {"outcome": "captured", "sample": range(8)}
    )
    frame.loc[5, "outcome"] = "not_finite"
    verdict = verdicts.judge(Requirement(metric="margin.any", above=0, at_least=0.5), frame, Independent())
    assert (verdict.successes, verdict.n) == (4, 8)
    with pytest.raises(Exception, match=r"accepted: captured, margin\.a, margin\.any"):
        verdicts.judge(Requirement(metric="margin", above=0, at_least=0.5), frame, Independent())


@pytest.mark.parametrize(
    ("said", "equal"),
    [
        ({"b": {"always": {"signal": "speed_m_s", "below": 1.0, "from_s": 0}}, "a": {"not": SLOW}}, True),
        ({"a": {"not": SLOW}, "c": SLOW}, False),
        ({"a": {"not": SLOW}}, False),
        ({"a": SLOW, "b": SLOW}, False),
        ({"a": {"not": SLOW}, "b": {"eventually": {"signal": "speed_m_s", "below": 1}}}, False),
        ({"a": {"not": SLOW}, "b": {"always": {"signal": "speed_m_s", "below": 2}}}, False),
        ({"a": {"not": SLOW}, "b": {"always": {"signal": "speed_m_s", "above": 1}}}, False),
        ({"a": {"not": SLOW}, "b": {"always": {"signal": "speed_m_s", "below": 1, "scale": 1}}}, False),
        ({"a": {"not": SLOW}, "b": {"always": {"signal": "speed_m_s", "below": 1, "to_s": 300}}}, False),
    ],
)
def test_the_identity_is_what_the_formulas_say(said: Any, equal: bool) -> None:
    """In whatever order, defaults written or not. Kills: a number, an operator or a name that the identity does not know."""
    assert (with_margins(said).fingerprint == with_margins({"a": {"not": SLOW}, "b": SLOW}).fingerprint) is equal


def test_the_meaning_of_a_margin_is_the_formula_in_words() -> None:
    said = {"a": {"all": [{"not": SLOW}, {"until": {"hold": SLOW["always"], "reach": SLOW["always"], "from_s": 2, "to_s": 9}}]}}
    column = with_margins(said).metric_columns["margin.a"]
    assert (column.unit, column.better) == ("m/s", "higher")
    assert column.description == (
        "margin, above 0: satisfied; all of (not (always (speed_m_s below 1 m/s)); "
        "hold (speed_m_s below 1 m/s) until from 2 s to 9 s (speed_m_s below 1 m/s))"
    )


def test_editors_and_the_manual_know_margins() -> None:
    """Every reference in the schema leads somewhere. Kills: a section that is missing in either."""
    schema = campaign_schema()
    assert schema["properties"]["margins"]["additionalProperties"] == {"$ref": "#/$defs/Margin"}
    assert set(re.findall(r'"#/\$defs/([^"]+)"', json.dumps(schema))) <= set(schema["$defs"])
    temporal = {next(iter(one["properties"])) for one in schema["$defs"]["Formula"]["oneOf"]}
    assert temporal == {"always", "eventually", "until_settled", "until", "all", "any", "not"}
    assert "FORMATS 2010" in pages_called("margins")[0].text
    assert "closing_speed_m_s" in pages_called("signals")[0].text


def test_very_many_predicates_take_a_bounded_time() -> None:
    """Kills: a suggestion for each of them, no limit."""
    many = ", ".join(f"{{signal: sped_{index}, below: 1}}" for index in range(700))
    start = time.process_time()
    with pytest.raises(CampaignError, match=f"accepted: at most {MOST} in all margins") as caught:
        load(CAMPAIGN, [f"margins={{a: {{always: {{any: [{many}]}}}}}}"])
    assert len(caught.value.findings) > 650
    assert time.process_time() - start < 5.0


def test_the_order_of_the_file_is_no_order_of_the_table() -> None:
    """Kills: numbers and columns that come in the order of the file, so that one identity has two programs."""
    one, other = with_margins({"b": SLOW, "a": {"not": SLOW}}), with_margins({"a": {"not": SLOW}, "b": SLOW})
    assert list(one.metric_columns) == list(other.metric_columns)
    assert one.margins == other.margins
