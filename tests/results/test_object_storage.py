"""A run folder in an object store keeps the promises of a local one."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from rvjax.errors import FolderError, IncompleteError, UsageError
from rvjax.places import ObjectPath, place_of
from rvjax.run_folder import RunFolder, object_storage
from rvjax.run_folder.object_client import ATTEMPTS, Refused, Unavailable
from rvjax.run_folder.storages import is_run_folder
from tests.disk import Killed
from tests.objects import FailingClient, MemoryClient

from .conftest import COLUMNS, chunk, create, fly, resume

PLACE = ObjectPath("s3://bucket/runs/a")
SAMPLES = 10


@pytest.fixture
def store(monkeypatch: pytest.MonkeyPatch) -> MemoryClient:
    """The bucket; requests are repeated without a pause."""
    client = MemoryClient()
    reach(monkeypatch, client)
    monkeypatch.setattr("rvjax.run_folder.object_client.FIRST_WAIT_S", 0.0)
    return client


def reach(monkeypatch: pytest.MonkeyPatch, client: object) -> None:
    """From now on every place is reached through this client."""
    monkeypatch.setattr("rvjax.run_folder.s3_client.client_of", lambda place: client)


def attempt() -> None:
    """A run, new or resumed."""
    begun = is_run_folder(PLACE)
    with resume(PLACE, SAMPLES) if begun else create(PLACE, SAMPLES) as folder:  # pyright: ignore[reportArgumentType]
        fly(folder, SAMPLES)


def data(store: MemoryClient) -> dict[str, bytes]:
    """The data files, by their names in the run folder."""
    names = {key.removeprefix(f"{PLACE.key}/"): value for key, value in store.objects.items()}
    return {name: value for name, value in names.items() if name.endswith(".parquet")}


def local(path: Path) -> dict[str, bytes]:
    """The data files of the same run in a local folder."""
    with create(path, SAMPLES) as folder:
        fly(folder, SAMPLES)
    return {file.relative_to(path).as_posix(): file.read_bytes() for file in path.rglob("*.parquet")}


def test_the_same_files_as_in_a_local_folder(store: MemoryClient, tmp_path: Path) -> None:
    """Manifest included. Kills: other names or bytes, a lease that stays, a journal that is not folded."""
    attempt()
    assert data(store) == local(tmp_path / "run")
    assert store.objects[f"{PLACE.key}/manifest.json"] == (tmp_path / "run" / "manifest.json").read_bytes()
    folder = RunFolder.open("s3://bucket/runs/a")
    folder.verify()
    assert folder.samples().frame.equals(RunFolder.open(tmp_path / "run").samples().frame)
    assert not any(key.endswith("writer.json") for key in store.objects)
    assert sum("/journal/" in key for key in store.objects) == 1
    assert RunFolder.open(place_of(Path("s3://bucket/runs/a"))).missing(3, 3) == []


@pytest.mark.parametrize("limit", [2, 1_000])
def test_what_is_committed_is_there_at_once(store: MemoryClient, limit: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a commit that waits for the end of the run, a journal that grows without a fold."""
    monkeypatch.setattr("rvjax.run_folder.object_storage.MOST_LINES", limit)
    with create(PLACE, 40) as folder:  # pyright: ignore[reportArgumentType]
        for index in range(6):
            folder.commit(index, chunk(index, 40), COLUMNS)
            assert RunFolder.open(PLACE).chunks.number.tolist() == list(range(index + 1))
            assert sum("/journal/" in key for key in store.objects) <= limit + 2


