"""The public functions and types: there, imported on first use, typed for the programs of users, and silent on import."""

from __future__ import annotations

import inspect
import json
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import rvjax

ROOT = Path(__file__).parents[2]
FUNCTIONS = [name for name in rvjax.__all__ if name[0].islower() and not name.startswith("_")]

PROGRAM = """
import rvjax

rvjax.configure("float64")
folder = rvjax.fly_campaign("quickstart.yaml", out="reports/mine")
reveal_type(folder)
for verdict in rvjax.judge_folder(folder):
    reveal_type(verdict)
reveal_type(rvjax.compare_runs(folder, folder))
reveal_type(rvjax.plan_samples(0.99))
"""
REVEALED = ("Path | ObjectPath", "Verdict", "Comparison", "Plan")


@pytest.mark.parametrize("name", rvjax.__all__)
def test_every_public_name_is_there(name: str) -> None:
    """Kills: a name that is listed and whose module has moved."""
    assert getattr(rvjax, name) is not None
    assert name in dir(rvjax)


def test_an_unknown_name_is_an_attribute_error() -> None:
    """As of every module."""
    with pytest.raises(AttributeError, match="has no attribute 'no_such_name'"):
        _ = rvjax.no_such_name


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_public_function_is_documented_and_short_of_positions(name: str) -> None:
    """Kills: a public function without a docstring or annotations, or with more than six positional parameters."""
    function = getattr(rvjax, name)
    assert inspect.getdoc(function)
    signature = inspect.signature(function)
    positional = [p for p in signature.parameters.values() if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    assert len(positional) <= 6
    assert signature.return_annotation is not inspect.Signature.empty
    assert all(parameter.annotation is not parameter.empty for parameter in signature.parameters.values())


def test_import_is_silent_and_light() -> None:
    """Kills: an import of the package that prints, warns, or imports JAX."""
    code = "import sys, rvjax; print(sorted({'jax', 'numpy', 'pandas', 'matplotlib'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True)
    assert (done.stdout.strip(), done.stderr) == ("[]", "")


def test_a_users_program_sees_the_types(tmp_path: Path) -> None:
    """pyright in strict mode knows the types of a five-line program. Kills: a missing py.typed; untyped lazy names."""
    assert (ROOT / "rvjax" / "py.typed").is_file()
    if (pyright := shutil.which("pyright", path=str(Path(sys.executable).parent))) is None:
        pytest.skip("pyright is not installed beside this Python")
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    settings = {"typeCheckingMode": "strict", "extraPaths": [str(ROOT)], "include": ["program.py"]}
    (tmp_path / "pyrightconfig.json").write_text(json.dumps(settings))
    command = [pyright, "--outputjson", "--pythonpath", sys.executable]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    findings = json.loads(done.stdout)["generalDiagnostics"]
    assert [finding["message"] for finding in findings if finding["severity"] == "error"] == []
    types = [finding["message"].split(" is ")[-1].strip('"') for finding in findings if finding["severity"] == "information"]
    assert tuple(types) == REVEALED


def test_every_path_in_pyproject_exists() -> None:
    """Kills: a module that is gone and still "checked strictly"; a folder that is not shipped any more."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    build = settings["hatch"]["build"]["targets"]
    paths = [*settings["pyright"]["include"], *settings["pyright"]["strict"], settings["hatch"]["version"]["path"]]
    paths += [*build["wheel"]["packages"], *(path.lstrip("/") for path in build["sdist"]["include"])]
    paths += [*settings["pytest"]["ini_options"]["testpaths"], *settings["ruff"]["lint"]["per-file-ignores"]]
    assert [path for path in paths if not (ROOT / path).exists()] == []
