"""Run folders in S3, through the whole program, against a server on this machine."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rvjax.components.extras import lacking
from rvjax.notebook import Run as FinishedRun
from rvjax.run_folder import RunFolder, rare_record
from tests.program import Run
from tests.rare.test_rare_search import CAMPAIGN as SELDOM
from tests.reliability.nursery import Nursery
from tests.reliability.plain import PLAIN, proved
from tests.short import CAMPAIGN, SHIPPED, SHORT

if lacking("fsspec", "s3fs"):
    pytest.skip("run folders in object stores need rvjax[cloud]", allow_module_level=True)
server = pytest.importorskip("moto.server", reason="a local S3 needs moto and flask")

SETS = [part for setting in (*SHORT, *PLAIN, "keep={worst: 2}") for part in ("--set", setting)]
UNDECIDED = 3
"""40 samples are too few for a verdict."""
FAILED = 1


@pytest.fixture
def bucket(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """An empty bucket `runs` on a server of this process."""
    import s3fs

    running = server.ThreadedMotoServer(port=0, verbose=False)
    running.start()
    host, port = running.get_host_and_port()
    settings = {"ENDPOINT_URL": f"http://{host}:{port}", "ACCESS_KEY_ID": "a", "SECRET_ACCESS_KEY": "b"}
    for name, value in (settings | {"DEFAULT_REGION": "us-east-1"}).items():
        monkeypatch.setenv(f"AWS_{name}", value)
    files: Any = s3fs.S3FileSystem(skip_instance_cache=True)
    files.call_s3("create_bucket", Bucket="runs")
    yield files
    running.stop()


@pytest.fixture(autouse=True)
def without_audit(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the campaign is does not matter here, and two sections of the report are enough."""
    monkeypatch.setattr("rvjax.execution.run.prove", proved)
    monkeypatch.setattr("rvjax.report.sections.SECTIONS", ())


def data_of(files: Any, place: str) -> dict[str, str]:
    """Name and SHA-256 of the data files."""
    names = [
        name for name in files.find(place) if name.endswith(".parquet") and "quarantine" not in name and "judged" not in name
    ]
    return {name.removeprefix(f"{place}/"): hashlib.sha256(files.cat_file(name)).hexdigest() for name in names}


def local_data(path: Path) -> dict[str, str]:
    """The same of a local folder."""
    names = [file for file in path.rglob("*.parquet") if file.name != "judged.parquet"]
    return {file.relative_to(path).as_posix(): hashlib.sha256(file.read_bytes()).hexdigest() for file in names}


def test_every_command_on_a_run_in_s3(bucket: Any, tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """The files are those of a local run. Kills: a command that takes a URL for a local name and makes a folder of it."""
    monkeypatch.chdir(tmp_path)
    place = "s3://runs/some/run"
    assert rvjax("run", CAMPAIGN, "--quiet", "--out", tmp_path / "local", *SETS)[0] == UNDECIDED
    code, out, err = rvjax("run", CAMPAIGN, "--out", place, *SETS)
    assert code == UNDECIDED, err
    assert f"report: {place}/report.html" in out
    assert data_of(bucket, "runs/some/run") == local_data(tmp_path / "local")
    code, out, err = rvjax("run", CAMPAIGN, "--quiet", "--out", place, *SETS)
    assert code == UNDECIDED, err
    code, out, err = rvjax("check", place, "--json")
    assert (code, json.loads(out)["folder"]) == (UNDECIDED, place), err
    report = bucket.cat_file("runs/some/run/report.md")
    bucket.rm_file("runs/some/run/report.md")
    code, out, err = rvjax("report", place)
    assert (code, out.strip()) == (0, f"{place}/report.html"), err
    assert bucket.cat_file("runs/some/run/report.md") == report
    for folder, name in ((place, "a.csv"), (tmp_path / "local", "b.csv")):
        code, out, err = rvjax("replay", folder, "--sample", 3, "--out", tmp_path / name)
        assert code == 0, err
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    code, out, err = rvjax("compare", tmp_path / "local", place)
    assert "s3://runs/some/run" in out, err
    assert "Traceback" not in err
    code, out, err = rvjax("doctor", place)
    assert "every file is intact" in out, err
    assert FinishedRun(place).summary == json.loads((tmp_path / "local" / "summary.json").read_text()) | {
        name: value for name, value in FinishedRun(place).summary.items() if name == "timings"
    }
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "b.csv", "local"]


