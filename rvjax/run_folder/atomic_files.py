"""Atomic writes: a file is on the disk completely or not at all. Errors of the file system become messages for the user."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import os
import re
import uuid
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath

from rvjax.errors import FolderError, IncompleteError, UsageError
from rvjax.places import ObjectPath, Place, place_of

_REFUSED = {errno.EACCES, errno.EPERM, errno.EROFS}
_WRONG_PLACE = {errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.EEXIST, errno.ENAMETOOLONG, errno.ELOOP}
_FULL = {errno.ENOSPC, errno.EDQUOT}


QUARANTINE = "quarantine"
"""The folder for damaged files in a run folder."""


def sha256(data: bytes) -> str:
    """The SHA-256 of the data, in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


@contextmanager
def explained(path: Path) -> Generator[None, None, None]:
    """Turns an OSError about `path` into a message: what happened, what is safe, and what to do.

    FolderError if the path is wrong or access is denied, IncompleteError if the disk is full or fails.
    """
    try:
        yield
    except OSError as error:
        reason = f"{path}: {error.strerror or error}"
        if error.errno in _REFUSED:
            raise FolderError(f"{reason}; give yourself access to it, or choose another folder with --out") from error
        if error.errno in _WRONG_PLACE:
            raise FolderError(f"{reason}; give the path of a run folder, or a new path with --out") from error
        remedy = "free some space" if error.errno in _FULL else "check the disk"
        advice = "give the same command again: committed results are kept"
        raise IncompleteError(f"{reason}; {remedy} and {advice}") from error


def check_folder(path: Path) -> None:
    """UsageError where `path` is no folder and cannot become one, or where nothing can be written in it. Changes nothing."""
    if isinstance(place_of(path), ObjectPath):
        raise UsageError(f"{place_of(path)}: this command writes to a folder of this machine; accepted: the path of a folder")
    whole = path.absolute()
    here = next(place for place in (whole, *whole.parents) if os.path.lexists(place))
    if not os.path.isdir(here):
        reason = os.strerror(errno.ENOTDIR) if here == whole else f"{here} is not a folder"
    elif any(len(os.fsencode(part)) > os.pathconf(here, "PC_NAME_MAX") for part in whole.relative_to(here).parts):
        reason = os.strerror(errno.ENAMETOOLONG)
    elif os.access(here, os.W_OK | os.X_OK):
        return
    else:
        reason = os.strerror(errno.EROFS if os.statvfs(here).f_flag & os.ST_RDONLY else errno.EACCES)
    raise UsageError(f"{path}: cannot be written: {reason}; accepted: a folder that can be written, or the path of a new folder")


def check_file(path: Path) -> None:
    """UsageError where no file can be written at `path`. Makes the folders above it; does not change an existing file."""
    accepted = "accepted: the path of a file that can be written"
    try:
        if path.is_dir():
            raise UsageError(f"{path}: this is a folder; accepted: the path of a file to write")
        if path.exists() and not path.is_file():
            raise UsageError(f"{path}: this is not a regular file; {accepted}")
        if path.exists() and not os.access(path, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        path.parent.mkdir(parents=True, exist_ok=True)
        trial = _temporary(path)
        trial.open("xb").close()
        trial.unlink()
    except OSError as error:
        raise UsageError(f"{path}: cannot be written: {error.strerror}; {accepted}") from error


def plain_parts(root: Place, name: str) -> tuple[str, ...]:
    """The parts of a relative name in a run folder; FolderError if it leads out of the folder."""
    parts = PurePosixPath(name).parts
    if not parts or name.startswith("/") or any(c in name for c in "\0\\") or ".." in parts:
        raise FolderError(f"{root}: {name!r} leads out of the run folder; accepted: the relative path of a file in it")
    return parts


def inside(root: Path, name: str) -> Path:
    """The path of `name` under `root`; FolderError if it leads out of `root`, also through a link."""
    path = root.joinpath(*plain_parts(root, name))
    if not os.path.realpath(path).startswith(os.path.realpath(root) + os.sep):
        raise FolderError(f"{root}: {name!r} leads out of the run folder; accepted: the relative path of a file in it")
    return path


def exists(path: Path) -> bool:
    """Whether the path is a file."""
    with explained(path):
        return path.is_file()


def read(path: Path) -> bytes:
    """The whole file."""
    with explained(path):
        return path.read_bytes()


def replace(path: Path, data: bytes) -> None:
    """Writes `data` to `path` atomically: a reader sees the old bytes or the new bytes, also after a power cut."""
    _publish(path, data, os.replace)


def publish(path: Path, data: bytes, durable: bool = True) -> bool:
    """Writes `data` to `path` unless the file exists: the first writer wins. Returns whether `path` now holds `data`.

    durable: the name is on the disk on return; otherwise only the bytes are, and the caller must `sync` the folder.
    """
    _publish(path, data, _link, durable)
    return read(path) == data


def _link(temporary: Path, path: Path) -> None:
    with suppress(FileExistsError):
        os.link(temporary, path)


def _publish(path: Path, data: bytes, move: Callable[[Path, Path], None], durable: bool = True) -> None:
    """Temporary file next to `path` -> write -> fsync -> read back and compare -> move to `path` -> fsync the folder."""
    with explained(path):
        if not path.parent.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            sync(path.parent.parent)
        temporary = _temporary(path)
        try:
            with temporary.open("xb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            if temporary.read_bytes() != data:
                raise OSError(errno.EIO, "the disk gave back other bytes than were written")
            move(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)
        if durable:
            sync(path.parent)


def _temporary(path: Path) -> Path:
    """A new name next to `path`."""
    return path.with_name(f".{path.name}.{uuid.uuid4().hex}")


def is_temporary(name: str) -> bool:
    """Whether this is the name of a temporary file of `replace` or `publish`."""
    return re.fullmatch(r"\..+\.[0-9a-f]{32}", name) is not None


def listing(root: Path, folders: Iterable[str], sweep: bool = True) -> Iterator[tuple[str, int]]:
    """Name and size in bytes of every file in the given folders below `root`, in turn; "" is `root` itself.

    sweep: remove temporary files, which a stopped process left.
    """
    for folder in folders:
        prefix = f"{folder}/" if folder else ""
        with explained(root / folder), suppress(FileNotFoundError), os.scandir(root / folder) as entries:
            for entry in entries:
                if not entry.is_file(follow_symlinks=False):
                    continue
                if not entry.name.startswith(".") or not is_temporary(entry.name):
                    yield prefix + entry.name, entry.stat(follow_symlinks=False).st_size
                elif sweep:
                    os.unlink(entry.path)


def sweep(root: Path, folders: Iterable[str]) -> None:
    """Removes the temporary files, which a stopped process left, in the given folders below `root`; "" is `root` itself."""
    for _ in listing(root, folders):
        pass


def set_aside(root: Path, name: str) -> None:
    """Moves a file to `quarantine/` under an unused name."""
    source, place = inside(root, name), inside(root, QUARANTINE)
    with explained(source):
        if source.exists():
            place.mkdir(exist_ok=True)
            source.rename(place / f"{name.replace('/', '-')}.{len(os.listdir(place))}")
            sync(source.parent)


def sync(folder: Path) -> None:
    """Makes the names of the files in a folder durable (fsync)."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def lock(folder: Path) -> int:
    """Locks a folder for this process until the returned handle is closed or the process ends.

    UsageError if another process holds the lock.
    """
    with explained(folder):
        handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        advice = "wait for its end, or choose another folder with --out"
        raise UsageError(f"{folder}: another process is writing here; {advice}") from None
    except OSError:  # a file system without locks
        pass
    return handle