@pytest.mark.parametrize("seed", range(6))
def test_a_store_that_fails_one_request_in_twenty(
    store: MemoryClient, seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before or after its work. Kills: an answer that was lost taken for another writer, a request that is not repeated,
    a listing that ends where a page failed."""
    failing = FailingClient(store, every=20 if seed else 5, seed=seed)
    reach(monkeypatch, failing)
    attempt()
    attempt()
    RunFolder.open(PLACE).verify()
    assert failing.failures > 1
    assert data(store) == local(tmp_path / "run")
    assert not any("quarantine" in key for key in store.objects)


@pytest.mark.parametrize("after", [False, True])
def test_a_stop_at_any_request_loses_nothing(
    after: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, figure: Callable[[str], None]
) -> None:
    """The process ends before or after a request; the same command goes on. Kills: a manifest that names what is not there, a
    journal that nobody can go on with, a line lost between two series."""
    monkeypatch.setattr("rvjax.run_folder.object_storage.LEASE_S", -1.0)  # the process that was stopped is this one
    expected, stop = local(tmp_path / "run"), 1
    while True:
        store = MemoryClient()
        client = FailingClient(store, stop=stop, after=after)
        reach(monkeypatch, client)
        stopped = False
        try:
            attempt()
        except Killed:
            stopped = True
        reach(monkeypatch, store)
        before = data(store)
        listed = RunFolder.open(PLACE).chunks.number.tolist() if is_run_folder(PLACE) else []
        attempt()
        assert before.items() <= data(store).items()
        assert data(store) == expected, stop
        assert not any("quarantine" in key for key in store.objects), stop
        folder = RunFolder.open(PLACE)
        folder.verify()
        assert set(listed) <= set(folder.chunks.number.tolist())
        if not stopped:
            break
        stop += 1
    assert stop > 50
    figure(
        f"object store: the process ended {'after' if after else 'before'} each of {stop - 1} requests; "
        "the same files after resuming"
    )


def test_a_second_writer_is_refused(store: MemoryClient) -> None:
    """At its start, by the lease. Kills: two runs in one folder, a lease that outlives its run."""
    with create(PLACE, SAMPLES) as folder:  # pyright: ignore[reportArgumentType]
        with pytest.raises(
            UsageError, match=r"another process is writing here \(process \d+ on .*remove s3://bucket/runs/a/writer.json"
        ):
            resume(PLACE, SAMPLES)  # pyright: ignore[reportArgumentType]
        folder.commit(0, chunk(0, SAMPLES), COLUMNS)
        RunFolder.open(PLACE).verify()
    attempt()


@pytest.mark.parametrize("act", ["commit", "fold"])
def test_a_writer_that_was_taken_for_dead_is_refused(store: MemoryClient, act: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """It goes on after its lease has ended and another writer has begun. Kills: trusting clocks instead of the store; a manifest
    without what the other has committed."""
    monkeypatch.setattr("rvjax.run_folder.object_storage.LEASE_S", -1.0)
    monkeypatch.setattr(object_storage.ObjectStorage, "renew", lambda self: None)
    first = create(PLACE, SAMPLES)  # pyright: ignore[reportArgumentType]
    first.commit(0, chunk(0, SAMPLES), COLUMNS)
    second = resume(PLACE, SAMPLES)  # pyright: ignore[reportArgumentType]
    second.commit(1, chunk(1, SAMPLES), COLUMNS)
    with pytest.raises(UsageError, match="another process is writing here"):
        first.commit(2, chunk(2, SAMPLES), COLUMNS) if act == "commit" else first.close()
    second.commit(2, chunk(2, SAMPLES), COLUMNS)
    second.close()
    assert RunFolder.open(PLACE).chunks.number.tolist() == [0, 1, 2]


def test_a_lease_that_was_taken_over_is_noticed(store: MemoryClient, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a sign of life that overwrites the lease of another."""
    folder = create(PLACE, SAMPLES)  # pyright: ignore[reportArgumentType]
    store.objects[f"{PLACE.key}/writer.json"] = b'{"token": "x", "host": "other", "pid": 1, "until": 9e9}'
    monkeypatch.setattr("rvjax.run_folder.object_storage.LEASE_S", 0.0)
    with pytest.raises(UsageError, match="another process is writing here"):
        folder.commit(0, chunk(0, SAMPLES), COLUMNS)


@pytest.mark.parametrize(("host", "refused"), [("here", False), ("other", True)])
def test_the_lease_of_a_process_that_ended(
    store: MemoryClient, host: str, refused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Here it is seen that it has ended; elsewhere its lease must end first. Kills: a wait after every killed run."""
    attempt()
    monkeypatch.setattr("socket.gethostname", lambda: "here")
    lease = {"token": "x", "host": host, "pid": 2**22 + 1, "until": 9e9}
    store.objects[f"{PLACE.key}/writer.json"] = json.dumps(lease).encode()
    if refused:
        with pytest.raises(UsageError, match=r"process \d+ on other"):
            attempt()
    else:
        attempt()


def test_a_bit_flip_anywhere_is_noticed(store: MemoryClient) -> None:
    """Also in the journal of a run that was stopped, but for the token of its writer. Kills: trusting the store."""
    attempt()
    for key, good in list(store.objects.items()):
        token = good.find(b"\n") + 1 if "/journal/" in key else 0
        for place in range(token, len(good), max(1, len(good) // 40)):
            changed = bytearray(good)
            changed[place] ^= 1 << place % 8
            store.objects[key] = bytes(changed)
            with pytest.raises(FolderError):
                RunFolder.open(PLACE).verify()
        store.objects[key] = good
    RunFolder.open(PLACE).verify()


def test_damaged_objects_are_set_aside_and_flown_again(store: MemoryClient) -> None:
    """Kills: a damaged object that stays or is lost."""
    attempt()
    expected = data(store)
    key = next(key for key in store.objects if "/samples/00001" in key)
    for damaged in (store.objects[key][:-1], store.objects[key][:-1] + b"x"):
        store.objects[key] = damaged
        attempt()
        aside = {name: value for name, value in store.objects.items() if "/quarantine/" in name}
        assert damaged in aside.values()
        assert {name: value for name, value in data(store).items() if "quarantine" not in name} == expected


@pytest.mark.parametrize("name", ["manifest.json", "journal"])
def test_manifest_and_journal_are_rebuilt(store: MemoryClient, name: str) -> None:
    """Kills: a rebuild that needs what is damaged."""
    attempt()
    good = store.objects[f"{PLACE.key}/manifest.json"]
    for key in [key for key in store.objects if key.startswith(f"{PLACE.key}/{name}")]:
        store.objects[key] = store.objects[key][:-9]
    with pytest.raises(FolderError, match="rvjax doctor"):
        RunFolder.open(PLACE)
    with RunFolder.rebuild(PLACE) as folder:
        folder.verify()
    assert store.objects[f"{PLACE.key}/manifest.json"] == good
    RunFolder.open(PLACE).verify()


def test_a_journal_with_a_gap_is_damage(store: MemoryClient) -> None:
    """Kills: lines behind a lost object that count, or vanish without a word."""
    folder = create(PLACE, SAMPLES)  # pyright: ignore[reportArgumentType]
    for index in range(3):
        folder.commit(index, chunk(index, SAMPLES), COLUMNS)
    del store.objects[next(key for key in store.objects if key.endswith("-00000001"))]
    with pytest.raises(FolderError, match=r"objects of journal/.* are missing; run `rvjax doctor`"):
        RunFolder.open(PLACE)


def test_a_store_that_ignores_conditions_is_refused(store: MemoryClient) -> None:
    """Before anything is written. Kills: two writers that destroy each other's results."""
    store.honest = False
    with pytest.raises(UsageError, match=r"ignores the conditions If-None-Match .*accepted: a store with conditional"):
        create(PLACE, SAMPLES)  # pyright: ignore[reportArgumentType]
    assert store.objects == {}


def test_a_store_that_never_answers(store: MemoryClient, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: endless repetition, a traceback, a message that does not say what to do."""
    tries: list[str] = []

    def silent(key: str, *_: object) -> bytes:
        tries.append(key)
        raise Unavailable("503 Slow Down")

    folder = create(PLACE, SAMPLES)  # pyright: ignore[reportArgumentType]
    monkeypatch.setattr(store, "put", silent)
    with pytest.raises(IncompleteError, match="503 Slow Down; the store does not answer: give the same command again"):
        folder.commit(0, chunk(0, SAMPLES), COLUMNS)
    assert len(tries) == ATTEMPTS
    monkeypatch.undo()


def test_what_is_refused_is_not_repeated(store: MemoryClient, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a minute of waiting for a bucket that is not there."""
    tries: list[str] = []

    def refused(prefix: str, *_: object) -> bytes:
        tries.append(prefix)
        raise Refused("there is no such bucket")

    monkeypatch.setattr(store, "etag", refused)
    with pytest.raises(FolderError, match=r"s3://bucket/runs/a/manifest.json: there is no such bucket"):
        is_run_folder(PLACE)
    assert len(tries) == 1


@pytest.mark.parametrize("text", ["s3://bucket/a/b", "s3:/bucket/a/b"])
def test_a_place_is_a_path_in_a_bucket(text: str) -> None:
    """Kills: a URL that loses a slash, a local name that is taken for a URL."""
    place = place_of(text)
    assert isinstance(place, ObjectPath)
    assert (str(place / "c"), place.protocol, place.bucket, (place / "c").key) == ("s3://bucket/a/b/c", "s3", "bucket", "a/b/c")
    assert place_of(place) == place == place_of(Path(text))
    assert all(isinstance(place_of(name), Path) for name in ("s3", "a/s3:x", "/s3://x", "c:x", "./s3:/x/y"))
