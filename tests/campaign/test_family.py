"""Components that other packages bring, and names that two of them claim."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from rvjax.components import registry
from rvjax.errors import UsageError
from rvjax.execution.identity import identity
from rvjax.simulation.jax_config import configure
from rvjax.simulation.problem import load
from tests.short import CAMPAIGN

DRIFT = '''"""Creep: u = h + a (t − t_f) from the onset on."""

from rvjax.physics.vectors import each
from rvjax.components.registry import Component
from rvjax.components.faults.interface import FaultParameters, fault
from rvjax.campaign import Quantity, channels


class Parameters(FaultParameters):
    rate: Quantity = channels("1", doc="rate a, N/s or N·m/s")


def failed(u, since, memory, upper, numbers):
    return each(lambda h, s, a: h + a * s, u, since, numbers.rate)


COMPONENT = Component(Parameters, lambda parameters: fault(failed))
'''


@pytest.fixture(autouse=True)
def _packages_as_they_are() -> Iterator[None]:
    """What a test brings is forgotten behind it."""
    yield
    registry.members.cache_clear()


def bring(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """As if an installed package had this entry point."""
    entry = EntryPoint(name, "drifting:COMPONENT", "rvjax.faults")
    monkeypatch.setattr(registry, "entry_points", lambda group: [entry] if group == "rvjax.faults" else [])
    registry.members.cache_clear()


def test_a_fault_from_elsewhere_is_one_like_ours(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """It is listed, its parameters are read, and its code is part of the run's identity."""
    (tmp_path / "drifting.py").write_text(DRIFT)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "drifting", raising=False)
    bring(monkeypatch, "creep")
    assert registry.members("faults")["creep"] == "drifting:COMPONENT"
    problem = load(CAMPAIGN, ["faults=[{use: creep, onset_s: 30, rate: {uniform: [0, 0.01]}, channels: [fx]}]"])
    assert problem.faults[0].prefix == "faults.creep"
    configure()
    assert list(identity(problem)["components"]) == ["drifting"]
    assert identity(load(CAMPAIGN))["components"] == {}


def test_a_name_that_two_claim_is_an_error_that_names_both(monkeypatch: pytest.MonkeyPatch) -> None:
    bring(monkeypatch, "bias")
    with pytest.raises(UsageError, match=r"'bias' in rvjax\.faults: rvjax\.components\.faults\.bias and drifting:COMPONENT"):
        registry.members("faults")
