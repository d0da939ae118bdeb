"""CSV files as spreadsheets write them: separators, decimal commas, units; every mistake with its file and line."""

from __future__ import annotations

from pathlib import Path

import pytest

from rvjax.campaign import load, parse
from rvjax.campaign.csv_text import decoded, parsed
from rvjax.campaign.distributions import Empirical
from rvjax.campaign.named_files import RefusedFile
from rvjax.errors import CampaignError
from rvjax.simulation.problem import load as load_problem
from tests.short import CAMPAIGN
from tests.spec.test_csv import TABLE, place, wind, with_mass

PLAIN = "t_s,fx,fy\n0,1.5,-2\n1,0.25,1e-3\n"


@pytest.mark.parametrize(
    "text",
    [
        "t_s;fx;fy\n0;1.5;-2\n1;0.25;1e-3\n",
        "t_s;fx;fy\r\n0;1,5;-2\r\n1;,25;1,0e-3\r\n",
        "t_s\tfx\tfy\n0\t1,5\t-2\n1\t0,25\t0,001\n",
        "sep=;\r\nt_s;fx;fy\r\n0;1,5;-2\r\n1;0,25;0,001\r\n",
        "\nsep=,\nt_s,fx,fy\n0,1.5,-2\n1,.25,1e-3\n",
        '"sep=\t"\nt_s\tfx\tfy\n0\t1.5\t-2\n1\t0.25\t1e-3\n',
        'SEP=;\n"t_s";"fx";fy\n0;"1,5";-2\n1;"0,25";0,001\n',
        "t_s,fx,fy\r0,1.5,-2\r1,0.25,1e-3\r",
    ],
    ids=["semicolons", "decimal-commas", "tabs", "sep", "sep-comma", "sep-tab", "sep-quotes", "old-line-ends"],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_every_spelling_is_the_same_table(text: str, encoding: str) -> None:
    """Names and numbers are those of the plain file. Kills: semicolons read as text, a decimal comma that separates, a line
    `sep=` that is a row, a byte order mark in the first name."""
    table, plain = (parsed("a.csv", decoded("a.csv", given)) for given in (text.encode(encoding), PLAIN.encode()))
    assert table.names == plain.names
    assert [table.column(name) for name in table.names] == [plain.column(name) for name in plain.names]


def test_a_decimal_comma_is_no_other_law(tmp_path: Path) -> None:
    """The spelling of a file is not part of a run's identity. Kills: a fingerprint of the text."""
    plain = load(place(tmp_path / "a", with_mass(TABLE), masses="mass_kg,x\n95.5,1\n101,2\n"))
    german = load(place(tmp_path / "b", with_mass(TABLE), masses="sep=;\nmass_kg;x\n95,5;1\n101;2\n"))
    assert german.pursuer.mass_kg.parts == (Empirical((95.5, 101.0)),)
    assert german.fingerprint() == plain.fingerprint()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sep=|\nt_s|fx\n0|1\n", "a.csv line 1: sep=|; accepted: commas, semicolons, tabs between cells"),
        ("t_s;fx,fy\n0;1\n", "a.csv line 1: commas and semicolons between the names; accepted: one of them"),
        ("t_s\tfx;fy\n0\t1\n", "a.csv line 1: semicolons and tabs between the names"),
        ("t_s;fx\n0;1,5\n1;2.5\n", "a.csv line 3: 2.5 has a decimal point, but 1,5 in line 2 has a decimal comma"),
        ("t_s,fx\n0,1,5\n", "a.csv line 2: 3 cells between commas; accepted: 2 cells, as in line 1; decimal commas need"),
        ("\nt_s;fx\n0;1\n\n1\n", "a.csv line 5: 1 cells between semicolons; accepted: 2 cells, as in line 2"),
        ("sep=;\nt_s;\n0;1\n", "a.csv line 2: a column without a name"),
        ("t_s;t_s\n0;1\n", "a.csv line 1: the column t_s occurs twice"),
        ("", "a.csv line 1: no rows"),
        ("sep=;\n\nt_s;fx\n", "a.csv line 3: no rows"),
        ('t_s;fx\n0;"1"2\n', "a.csv line 2: this is not CSV"),
    ],
)
def test_a_mistake_has_its_file_line_and_separator(text: str, words: str) -> None:
    """Kills: a mistake without a line, lines counted from the first row, a message that hides the separator."""
    with pytest.raises(RefusedFile) as caught:
        parsed("a.csv", text)
    assert words in f"{caught.value.message}; {caught.value.accepted}"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('t_s,fx\n0,"1,5"\n', "a.csv line 2, column fx: the text '1,5' is not a number, a decimal comma needs semicolons"),
        ("t_s;fx\ns;N\n0;1\n", "a.csv line 2, column fx: the text 'N' is not a number, a unit belongs in the name of the column"),
        ("t_s;fx\n0;1.234,5\n", "a.csv line 2, column fx: the text '1.234,5' is not a number"),
        ("t_s;fx\n0;1 000\n", "a.csv line 2, column fx: the text '1 000' is not a number"),
        ("t_s;fx\n0;\n", "a.csv line 2, column fx: an empty cell is not a number"),
        ("t_s;fx\n0;1e300\n", "a.csv line 2, column fx: 1e300 is too large"),
    ],
)
def test_a_cell_that_is_no_number_says_why(text: str, words: str) -> None:
    """Kills: thousands read as decimals, a decimal comma guessed between commas, a line of units without advice."""
    table = parsed("a.csv", text)
    with pytest.raises(ValueError, match="line 2") as caught:
        table.column("fx")
    assert str(caught.value).startswith(words)


