"""Nothing is compiled twice: compilations are counted, not timed."""

from __future__ import annotations

from collections import Counter, OrderedDict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest

from rvjax.execution.run import run
from rvjax.simulation.batch import LANES, Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.engines import choice
from rvjax.simulation.engines.llvm import engine, machine_code
from rvjax.simulation.problem import load
from tests.short import CAMPAIGN, QUICK, SHORT

BUILT = "/jax/core/compile/backend_compile_duration"
"""Recorded for each program that is compiled or read from the cache."""

HIT, MISSED = "/jax/compilation_cache/cache_hits", "/jax/compilation_cache/cache_misses"

OTHER = ("seed=7", "samples=300", "pursuer.mass_kg={uniform: [90, 95]}", "horizon.duration_s=19")
XLA = "engine=xla"
GAIN, GAIN_QUICK = "controller.gains.k1=0.07", "controller.gains.k_nu=0.11"
"""Another seed, number of samples, range and duration; and another gain, of either controller."""

Count = Callable[[], Counter[str]]

_events: Counter[str] = Counter()


def _record(event: str, duration: float = 0.0, **more: object) -> None:
    del duration, more
    _events[event] += 1


@pytest.fixture(scope="module")
def count() -> Count:
    """What JAX has recorded since the last call. Listeners cannot be taken back: they stay until the tests end."""
    jax.monitoring.register_event_listener(_record)
    jax.monitoring.register_event_duration_secs_listener(_record)

    def taken() -> Counter[str]:
        found = Counter(_events)
        _events.clear()
        return found

    return taken


@pytest.fixture
def forgetful(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a new process: nothing that other tests have compiled is there."""
    monkeypatch.setattr(choice, "_choices", OrderedDict())


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The functions that the engine `llvm` has compiled."""
    made: list[str] = []

    class Counted(machine_code.Function):
        def __init__(self, *arguments: Any) -> None:
            made.append("function")
            super().__init__(*arguments)

    monkeypatch.setattr(engine, "Function", Counted)
    return made


@pytest.mark.usefixtures("forgetful")
def test_machine_code_is_made_once(count: Count, compiled: list[str]) -> None:
    """Four functions for all chunks, draws and durations, two more for a trace; none for JAX. Kills: a number that is a constant
    of the program, a function that is compiled before it is needed."""
    llvm = (*SHORT, QUICK, "engine=llvm")
    first = load(CAMPAIGN, llvm)
    flyer = Flyer.of(first)
    count()
    for place, (problem, chunk) in enumerate(((first, 0), (first, 3), (load(CAMPAIGN, [*llvm, *OTHER, GAIN_QUICK]), 1))):
        _, drawn = Draws.of(problem, np.arange(chunk * LANES, (chunk + 1) * LANES))
        Flyer.of(problem).fly(drawn, 10 + place, every=5, with_envelope=True)
        assert len(compiled) == 4, place
    _, drawn = Draws.of(first, np.arange(LANES))
    flyer.fly(drawn, 10, every=5, trace=[0])
    assert (len(compiled), count()[BUILT]) == (6, 0)


@pytest.mark.usefixtures("forgetful")
def test_one_flyer_compiles_once(count: Count, full: bool) -> None:
    """With `--long` the controller with the most numbers. Kills: a number that is a constant of the program, a shape or a type
    that differs from chunk to chunk."""
    quick, gain = ([], GAIN) if full else ([QUICK], GAIN_QUICK)
    quick = [*quick, XLA]
    first = load(CAMPAIGN, [*SHORT, *quick])
    flyer = Flyer.of(first)
    count()
    for place, (problem, chunk) in enumerate(((first, 0), (first, 3), (load(CAMPAIGN, [*SHORT, *quick, *OTHER, gain]), 1))):
        _, drawn = Draws.of(problem, np.arange(chunk * LANES, (chunk + 1) * LANES))
        flyer.fly(drawn, 10 + place, every=5, with_envelope=True, trace=range(place + 1))
        assert count()[BUILT] == (6 if place == 0 else 0), place


@pytest.mark.usefixtures("bare", "forgetful")
def test_another_run_of_the_same_structure_finds_its_programs(
    count: Count, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the same process the programs themselves, in another process those in the cache on the disk. Kills: a seed, a range, a
    gain, a duration or a number of samples that makes another program."""
    short = [*SHORT, QUICK, XLA, "horizon.step_s=0.2", "faults=[]", "disturbances=[]"]
    run(CAMPAIGN, tmp_path / "first", short)
    count()
    run(CAMPAIGN, tmp_path / "second", [*short, *OTHER, GAIN_QUICK])
    assert count()[BUILT] == 0
    monkeypatch.setattr(choice, "_choices", OrderedDict())
    run(CAMPAIGN, tmp_path / "third", [*short, *OTHER, GAIN_QUICK])
    found = count()
    assert (found[BUILT], found[HIT], found[MISSED]) == (6, 6, 0)
    run(CAMPAIGN, tmp_path / "fourth", [*SHORT, QUICK, XLA])
    assert count()[BUILT] == 6


@pytest.mark.usefixtures("forgetful")
def test_a_process_keeps_the_engines_used_last(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a process whose memory grows with every structure; the first that is dropped though it was used just now."""
    monkeypatch.setattr(choice, "KEPT", 2)
    one, two, three = (load(CAMPAIGN, [*SHORT, QUICK, *more]) for more in ((), ("faults=[]",), ("disturbances=[]",)))
    kept, dropped = choice.engine_of(one), choice.engine_of(two)
    assert choice.engine_of(load(CAMPAIGN, [*SHORT, QUICK, *OTHER])) is kept
    choice.engine_of(three)
    assert choice.engine_of(one) is kept
    assert choice.engine_of(two) is not dropped


@pytest.mark.parametrize(("engine_name", "lanes"), [("llvm", [40, 3]), ("xla", [LANES, LANES])])
def test_no_more_lanes_fly_than_needed(
    engine_name: str, lanes: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, bare: None
) -> None:
    """The only chunk of 40 samples, and three kept flights. Kills: a full chunk for each; with `xla`, whose
    programs have a number of lanes, any other number."""
    begun: list[int] = []

    def counted(self: Flyer, drawn: Any, *given: Any, **more: Any) -> Any:
        begun.append(len(jax.tree.leaves(drawn)[0]))
        return fly(self, drawn, *given, **more)

    fly = Flyer.fly
    monkeypatch.setattr(Flyer, "fly", counted)
    run(CAMPAIGN, tmp_path / "run", [*SHORT, QUICK, f"engine={engine_name}", "keep={worst: 3}"])
    assert begun == lanes
