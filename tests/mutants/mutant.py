"""What a mutant is."""

from __future__ import annotations

from typing import NamedTuple


class Mutant(NamedTuple):
    """name; file under rvjax/; old and new text; killer: file under tests/ and test."""

    name: str
    file: str
    old: str
    new: str
    killer: str
