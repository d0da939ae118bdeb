"""Machine code in memory: it reaches its constants wherever the process has put its other memory."""

from __future__ import annotations

import mmap

import numpy as np

from tests.engines.machine import machine


def test_code_and_constants_lie_together() -> None:
    """Functions with constants, while the free places of the process's memory are filled and others of a gigabyte are taken: code
    and its constants may not be 2 GB apart. Kills: a memory manager that puts each section where there is room; LLVM then ends
    the process."""
    chance, kept = np.random.default_rng(3), list[mmap.mmap]()
    given = np.arange(10.0)
    for i in range(60):
        kept.append(mmap.mmap(-1, int(chance.choice([4096, 8192, 65536, 1 << 30]))))
        if i % 3 == 0:
            kept.pop(int(chance.integers(len(kept)))).close()
        count = int(chance.choice([3, 60]))
        results = machine(lambda x, i=i, count=count: [x * (k + 0.1 * i) for k in range(count)], given)
        assert np.array_equal(results[-1], given * (count - 1 + 0.1 * i))
