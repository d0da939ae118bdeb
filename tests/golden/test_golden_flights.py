"""Golden flights: the same bits here as on every other machine."""

from __future__ import annotations

import hashlib
import json
import re
from collections import Counter
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np
import pytest

from rvjax.cli._app import program
from rvjax.simulation.batch import LANES
from rvjax.simulation.draws import Draws
from rvjax.simulation.engines import choice
from rvjax.simulation.engines.llvm import engine
from rvjax.simulation.engines.llvm.engine import LlvmEngine, count
from rvjax.simulation.engines.llvm.machine_code import Target
from rvjax.simulation.engines.llvm.text import Kernel, assembly
from tests.engines.targets import TARGETS, can_run
from tests.engines.test_flights import problem
from tests.golden.flights import CAMPAIGNS, FILE, digest
from tests.golden.flights import FOLDER as CAMPAIGN_FOLDER
from tests.golden.other_libraries import OLDER, SWITCHES, elsewhere

GOLDEN = json.loads(FILE.read_text(encoding="utf-8"))
FIRST = ("docking-faulted.yaml", "navigation.yaml")
OTHERS = sorted({*CAMPAIGNS} - {*FIRST})


def test_every_shipped_campaign_has_its_flights() -> None:
    """Kills: a new campaign without them."""
    assert sorted(GOLDEN) == CAMPAIGNS


@pytest.mark.parametrize("name", FIRST)
def test_a_flight_has_its_bits(name: str) -> None:
    """On this machine. Kills: anything that changes a result without being meant to."""
    assert digest(name) == GOLDEN[name]


@pytest.mark.parametrize("name", OTHERS)
def test_every_flight_has_its_bits(name: str) -> None:
    """On this machine."""
    assert digest(name) == GOLDEN[name]


@pytest.mark.parametrize("kind", ["AVX-512", "AVX2", "SSE2"])
@pytest.mark.parametrize("name", CAMPAIGNS)
def test_a_flight_has_its_bits_on_other_processors(name: str, kind: str) -> None:
    """With fewer instructions than this processor has."""
    can_run(kind)
    assert digest(name, TARGETS[kind]) == GOLDEN[name]


@SWITCHES
def test_a_flight_has_its_bits_where_libraries_choose_other_functions() -> None:
    """NumPy and the C library take their functions by processor; here they take those of an old one. Kills: a draw that goes
    through them."""
    code = f"from tests.golden.flights import digest; print(*(digest(name) for name in {FIRST}))"
    assert elsewhere(code, **OLDER).split() == [GOLDEN[name] for name in FIRST]


def test_a_folder_begun_on_another_machine_is_resumed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A chunk with the instructions of an old processor, the next with those of this one: the files of a single machine.
    Kills: an identity that names the processor."""

    def fly(folder: str, samples: int) -> dict[str, str]:
        choice._choices.clear()
        command = ["run", str(CAMPAIGN_FOLDER / "docking-faulted.yaml"), "--set", "require=[]", "--set", "horizon.duration_s=40"]
        command += ["--set", "capture.window_s=10", "--samples", str(samples), "--out", str(tmp_path / folder), "--quiet"]
        assert program()(command, standalone_mode=False) == 0
        return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in (tmp_path / folder / "samples").iterdir()}

    with monkeypatch.context() as other:
        other.setattr(engine, "host", lambda: TARGETS["SSE2"])
        begun = fly("begun", LANES)
    resumed = fly("begun", 2 * LANES)
    assert len(begun) == 1
    assert begun.items() <= resumed.items()
    assert resumed == fly("whole", 2 * LANES)


def test_code_for_arm_fuses_nothing_and_calls_nothing() -> None:
    """The machine code of a step for another instruction set. Kills: an operation that this processor has, and that another would
    take from its C library; a contraction that is usual there."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    found = problem("docking-faulted.yaml")
    flight = LlvmEngine(found.loop, found.metrics).flight(Draws.of(found, np.arange(1))[1])
    program, real = flight.traced("advance").program, flight.real
    arm = Target("neoverse-n1", "", 2)
    kernel = Kernel(program, count(flight.numbers), count(flight.carry), arm.lanes, real, real)
    module = llvm.parse_assembly(assembly(kernel, "fly", arm.attributes, "aarch64"))
    module.triple = "aarch64-unknown-linux-gnu"
    machine = llvm.Target.from_triple(module.triple).create_target_machine(cpu=arm.cpu, opt=2)
    instructions = Counter(re.findall(r"^\t([a-z]\w*)", machine.emit_assembly(module), re.M))
    assert instructions["fmul"] > 1000
    assert instructions["fdiv"] > 50
    assert not [name for name in instructions if re.fullmatch(r"fn?m(add|sub)|fml[as]|blr?", name)]
