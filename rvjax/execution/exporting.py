"""Export: the samples table of a run, or the trace of a sample, as a file for another tool.

A trace is the kept one, or flown again with the same rows, bit for bit; JAX is needed only to fly again.
"""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false
# (pandas says little about its types)

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from rvjax.analysis.sample_values import numbers, port
from rvjax.analysis.verdicts.folders import campaign_of
from rvjax.campaign import Spec
from rvjax.campaign.trace_retention import steps_per_row
from rvjax.columns import AXES
from rvjax.components.extras import lacking
from rvjax.errors import UsageError
from rvjax.export import ccsds, documents, viewers
from rvjax.export.exported import Exported, Numbers
from rvjax.export.inertial import Absolute, absolute, orbit_plane
from rvjax.places import Place
from rvjax.run_folder import RunFolder, atomic_files
from rvjax.run_folder.samples_table import KEYS

TABLES = (".csv", ".json", ".mat")
"""Formats of the samples table and of a trace; all others are of a trace."""

PACKAGES = {".rrd": ("rerun-sdk", "rerun"), ".mcap": ("mcap", "mcap")}
"""The package that a format needs, and the extra that installs it."""

MESSAGES = (".oem", ".aem")
"""CCSDS messages."""

FORMATS = (*TABLES, *MESSAGES, *PACKAGES)

BODIES = ("pursuer", "target")


@dataclass(frozen=True)
class Options:
    """every: flies the sample again with a row for every `every`-th step. epoch: of t = 0, ISO 8601 in UTC; None: J2000. plane:
    right ascension of the ascending node, inclination, argument of perigee [deg], of the orbit."""

    every: int | None = None
    epoch: str | None = None
    plane: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Flight:
    """A trace with what its sample drew. row: of the samples table."""

    trace: Exported
    spec: Spec
    row: Mapping[str, Any]
    options: Options = field(default_factory=Options)

    @property
    def port(self) -> Numbers:
        """δ, in T [m]."""
        return np.array(port(self.spec, self.row))

    @property
    def finite(self) -> Exported:
        """The rows before the flight diverged."""
        motion = self.trace.frame[[form.format(axis) for form in _MOTION for axis in AXES]].to_numpy(dtype=float)
        return self.trace.only(np.asarray(np.isfinite(motion).all(axis=1)))

    @property
    def absolute(self) -> Absolute:
        """The inertial motion."""
        attitude = numbers(self.spec.target.attitude_mrp, "target.attitude_mrp", self.row)
        return absolute(self.finite, np.array(attitude), self.port, orbit_plane(*self.options.plane))


_MOTION = (
    *("rho_{}_m", "nu_{}_m_s", "sigma_{}", "omega_{}_rad_s"),
    *("target_r_{}_m", "target_v_{}_m_s", "target_w_{}_rad_s"),
)


def export(folder: str | Place, to: str | Path, sample: int | None = None, options: Options | None = None) -> list[Path]:
    """Writes the samples table of a run, or the trace of a sample, in the format of the suffix of `to`; returns the files.

    .csv, .json, .mat: tables, with units and descriptions. .oem, .aem: CCSDS messages of the pursuer in `to` and of the target
    beside it. .rrd, .mcap: recordings of Rerun and Foxglove. Errors: UsageError where the format is unknown or does not fit, a
    package is missing, the sample is not there, or the file cannot be written; FolderError where the folder is damaged or the
    flight cannot be repeated.
    """
    path, chosen = Path(to), options or Options()
    suffix = path.suffix
    _check(path, sample, chosen)
    opened = RunFolder.open(folder)
    spec = campaign_of(opened)
    if sample is None:
        return _write(path, _tables(path, _samples(opened)))
    flight = _flight(opened, spec, sample, chosen)
    if suffix in TABLES:
        return _write(path, _tables(path, flight.trace))
    if suffix in PACKAGES:
        return _record(path, flight)
    return _write(path, _messages(path, flight))


def _check(path: Path, sample: int | None, options: Options) -> None:
    """Refuses before anything is read or flown."""
    suffix, named = path.suffix, ", ".join(FORMATS)
    if suffix not in FORMATS:
        raise UsageError(f"{path}: unknown format; accepted: a name that ends in {named}")
    if sample is None and suffix not in TABLES:
        raise UsageError(f"{path}: {suffix} holds the flight of a sample; accepted: --sample K, or a name in {', '.join(TABLES)}")
    if sample is None and options.every is not None:
        raise UsageError("--every is of a trace; accepted: with --sample K")
    if suffix not in MESSAGES and (options.epoch is not None or any(options.plane)):
        raise UsageError(f"{path}: {suffix} has no date and no orbit plane; accepted: --epoch and --plane with .oem and .aem")
    if not all(np.isfinite(options.plane)):
        raise UsageError("--plane: not finite; accepted: three angles in degrees")
    ccsds.Epoch.of(options.epoch)
    if suffix in PACKAGES:
        package, extra = PACKAGES[suffix]
        if lack := lacking(package):
            raise UsageError(f"{path}: {suffix} needs {lack}; accepted: pip install 'rvjax[{extra}]'")
    for name in _files(path):
        atomic_files.check_file(name)


