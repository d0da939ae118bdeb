"""What each lever is worth, and where the time goes: `python -m benchmarks.levers [--rounds N] [--float32]`.

Every row is the product with one thing changed, in a process of its own; the processes stand ready and fly in turn, and a row's
ratio is the median over the rounds of its speed over that of the product in the same round. What came out: docs/performance.md.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

CAMPAIGN = Path(__file__).parents[1] / "campaigns" / "docking-faulted.yaml"
STEPS = 1200
EXTRA = "--xla_backend_extra_options="
FUSED, WIDE = f"{EXTRA}xla_cpu_use_multi_output_fusion=true", "--xla_cpu_prefer_vector_width=512"
PRODUCT: Mapping[str, Any] = {"flags": f"{FUSED} {WIDE}", "lanes": 416, "threads": 2, "devices": 1, "code": "", "replaced": ""}

ROWS: Mapping[str, Mapping[str, Any]] = {
    "the product": {},
    "without multi-output fusion": {"flags": WIDE},
    "without 512-bit registers": {"flags": FUSED},
    "sine and cosine of the C library": {"replaced": "sin cos by the C library"},
    "one thread": {"threads": 1},
    "272 lanes": {"lanes": 272},
    "256 lanes (a power of two)": {"lanes": 256},
    "64 lanes": {"lanes": 64},
    "832 lanes": {"lanes": 832},
    "an XLA device a core instead of a thread a core": {"devices": 2},
    "stages of RK4 as an inner loop": {"code": "stage loop"},
    "numbers of a sample packed in one array": {"code": "packed"},
    "whole loop in one function, 64 lanes": {
        "flags": f"{FUSED},xla_cpu_small_while_loop_byte_threshold=1000000000 {WIDE}",
        "lanes": 64,
        "code": "stage loop",
    },
    "copy insertion by regions": {"flags": f"{FUSED} {WIDE} --xla_cpu_copy_insertion_use_region_analysis=true"},
    "scheduler for memory": {"flags": f"{FUSED} {WIDE} --xla_cpu_scheduler_type=CPU_SCHEDULER_TYPE_MEMORY_OPTIMIZED"},
    "no thread pool inside a kernel": {"flags": f"{FUSED} {WIDE} --xla_cpu_multi_thread_eigen=false"},
    "preset FAST_RUNTIME": {"flags": f"{FUSED} {WIDE} --xla_cpu_opt_preset=CPU_OPT_PRESET_FAST_RUNTIME"},
    "divisions as products with a reciprocal": {"replaced": "division by reciprocal"},
    "profile: no sine, cosine, exponential, tanh": {"replaced": "sin cos exp tanh by a product"},
    "profile: no square root either": {"replaced": "sin cos exp tanh sqrt by a product"},
    "profile: no metrics": {"code": "no metrics"},
    "profile: 1664 lanes": {"lanes": 1664},
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
        spec = json.dumps({**PRODUCT, **changes, "float32": given.float32})
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
    """Says how long it compiled; then, at each line it reads, flies and says how many steps a second."""
    os.environ["XLA_FLAGS"] = spec["flags"]
    import jax
    import numpy as np

    jax.config.update("jax_enable_x64", not spec["float32"])
    if spec["devices"] > 1:
        jax.config.update("jax_num_cpu_devices", spec["devices"])
    replace(spec["replaced"])
    from rvjax.simulation import flight
    from rvjax.simulation.draws import Draws
    from rvjax.simulation.problem import load

    problem, lanes = load(CAMPAIGN), spec["lanes"]
    chunks = max(2 * spec["threads"], 1664 // lanes)
    begin = jax.jit(jax.vmap(partial(flight.begin, problem.loop, problem.metrics)))
    numbers = []
    for chunk in range(chunks):
        _, drawn = Draws.of(problem, np.arange(chunk * lanes, (chunk + 1) * lanes))
        kind = np.float32 if spec["float32"] else np.float64
        device = jax.devices()[chunk % len(jax.devices())]
        drawn = jax.tree.map(lambda x, kind=kind, device=device: jax.device_put(np.asarray(x, kind), device), drawn)
        numbers.append((drawn, begin(drawn)))
    advance = jax.jit(written(spec["code"], problem))
    jax.block_until_ready(numbers)
    started = time.perf_counter()
    for pair in numbers[: spec["devices"]]:
        jax.block_until_ready(advance(*pair, 0, 0))
    print(time.perf_counter() - started, flush=True)
    with ThreadPoolExecutor(spec["threads"]) as threads:
        for _ in sys.stdin:
            flights, started = 0, time.perf_counter()
            while time.perf_counter() - started < 2.0:
                list(threads.map(lambda pair: jax.block_until_ready(advance(*pair, 0, STEPS)), numbers))
                flights += 1
            print(flights * chunks * lanes * STEPS / (time.perf_counter() - started), flush=True)


def replace(what: str) -> None:
    """Replaces functions before the model is imported."""
    names, _, by = what.partition(" by ")
    import jax.numpy as jnp

    from rvjax.physics import elementary, vectors

    def divided(a: Any, b: Any) -> Any:
        return a * (vectors.each(lambda x: 1.0 / x, b) if isinstance(b, vectors._Elementwise) else 1.0 / b)

    cheap: dict[str, Callable[[Any], Any]] = {
        "sin": lambda x: 0.5 * x,
        "cos": lambda x: 1.0 - 0.25 * x,
        "exp": lambda x: 1.0 + 0.5 * x,
        "tanh": lambda x: 0.5 * x,
        "sqrt": lambda x: 0.5 + 0.5 * x,
    }
    for name in names.split():
        if by == "reciprocal":
            vectors._Elementwise.__truediv__ = divided
        else:
            home = elementary if hasattr(elementary, name) else jnp
            setattr(home, name, getattr(jnp, name) if by == "the C library" else cheap[name])


def written(code: str, problem: Any) -> Callable[..., Any]:
    """The advance of a chunk, written in one way or another."""
    import jax
    import jax.numpy as jnp

    from rvjax.simulation import closed_loop, flight, rk4

    def stages(rate: Callable[..., Any], t: Any, y: Any, h: Any, first: Any) -> Any:
        where, weight = jnp.asarray([0.5, 0.5, 1.0], h.dtype), jnp.asarray([2.0, 2.0, 1.0], h.dtype)

        def stage(i: Any, now: Any) -> Any:
            slope, total = now
            slope = rate(t + where[i] * h, rk4.along(y, where[i] * h, slope))
            return slope, rk4.along(total, weight[i], slope)

        return rk4.along(y, h / 6.0, jax.lax.fori_loop(0, 3, stage, (first, first))[1])

    if code == "stage loop":
        rk4.step = stages
    evaluate = jax.jit(partial(closed_loop.evaluate, problem.loop))
    metrics = () if code == "no metrics" else problem.metrics
    step = jax.vmap(partial(flight.step, evaluate, metrics), in_axes=(0, 0, None))

    def advance(drawn: Any, carry: Any, first: Any, last: Any) -> Any:
        carry = carry._replace(accumulators=carry.accumulators[: len(metrics)])
        if code != "packed":
            return jax.lax.fori_loop(first, last, lambda k, now: step(drawn, now, k), carry)
        leaves, structure = jax.tree.flatten(carry)
        numbers, shape = jax.tree.flatten(drawn)
        packed = jnp.stack(numbers)

        def body(k: Any, rows: Any) -> Any:
            now = jax.tree.unflatten(structure, list(rows))
            return jnp.stack(jax.tree.leaves(step(jax.tree.unflatten(shape, list(packed)), now, k)))

        return jax.tree.unflatten(structure, list(jax.lax.fori_loop(first, last, body, jnp.stack(leaves))))

    return advance


if __name__ == "__main__":
    main()
