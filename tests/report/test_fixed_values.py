"""Gains and fixed values; where requirements come from; sections that have nothing to say."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pandas as pd

from rvjax.analysis.verdicts import judge_folder
from rvjax.execution.identity import fixed
from rvjax.report import build
from rvjax.report.blocks import Code, Section, Table
from rvjax.report.ci import junit
from rvjax.report.run_view import open_run
from rvjax.report.sections import envelopes, fixed_values, verdicts
from rvjax.simulation.problem import load
from tests.program import Run
from tests.report.conftest import Within

ROOT = Path(__file__).parents[2]
REQUIRE = """
  - {metric: captured, at_least: 0.5, id: SYS-1, parent: MIS-7, rationale: "why | not", source: "ICD <3>"}
  - {metric: settling_time_s, quantile: 0.5, below: 150, id: SYS-2}
"""


def rows(section: Section | None) -> dict[str, tuple[object, ...]]:
    assert section is not None
    tables = [block for block in section.body if isinstance(block, Table)]
    return {row[0].text: row[1:] for table in tables for row in table.rows if isinstance(row[0], Code)}


def test_defaults_of_the_controller_are_among_them(made: Callable[..., Path], tmp_path: Path) -> None:
    """Kills: values in the unit of the file, gains that are drawn, defaults that are left out, digits that are rounded."""
    problem = load(ROOT / "campaigns" / "docking-faulted.yaml", ["controller.gains.k1={uniform: [0.1, 0.2]}"])
    run = open_run(made(tmp_path / "run"))
    known = rows(fixed_values.section(replace(run, spec=problem.spec, provenance={"fixed": fixed(problem)})))
    assert known["controller.gains.k_sigma"] == ("0.4", "rad/s")
    assert known["controller.nussbaum"] == ("exp-cos", "")
    assert known["target.orbit.semi_major_axis_m"] == ("6878000", "m")
    assert known["target.port_m"] == ("5, 0, 0", "m")
    assert known["corridor.half_angle_rad"] == ("0.174532925199", "rad")
    assert known["guidance.gate_m"] == ("12", "m")
    drawn = ("controller.gains.k1", "pursuer.mass_kg", "require", "start.position_m")
    assert not [name for name in known if name.startswith(drawn)]


def test_a_folder_without_a_record_says_so(made: Callable[..., Path], tmp_path: Path) -> None:
    """Kills: a traceback for a folder of an earlier version."""
    section = fixed_values.section(open_run(made(tmp_path / "run")))
    assert rows(section)["horizon.step_s"] == ("0.05", "s")
    assert "not recorded in this folder" in str(section)


def test_requirements_say_where_they_come_from(made: Callable[..., Path], tmp_path: Path, rvjax: Run, undrawn: Within) -> None:
    """In the report, summary.json, --json and JUnit. Kills: a key that is lost on the way, a column that nobody states."""
    folder = made(tmp_path / "run", require=REQUIRE)
    with undrawn():
        build(folder)
    told = json.loads((folder / "summary.json").read_text())["requirements"]
    assert (told[0]["id"], told[0]["parent"], told[0]["source"], told[1]["id"]) == ("SYS-1", "MIS-7", "ICD <3>", "SYS-2")
    assert "rationale" not in told[1]
    section = verdicts.section(open_run(folder))
    (table,) = (block for block in section.body if isinstance(block, Table) and block.caption.startswith("Traceability"))
    assert table.head == ("requirement", "verdict", "id", "parent", "rationale", "source")
    assert table.rows[1][2:] == ("SYS-2", "–", "–", "–")
    assert "ICD &lt;3&gt;" in (folder / "report.html").read_text()
    xml = ElementTree.fromstring(junit.junit("x", junit.of_verdicts(judge_folder(folder))))
    given = [{p.get("name"): p.get("value") for p in case.iter("property")} for case in xml.iter("testcase")]
    assert given[0]["rationale"] == "why | not"
    assert "parent" not in given[1]
    _, out, _ = rvjax("check", folder, "--json")
    document = json.loads(out)
    assert [verdict["requirement"]["id"] for verdict in document["verdicts"]] == ["SYS-1", "SYS-2"]


def test_they_decide_nothing(tmp_path: Path) -> None:
    """Kills: an id in the fingerprint of the flights."""
    path = ROOT / "campaigns" / "quickstart.yaml"
    traced = load(path, ["require.0.id=SYS-1", "require.0.source=here"])
    assert traced.fingerprint == load(path).fingerprint
    assert traced.spec.require[0].origin == {"id": "SYS-1", "source": "here"}


def test_sections_without_anything_to_say_are_left_out(made: Callable[..., Path], tmp_path: Path) -> None:
    """Kills: an empty section in the table of contents."""
    run = replace(open_run(made(tmp_path / "run", kept=0)), envelopes=pd.DataFrame())
    assert envelopes.section(run) is None
