"""CSV files that a campaign names: found, bounded, and nowhere but in its folder; the law of a column; declared columns."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

from rvjax.campaign import Model, Quantity, Series, Spec, csv_text, load, named_files, parse, scalar, series, validate
from rvjax.campaign.attachments import attach
from rvjax.campaign.distributions import Empirical, Fixed
from rvjax.campaign.source import read
from rvjax.errors import CampaignError, Finding
from rvjax.stats.random_streams import uniforms
from tests.spec.conftest import GOOD

U = np.concatenate((2.0 ** -np.arange(1.0, 54.0), 1.0 - 2.0 ** -np.arange(2.0, 53.0), np.linspace(0.001, 0.999, 999)))
VALUES = [3.0, -1.0, 4.0, 1.0, 5.0, 9.0, 2.0, 6.0, 5.0, 3.5]


def test_a_table_draws_its_own_numbers() -> None:
    """x_(⌈nu⌉), NumPy's inverted_cdf; each number of a table of 1,000 in a share 1/1000 of the interval. Kills x_(⌊nu⌋)."""
    law = Empirical.of(VALUES)
    np.testing.assert_array_equal(law.ppf(U), np.quantile(VALUES, U, method="inverted_cdf"))
    np.testing.assert_array_equal(law.cdf([-2.0, -1.0, 4.5, 5.0, 9.0]), [0.0, 0.1, 0.6, 0.8, 1.0])
    assert (law.low, law.high) == (-1.0, 9.0)
    many = Empirical.of(np.arange(1000.0)[::-1].tolist())
    np.testing.assert_array_equal(many.ppf((np.arange(1000) + 0.5) / 1000), np.arange(1000.0))
    np.testing.assert_array_equal(many.scaled(0.5).ppf([0.25]), [124.5])


def test_a_table_draws_between_its_numbers() -> None:
    """NumPy's linear quantiles; F undoes F⁻¹. Kills the other conventions of a quantile, and F on ties."""
    law = Empirical.of(VALUES, interpolate=True)
    np.testing.assert_allclose(law.ppf(U), np.quantile(VALUES, U), rtol=1e-13)
    np.testing.assert_allclose(law.ppf(law.cdf(law.ppf(U))), law.ppf(U), rtol=1e-12)
    np.testing.assert_allclose(law.cdf([-2.0, -1.0, 5.0, 5.5, 9.0]), [0.0, 0.0, 7 / 9, 7.5 / 9, 1.0])
    untied = Empirical.of((np.arange(50.0) ** 2).tolist(), interpolate=True)
    drawn = untied.ppf(uniforms(3, "table", np.arange(20_000))[:, 0])
    assert stats.kstest(drawn, untied.cdf).pvalue > 1e-6
    assert Empirical.of([2.0], interpolate=True).ppf([0.3]).tolist() == [2.0]


def place(folder: Path, campaign: str, **files: str) -> Path:
    """A campaign in a folder with CSV files: name without suffix → text."""
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / f"{name}.csv").write_text(text)
    path = folder / "campaign.yaml"
    path.write_text(campaign)
    return path


def with_mass(given: str) -> str:
    """The good campaign with another mass."""
    return GOOD.read_text().replace("{uniform: [80, 120]}", given)


TABLE = "{table: {csv: masses.csv, column: mass_kg}}"


def test_a_column_of_a_file_beside_the_campaign(tmp_path: Path) -> None:
    """A byte order mark, Windows line ends, quotes, blanks and a column of words are no mistake; what is read is kept."""
    text = '\ufeffmass_kg, "label"\r\n 95.5 ,first\r\n\r\n"101.25","a, b"\r\n8.8e1,\r\n'
    path = place(tmp_path, with_mass(TABLE), masses=text)
    spec = load(path)
    assert spec.pursuer.mass_kg.parts == (Empirical((88.0, 95.5, 101.25)),)
    assert spec.source.inputs == {"masses.csv": text.encode()}
    smooth = load(path, ["pursuer.mass_kg.table.interpolate=true"])
    assert smooth.pursuer.mass_kg.parts == (Empirical((88.0, 95.5, 101.25), interpolate=True),)
    assert load(GOOD).source.inputs == {}


