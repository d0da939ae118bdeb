"""A MAT-file as SciPy and as Octave read it: every number to the bit, every text to the letter."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat

from rvjax.columns import Column
from rvjax.errors import UsageError
from rvjax.execution.exporting import export
from rvjax.export import documents, matlab
from rvjax.export.exported import Exported
from rvjax.run_folder import RunFolder

NUMBERS = [1.5, -2.25, np.nan, np.inf, -np.inf, -0.0, 5e-324, 1 / 3]
FRAME = pd.DataFrame(
    {
        "sample": np.arange(len(NUMBERS)),
        "number": NUMBERS,
        "inside": [True, False] * 4,
        "outcome": ["captured", "not_settled", "", "µ·²φ−", *["captured"] * 4],
    }
)
COLUMNS = {"number": Column("number", "kg·m²", "Jxy = −∫xy dm, 0 ≤ φ < 2π"), "inside": Column("inside", "1", "")}
FACTS = {"campaign": "naïve", "seed": 2**53 + 1, "least": -(2**63), "largest": 2**64 - 1}


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("mat") / "table.mat"
    path.write_bytes(b"".join(documents.mat(Exported("samples", FRAME, COLUMNS, FACTS))))
    return path


def by_scipy(path: Path) -> dict[str, Any]:
    """`struct.field` → numbers, texts, a text or an integer."""
    read = {name: value[0, 0] for name, value in loadmat(path).items() if not name.startswith("__")}
    return {f"{name}.{field}": _plain(values[field]) for name, values in read.items() for field in values.dtype.names}


def _plain(value: np.ndarray) -> Any:
    if value.dtype == object:
        assert value.shape[1:] == (1,)
        return [_plain(cell) for cell in value[:, 0]]
    if value.dtype.kind == "U":
        return str(value[0]) if value.size else ""
    if value.dtype.kind in "iu":
        return int(value[0, 0])
    assert value.shape[1:] == (1,)
    return value[:, 0]


def by_octave(path: Path) -> dict[str, Any]:
    """Likewise. Skips the test where there is no Octave."""
    program = shutil.which("octave-cli")
    if program is None:
        pytest.skip("no octave-cli on the PATH")
    command = [program, "--no-init-file", "--no-history", "--path", str(Path(__file__).parent), "--eval", f"read_mat('{path}')"]
    done = subprocess.run(command, capture_output=True, check=True, timeout=300)
    assert not done.stderr
    lines = [line.split("\t") for line in done.stdout.decode().splitlines()]
    return {name: _told(kind, int(rows), int(columns), values) for name, kind, rows, columns, *values in lines}


def _told(kind: str, rows: int, columns: int, values: list[str]) -> Any:
    if kind == "char":
        return "".join(values)
    if kind in ("int64", "uint64"):
        return int(values[0])
    assert columns == 1
    assert len(values) == rows
    return values if kind == "cell" else np.array([int(value, 16) for value in values], dtype=np.uint64).view(np.float64)


READERS = pytest.mark.parametrize("read", [by_scipy, by_octave])


@READERS
def test_every_kind_of_value(file: Path, read: Any) -> None:
    """Kills: texts in UTF-8, which Octave cuts; seeds as floats; truths and whole numbers that are lost; -0 and NaN that are not
    kept; a text that is filled up."""
    found = read(file)
    bits, truth = (np.asarray(part, dtype=np.float64).view(np.uint64) for part in (found["samples.number"], NUMBERS))
    np.testing.assert_array_equal(bits, truth)
    np.testing.assert_array_equal(found["samples.sample"], np.arange(8.0))
    np.testing.assert_array_equal(found["samples.inside"], [1.0, 0.0] * 4)
    assert found["samples.outcome"] == FRAME["outcome"].tolist()
    assert [found[f"units.{name}"] for name in FRAME] == ["", "kg·m²", "1", ""]
    assert found["descriptions.number"] == COLUMNS["number"].description
    assert {name: found[f"run.{name}"] for name in FACTS} == FACTS


@READERS
@pytest.mark.parametrize("sample", [None, 1])
def test_a_run(folder: Path, tmp_path: Path, read: Any, sample: int | None) -> None:
    """All columns of the samples, and of a flight. Kills: a field that is called as its neighbour; a column that is left out."""
    (path,) = export(folder, tmp_path / "all.mat", sample)
    found, opened = read(path), RunFolder.open(folder)
    frame, columns = (opened.samples().frame, opened.samples().columns) if sample is None else opened.trace_table(sample)
    table = "samples" if sample is None else "trace"
    names = {name.removeprefix("names."): text for name, text in found.items() if name.startswith("names.")}
    assert list(names.values()) == list(frame.columns)
    assert {f"{table}.{field}" for field in names} == {name for name in found if name.startswith(f"{table}.")}
    for field, name in names.items():
        values = found[f"{table}.{field}"]
        if name == "outcome":
            assert values == frame[name].tolist()
        else:
            np.testing.assert_array_equal(values, frame[name].to_numpy(dtype=float))
        if name in columns:
            assert (found[f"units.{field}"], found[f"descriptions.{field}"]) == (columns[name].unit, columns[name].description)


def test_rows_are_written_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of any length, the same bytes. Kills: a part that is written twice; a header for each part; a comma too many."""
    table = Exported("samples", FRAME, COLUMNS, FACTS)

    def written() -> list[bytes]:
        return [b"".join(parts) for parts in (*documents.csv(table), documents.document(table), documents.mat(table))]

    whole = written()
    for rows in (1, 3, 8):
        monkeypatch.setattr(documents, "ROWS", rows)
        monkeypatch.setattr(matlab, "ROWS", rows)
        assert written() == whole
    assert whole[0] == FRAME.to_csv(index=False).encode()


def test_a_table_that_is_too_large_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before anything is written. Kills: sizes that overflow in the file."""
    monkeypatch.setattr(matlab, "LARGEST", 1000)
    with pytest.raises(UsageError, match=r"8 rows of 4 columns: .* accepted: csv or json"):
        documents.mat(Exported("samples", FRAME, COLUMNS, FACTS))
