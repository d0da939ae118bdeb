"""How the process is configured: in a process of its own, because it can be done once."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rvjax.execution.run import run
from rvjax.run_folder import RunFolder
from rvjax.simulation.batch import LANES, Flyer
from rvjax.simulation.jax_config import EXTRA, SETTINGS, with_settings
from tests.short import CAMPAIGN, QUICK, SHORT

CONFIGURED = "from rvjax.simulation import jax_config; jax_config.configure(); import os; print(os.environ['XLA_FLAGS'])"


BARE = (QUICK, "faults=[]", "disturbances=[]", "require=[]", "keep={worst: 0}")
"""The programs that compile soonest."""

WORDS = ("rvjax", "run", str(CAMPAIGN), "--quiet")


def python(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Runs some code with XLA_FLAGS unset but for what is given."""
    clean = {name: value for name, value in os.environ.items() if name != "XLA_FLAGS"}
    done = [sys.executable, "-c", code]
    return subprocess.run(done, env=clean | environment, capture_output=True, text=True, check=False)


def test_settings_are_made() -> None:
    """Kills: a setting that is lost."""
    assert python(CONFIGURED).stdout.strip() == with_settings("", SETTINGS)


def test_what_the_user_has_set_stays() -> None:
    """Kills: a setting of ours that replaces the user's or stands beside it."""
    own = f"--xla_cpu_prefer_vector_width=256 --{EXTRA}=xla_cpu_use_multi_output_fusion=false"
    done = python(CONFIGURED, XLA_FLAGS=own)
    assert (done.stdout.strip(), done.stderr) == (own, "")
    more = with_settings(f"--{EXTRA}=one=1", SETTINGS).split()
    assert more[0] == f"--{EXTRA}=one=1,xla_cpu_use_multi_output_fusion=true"
    assert len(more) == 2


def test_a_setting_that_xla_does_not_know_is_left_out_with_a_warning() -> None:
    """Kills: a crash of XLA at an unknown flag; known settings that go with it; a warning for each call."""
    unknown = "from rvjax.simulation import jax_config; jax_config.SETTINGS = (('xla_no_such_flag', '1'), *jax_config.SETTINGS);"
    done = python(unknown + CONFIGURED + "; jax_config.configure('float32'); import jax; print(jax.devices()[0].platform)")
    assert done.returncode == 0
    assert done.stdout.splitlines() == [with_settings("", SETTINGS), "cpu"]
    assert "does not know xla_no_such_flag" in done.stderr
    doctor = "from rvjax.cli import main; import sys; sys.argv = ['rvjax', 'doctor']; main()"
    health = python(unknown + doctor)
    assert health.returncode == 2
    assert "does not know xla_no_such_flag: flights may be slower" in health.stdout + health.stderr
    assert "SettingsWarning" not in health.stderr


def test_what_xla_knows_is_asked_once(tmp_path: Path) -> None:
    """Kills: a child process at every start; a refusal that is remembered as an acceptance."""
    count = (
        "from rvjax.simulation import jax_config; asked = []; run = jax_config.subprocess.run\n"
        "jax_config.subprocess.run = lambda *given, **more: asked.append(1) or run(*given, **more)\n"
        "jax_config.configure(); print(len(asked))"
    )
    assert [python(count, XDG_CACHE_HOME=str(tmp_path)).stdout for _ in range(2)] == ["1\n", "0\n"]
    for _ in range(2):
        refused = python(CONFIGURED, XDG_CACHE_HOME=str(tmp_path), XLA_FLAGS="--xla_no_such_flag=1")
        assert "UsageError" in refused.stderr


def test_flags_of_the_user_that_xla_does_not_know_are_named() -> None:
    """Kills: a crash of XLA, a traceback of ours."""
    done = python(
        "from rvjax.cli import main; import sys; sys.argv = ['rvjax', 'doctor']; main()", XLA_FLAGS="--xla_no_such_flag=1"
    )
    assert done.returncode == 2
    assert "--xla_no_such_flag=1" in done.stderr
    assert "Traceback" not in done.stderr


def test_flags_in_a_file_stay_there(tmp_path: Path) -> None:
    """XLA_FLAGS may name a file of flags, to which nothing can be added."""
    (tmp_path / "flags").write_text("--xla_cpu_prefer_vector_width=256")
    done = python(CONFIGURED, XLA_FLAGS=str(tmp_path / "flags"))
    assert done.stdout.strip() == str(tmp_path / "flags")
    assert "names a file" in done.stderr