def test_the_copy_of_a_run_folder_is_read(tmp_path: Path) -> None:
    """`inputs/` first. Kills a run folder whose numbers come from a file that somebody puts beside its campaign."""
    path = place(tmp_path, with_mass(TABLE), masses="mass_kg\n90\n")
    (tmp_path / "inputs").mkdir()
    (tmp_path / "inputs" / "masses.csv").write_text("mass_kg\n95\n")
    assert load(path).pursuer.mass_kg.parts == (Fixed(95.0),)


def test_a_file_below_the_folder_is_read_once(tmp_path: Path) -> None:
    place(tmp_path / "data", "", masses="mass_kg\n90\n")
    given = "{table: {csv: ./data/masses.csv, column: mass_kg}}"
    path = place(tmp_path, with_mass(given).replace("nu_m_s: {box: 0.1}", f"nu_m_s: {given}"))
    assert load(path).source.inputs == {"data/masses.csv": b"mass_kg\n90\n"}


def _mass_findings(path: Path) -> list[Finding]:
    return [finding for finding in parse(path)[1] if finding.path.startswith("pursuer.mass_kg")]


def test_no_file_outside_the_folder_is_reached(tmp_path: Path) -> None:
    """Kills: a link out of the folder that is followed, a pipe that is waited for, a device that never ends."""
    (tmp_path / "secret.csv").write_text("mass_kg\n90\n")
    home = tmp_path / "home"
    path = place(home, with_mass(TABLE))
    (home / "masses.csv").symlink_to(tmp_path / "secret.csv")
    assert "is outside the campaign's folder" in str(_mass_findings(path)[0])
    (home / "masses.csv").unlink()
    os.mkfifo(home / "masses.csv")
    assert "is not a plain file" in str(_mass_findings(path)[0])
    (home / "masses.csv").unlink()
    (home / "masses.csv").symlink_to("/dev/zero")
    assert len(_mass_findings(path)) == 1
    (home / "masses.csv").unlink()
    (home / "masses.csv").mkdir()
    assert "is not a plain file" in str(_mass_findings(path)[0])
    inside = home / "real.csv"
    inside.write_text("mass_kg\n90\n")
    (home / "masses.csv").rmdir()
    (home / "masses.csv").symlink_to("real.csv")
    assert load(path).pursuer.mass_kg.parts == (Fixed(90.0),)


@pytest.mark.parametrize(
    ("text", "fragment"),
    [
        ("mass_kg\n95\nnan\n", "line 3, column mass_kg: the text 'nan' is not a finite number"),
        ("mass_kg\n95\n1_0\n", "line 3, column mass_kg: the text '1_0' is not a number"),
        ("mass_kg\n95\n\u0661\n", "is not a number"),
        ("mass_kg,\n95,1\n", "line 1: a column without a name"),
        ("mass;x\n95;1\n", "line 1 has no column mass_kg, its columns between semicolons are mass, x"),
        ('mass_kg\n"95\n96"\n', "line 3, column mass_kg"),
        ("mass_kg\n95\n-inf\n", "line 3, column mass_kg: the text '-inf' is not a number"),
    ],
)
def test_files_that_hold_no_table(text: str, fragment: str, tmp_path: Path) -> None:
    """One finding each, at the key `csv`."""
    path = place(tmp_path, with_mass(TABLE), masses=text)
    (found,) = parse(path)[1]
    assert found.where == f"{path}:12:21"
    assert fragment in found.found


