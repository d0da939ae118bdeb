"""What each lever is worth, and where the time goes: `python -m benchmarks.levers [--rounds N] [--float32]`.

Every row is the engine `llvm` with one thing changed. Each row has its process, and the processes fly in turn. A ratio is the
median over the rounds: speed of the row by speed of the product in the same round. Rows that begin with `profile` compute
something else. They show what a part of a step costs. Results: docs/performance.md.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

CAMPAIGN = Path(__file__).with_name("docking.yaml")
STEPS, CHUNKS = 1200, 4

ROWS: Mapping[str, Mapping[str, Any]] = {
    "the product": {},
    "engine xla": {"engine": "xla"},
    "one thread": {"threads": 1},
    "two groups of lanes at a time": {"groups": 2.0},
    "half a register": {"groups": 0.5},
    "stack at 16 bytes": {"text": ('"stackrealign" ', "")},
    "stages of RK4 as a loop": {"code": "stage loop"},
    "without LLVM's passes over the code": {"code": "no passes"},
    "instructions in the order of the program": {"options": ["-enable-misched=false"]},
    "scheduled for parallel instructions": {"options": ["-misched=ilpmax"]},
    "scheduled for few registers": {"options": ["-misched=ilpmin"]},
    "products and sums contracted, other bits": {"flags": "contract"},
    "everything that -ffast-math allows, other bits": {"flags": "fast"},
    "profile: divisions as products": {"row": "div"},
    "profile: divisions and roots as products": {"row": "div sqrt"},
    "profile: max and min without their rule for NaN": {"row": "max min"},
    "profile: no tanh": {"function": "tanh"},
    "profile: no exponential": {"function": "exp"},
    "profile: no sine and cosine": {"function": "sin cos"},
    "profile: none of these": {"function": "sin cos exp tanh"},
    "profile: no metrics": {"code": "no metrics"},
}


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--float32", action="store_true")
    parser.add_argument("--child", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        child(json.loads(given.child))
        return
    running: dict[str, subprocess.Popen[str]] = {}
    built: dict[str, float] = {}
    speeds: dict[str, list[float]] = {}
    for name, changes in ROWS.items():
        spec = json.dumps({**changes, "precision": "float32" if given.float32 else "float64"})
        command = [sys.executable, "-m", "benchmarks.levers", "--child", spec]
        running[name] = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        built[name], speeds[name] = answer(running[name]), []
    for _ in range(given.rounds):
        for name, process in running.items():
            assert process.stdin is not None
            print("fly", file=process.stdin, flush=True)
            speeds[name].append(answer(process))
    print(f"{'':50s} {'M steps/s':>9s} {'ratio':>6s} {'compile':>9s}")
    for name, process in running.items():
        process.communicate()
        ratio = median(a / b for a, b in zip(speeds[name], speeds["the product"], strict=True))
        print(f"{name:50s} {median(speeds[name]) / 1e6:9.2f} {ratio:6.2f} {built[name]:7.1f} s")


def answer(process: subprocess.Popen[str]) -> float:
    """The number on the next line."""
    assert process.stdout is not None
    return float(process.stdout.readline())


def child(spec: Mapping[str, Any]) -> None:
    """Says how long it traced and compiled; then, at each line it reads, flies and says how many steps a second."""
    import llvmlite.binding as llvm
    import numpy as np

    for option in spec.get("options", ()):
        llvm.set_option("levers", option)
    from rvjax.simulation import jax_config

    jax_config.configure(spec["precision"])
    from rvjax.simulation.batch import LANES
    from rvjax.simulation.draws import Draws
    from rvjax.simulation.engines.llvm.engine import LlvmEngine
    from rvjax.simulation.engines.llvm.machine_code import host
    from rvjax.simulation.engines.xla import XlaEngine
    from rvjax.simulation.problem import load

    written(spec)
    problem = load(CAMPAIGN)
    metrics = () if spec.get("code") == "no metrics" else problem.metrics
    target = replace(host(), lanes=int(host().lanes * spec.get("groups", 1.0)))
    engine = XlaEngine(problem.loop, metrics) if spec.get("engine") else LlvmEngine(problem.loop, metrics, target)
    drawn = [Draws.of(problem, np.arange(i * LANES, (i + 1) * LANES))[1] for i in range(CHUNKS)]
    started = time.perf_counter()
    engine.begin(drawn[0], steps=10**9).advance(0, 1)
    print(time.perf_counter() - started, flush=True)
    chunks = [engine.begin(numbers) for numbers in drawn]
    flown = 0
    with ThreadPoolExecutor(spec.get("threads", 2)) as threads:
        for _ in sys.stdin:
            first, started = flown, time.perf_counter()
            while time.perf_counter() - started < 2.0:
                list(threads.map(lambda chunk, at=flown: chunk.advance(at, at + STEPS), chunks))
                flown += STEPS
            print((flown - first) * CHUNKS * LANES / (time.perf_counter() - started), flush=True)


def written(spec: Mapping[str, Any]) -> None:
    """Changes what the engine writes."""
    from rvjax.simulation import rk4
    from rvjax.simulation.engines.llvm import control, elementwise, instructions, machine_code

    rows = dict(elementwise.ROWS)
    cheap = {"div": multiplied, "sqrt": scaled, "max": partial(extreme, "ogt"), "min": partial(extreme, "olt")}
    elementwise.ROWS = rows | {name: partial(real_only, cheap[name], rows[name]) for name in spec.get("row", "").split()}
    if names := spec.get("function", "").split():
        control.ROWS = {**control.ROWS, "custom_jvp_call": partial(without, names, control.ROWS["custom_jvp_call"])}
    if spec.get("code") == "stage loop":
        rk4.step = stages
    if spec.get("code") == "no passes":
        machine_code._linked = unoptimised
    assembly, (old, new) = machine_code.assembly, spec.get("text", ("", ""))
    machine_code.assembly = lambda *given: assembly(*given).replace(old, new) if old else assembly(*given)
    if flags := spec.get("flags"):
        write = instructions.Writer.new
        codes = {f"{code} ": f"{code} {flags} " for code in ("fadd", "fsub", "fmul", "fdiv")}

        def flagged(self: Any, expression: str) -> str:
            code = expression.partition(" ")[0] + " "
            return write(self, expression.replace(code, codes.get(code, code), 1))

        instructions.Writer.new = flagged


def real_only(row: Callable[..., Any], usual: Callable[..., Any], to: Any, params: Any, kind: Any, operands: Any) -> Any:
    """A changed row for real numbers, the usual one for all others."""
    return (row if kind.kind == "f" else usual)(to, params, kind, operands)


def multiplied(to: Any, params: Any, kind: Any, operands: Any) -> Any:
    """Multiplies instead of dividing."""
    return to.emit("fmul", kind, *operands)


def scaled(to: Any, params: Any, kind: Any, operands: Any) -> Any:
    """A product with a number."""
    return to.emit("fmul", kind, operands[0], to.constant(0.7, kind))


def extreme(code: str, to: Any, params: Any, kind: Any, operands: Any) -> Any:
    """The larger or smaller of two numbers, whatever there is to say about NaN."""
    from rvjax.simulation.engines.llvm.program import BOOL

    return to.emit("select", kind, to.emit(f"fcmp {code}", BOOL, *operands), *operands)


def without(names: list[str], call: Callable[..., Any], to: Any, params: Any, avals: Any, operands: Any) -> Any:
    """Multiplies instead of computing an elementary function."""
    import numpy as np

    if params["call_jaxpr"].jaxpr.debug_info.func_name not in names:
        return call(to, params, avals, operands)
    return (np.asarray(scaled(to, {}, np.dtype(avals[0].dtype), tuple(map(int, operands)))),)


def stages(rate: Callable[..., Any], t: Any, y: Any, h: Any, first: Any) -> Any:
    """RK4 with a loop over its last three stages; the same bits."""
    import jax
    import jax.numpy as jnp

    from rvjax.simulation import rk4

    def stage(i: Any, now: Any) -> Any:
        slope, total = now
        width = jnp.where(i < 2, 0.5 * h, h)
        slope = rate(t + width, rk4.along(y, width, slope))
        middle = jax.tree.map(lambda a, b: jnp.where(i == 0, b, jnp.where(i == 1, a + b, a)), total, slope)
        return slope, middle

    last, middle = jax.lax.fori_loop(0, 3, stage, (first, jax.tree.map(lambda x: x * 0.0, first)))
    return jax.tree.map(lambda a, p, q, s: a + (h / 6.0) * (p + 2.0 * q + s), y, first, middle, last)


def unoptimised(linker: Any, module: Any, machine: Any, level: int) -> Any:
    """Links a module without optimising it."""
    import llvmlite.binding as llvm

    from rvjax.simulation.engines.llvm.machine_code import ENTRY

    return llvm.JITLibraryBuilder().add_ir(module).export_symbol(ENTRY).add_current_process().link(linker, ENTRY)


if __name__ == "__main__":
    main()
