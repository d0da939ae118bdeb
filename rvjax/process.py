"""The one place where this process is configured for flying: before JAX starts its backend, or not at all.

Settings (part of a run's identity):
    precision      float64 or float32 for everything that flies
    compile cache  programs compiled before are read from a private folder of the user; changes no bits
    XLA_FLAGS      multi-output fusion, without which XLA's CPU fusion copies shared terms of the equations over and over
"""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false, reportMissingTypeStubs=false
# (JAX and pandas say little about their types)

from __future__ import annotations

import contextlib
import os
import platform
import stat
from pathlib import Path
from typing import Literal

import platformdirs

from rvjax.errors import UsageError

Precision = Literal["float64", "float32"]

XLA_FLAGS = ("--xla_backend_extra_options=xla_cpu_use_multi_output_fusion=true",)


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def configure(precision: Precision = "float64") -> None:
    """Configures JAX for flying, without starting it. Call it before anything in the process uses JAX; the precision can be
    changed later, the compiler settings cannot.

    Errors: UsageError if JAX runs already, without the compiler settings.
    """
    flags = os.environ.get("XLA_FLAGS", "").split()
    lacking = [flag for flag in XLA_FLAGS if flag not in flags]
    import jax

    if lacking and _running():
        raise UsageError(
            "JAX is already running, without the compiler settings that campaigns fly with; "
            "call rvjax.configure() before anything uses JAX, or use a new process"
        )
    os.environ["XLA_FLAGS"] = " ".join(flags + lacking)
    jax.config.update("jax_enable_x64", precision == "float64")
    cache = _private_cache()
    if cache is not None:
        jax.config.update("jax_compilation_cache_dir", str(cache))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.5)
        jax.config.update("jax_persistent_cache_min_entry_size_bytes", 0)


def _running() -> bool:
    """Whether JAX's backend has started: from then on its number of devices cannot be set, not even to what it is."""
    import jax

    try:
        now = jax.config.jax_num_cpu_devices  # pyright: ignore[reportAttributeAccessIssue]
        jax.config.update("jax_num_cpu_devices", now)
    except RuntimeError:
        return True
    return False


def _private_cache() -> Path | None:
    """Where compiled programs are kept between runs: a folder that only this user can read or write, or None.

    What lies there is executable code, so a folder that somebody else could write is not used.
    """
    folder = Path(platformdirs.user_cache_dir("rvjax")) / "compiled"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = folder.lstat()
    except OSError:
        return None
    private = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o077
    return folder if private else None


def settings() -> dict[str, object]:
    """What of the process decides about bits: goes into the identity of a run."""
    import jax

    return {
        "precision": "float64" if jax.config.read("jax_enable_x64") else "float32",
        "device": jax.devices()[0].platform,
        "device_kind": jax.devices()[0].device_kind,
        "processor": _processor(),
        "xla_flags": os.environ.get("XLA_FLAGS", ""),
    }


def _processor() -> str:
    """The model of the CPU: the compiler writes other code for another one."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def devices() -> list[str]:
    """JAX's devices by name. Starts JAX."""
    import jax

    return [str(device) for device in jax.devices()]
