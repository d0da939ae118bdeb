"""Every command of docs/cluster.md, run as it stands there against real scheduler and worker processes.

Only names are replaced: the campaign by a shorter one, host names by this machine's, ports by free ones, `srun` by a script that
starts its task once for each node, and the program by itself with reports without sections.
"""

from __future__ import annotations

import re
import shlex
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from rvjax.campaign.overrides import override
from rvjax.campaign.source import read
from rvjax.run_folder import RunFolder
from tests.reliability.cluster import OVERRIDES, PROGRAM, SETS, dead, ended, free_port, process, scheduler, worker
from tests.short import CAMPAIGN

ROOT = Path(__file__).parents[2]
NODE = '"$@" & '
"""What `srun` does for each node: two of them in the full numbers, one by default."""

PAGE = (ROOT / "docs" / "cluster.md").read_text()


def block(language: str, beginning: str) -> str:
    """The one block of code that begins so."""
    (found,) = re.findall(rf"```{language}\n({re.escape(beginning)}.*?)```", PAGE, re.DOTALL)
    return found


def whole(folder: Path) -> bool:
    """Whether every sample is there and every file intact."""
    opened = RunFolder.open(folder)
    opened.verify()
    return opened.account().missing == 0


@pytest.fixture
def campaign(tmp_path: Path) -> Path:
    """A folder with the short campaign as `campaign.yaml`."""
    with (tmp_path / "campaign.yaml").open("w") as file:
        YAML(typ="safe").dump(override(read(CAMPAIGN), OVERRIDES).value, file)
    return tmp_path


def test_commands_at_the_top(tmp_path: Path, full: bool) -> None:
    """Kills: an option that is spelt otherwise on the page than in the program. (test_executors flies both ways as well.)"""
    if not full:
        pytest.skip("half a minute; with --long")
    install, *commands = block("sh", "pip install").splitlines()
    assert shlex.split(install, comments=True) == ["pip", "install", "rvjax[dask]"]
    assert len(commands) == 2
    with scheduler() as (address, _), worker(address):
        for number, command in enumerate(commands):
            words = shlex.split(command.replace("tcp://scheduler.example:8786", address), comments=True)
            assert words[:3] == ["rvjax", "run", "campaigns/quickstart.yaml"]
            code, _, err = ended(process([*PROGRAM, *words[1:], "--out", str(tmp_path / f"{number}"), *SETS], {}))
            assert code == 0, err
            assert whole(tmp_path / f"{number}")


def test_slurm_script(campaign: Path, full: bool) -> None:
    """Kills: a worker that never finds the scheduler, a job that does not end by itself, processes that outlive it."""
    (campaign / "job").write_text(block("bash", "#!/bin/bash\n#SBATCH"))
    programs = campaign / "bin"
    programs.mkdir()
    (programs / "srun").write_text(f"#!/bin/bash\n{NODE * (2 if full else 1)}wait\n")
    (programs / "rvjax").write_text(f'#!/bin/bash\nPYTHONPATH={shlex.quote(str(ROOT))} exec {shlex.join(PROGRAM)} "$@"\n')
    (programs / "hostname").write_text("#!/bin/bash\necho 127.0.0.1\n")
    for path in programs.iterdir():
        path.chmod(0o755)
    slurm = {"SLURM_JOB_ID": str(free_port()), "SLURM_CPUS_PER_TASK": "1", "SLURM_SUBMIT_DIR": str(campaign)}
    command = f'cd {shlex.quote(str(campaign))} && PATH="$PWD/bin:$PATH" && bash job'
    running = process(["bash", "-c", command], slurm)
    try:
        code, _, err = ended(running)
    finally:
        dead(running)
    assert code == 0, err
    assert whole(campaign / "run")


def test_kubernetes_commands(campaign: Path, full: bool) -> None:
    """Kills: arguments that a container would not start with."""
    if not full:
        pytest.skip("the same three commands as by SLURM: --long")
    documents: list[dict[str, Any]] = list(YAML(typ="safe").load_all(block("yaml", "apiVersion: apps/v1")))
    containers = [c for one in documents if one["kind"] != "Service" for c in one["spec"]["template"]["spec"]["containers"]]
    commands = {container["name"]: container["command"] for container in containers}
    assert list(commands) == ["scheduler", "worker", "run"]
    port = str(free_port())
    names = {"rvjax-scheduler:8786": f"127.0.0.1:{port}", "8786": port, ":8787": ":0", "/data/run": str(campaign / "run")}
    names["campaign.yaml"] = str(campaign / "campaign.yaml")
    with ExitStack() as stack:
        for name, command in commands.items():
            for old, new in names.items():
                command = [word.replace(old, new) for word in command]
            running = process([*PROGRAM, *command[1:]] if command[0] == "rvjax" else command, {})
            stack.callback(dead, running)
            if name == "run":
                code, _, err = ended(running)
                assert code == 0, err
    assert whole(campaign / "run")
