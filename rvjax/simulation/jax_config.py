"""Configuration of the process for flights, before JAX starts its backend.

Settings (part of the identity of a run, except the cache):
    precision      float64 or float32, of all flights
    compile cache  compiled programs are kept in a private folder of the user; changes no bit
    XLA_FLAGS      `SETTINGS`: faster code for a CPU, measured in docs/performance.md

A setting of the user in XLA_FLAGS stays. A setting that this version of XLA does not know is left out, with a warning.
"""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false, reportMissingTypeStubs=false
# (JAX and pandas say little about their types)

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import stat
import subprocess
import sys
import warnings
from collections.abc import Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Literal

import platformdirs

from rvjax.errors import IncompleteError, UsageError

Precision = Literal["float64", "float32"]

EXTRA = "xla_backend_extra_options"
"""The XLA flag that holds a list of further options, `key=value,key=value`; an unknown key is ignored."""

SETTINGS: tuple[tuple[str, str], ...] = (
    (EXTRA, "xla_cpu_use_multi_output_fusion=true"),  # else XLA copies shared terms of the equations over and over
    ("xla_cpu_prefer_vector_width", "512"),  # registers of 512 bits where the processor has them
)
"""XLA flags of all flights."""

PROBE_S = 300.0
"""How long JAX may take to start in another process."""

_PROBE = """
try:
    from jaxlib import xla_client
    xla_client.CompileOptions()
except (ImportError, AttributeError):
    import jax
    jax.devices("cpu")
"""
"""Makes XLA read its flags, in 0.1 s; all of JAX takes 0.7 s. XLA ends the process at an unknown flag."""


class SettingsWarning(UserWarning):
    """A setting for faster flights is not available."""


def configure(precision: Precision = "float64", threads: int | None = None) -> None:
    """Configures JAX for flights, without starting it. Call it before the process uses JAX. The precision can be changed later,
    the compiler settings cannot.

    threads: how many chunks fly in parallel in this process; all cores by default. Set it if several processes share the machine:
    more XLA threads than that cost 15 % with two processes on two cores. It changes no bit.

    Errors: UsageError if JAX already runs with other compiler settings, or if XLA does not know a flag in XLA_FLAGS.
    Warnings: SettingsWarning for a setting that this version of XLA does not know.
    """
    flags = os.environ.get("XLA_FLAGS", "")
    wanted_flags = _settled(flags)
    if threads is not None:
        os.environ.setdefault("NPROC", str(threads))  # XLA's CPU client reads the number of cores from it
    import jax

    if wanted_flags != flags:
        if _running():
            raise UsageError(
                f"JAX is already running with XLA_FLAGS={flags!r}, campaigns fly with {wanted_flags!r}; "
                "call rvjax.configure() before anything uses JAX, or use a new process"
            )
        os.environ["XLA_FLAGS"] = wanted_flags
    jax.config.update("jax_enable_x64", precision == "float64")
    folder = _private_cache()
    if folder is not None:
        jax.config.update("jax_compilation_cache_dir", str(folder))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.1)
        jax.config.update("jax_persistent_cache_min_entry_size_bytes", 0)


@cache
def _settled(flags: str) -> str:
    """XLA_FLAGS with each of our settings that the user has not set and that XLA knows."""
    if flags.strip() and not flags.lstrip().startswith("--"):
        warnings.warn(f"XLA_FLAGS={flags!r} names a file of flags, which is not changed", SettingsWarning, stacklevel=3)
        return flags
    if (wanted := with_settings(flags, SETTINGS)) == flags or _known(wanted):
        return wanted
    if not _known(flags):
        raise UsageError(
            f"XLA_FLAGS={flags!r}: XLA of jaxlib {version('jaxlib')} does not know all of these; accepted: flags of this XLA"
        )
    kept = tuple(setting for setting in SETTINGS if _known(with_settings(flags, (setting,))))
    refused = ", ".join(name for name, _ in SETTINGS if name not in dict(kept))
    message = f"XLA of jaxlib {version('jaxlib')} does not know {refused}: flights may be slower and differ in the last digits"
    warnings.warn(message, SettingsWarning, stacklevel=3)
    return with_settings(flags, kept)


def with_settings(flags: str, settings: Sequence[tuple[str, str]]) -> str:
    """XLA flags with these (name, value) added; a flag that is already set keeps its value."""
    parts = flags.split()
    for name, value in settings:
        start = f"--{name}="
        position = next((index for index, part in enumerate(parts) if part.startswith(start)), None)
        if position is None:
            parts.append(start + value)
        elif name == EXTRA and value.partition("=")[0] not in parts[position]:
            parts[position] += f",{value}"
    return " ".join(parts)


def _known(flags: str) -> bool:
    """Whether XLA knows these flags. A file in the cache records a yes."""
    folder = _private_cache()
    name = hashlib.sha256(f"{version('jaxlib')} {flags}".encode()).hexdigest()[:16]
    known = None if folder is None else folder / f"flags-{name}"
    if known is not None and known.exists():
        return True
    environment = {**os.environ, "XLA_FLAGS": flags}
    try:
        done = subprocess.run(
            [sys.executable, "-c", _PROBE],
            env=environment,
            capture_output=True,
            check=False,
            timeout=PROBE_S,
            stdin=subprocess.DEVNULL,
        )
    except subprocess.TimeoutExpired as error:
        raise IncompleteError(
            f"JAX has not started in {PROBE_S:g} s in a process that tries XLA_FLAGS={flags!r}; look whether its device is busy, "
            "then give the same command again"
        ) from error
    if done.returncode == 0 and known is not None:
        with contextlib.suppress(OSError):
            known.touch()
    return done.returncode == 0


def _running() -> bool:
    """Whether JAX's backend has started: it then refuses another number of devices, which is reset at once."""
    import jax

    now = jax.config.jax_num_cpu_devices  # pyright: ignore[reportAttributeAccessIssue]
    try:
        jax.config.update("jax_num_cpu_devices", now + 1 if now > 0 else 2)
    except RuntimeError:
        return True
    jax.config.update("jax_num_cpu_devices", now)
    return False


def _private_cache() -> Path | None:
    """The folder of compiled programs, which only this user can read or write; None without such a folder.

    It holds executable code, so a folder that others can write is not used.
    """
    folder = Path(platformdirs.user_cache_dir("rvjax")) / "compiled"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = folder.lstat()
    except OSError:
        return None
    private = stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and not status.st_mode & 0o077
    return folder if private else None


def precision() -> Precision:
    """The precision of the flights now."""
    import jax

    return "float64" if jax.config.read("jax_enable_x64") else "float32"


def settings() -> dict[str, object]:
    """The settings of the process that affect the bits of results: part of the identity of a run."""
    import jax

    return {
        "precision": precision(),
        "device": jax.devices()[0].platform,
        "device_kind": jax.devices()[0].device_kind,
        "processor": _processor(),
        "xla_flags": os.environ.get("XLA_FLAGS", ""),
    }


def _processor() -> str:
    """The model of the CPU: the compiled code depends on it."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def devices() -> list[str]:
    """JAX's devices by name. Starts JAX."""
    import jax

    return [str(device) for device in jax.devices()]
