"""RunFolder: chunks of samples come in, one table comes out; the manifest says what belongs to it.

A file counts only once it is in the manifest, and only while its SHA-256 matches. What a stopped run leaves besides
(temporary files, files that did not reach the manifest) is ignored, and flown or written again. One process writes.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import pandas as pd
import pyarrow as pa

from rvjax.columns import Column
from rvjax.errors import FolderError, IncompleteError, UsageError
from rvjax.results import files
from rvjax.results.manifest import NAME, Chunk, Manifest, differences, json_bytes, plain
from rvjax.results.parquet import decode, encode
from rvjax.results.samples import KEYS, OUTCOMES, Account, Samples, check_chunk, join

CAMPAIGN = "campaign.yaml"
"""The campaign as it was given, in a run folder."""

FLUSH_S = 1.0
"""The manifest is rewritten at most this often while chunks arrive."""


class RunFolder:
    """A run folder, open for reading, and for writing by one process at a time; leaving the context closes it.

    Get one from `create`, `open` or `resume`. `path` is the folder.
    """

    def __init__(self, path: Path, manifest: Manifest) -> None:
        self.path = path
        self._manifest = manifest
        self._lock: int | None = None
        self._dirty = False
        self._flushed = time.monotonic()

    @classmethod
    def create(
        cls,
        path: str | Path,
        identity: Mapping[str, Any],
        provenance: Mapping[str, Any],
        campaign_text: str,
        samples: int,
        name: str,
    ) -> Self:
        """Makes a new run folder with the campaign as given and an empty manifest.

        `identity`: everything the flights are a function of, `provenance`: what else is worth knowing; both JSON.
        FolderError where something is there already or the place cannot be written, UsageError where another process
        writes there.
        """
        root = Path(path)
        with files.explained(root):
            root.mkdir(parents=True, exist_ok=True)
            files.sync(root.parent)
        folder = cls(root, Manifest(name=name, samples=samples, identity=plain(identity), provenance=plain(provenance)))
        folder._lock = files.lock(root)
        try:
            with files.explained(root):
                if any(entry.name != CAMPAIGN and not files.is_temporary(entry) for entry in root.iterdir()):
                    raise FolderError(f"{root}: there already and not empty; resume it, or choose another with --out")
            files.sweep(root)
            files.replace(root / CAMPAIGN, campaign_text.encode())
            folder._manifest.files[CAMPAIGN] = files.sha256(campaign_text.encode())
            folder._dirty = True
            folder.flush()
        except BaseException:
            folder._release()
            raise
        return folder

    @classmethod
    def open(cls, path: str | Path) -> Self:
        """Opens a run folder.

        FolderError where it is none or its manifest is damaged. Other files are verified as they are read.
        """
        return cls(Path(path), Manifest.read(Path(path)))

    @classmethod
    def resume(
        cls,
        path: str | Path,
        identity: Mapping[str, Any],
        provenance: Mapping[str, Any],
        campaign_text: str,
        samples: int,
        name: str,
        lanes: int,
    ) -> Self:
        """Opens a run folder to fly what it lacks of `samples`.

        What is not part of the identity (name, requirements, provenance) is from now on what is given here. Damaged files
        go to `quarantine/`; their chunks count as missing. Where `samples` grows, so does a last chunk of fewer than
        `lanes` samples, which was cut short.
        FolderError where the identity differs (saying in what), UsageError where more samples were requested before or
        another process writes there.
        """
        folder = cls.open(path)
        if differing := differences(folder.identity, identity):
            what = "\n".join(differing)
            raise FolderError(f"{path}: belongs to another run; choose another with --out. They differ in\n{what}")
        if samples < folder.requested:
            raise UsageError(
                f"{path}: {folder.requested} samples were requested before, now {samples}; "
                f"go on with --samples {folder.requested} or more, or choose another folder with --out"
            )
        folder._claim()
        try:
            folder._set_aside(samples, lanes)
            folder._describe(name, provenance, campaign_text)
            folder.flush()
        except BaseException:
            folder._release()
            raise
        return folder

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Writes what the manifest still lacks on the disk, and lets other processes write."""
        try:
            self.flush()
        finally:
            self._release()

    def flush(self) -> None:
        """Rewrites the manifest atomically if something was added since."""
        if self._dirty:
            files.replace(self.path / NAME, self._manifest.encode())
            self._dirty, self._flushed = False, time.monotonic()

    @property
    def name(self) -> str:
        """The campaign's name."""
        return self._manifest.name

    @property
    def identity(self) -> dict[str, Any]:
        """Everything the flights are a function of."""
        return self._manifest.identity

    @property
    def provenance(self) -> dict[str, Any]:
        """When, where and how the run was started."""
        return self._manifest.provenance

    @property
    def requested(self) -> int:
        """The number of samples asked for."""
        return self._manifest.samples

    @property
    def chunks(self) -> tuple[Chunk, ...]:
        """The finished chunks in order, each with its file and SHA-256."""
        return tuple(sorted(self._manifest.chunks, key=lambda entry: entry.chunk))

    def missing(self, chunk_count: int) -> list[int]:
        """The chunks of 0 .. chunk_count - 1 that are not finished."""
        return sorted(set(range(chunk_count)) - {entry.chunk for entry in self.chunks})

    def campaign_text(self) -> str:
        """The campaign file as it was given, verified."""
        return self._verified(CAMPAIGN).decode()

    def commit(self, chunk: int, table: pd.DataFrame | pa.Table, columns: Mapping[str, Column]) -> None:
        """Adds a finished chunk: verified on the disk when this returns, in the manifest within a second or on closing.

        `table`: one row per sample, consecutive numbers, every column in `columns` (except `sample`, `outcome`).
        ValueError where the table is not such a table, FolderError where the chunk is there with other contents,
        IncompleteError where the disk refuses; what was committed before stays.
        """
        sample = np.asarray(table["sample"])
        check_chunk(chunk, sample, np.asarray(table["outcome"]))
        name = f"samples/{chunk:05d}.parquet"
        digest = self._publish(name, encode(table, {**KEYS, **columns}))
        if self._manifest.find(chunk) is None:
            first = int(sample[0])
            self._manifest.chunks.append(Chunk(chunk=chunk, file=name, first=first, count=sample.size, sha256=digest))
        self._changed()

    def samples(self) -> Samples:
        """All samples of the finished chunks, verified, in ascending order.

        FolderError where a file is missing or damaged, or chunks contradict each other. IncompleteError where no
        chunk is finished.
        """
        if not self.chunks:
            raise IncompleteError(f"{self.path}: no chunk is finished yet; fly it with `rvjax run` and the same --out")
        return join({entry.file: self._table(entry.file) for entry in self.chunks}, self.requested)

    def account(self) -> Account:
        """How many of the requested samples ended how, and how many are missing."""
        counts: dict[str, int] = self.samples().frame["outcome"].value_counts().to_dict() if self.chunks else {}
        captured, not_settled, not_finite = (int(counts.get(outcome, 0)) for outcome in OUTCOMES)
        missing = self.requested - sum(entry.count for entry in self.chunks)
        return Account(self.requested, captured, not_settled, not_finite, missing)

    def write_trace(self, sample: int, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Keeps one sample's flight, one row per step, every column in `columns`."""
        self._record(_trace(sample), encode(frame, columns))

    def drop_traces(self, samples: Iterable[int]) -> None:
        """Removes kept flights."""
        self._claim()
        self._drop({_trace(sample) for sample in samples})

    def traces(self) -> dict[int, pd.DataFrame]:
        """The kept flights by sample, verified."""
        return {int(Path(name).stem.removeprefix("sample-")): table for name, table in self._recorded("traces")}

    def write_envelope(self, chunk: int, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Keeps a chunk's thinned histories, one row per sample and instant, every column in `columns`.

        To be called before the chunk is committed, so that no finished chunk lacks its histories.
        """
        self._record(_envelope(chunk), encode(frame, {**KEYS, **columns}))

    def envelopes(self) -> pd.DataFrame:
        """The thinned histories of all chunks, verified; empty where none was kept."""
        tables = [table for _, table in self._recorded("envelopes")]
        return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()

    def write_summary(self, summary: Mapping[str, Any]) -> Path:
        """Writes `summary.json`, strict JSON; numbers that are not finite become null."""
        return self.write_bytes("summary.json", json_bytes(summary))

    def write_text(self, name: str, text: str) -> Path:
        """Writes a text file (UTF-8) into the folder, atomically; bytes of a path that are no UTF-8 are spelt out."""
        return self.write_bytes(name, text.encode(errors="backslashreplace"))

    def write_bytes(self, name: str, data: bytes) -> Path:
        """Writes a file into the folder, atomically, over an older one; returns its path.

        For what can be made again from the data: it is not in the manifest.
        FolderError where `name` leads out of the folder or names data.
        """
        path = files.inside(self.path, name)
        if path.relative_to(self.path).parts[0] in {"samples", "traces", "envelopes", "quarantine", CAMPAIGN, NAME}:
            raise FolderError(f"{path}: holds data of the run, which is never overwritten; accepted: another name")
        files.replace(path, data)
        return path

    def verify(self) -> None:
        """Reads every file of the manifest; FolderError names all that are missing or damaged."""
        if complaints := [complaint for name in self._digests() if (complaint := self._complaint(name))]:
            raise FolderError("\n".join(complaints))

    def _digests(self) -> dict[str, str]:
        return {entry.file: entry.sha256 for entry in self.chunks} | self._manifest.files

    def _complaint(self, name: str) -> str:
        """What is wrong with a file of the manifest; empty where nothing is."""
        try:
            self._verified(name)
        except FolderError as error:
            return str(error)
        return ""

    def _verified(self, name: str) -> bytes:
        """The bytes of a file of the manifest; FolderError where they are not what was committed."""
        path, digest = files.inside(self.path, name), self._digests()[name]
        advice = "`rvjax run` with the same --out sets it aside and flies it again"
        with files.explained(path):
            present = path.is_file()
        if not present:
            raise FolderError(f"{path}: missing, but SHA-256 {digest} was committed; {advice}")
        data = files.read(path)
        if (found := files.sha256(data)) != digest:
            raise FolderError(f"{path}: damaged or edited: SHA-256 {digest} was committed, {found} is there; {advice}")
        return data

    def _table(self, name: str) -> tuple[pd.DataFrame, dict[str, Column]]:
        data = self._verified(name)
        try:
            return decode(data)
        except (pa.ArrowException, OSError) as error:
            raise FolderError(f"{self.path / name}: not a table ({error}); fly the campaign again") from error

    def _recorded(self, part: str) -> list[tuple[str, pd.DataFrame]]:
        return [(name, self._table(name)[0]) for name in sorted(self._manifest.files) if name.startswith(f"{part}/")]

    def _record(self, name: str, data: bytes) -> None:
        self._manifest.files[name] = self._publish(name, data)
        self._changed()

    def _publish(self, name: str, data: bytes) -> str:
        """Puts a file of data in its place, where the first writer wins; its SHA-256.

        A file that is there and not in the manifest is what a stopped run left: it gives way.
        """
        self._claim()
        path, digest = files.inside(self.path, name), files.sha256(data)
        if not files.publish(path, data):
            if name in self._digests():
                raise FolderError(
                    f"{path}: committed with SHA-256 {self._digests()[name]}, flown again it has {digest}; the same "
                    "identity must give the same bytes. Choose another folder with --out, and please report this"
                )
            self._quarantine(name)
            files.publish(path, data)
        return digest

    def _changed(self) -> None:
        self._dirty = True
        if time.monotonic() - self._flushed >= FLUSH_S:
            self.flush()

    def _claim(self) -> None:
        """Makes this process the one that writes, from the manifest as it is now."""
        if self._lock is None:
            self._lock = files.lock(self.path)
            self._manifest = Manifest.read(self.path)
            files.sweep(self.path)

    def _release(self) -> None:
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def _set_aside(self, requested: int, lanes: int) -> None:
        """Takes out of the manifest and of the way what has to be flown again."""
        manifest = self._manifest
        bad = {name for name in self._digests() if name != CAMPAIGN and self._complaint(name)}
        short: set[str] = set()
        for entry in self.chunks:
            of_chunk = {entry.file, _envelope(entry.chunk)}
            if of_chunk & bad:
                bad |= of_chunk
            elif requested > manifest.samples and entry.count < lanes:
                short |= of_chunk
        for name in bad:
            self._quarantine(name)
        self._forget(bad)
        self._drop(short)
        manifest.samples = requested
        self._dirty = True

    def _describe(self, name: str, provenance: Mapping[str, Any], campaign_text: str) -> None:
        """What the folder says of itself, as of now; the first start is kept."""
        started = {key: self.provenance[key] for key in ("started",) if key in self.provenance}
        with files.explained(self.path):
            files.replace(self.path / CAMPAIGN, campaign_text.encode())
        self._manifest.files[CAMPAIGN] = files.sha256(campaign_text.encode())
        self._manifest.provenance = {**plain(provenance), **started}
        self._manifest.name = name

    def _forget(self, names: set[str]) -> None:
        manifest = self._manifest
        manifest.chunks = [entry for entry in manifest.chunks if entry.file not in names]
        manifest.files = {name: digest for name, digest in manifest.files.items() if name not in names}

    def _drop(self, names: set[str]) -> None:
        """Removes files of data, first from the manifest."""
        self._forget(names)
        self._dirty = True
        self.flush()
        for name in names:
            with files.explained(self.path / name):
                files.inside(self.path, name).unlink(missing_ok=True)

    def _quarantine(self, name: str) -> None:
        """Moves a file of data out of the way, under a name that is still free."""
        source, place = files.inside(self.path, name), files.inside(self.path, "quarantine")
        with files.explained(source):
            if source.exists():
                place.mkdir(exist_ok=True)
                source.rename(place / f"{Path(name).parent}-{source.name}.{len(list(place.iterdir()))}")
                files.sync(source.parent)


def _trace(sample: int) -> str:
    return f"traces/sample-{sample:07d}.parquet"


def _envelope(chunk: int) -> str:
    return f"envelopes/{chunk:05d}.parquet"