def test_jax_that_runs_with_other_settings_is_an_error() -> None:
    """Kills: settings that come too late and are believed to act."""
    done = python("import jax; jax.devices(); from rvjax.simulation import jax_config; jax_config.configure()")
    assert "UsageError: JAX is already running with XLA_FLAGS=''" in done.stderr
    again = python(CONFIGURED + "; import jax; jax.devices(); jax_config.configure('float32'); jax_config.configure()")
    assert (again.returncode, again.stderr) == (0, "")


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user's cache, in which XLA is asked once."""
    return tmp_path_factory.mktemp("home")


@pytest.mark.parametrize(("mode", "used"), [(0o700, True), (0o750, False), (0o707, False)])
def test_the_compile_cache_is_private(mode: int, used: bool, home: Path) -> None:
    """What lies in the cache is executed. Kills: a folder that others can read or write; one made with the usual mode."""
    folder = home / "rvjax" / "compiled"
    look = (
        "from rvjax.simulation import jax_config; jax_config.configure(); import jax; print(jax.config.jax_compilation_cache_dir)"
    )
    if not folder.exists():
        assert python(look, XDG_CACHE_HOME=str(home)).stdout.strip() == str(folder)
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    folder.chmod(mode)
    assert python(look, XDG_CACHE_HOME=str(home)).stdout.strip() == (str(folder) if used else "None")


@pytest.mark.usefixtures("bare")
def test_devices_share_the_chunks_and_change_no_bit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two XLA devices, a chunk each, against the one of this process. Kills: a chunk that stays on the first device, bits that
    depend on it."""
    short = (*SHORT, *BARE, f"samples={LANES + 28}")
    words = [*WORDS, *(part for one in short for part in ("--set", one)), "--out", str(tmp_path / "2")]
    look = (
        f"import jax, sys; jax.config.update('jax_num_cpu_devices', 2); sys.argv = {words!r}\n"
        "from rvjax.report import sections; sections.SECTIONS = ()\n"
        "from rvjax.simulation import batch; fly, used = batch.Flyer.fly, set()\n"
        "def seen(*given, **more):\n    used.add(more.get('device'))\n    return fly(*given, **more)\n"
        "batch.Flyer.fly = seen\n"
        "from rvjax.cli import main\n"
        "try:\n    main()\nfinally:\n    print(len(used - {None}))"
    )
    done = python(look)
    assert done.stdout.splitlines()[-1] == "2", done.stderr
    used: set[object] = set()
    fly = Flyer.fly

    def seen(*given: Any, **more: Any) -> Any:
        used.add(more.get("device"))
        return fly(*given, **more)

    monkeypatch.setattr(Flyer, "fly", seen)
    run(CAMPAIGN, tmp_path / "1", short)
    assert len(used - {None}) == 1
    one, two = (RunFolder.open(tmp_path / name).samples().frame for name in ("1", "2"))
    assert len(one) == LANES + 28
    assert one.equals(two)


@pytest.mark.usefixtures("bare")
def test_outcomes_do_not_depend_on_the_settings(tmp_path: Path) -> None:
    """The same campaign without any of them: the same outcomes and, to the last digits, the same metrics."""
    off = f"--xla_cpu_prefer_vector_width=256 --{EXTRA}=xla_cpu_use_multi_output_fusion=false"
    short = (*SHORT, *BARE)
    words = [*WORDS, "--out", str(tmp_path / "run"), *(part for one in short for part in ("--set", one))]
    bare = "from rvjax.report import sections; sections.SECTIONS = ()"
    done = python(f"{bare}; from rvjax.cli import main; import sys; sys.argv = {words!r}; main()", XLA_FLAGS=off)
    assert done.returncode == 0, done.stderr
    run(CAMPAIGN, tmp_path / "ours", short)
    plain, ours = (RunFolder.open(tmp_path / name).samples().frame for name in ("run", "ours"))
    assert plain["outcome"].tolist() == ours["outcome"].tolist()
    draws = [name for name in ours if name.startswith("draw.")]
    assert plain[draws].equals(ours[draws])
    for name in ("metric.delta_v_m_s", "metric.final_position_error_m", "metric.closest_approach_m"):
        np.testing.assert_allclose(plain[name], ours[name], rtol=1e-5, err_msg=name)
