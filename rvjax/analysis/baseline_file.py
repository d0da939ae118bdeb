"""The format of a baseline file, and the check of one that somebody may have edited or merged by hand."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from rvjax.errors import UsageError

FORMAT = 1
MOST = 2_000
"""The largest number of samples in a file: the first of the run."""

NAMED = 10
"""The most mistakes of a file that a message lists."""

Finite = Annotated[float, Field(allow_inf_nan=False)]
Share = Annotated[str, Field(pattern="^[01]*$")]

ACCEPTED = {
    "missing": "a file with this key",
    "extra_forbidden": "no such key",
    "literal_error": "",
    "string_pattern_mismatch": "a text of 0 and 1",
    "finite_number": "a finite number",
    "float_type": "a finite number",
    "int_type": "a whole number",
    "string_type": "a text",
    "list_type": "a list",
    "model_type": "a mapping",
    "model_attributes_type": "a mapping",
    "dict_type": "a mapping",
}
"""What is accepted, by pydantic's type of a mistake; for others, and where the text is empty, pydantic's words."""


class _Part(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class MetricValues(_Part):
    """A metric of every sample, null where the flight is not finite. better: which values are better."""

    better: Literal["lower", "higher"]
    values: list[Finite | None]


class BaselineFile(_Part):
    """draws: name → first, last, mean and number of the finite values, or nothing; requirements: title → a digit for each sample,
    1 where it complies."""

    format: Literal[1]
    campaign: str
    samples: Annotated[int, Field(ge=1, le=MOST)]
    draws: dict[str, list[Finite]]
    requirements: dict[str, Share]
    metrics: dict[str, MetricValues]

    def encode(self) -> bytes:
        """The bytes of the file."""
        return (json.dumps(self.model_dump(), indent=1, allow_nan=False) + "\n").encode()


def read(path: Path) -> BaselineFile:
    """Reads a baseline file. UsageError with every mistake and its place if `write` cannot have written it."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"), object_pairs_hook=_mapping)
    except (OSError, ValueError, RecursionError) as error:
        raise _refusal(path, [str(error)]) from error
    if isinstance(document, dict) and isinstance(made := document.get("format"), int) and made != FORMAT:
        raise UsageError(f"{path}: a baseline of format {made}; accepted: {FORMAT}")
    try:
        found = BaselineFile.model_validate(document)
    except ValidationError as error:
        raise _refusal(path, [_words(mistake) for mistake in error.errors(include_url=False)]) from error
    if wrong := _lengths(found):
        raise _refusal(path, wrong)
    return found


def _mapping(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object, in which no key stands twice, as it may after a merge."""
    known: dict[str, Any] = {}
    for key, value in pairs:
        if key in known:
            raise ValueError(f"key {key!r} stands twice")
        known[key] = value
    return known


def _lengths(file: BaselineFile) -> list[str]:
    """The parts that are not of as many samples as the file says, and the draws without their four numbers."""
    n = file.samples
    wrong = [f"draws.{name}: {len(x)} numbers; accepted: 4 or 0" for name, x in file.draws.items() if len(x) not in (0, 4)]
    parts = [(f"requirements.{name}", len(marks)) for name, marks in file.requirements.items()]
    parts += [(f"metrics.{name}.values", len(metric.values)) for name, metric in file.metrics.items()]
    return wrong + [f"{place}: {length} samples; accepted: {n}, as `samples` says" for place, length in parts if length != n]


def _words(mistake: Any) -> str:
    """Where, what was found, what is accepted."""
    place = ".".join(str(step) for step in mistake["loc"]) or "the file"
    accepted = ACCEPTED.get(mistake["type"], "") or mistake["msg"].lower()
    if mistake["type"] == "missing":
        return f"{place}: missing"
    if mistake["type"] == "extra_forbidden":
        return f"{place}: unknown key"
    return f"{place}: {_shown(mistake['input'])}; accepted: {accepted}"


def _shown(value: Any) -> str:
    text = json.dumps(value, default=repr)
    return text if len(text) <= 40 else f"{text[:37]}…"


def _refusal(path: Path, mistakes: Sequence[str]) -> UsageError:
    rest = [f"and {len(mistakes) - NAMED} more"] if len(mistakes) > NAMED else []
    reasons = "\n  ".join([*mistakes[:NAMED], *rest])
    return UsageError(
        f"{path}: not a baseline (edited or damaged):\n  {reasons}\naccepted: a file that --write-baseline wrote, as it wrote it"
    )
