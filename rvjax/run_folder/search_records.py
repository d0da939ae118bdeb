"""Records of searches: JSON documents of a model, whose SHA-256 stands in `SHA256SUMS`."""

from __future__ import annotations

from typing import TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from rvjax.errors import FolderError
from rvjax.run_folder import checksums
from rvjax.run_folder.storage import Storage


class RecordPart(BaseModel):
    """A frozen part of a record. Strict JSON; numbers that are not finite become text."""

    model_config = ConfigDict(frozen=True, extra="forbid", ser_json_inf_nan="strings")

    def encode(self) -> bytes:
        """The JSON document."""
        return f"{self.model_dump_json(indent=1)}\n".encode()


Record = TypeVar("Record", bound=RecordPart)


def read(storage: Storage, name: str, model: type[Record], command: str) -> Record | None:
    """The record in the file `name`; None where there is none. command: makes it again. FolderError if the file was changed."""
    if not storage.exists(name):
        return None
    data = checksums.verified(storage, name)
    try:
        if data is None:
            raise ValueError("its SHA-256 is not that in SHA256SUMS")
        return model.model_validate_json(data)
    except (ValidationError, ValueError) as error:
        path = storage.place / name
        raise FolderError(f"{path}: damaged or edited ({error}); `{command}` with the same --out makes it again") from error
