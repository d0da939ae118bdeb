"""A new component is one file and one line: a copy of the package gets a controller, a fault and a metric this way, and the
tests of every member run on them without any change."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.mutants.test_mutants import FAILED, copy_to

NAME = "rehearsed"
BAD = f"{NAME}_badly"
"""What the sound components are called, and the broken one."""

CONTROLLER = '''"""Rehearsed controller: v = −k ρ, in P, with no torque."""

from rvjax.campaign import Model, Quantity, part, scalar
from rvjax.components.controllers.interface import Controller, Response
from rvjax.components.registry import Component
from rvjax.physics.state import Report
from rvjax.physics.vectors import Channels


class Gains(Model):
    """The stiffness."""

    k: Quantity = scalar("N/m", default=0.1, above=0.0, doc="stiffness k")


class Parameters(Model):
    """The gains."""

    gains: Gains = part(default={}, doc="gains")


def respond(seen, control, saturate, gains):
    """v."""
    rho = seen.motion.rho
    command = Channels(rho * -gains.k, rho * 0.0)
    nothing = command * 0.0
    return Response(command, (), Report(nothing, rho.x * 0.0, {}))


COMPONENT = Component(Parameters, lambda parameters: Controller(lambda seen, gains: (), respond))
'''

FAULT = '''"""Rehearsed fault: u = h + s while it acts."""

from rvjax.campaign import Quantity, channels
from rvjax.components.faults.interface import Fault, FaultParameters, fault
from rvjax.components.registry import Component


class Parameters(FaultParameters):
    """The offset, per channel."""

    offset: Quantity = channels("1", above=0.0, doc="offset s")


def failed(u, since, memory, upper, numbers):
    """u."""
    return u + numbers.offset


COMPONENT = Component(Parameters, lambda parameters: fault(failed))
'''

BROKEN = FAULT.replace("fault(failed)", "Fault(lambda t, u, memory, upper, numbers: u + numbers.offset)")
"""The same, but it also acts before its onset."""

METRIC = '''"""Rehearsed metric: ∫ |ρ| dt."""

import jax.numpy as jnp

from rvjax.columns import Column
from rvjax.components.metrics.interface import Metric

NAME = "rehearsed_ms"


def update(acc, step, weight, context):
    """The integral so far."""
    rho = step.motion.rho
    return acc + weight * jnp.sqrt(rho.x**2 + rho.y**2 + rho.z**2)


COMPONENT = Metric(
    {NAME: Column(NAME, "m·s", "integral of the distance", "lower")},
    lambda context: context.tube_m * 0.0,
    update,
    lambda acc, context: {NAME: acc},
)
'''

CONTRACTS = {
    "controllers": "test_baselines.py::test_what_a_controller_gives",
    "faults": "test_faults.py",
    "metrics": "test_metric_members.py",
}
"""Family → the tests of every member."""


def add(folder: Path, family: str, source: str, name: str = NAME) -> None:
    """One file in the family's package, and one line in its table."""
    package = folder / "rvjax" / "components" / family
    (package / f"{name}.py").write_text(source, encoding="utf-8")
    table = (package / "__init__.py").read_text(encoding="utf-8")
    line = f'    "{name}": "rvjax.components.{family}.{name}",\n'
    (package / "__init__.py").write_text(table.replace("MEMBERS = {\n", f"MEMBERS = {{\n{line}"), encoding="utf-8")


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> subprocess.CompletedProcess[str]:
    """The tests of every member, on the new ones alone, sound and broken, in one process."""
    folder = copy_to(tmp_path_factory.mktemp("copy"))
    for family, source in (("controllers", CONTROLLER), ("faults", FAULT), ("metrics", METRIC)):
        add(folder, family, source)
    add(folder, "faults", BROKEN, BAD)
    files = [f"tests/physics/{file}" for file in CONTRACTS.values()]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:xdist", "-rpfE", "--tb=short", "-k", NAME, *files]
    environment = os.environ | {"PYTHONPATH": str(folder), "HYPOTHESIS_PROFILE": "mutant"}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def ended(done: subprocess.CompletedProcess[str], word: str, bad: bool) -> list[str]:
    """The tests of the broken fault, or of the sound members, that ended like this."""
    return [line for line in done.stdout.splitlines() if line.startswith(f"{word} ") and (BAD in line) == bad]


def test_a_new_component_is_one_file_and_one_line(done: subprocess.CompletedProcess[str]) -> None:
    """Kills: a list of members in a test, which would have to be extended by hand; a member that no test finds."""
    assert not ended(done, "FAILED", bad=False), done.stdout[-3000:]
    assert not ended(done, "ERROR", bad=False), done.stdout[-3000:]
    assert len(ended(done, "PASSED", bad=False)) == 1 + 2 + 4, done.stdout[-3000:]


def test_a_broken_component_fails(done: subprocess.CompletedProcess[str]) -> None:
    """A fault that also acts before its onset. Kills: tests of every member that a new one passes whatever it does."""
    assert done.returncode == FAILED, done.stdout[-3000:]
    assert any("test_before_its_onset_a_fault_is_nothing" in line for line in ended(done, "FAILED", bad=True)), done.stdout
