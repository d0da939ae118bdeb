"""RunDescription: the run that a folder is created or resumed for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, kw_only=True)
class RunDescription:
    """A run as its folder records it.

    identity: everything that determines the flights; provenance: when, where and how the run was started; both are JSON.
    samples: the number requested. name: of the campaign. inputs: the files that the campaign names, by their names.
    """

    identity: Mapping[str, Any]
    provenance: Mapping[str, Any]
    campaign_text: str
    samples: int
    name: str
    inputs: Mapping[str, bytes] = field(default_factory=dict[str, bytes])
