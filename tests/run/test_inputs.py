"""A run whose campaign names a CSV file: everything works from its folder alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rvjax.execution.chunks import ChunkRunner
from rvjax.execution.doctor import examine
from rvjax.execution.executors import dask_worker
from rvjax.execution.identity import identity, packages
from rvjax.run_folder import RunFolder
from rvjax.simulation.problem import load
from tests.program import Run
from tests.short import CAMPAIGN, SHORT

MASSES = "serial,mass_kg\nA1,91.5\nA2,101.25\nA3,88\n"


@pytest.mark.usefixtures("bare")
def test_the_folder_alone_is_enough(rvjax: Run, tmp_path: Path) -> None:
    """run, then the CSV file goes; replay, check, report, doctor, flying again from the folder, and a worker that has it only
    by its bytes. Kills: a file that is read from where it was, bytes that are not sent, a hash that nobody compares."""
    home, folder = tmp_path / "home", tmp_path / "run"
    home.mkdir()
    (home / "masses.csv").write_text(MASSES)
    campaign = home / "campaign.yaml"
    campaign.write_text(CAMPAIGN.read_text())
    sets = [*SHORT, "controller={use: pd-plus}", "pursuer.mass_kg={table: {csv: masses.csv, column: mass_kg}}"]
    given = [part for one in sets for part in ("--set", one)]
    code, _, told = rvjax("run", campaign, "--out", folder, *given, "--quiet")
    assert code in (0, 1, 3), told
    (home / "masses.csv").unlink()
    masses = RunFolder.open(folder).samples().frame["draw.pursuer.mass_kg"]
    assert sorted(set(masses)) == [88.0, 91.5, 101.25]
    assert rvjax("replay", folder, "--sample", 3, "--out", tmp_path / "trace.csv")[0] == 0
    assert rvjax("check", folder)[0] == code
    assert rvjax("report", folder)[0] == 0
    assert examine(folder).exit_code != 5
    before = sorted(path.name for path in (folder / "samples").iterdir())
    assert rvjax("run", folder / "campaign.yaml", "--out", folder, *given, "--quiet")[0] == code
    assert sorted(path.name for path in (folder / "samples").iterdir()) == before
    problem = load(folder / "campaign.yaml", sets)
    order = dask_worker.WorkOrder(
        problem.spec.source.text,
        problem.spec.source.inputs,
        tuple(sets),
        identity(problem),
        packages(),
        str(folder),
        "t",
        local=False,
    )
    worker = dask_worker.DaskWorkerState(order)
    worker._threads = None
    assert isinstance(worker._make(), ChunkRunner)
    (folder / "inputs" / "masses.csv").write_text(MASSES.replace("88", "89"))
    for command in ("check", "report"):
        code, _, told = rvjax(command, folder)
        assert code == 5
        assert "inputs/masses.csv: damaged or edited" in told
    assert rvjax("replay", folder, "--sample", 3, "--out", tmp_path / "trace.csv")[0] == 5
    np.testing.assert_equal(examine(folder).exit_code, 5)
