"""Connection to Dask: the address, the versions, the log."""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false, reportMissingTypeStubs=false
# (Dask says little about its types)

from __future__ import annotations

import logging
from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from typing import Any, cast

from dask import config
from dask.utils import parse_timedelta
from distributed import Client, LocalCluster
from distributed.comm.addressing import parse_host_port

from rvjax.cores import cores
from rvjax.errors import UsageError
from rvjax.execution.executors.waiting import Say, reach, within

ANSWER_S = 120.0
"""How long the scheduler may take to answer."""


def parse(text: str) -> int | str:
    """`local:4` → 4 workers; `tcp://host:8786` → that address. UsageError for anything else."""
    kind, _, rest = text.partition(":")
    if kind == "local" and rest.isdecimal() and 0 < int(rest) <= 1024:
        return int(rest)
    if kind in ("tcp", "tls", "ws", "wss", "ucx") and rest.startswith("//") and len(rest) > 2:
        return text
    raise UsageError(f"--dask {text}: accepted: local:N with N worker processes here, or a scheduler's tcp://host:port")


def try_address(place: str, say: Say) -> None:
    """UsageError where nobody listens at a scheduler's address. `ucx` is left to Dask."""
    kind, _, rest = place.partition("://")
    accepted = "accepted: the address that `dask scheduler` prints"
    try:
        host, port = parse_host_port(rest.partition("/")[0])
    except ValueError as error:
        raise UsageError(f"--dask {place}: {error}; {accepted}") from error
    if kind == "ucx":
        return
    patience = parse_timedelta(config.get("distributed.comm.timeouts.connect", "30s"))
    try:
        reach(host, int(port), patience, say)
    except (OSError, OverflowError) as error:
        raise UsageError(f"--dask {place}: nobody listens there for {patience:g} s: {error}; {accepted}") from error


def check_versions(client: Client, say: Say) -> None:
    """UsageError where a worker or the scheduler has another version of Dask: it may die of what it is sent."""
    found = cast("dict[str, Any]", within(ANSWER_S, client.get_versions, "a Dask worker or the scheduler does not answer", say))
    mine = found["client"]["packages"]
    others = {"the scheduler": found["scheduler"], **found["workers"]}
    differing = [
        f"{who}: {name} {theirs}, here {mine[name]}"
        for who, answer in others.items()
        for name in ("dask", "distributed")
        if (theirs := (answer or {}).get("packages", {}).get(name, mine[name])) != mine[name]
    ]
    if differing:
        raise UsageError("these Dask processes have other versions; install the same rvjax[dask] there\n" + "\n".join(differing))


@contextmanager
def silence() -> Generator[None, None, None]:
    """Silences Dask's log in this process: tracebacks of lost connections, for which rvjax prints messages."""
    names = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] in ("distributed", "tornado")]
    levels = {logger: logger.level for logger in map(logging.getLogger, names)}
    for logger in levels:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in levels.items():
            logger.setLevel(level)


def connect(place: int | str, stack: ExitStack) -> Client:
    if isinstance(place, int):
        threads = max(1, cores() // place)
        local = {"dashboard_address": "127.0.0.1:0", "memory_limit": 0, "silence_logs": "CRITICAL"}
        with config.set({"distributed.worker.profile.enabled": False}):  # 5 % of the speed
            cluster = LocalCluster(n_workers=place, threads_per_worker=threads, processes=True, **local)
        return Client(stack.enter_context(cluster))
    try:
        return Client(place)
    except (OSError, ValueError) as error:
        raise UsageError(f"--dask {place}: {error}; accepted: the address that `dask scheduler` prints") from error
