"""csv, json and mat hold every number to the bit, with its unit and its meaning."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat

from rvjax.components.extras import lacking
from rvjax.errors import UsageError
from rvjax.execution.exporting import Options, export
from rvjax.export.documents import field_names
from rvjax.run_folder import RunFolder
from tests.export.conftest import Truth
from tests.program import Run

LONG = "draw.faults.effectiveness-of-the-thrusters-on-the-far-side.onset_s.fx"


def test_csv(folder: Path, tmp_path: Path) -> None:
    """Kills: digits that are rounded; a companion without units."""
    table, companion = export(folder, tmp_path / "all.csv")
    frame = pd.read_csv(table)
    pd.testing.assert_frame_equal(frame, RunFolder.open(folder).samples().frame, check_exact=True, check_dtype=False)
    columns = pd.read_csv(companion).set_index("name")
    assert companion.name == "all.columns.csv"
    assert list(columns.index) == list(frame.columns)
    assert columns.loc[LONG, "unit"] == "m·s"
    assert columns.loc["metric.settling_time_s", "description"] == "what metric.settling_time_s means"


def test_json(folder: Path, tmp_path: Path) -> None:
    """Kills: NaN that is no JSON; infinity that becomes null."""
    (path,) = export(folder, tmp_path / "all.json")
    document = json.loads(path.read_text(), parse_constant=lambda word: pytest.fail(word))
    assert document["data"]["metric.settling_time_s"] == [12.5, "Infinity", "NaN"]
    assert document["data"]["outcome_time_s"][1] == 0.1 + 0.2
    assert document["columns"]["outcome_time_s"]["unit"] == "m·s"
    assert document["run"]["campaign"] == "made-elsewhere"
    assert document["run"]["seed"] == 5


def test_mat(folder: Path, tmp_path: Path, truth: Truth) -> None:
    """Kills: names that MATLAB does not take; names cut to 31 letters; units that are lost; rows in the place of columns."""
    (path,) = export(folder, tmp_path / "all.mat")
    read = loadmat(path, squeeze_me=False)
    samples, names = read["samples"][0, 0], read["names"][0, 0]
    fields = samples.dtype.names
    assert all(len(field) <= 63 and field.isidentifier() and field.isascii() for field in fields)
    back = {str(names[field][0]): field for field in fields}
    assert samples[back[LONG]].shape == (3, 1)
    np.testing.assert_array_equal(samples[back[LONG]][:, 0], [np.inf, 30.0, 1 / 3])
    assert [str(cell[0]) for cell in samples["outcome"][:, 0]] == ["captured", "captured", "not_finite"]
    assert str(read["units"][0, 0][back[LONG]][0]) == "m·s"
    assert str(read["descriptions"][0, 0]["metric_settling_time_s"][0]) == "what metric.settling_time_s means"
    (path,) = export(folder, tmp_path / "trace.mat", 1)
    read = loadmat(path)
    np.testing.assert_array_equal(read["trace"][0, 0]["rho_x_m"][:, 0], truth.trace()["rho_x_m"])
    assert read["run"][0, 0]["sample"][0, 0] == 1


def test_names_of_fields_are_valid_and_different() -> None:
    """Kills: two columns in one field."""
    fields = field_names(["a.b", "a_b", "end", "1x", "_y", "é", "x" * 80 + "1", "x" * 80 + "2"])
    assert list(fields.values())[:3] == ["a_b", "a_b_2", "x_end"]
    assert len(set(fields.values())) == 8
    assert all(len(field) <= 63 and field.isascii() and field[0].isalpha() and field.isidentifier() for field in fields.values())


@pytest.mark.parametrize(
    ("name", "sample", "options", "message"),
    [
        ("x.xlsx", None, Options(), "unknown format; accepted: a name that ends in .csv, .json, .mat, .oem"),
        ("x.oem", None, Options(), ".oem holds the flight of a sample; accepted: --sample K"),
        ("x.csv", None, Options(every=5), "--every is of a trace"),
        ("x.csv", 1, Options(epoch="2030-01-01"), ".csv has no date and no orbit plane"),
        ("x.oem", 1, Options(plane=(0.0, float("nan"), 0.0)), "--plane: not finite"),
        ("x.csv", 99, Options(), "no sample 99"),
    ],
)
def test_what_does_not_fit_is_refused(
    folder: Path, tmp_path: Path, name: str, sample: int | None, options: Options, message: str
) -> None:
    """Kills: a file that is written all the same."""
    with pytest.raises(UsageError, match=r"(?s).*") as caught:
        export(folder, tmp_path / name, sample, options)
    assert message in str(caught.value)
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize(("suffix", "package"), [("rrd", "rerun-sdk"), ("mcap", "mcap")])
def test_recordings_need_their_extra(folder: Path, tmp_path: Path, suffix: str, package: str) -> None:
    """Kills: a traceback without the package; an empty file with it."""
    path = tmp_path / f"flight.{suffix}"
    if lacking(package):
        with pytest.raises(UsageError, match=rf"needs {package}.*; accepted: pip install 'rvjax\[{package.split('-')[0]}\]'"):
            export(folder, path, 1)
    else:
        export(folder, path, 1)
        assert path.stat().st_size > 10_000


def test_a_recording_of_mcap_is_read_back(folder: Path, tmp_path: Path, truth: Truth) -> None:
    """Kills: a pose in the pursuer's frame; the time in seconds."""
    reader = pytest.importorskip("mcap.reader", reason="pip install 'rvjax[mcap]'")
    (path,) = export(folder, tmp_path / "flight.mcap", 1)
    with path.open("rb") as stream:
        messages = [
            (m.log_time, json.loads(m.data)) for _, c, m in reader.make_reader(stream).iter_messages() if c.topic == "/pose"
        ]
    assert len(messages) == len(truth.t)
    stamp, last = messages[-1]
    assert stamp == 60_000_000_000
    np.testing.assert_allclose(
        [last["translation"][axis] for axis in "xyz"], truth.target[-1].inv().apply(truth.p[-1] - truth.r[-1]), atol=1e-7
    )


def test_the_command(rvjax: Run, folder: Path, tmp_path: Path) -> None:
    """Kills: a command that does not say what it wrote."""
    code, out, _ = rvjax("export", folder, "--sample", 1, "--to", tmp_path / "a.aem", "--epoch", "2030-05-01", "--json")
    assert code == 0
    assert json.loads(out)["files"] == [str(tmp_path / "a.aem"), str(tmp_path / "a-target.aem")]
    code, _, err = rvjax("export", folder, "--to", tmp_path / "a.doc")
    assert code == 2
    assert "unknown format" in err