def _files(path: Path) -> tuple[Path, ...]:
    """The files of an export: a table as CSV has a companion, and of CCSDS messages there is one for each of `BODIES`."""
    if path.suffix == ".csv":
        return path, path.with_suffix(".columns.csv")
    return (path, path.with_name(f"{path.stem}-target{path.suffix}")) if path.suffix in MESSAGES else (path,)


def _samples(folder: RunFolder) -> Exported:
    table = folder.samples()
    return Exported("samples", table.frame, KEYS | table.columns, _facts(folder))


def _facts(folder: RunFolder) -> dict[str, str | int]:
    known = {name: folder.identity[name] for name in ("seed", "rvjax", "precision") if name in folder.identity}
    return {"campaign": folder.name, "requested": folder.requested, "identity": folder.digest, **known}


def _flight(folder: RunFolder, spec: Spec, sample: int, options: Options) -> Flight:
    """The kept trace, or the sample flown again with the same rows, or with those of `every`."""
    if options.every is None and sample in folder.trace_samples():
        chunks, _ = folder.chunks.holding(np.array([sample]))
        (frame,) = (frame for _, frame, _ in folder.tables(chunks.number.tolist()))
        row: dict[str, Any] = frame.set_index("sample", drop=False).loc[sample].to_dict()
        table = folder.trace_table(sample)
    else:
        from rvjax.execution.replay import replay

        frame, columns, row = replay(folder.path, sample, options.every or steps_per_row(spec.horizon.steps))
        table = frame, columns
    facts = _facts(folder) | {"sample": sample, "outcome": str(row["outcome"])}
    return Flight(Exported("trace", *table, facts), spec, row, options)


def _tables(path: Path, table: Exported) -> dict[Path, Iterable[bytes]]:
    if path.suffix == ".csv":
        return dict(zip(_files(path), documents.csv(table), strict=True))
    return {path: documents.document(table) if path.suffix == ".json" else documents.mat(table)}


def _messages(path: Path, flight: Flight) -> dict[Path, Iterable[bytes]]:
    """A message of each body."""
    motion, epoch, spec = flight.absolute, ccsds.Epoch.of(flight.options.epoch), flight.spec
    (node, inclination, perigee), facts = flight.options.plane, flight.trace.facts
    lost = len(flight.trace.frame) - len(motion.t)
    comments = [
        f"Sample {facts['sample']} of the campaign {spec.name}, flown by rvjax; outcome: {facts['outcome']}.",
        epoch.comment,
        f"The orbit plane as chosen for this file: right ascension of the ascending node {node:g} deg, inclination "
        f"{inclination:g} deg, argument of perigee {perigee:g} deg; the campaign gives none.",
        "Position and velocity of the pursuer are those of its centre of mass. Frames of the bodies: as in the campaign.",
        *([f"The flight diverged: its last {lost} rows are left out."] if lost else []),
    ]
    objects = {body: f"{spec.name.upper()}-{body.upper()}" for body in BODIES}
    message = ccsds.Message(epoch, objects, comments, datetime.now(UTC))
    write: Callable[..., str] = message.oem if path.suffix == ".oem" else message.aem
    parts = zip(_files(path), BODIES, strict=True)
    return {name: [write(body, motion.t, getattr(motion, body)).encode("ascii")] for name, body in parts}


def _record(path: Path, flight: Flight) -> list[Path]:
    write = viewers.write_rerun if path.suffix == ".rrd" else viewers.write_mcap
    try:
        write(path, flight.finite, flight.port)
    except OSError as error:
        raise UsageError(f"{path}: cannot be written ({error.strerror}); accepted: a path that can be written") from error
    return [path]


def _write(path: Path, files: Mapping[Path, Iterable[bytes]]) -> list[Path]:
    try:
        for name, parts in files.items():
            with name.open("wb") as file:
                file.writelines(parts)
    except OSError as error:
        raise UsageError(f"{path}: cannot be written ({error.strerror}); accepted: a path that can be written") from error
    return [*files]