def test_files_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All together in bytes, each in cells. Kills a limit for each file alone: many files of the limit are as bad as one."""
    monkeypatch.setattr(named_files, "MOST_BYTES", 1024 * 1024)
    row = "95\n" * 150_000
    two = with_mass(TABLE).replace("nu_m_s: {box: 0.1}", "nu_m_s: {table: {csv: other.csv, column: mass_kg}}")
    path = place(tmp_path, two, masses=f"mass_kg\n{row}", other=f"mass_kg\n{row * 2}")
    assert [finding.found for finding in parse(path)[1]] == ["other.csv is too large"]
    monkeypatch.setattr(csv_text, "MOST_CELLS", 100_000)
    assert "masses.csv line 100002: too many cells" in [finding.found for finding in parse(path)[1]]


def test_the_values_are_the_identity(tmp_path: Path) -> None:
    """Kills a fingerprint with the file's name in it, or without what the file says; rows in another order are the same law."""
    one = load(place(tmp_path / "a", with_mass(TABLE), masses="mass_kg\n90\n95\n")).fingerprint()
    renamed = with_mass(TABLE.replace("masses.csv", "weights.csv"))
    assert load(place(tmp_path / "b", renamed, weights="x,mass_kg\n,95\n,90.0\n")).fingerprint() == one
    winds = [
        GOOD.read_text().replace("[{use: constant, force_N: [0.01, 0, 0]}]", f"[{{use: wind, csv: {name}.csv}}]") for name in "ab"
    ]
    text = "t_s,fx\n0,1\n"
    found = {load(place(tmp_path / name, wind, **{name: text})).fingerprint() for name, wind in zip("ab", winds, strict=True)}
    assert len(found) == 1
    assert load(place(tmp_path / "c", with_mass(TABLE), masses="mass_kg\n90\n95.5\n")).fingerprint() != one


class Wind(Model):
    """A component that reads a table."""

    table: Series = series("t_s", "fx", optional=("fy",), doc="force over time")
    factor: Quantity = scalar("1", default=1.0, doc="factor")


def wind(folder: Path, text: str) -> tuple[Wind | None, list[str]]:
    """The component of a campaign beside a file."""
    campaign = GOOD.read_text().replace("[{use: constant, force_N: [0.01, 0, 0]}]", "[{use: wind, csv: wind.csv}]")
    path = place(folder, campaign, wind=text)
    source = attach(read(path))
    assert source.value is not None
    raw: dict[str, Any] = {key: value for key, value in source.value["disturbances"][0].items() if key != "use"}
    model, findings = validate(Wind, raw, ("disturbances", 0), source)
    return model, [str(finding).removeprefix(f"{path}:") for finding in (*source.findings, *findings)]


def test_a_component_declares_the_columns_that_it_reads(tmp_path: Path) -> None:
    model, findings = wind(tmp_path, "t_s,fx,fy\n0,1,2\n1,1.5,2.5\n")
    assert findings == []
    assert model is not None
    assert (model.table["fx"], model.table.rows, "fy" in model.table) == ((1.0, 1.5), 2, True)
    assert wind(tmp_path, "t_s,fx\n0,1\n")[1] == []
    assert wind(tmp_path, "t_s,fyy\n0,1\n")[1] == [
        "16:28: disturbances.0.csv: wind.csv line 1 has no column fx, its columns between commas are t_s, fyy; "
        "accepted: t_s, fx, fy",
        "16:28: disturbances.0.csv: wind.csv line 1 has an unknown column fyy; did you mean fy?",
    ]
    assert wind(tmp_path, "t_s,fx\n0,a\n")[1] == [
        "16:28: disturbances.0.csv: wind.csv line 2, column fx: the text 'a' is not a number; accepted: a number in every row"
    ]
    assert len(wind(tmp_path, "")[1]) == 1  # said once, by whoever read it
    assert Wind.model_json_schema()["properties"]["csv"]["type"] == "string"


def test_a_file_set_beside_the_campaign_is_one_of_its_folder(tmp_path: Path) -> None:
    path = place(tmp_path, GOOD.read_text(), masses="mass_kg\n90\n")
    spec = load(path, [f"pursuer.mass_kg={TABLE}"])
    assert isinstance(spec, Spec)
    assert spec.pursuer.mass_kg.parts == (Fixed(90.0),)
    with pytest.raises(CampaignError, match=r"--set .*: pursuer.mass_kg.table.csv: none.csv cannot be read"):
        load(path, ["pursuer.mass_kg={table: {csv: none.csv, column: mass_kg}}"])
