"""Machine code for this process, from LLVM assembly. Nothing is kept on the disk."""

from __future__ import annotations

import ctypes
import platform
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rvjax.simulation.engines.llvm.text import Kernel, assembly

ENTRY = "fly"
"""Name of the function."""

ALIGNED = 256
"""Bytes of a group's vectors: the longest that are used, and more."""


@dataclass(frozen=True)
class Target:
    """cpu, features: what the code may use, as LLVM names them. lanes: numbers of 8 bytes in a vector register."""

    cpu: str
    features: str
    lanes: int

    @property
    def attributes(self) -> str:
        """As attributes of a function."""
        width = 64 * self.lanes
        return f'"target-cpu"="{self.cpu}" "target-features"="{self.features}" "prefer-vector-width"="{width}"'


@cache
def host() -> Target:
    """This machine."""
    import llvmlite.binding as llvm

    features = llvm.get_host_cpu_features()
    lanes = 8 if features.get("avx512f") else 4 if features.get("avx") else 2
    return Target(llvm.get_host_cpu_name(), features.flatten(), lanes)


@cache
def _started() -> None:
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


class Function:
    """A function of machine code (`text.assembly`). Threads may share it."""

    def __init__(self, kernel: Kernel, target: Target | None = None, level: int = 2) -> None:
        """target: this machine by default. level: of LLVM's optimisation, which changes no bit. 0 is compiled in a third of the
        time and takes 2.5 times as long to fly as 2."""
        import llvmlite.binding as llvm

        _started()
        target = target or host()
        machine = {"AMD64": "x86_64", "arm64": "aarch64"}.get(platform.machine(), platform.machine())
        self._kernel = kernel
        text = assembly(kernel, ENTRY, target.attributes, machine)
        self._linker: Any = llvm.create_lljit_compiler(_machine(target, level), use_jit_link=True)
        self._code: Any = _linked(self._linker, llvm.parse_assembly(text), _machine(target, level), level)
        address = self._code[ENTRY]
        integers = (ctypes.c_int64, ctypes.c_int32, ctypes.c_int32)
        self._call: Any = ctypes.CFUNCTYPE(None, *integers, *(ctypes.c_void_p,) * 3)(address)

    def __call__(self, groups: int, first: int, last: int, *buffers: NDArray[Any]) -> None:
        """Runs groups of lanes from step `first` to step `last`. buffers: numbers, carry, out (`blocks`)."""
        self._call(groups, first, last, *(buffer.ctypes.data for buffer in buffers))


def _machine(target: Target, level: int) -> Any:
    import llvmlite.binding as llvm

    return llvm.Target.from_default_triple().create_target_machine(
        cpu=target.cpu, features=target.features, opt=level, codemodel="small", reloc="pic"
    )


def _linked(linker: Any, module: Any, machine: Any, level: int) -> Any:
    """Symbol → address. LLVM's JITLink puts code and its constants into one block: code reaches only what is within 2 GB, and
    its older linker ends the process where they lie apart."""
    import llvmlite.binding as llvm

    if level:
        options = llvm.create_pipeline_tuning_options(speed_level=level)
        options.slp_vectorization = options.loop_vectorization = False
        builder = llvm.create_pass_builder(machine, options)
        builder.getModulePassManager().run(module, builder)
    return llvm.JITLibraryBuilder().add_ir(module).export_symbol(ENTRY).add_current_process().link(linker, ENTRY)


def blocks(groups: int, leaves: int, lanes: int, kind: Any) -> NDArray[Any]:
    """(groups, leaves, lanes) memory that begins at a whole vector register."""
    size = np.dtype(kind).itemsize
    raw = np.zeros(groups * leaves * lanes + ALIGNED // size, dtype=kind)
    first = (-raw.ctypes.data % ALIGNED) // size
    return raw[first : first + groups * leaves * lanes].reshape(groups, leaves, lanes)


def packed(rows: NDArray[Any], lanes: int) -> NDArray[Any]:
    """(groups, leaves, lanes) memory with the numbers of rows (leaves, samples). The first samples fill up the last group."""
    leaves, samples = rows.shape
    groups = -(-samples // lanes)
    memory = blocks(groups, leaves, lanes, rows.dtype)
    whole = np.take(rows, np.arange(groups * lanes) % samples, axis=1)
    memory[:] = whole.reshape(leaves, groups, lanes).transpose(1, 0, 2)
    return memory


def unpacked(memory: NDArray[Any], samples: int) -> NDArray[Any]:
    """(leaves, samples) numbers of memory (groups, leaves, lanes)."""
    return memory.transpose(1, 0, 2).reshape(memory.shape[1], -1)[:, :samples]