@pytest.mark.parametrize("names", ["t [s];fx", "t (s),fx", "t_[s]\tfx", "t_s,fx"])
def test_a_unit_in_brackets_is_that_of_the_name(names: str, tmp_path: Path) -> None:
    """`t [s]` is `t_s`. Kills: a column by place, another unit taken for the right unit."""
    separator = next(mark for mark in ";,\t" if mark in names)
    model, findings = wind(tmp_path, f"{names}\n0{separator}1\n")
    assert findings == []
    assert model is not None
    assert model.table.names == ("t_s", "fx")


def test_another_unit_in_brackets_is_refused(tmp_path: Path) -> None:
    """Kills: milliseconds read as seconds, two spellings of a column in a file."""
    _, findings = wind(tmp_path, "t [ms];fx\n0;1\n")
    assert "16:28: disturbances.0.csv: wind.csv line 1 has an unknown column t [ms]; accepted: t_s, fx, fy" in findings
    _, findings = wind(tmp_path, "t_s;t [s];fx\n0;0;1\n")
    assert findings == ["16:28: disturbances.0.csv: wind.csv line 1 has two columns t [s]; accepted: one of them"]


def test_a_number_outside_its_range_has_a_line(tmp_path: Path) -> None:
    """Kills: a range that names the ends of the table only."""
    path = place(tmp_path, with_mass(TABLE), masses="mass_kg\n95\n-3\n-4\n")
    assert [finding.found for finding in parse(path)[1]] == ["masses.csv line 3, column mass_kg: -3 kg"]


def test_bytes_that_are_no_text_have_a_line() -> None:
    """Kills: a position in bytes only."""
    with pytest.raises(RefusedFile, match=r"a\.csv line 2: byte 0xe9 is not UTF-8"):
        decoded("a.csv", b"x\n\xe9\n")


@pytest.mark.parametrize("csv", ["3", "none.csv", "bytes.csv", "../above.csv"])
@pytest.mark.parametrize(
    ("place", "key"),
    [
        ("disturbances", "[{{use: table, csv: {}}}]"),
        ("disturbances.0.csv", "{}"),
        ("pursuer.mass_kg", "{{table: {{csv: {}, column: mass_kg}}}}"),
        ("sampler", "{{use: points, csv: {}}}"),
    ],
)
def test_a_file_that_cannot_be_read_is_the_only_finding(csv: str, place: str, key: str, tmp_path: Path) -> None:
    """For each key that names a file. Kills: a traceback from a table that is not there; findings on gains that follow a mass
    which is not known."""
    campaign = tmp_path / "campaign.yaml"
    campaign.write_text(CAMPAIGN.read_text())
    (tmp_path / "bytes.csv").write_bytes(b"t_s,fx_N\n0,\xff\n1,2\n")
    (tmp_path / "wrench.csv").write_text("t_s,fx_N\n0,1\n9,2\n")
    sets = ["disturbances=[{use: table, csv: wrench.csv}]", "controller={use: saturated-adaptive}", "require=[]"]
    with pytest.raises(CampaignError) as caught:
        load_problem(campaign, [*sets, f"{place}={key.format(csv)}"])
    (finding,) = caught.value.findings
    assert finding.path.startswith(place)
    assert finding.path.endswith("csv")
