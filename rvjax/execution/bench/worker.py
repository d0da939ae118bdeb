"""A way of flying in a separate process: `python -m rvjax.execution.bench.worker '{"way": …}'`.

It prepares and reports that. It flies for every line it reads and answers with a JSON document on a line. At the end of its
input it writes its results and reports its peak memory.
"""

from __future__ import annotations

import json
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

MIN_S = 1.5
"""A fast way repeats its flight until this time has passed; the mean is the time of a flight."""


def main(spec: dict[str, Any]) -> None:
    """spec: way, campaign, samples, steps, precision, start (file of the carry at t = 0), result (file to write), yardsticks."""
    from rvjax.execution.bench.workload import RVJAX, UnavailableError, case, save, yardsticks
    from rvjax.simulation.jax_config import configure

    ours = RVJAX.get(spec["way"])
    if ours is not None:
        configure(spec["precision"])
    else:  # JAX with its default settings
        import jax

        jax.config.update("jax_enable_x64", spec["precision"] == "float64")
    engine = ours.engine if ours is not None else "xla"
    flown = case(spec["campaign"], spec["samples"], spec["steps"], spec["precision"], spec["start"], engine)
    started = time.perf_counter()
    try:
        if ours is not None:
            from rvjax.execution.bench import own_flight

            fly = own_flight.prepare(flown, ours.threads)
        else:
            fly = yardsticks(Path(spec["yardsticks"]))[spec["way"]].prepare(flown)
    except UnavailableError as error:
        say(unavailable=str(error))
        return
    say(ready=time.perf_counter() - started)
    result = fly()
    for line in sys.stdin:
        if line.strip() == "fly":
            say(seconds=timed(fly))
    save(spec["result"], result)
    say(peak_memory_mb=peak_mb())


def timed(fly: Callable[[], Any]) -> float:
    """Seconds of a flight, results included."""
    flights, started = 0, time.perf_counter()
    while flights == 0 or time.perf_counter() - started < MIN_S:
        fly()
        flights += 1
    return (time.perf_counter() - started) / flights


def peak_mb() -> float:
    """Peak memory of this process [MB], since `forget_peak` where that was called."""
    try:
        for line in Path("/proc/self/status").read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024 / 1e6
    except OSError:
        pass
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6


def forget_peak() -> None:
    """Restarts the peak memory, where the system can do that (Linux)."""
    try:
        Path("/proc/self/clear_refs").write_bytes(b"5")
    except OSError:
        return


def say(**answer: Any) -> None:
    """Prints a document on a line."""
    print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
