"""S3Client: an `ObjectClient` for Amazon S3 and stores that speak its protocol, through s3fs.

Credentials, region and endpoint come from where s3fs looks for them: the environment (`AWS_ACCESS_KEY_ID`,
`AWS_ENDPOINT_URL`, …), `~/.aws`, the machine's role, or fsspec's configuration.
"""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportMissingTypeStubs=false
# (s3fs and botocore say nothing about their types)

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from typing import Any, Literal

from rvjax.components.extras import lacking
from rvjax.errors import UsageError
from rvjax.places import ObjectPath
from rvjax.run_folder.object_client import Conflict, Missing, ObjectClient, Page, Refused, Unavailable

PROTOCOLS = ("s3", "s3a")

_CONFLICTS = {"PreconditionFailed", "412"}
_MISSING = {"NoSuchKey", "NotFound", "404"}
_REFUSED = {
    "NoSuchBucket": "there is no such bucket; make it, or choose another place",
    "AccessDenied": "access denied; give yourself access to it, or choose another place",
    "403": "access denied; give yourself access to it, or choose another place",
    "InvalidAccessKeyId": "the access key is not known there; check your credentials",
    "SignatureDoesNotMatch": "the secret key does not fit the access key; check your credentials",
    "ExpiredToken": "the credentials have expired; renew them",
    "InvalidBucketName": "not the name of a bucket; choose another place",
    "NotImplemented": "the store has no conditional writes; accepted: a store that has them, such as Amazon S3, or a folder",
}


def client_of(place: ObjectPath) -> ObjectClient:
    """The client of a place's bucket; UsageError if the place cannot be reached from here."""
    if place.protocol not in PROTOCOLS:
        raise UsageError(
            f"{place}: a run folder in an object store needs the conditional requests of S3; accepted: s3://bucket/prefix, "
            "or a folder"
        )
    if not place.bucket:
        raise UsageError(f"{place}: no bucket; accepted: s3://bucket/prefix")
    if lack := lacking("fsspec", "s3fs"):
        raise UsageError(f"{place}: a run folder in an object store needs {lack}; accepted: pip install 'rvjax[cloud]'")
    return S3Client(place.bucket)


class S3Client:
    """The objects of a bucket."""

    def __init__(self, bucket: str) -> None:
        import s3fs  # only where a URL is given: it takes a second

        self._bucket = bucket
        self._files: Any = s3fs.S3FileSystem(skip_instance_cache=True)

    def get(self, key: str) -> tuple[bytes, str]:
        """As `ObjectClient.get`."""
        from fsspec.asyn import sync

        async def whole() -> tuple[bytes, str]:
            answer = await self._files._call_s3("get_object", Bucket=self._bucket, Key=key)
            async with answer["Body"] as body:
                return await body.read(), answer["ETag"]

        with _explained():
            answer: Any = sync(self._files.loop, whole)
        return answer

    def put(self, key: str, data: bytes, condition: Literal["new"] | str | None = None) -> str:
        """As `ObjectClient.put`."""
        conditions = {"IfNoneMatch": "*"} if condition == "new" else {"IfMatch": condition} if condition else {}
        return self._call("put_object", Key=key, Body=data, **conditions)["ETag"]

    def delete(self, key: str) -> None:
        """As `ObjectClient.delete`."""
        self._call("delete_object", Key=key)

    def etag(self, key: str) -> str | None:
        """As `ObjectClient.etag`: by a listing, since the answer to a request for its head does not name a missing bucket."""
        answer = self._call("list_objects_v2", Prefix=key, MaxKeys=1)
        return next((str(entry["ETag"]) for entry in answer.get("Contents", ()) if entry["Key"] == key), None)

    def page(self, prefix: str, deep: bool, after: str = "") -> Page:
        """As `ObjectClient.page`."""
        options = ({} if deep else {"Delimiter": "/"}) | ({"ContinuationToken": after} if after else {})
        answer = self._call("list_objects_v2", Prefix=prefix, **options)
        entries = [(str(entry["Key"]), int(entry["Size"])) for entry in answer.get("Contents", ())]
        entries += [(str(entry["Prefix"]), 0) for entry in answer.get("CommonPrefixes", ())]
        return Page(entries, answer.get("NextContinuationToken", ""))

    def _call(self, method: str, **arguments: Any) -> dict[str, Any]:
        with _explained():
            return self._files.call_s3(method, Bucket=self._bucket, **arguments)


@contextmanager
def _explained() -> Generator[None, None, None]:
    """Turns the errors of s3fs and botocore into those of an `ObjectClient`."""
    from botocore.exceptions import BotoCoreError, ClientError, NoCredentialsError, PartialCredentialsError

    try:
        yield
    except Exception as error:  # aiohttp and s3fs have many kinds of their own
        cause: Any = error if isinstance(error, ClientError | BotoCoreError) else error.__cause__ or error
        if isinstance(cause, NoCredentialsError | PartialCredentialsError):
            raise Refused(
                "no credentials; set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or sign in with `aws configure`"
            ) from error
        code = str(cause.response.get("Error", {}).get("Code", "")) if isinstance(cause, ClientError) else ""
        if code in _CONFLICTS:
            raise Conflict from error
        if code in _MISSING:
            raise Missing from error
        if code in _REFUSED:
            raise Refused(_REFUSED[code]) from error
        if isinstance(cause, ClientError | BotoCoreError | OSError | TimeoutError):
            raise Unavailable(str(error) or type(error).__name__) from error
        raise
