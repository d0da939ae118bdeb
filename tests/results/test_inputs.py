"""The files that a campaign names are part of its run folder: kept, verified, and read in place of the ones they came from."""

from __future__ import annotations

from pathlib import Path

import pytest

from rvjax.errors import FolderError
from rvjax.run_folder import RunDescription, RunFolder

from .conftest import IDENTITY, LANES

INPUTS = {"masses.csv": b"mass_kg\n90\n95\n", "data/wrench.csv": b"t_s,fx\n0,1\n"}


def described(inputs: dict[str, bytes]) -> RunDescription:
    """A small run with these input files."""
    return RunDescription(identity=IDENTITY, provenance={}, campaign_text="rvjax: 1\n", samples=10, name="small", inputs=inputs)


def create(path: Path, inputs: dict[str, bytes]) -> RunFolder:
    return RunFolder.create(path, described(inputs))


def test_inputs_are_kept_and_verified(tmp_path: Path) -> None:
    """Kills a copy that may change unseen, or go missing unseen."""
    path = tmp_path / "run"
    create(path, INPUTS).close()
    assert {name: (path / "inputs" / name).read_bytes() for name in INPUTS} == INPUTS
    RunFolder.open(path).verify()
    (path / "inputs" / "masses.csv").write_bytes(b"mass_kg\n90\n96\n")
    (path / "inputs" / "data" / "wrench.csv").unlink()
    for look in (RunFolder.open(path).verify, RunFolder.open(path).campaign_text):
        with pytest.raises(FolderError) as caught:
            look()
        assert "inputs/masses.csv: damaged or edited" in str(caught.value)
        assert "inputs/data/wrench.csv: missing" in str(caught.value)


def test_going_on_writes_them_again(tmp_path: Path) -> None:
    path = tmp_path / "run"
    create(path, INPUTS).close()
    (path / "inputs" / "masses.csv").unlink()
    newer = {"masses.csv": b"mass_kg\n95\n90.0\n"}
    RunFolder.resume(path, described(newer), LANES).close()
    RunFolder.open(path).verify()
    assert (path / "inputs" / "masses.csv").read_bytes() == newer["masses.csv"]


def test_a_folder_that_was_being_made_is_made_anew_and_nobody_elses_is_taken(tmp_path: Path) -> None:
    """Kills: inputs of a stopped start that are in the way, a folder `inputs` of the user's that is written into."""
    path = tmp_path / "run"
    (path / "inputs").mkdir(parents=True)
    (path / "inputs" / "masses.csv").write_bytes(b"half")
    create(path, INPUTS).close()
    RunFolder.open(path).verify()
    other = tmp_path / "other"
    (other / "inputs").mkdir(parents=True)
    (other / "inputs" / "mine.txt").write_text("mine")
    with pytest.raises(FolderError, match="there already and not empty"):
        create(other, INPUTS)


def test_inputs_stay_inside_and_are_no_report(tmp_path: Path) -> None:
    with pytest.raises(FolderError, match="leads out of the run folder"):
        create(tmp_path / "run", {"../escaped.csv": b"x"})
    folder = create(tmp_path / "other", INPUTS)
    with pytest.raises(FolderError, match="holds data of the run"):
        folder.write_bytes("inputs/masses.csv", b"x")
    folder.close()