def test_rare_failures_in_s3(bucket: Any, tmp_path: Path, rvjax: Run) -> None:
    """The record and the flights of a search are those of a local one. Kills: a search that is written beside the bucket."""
    (tmp_path / "seldom.yaml").write_text(SELDOM)
    for place in (tmp_path / "local", "s3://runs/seldom"):
        code, _, err = rvjax("run", tmp_path / "seldom.yaml", "--quiet", "--out", place)
        assert code == FAILED, err
    for name in (rare_record.NAME, rare_record.FAILING, rare_record.POINTS):
        assert bucket.cat_file(f"runs/seldom/rare-1/{name}") == (tmp_path / "local" / "rare-1" / name).read_bytes()
    assert data_of(bucket, "runs/seldom") == local_data(tmp_path / "local")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["local", "seldom.yaml"]


def test_a_killed_run_goes_on(bucket: Any, tmp_path: Path) -> None:
    """SIGKILL to a real process between two commits. Kills: a lease that outlives its process, lost or doubled chunks."""
    words = ["run", CAMPAIGN, "--quiet", *SETS, "--out"]
    nursery = Nursery()
    try:
        assert nursery.raise_child([*words, tmp_path / "local"], tmp_path / "log")["code"] == UNDECIDED, (
            tmp_path / "log"
        ).read_text()
        for place, delay in (("take", 0.02), ("worst", 0.05), ("write", 0.05)):
            killed = nursery.raise_child([*words, "s3://runs/killed"], tmp_path / "log", place, 1, delay)
            assert killed["code"] == -9, (tmp_path / "log").read_text()
        ended = nursery.raise_child([*words, "s3://runs/killed"], tmp_path / "log")
        assert ended["code"] == UNDECIDED, (tmp_path / "log").read_text()
    finally:
        nursery.close()
    assert data_of(bucket, "runs/killed") == local_data(tmp_path / "local")
    RunFolder.open("s3://runs/killed").verify()
    assert not [name for name in bucket.find("runs/killed") if name.endswith("writer.json")]


@pytest.mark.usefixtures("bucket")
def test_a_place_that_cannot_be_written(rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Refused before anything flies. Kills: a traceback, an error after the flights, a message that does not say what to do."""
    cases = [
        ("s3://missing/run", "s3://missing/run: cannot be written: there is no such bucket; make it"),
        ("s3://", "no bucket; accepted: s3://bucket/prefix"),
        ("ftp://host/run", "needs the conditional requests of S3; accepted: s3://bucket/prefix, or a folder"),
    ]
    for place, words in cases:
        code, out, err = rvjax("run", CAMPAIGN, "--quiet", "--out", place, *SETS)
        assert (code, out) == (2, ""), err
        assert words in err
        assert "Traceback" not in err
    assert rvjax("check", "s3://runs/nothing")[0] == 5
    code, _, err = rvjax("tune", SHIPPED / "tuning" / "pd-plus.yaml", "--out", "s3://runs/tune")
    assert (code, "s3://runs/tune: this command writes to a folder of this machine" in err) == (2, True), err
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.delenv(name)
    monkeypatch.setenv("AWS_EC2_METADATA_DISABLED", "true")
    monkeypatch.setenv("AWS_SHARED_CREDENTIALS_FILE", "/dev/null")
    code, _, err = rvjax("run", CAMPAIGN, "--quiet", "--out", "s3://runs/x", *SETS)
    assert code == 2, err
    assert "no credentials; set AWS_ACCESS_KEY_ID" in err
    assert "Traceback" not in err


def test_the_extra_that_is_missing_is_named(rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: an ImportError."""
    monkeypatch.setattr("rvjax.run_folder.s3_client.lacking", lambda *packages: "s3fs>=2024.9 (not installed)")
    code, _, err = rvjax("run", CAMPAIGN, "--quiet", "--out", "s3://runs/x", *SETS)
    assert code == 2
    assert "needs s3fs>=2024.9 (not installed); accepted: pip install 'rvjax[cloud]'" in err
    assert "rvjax.run_folder.s3_client" in sys.modules
