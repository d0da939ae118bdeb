"""A change of what users build on is seen, and said in words: does it break them, or add to what they have.

`python -m tests.docs.test_public_api` writes public_api.txt, after the change is in CHANGELOG.md. Why no `griffe check`: it
compares with a commit, which a clone without history or without a tag does not have, and it knows Python only, neither commands
nor keys.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.docs.public_api import Items, changes, items, parent, read, written
from tests.docs.public_api import _name as described  # pyright: ignore[reportPrivateUsage]

FILE = Path(__file__).with_name("public_api.txt")
WRITE = "python -m tests.docs.test_public_api"


@pytest.fixture(scope="module")
def known() -> Items:
    return read(FILE.read_text(encoding="utf-8"))


def test_nothing_public_has_changed_unsaid(known: Items) -> None:
    """Kills: an option without its old name; a parameter that takes less; a default that moves."""
    told = [f"{'BREAKS' if breaks else 'adds  '}  {words}" for breaks, words in changes(known, items())]
    advice = f"Say it in CHANGELOG.md (what breaks: under Changed or Removed, with what to do), then: {WRITE}"
    assert not told, "\n".join(["what users build on has changed:", *told, advice])
    assert FILE.read_text(encoding="utf-8") == written(items())


def test_what_users_use_is_there(known: Items) -> None:
    """Kills: a part that is not looked at."""
    assert known["key campaign.horizon.duration_s"]["required"]
    assert not known["key campaign.seed"]["required"]
    assert known["key campaign.seed"]["default"] == "0"
    assert known["cli rvjax export --to"]["required"]
    assert known["python rvjax.Run.export(sample)"]["type"] == ["None", "int"]
    assert "python rvjax.components.Parameters" in known
    assert all(parent(place) in known for place in known if place.startswith("key campaign."))


def renamed(known: Items, old: str, new: str) -> None:
    known[new] = known.pop(old)


def without(known: Items, beginning: str) -> None:
    """Takes an item away, with all its parts."""
    for place in [place for place in known if re.match(re.escape(beginning) + r"($|[.(\[])", place)]:
        del known[place]


EXPORT, SEED, SAMPLES = "python rvjax.Run.export", "key campaign.seed", "key campaign.samples"
SAMPLE, NUMBER, MORE = f"{EXPORT}(sample)", f"{EXPORT}(number)", f"{EXPORT}(more)"
TO, FORMAT = "cli rvjax export --to", "cli rvjax export --format"
DURATION, PD = "key campaign.horizon.duration_s", "key campaign.controller(pd-plus)"

PLANTED: dict[str, tuple[bool, str, Callable[[Items], object]]] = {
    "a name": (True, "python rvjax.Run: removed", lambda k: without(k, "python rvjax.Run")),
    "a parameter": (True, f"{SAMPLE}: removed", lambda k: k.pop(SAMPLE)),
    "another name": (True, f"{SAMPLE}: removed; renamed to {NUMBER}?", lambda k: renamed(k, SAMPLE, NUMBER)),
    "a required parameter": (True, f"{MORE}: new and required", lambda k: k.update({MORE: {"required": True}})),
    "an optional parameter": (False, f"{MORE}: new", lambda k: k.update({MORE: {"required": False}})),
    "a default": (True, f"{SAMPLE}: default None → 0", lambda k: k[SAMPLE].update(default="0")),
    "less accepted": (True, f"{SAMPLE}: narrower, no longer None", lambda k: k[SAMPLE].update(type=["int"])),
    "more accepted": (False, f"{SAMPLE}: also str", lambda k: k[SAMPLE].update(type=["None", "int", "str"])),
    "another place": (True, f"{SAMPLE}: position 1 → 2", lambda k: k[SAMPLE].update(position=2)),
    "more given": (True, f"{EXPORT}: may give None now", lambda k: k[EXPORT]["gives"].append("None")),
    "an option": (True, f"{TO}: removed", lambda k: k.pop(TO)),
    "a required option": (True, f"{FORMAT}: new and required", lambda k: k.update({FORMAT: {"required": True}})),
    "a key": (True, f"{DURATION}: removed", lambda k: k.pop(DURATION)),
    "a key that may be left out": (False, f"{DURATION}: may be left out now", lambda k: k[DURATION].update(required=False)),
    "a key that is required": (True, f"{SEED}: required now", lambda k: k[SEED].update(required=True)),
    "a smaller range": (True, f"{SEED}: minimum 0 → 1", lambda k: k[SEED].update(minimum=1)),
    "a larger range": (False, f"{SAMPLES}: minimum 1 → 0", lambda k: k[SAMPLES].update(minimum=0)),
    "a component": (True, f"{PD}: removed", lambda k: without(k, PD)),
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_change_is_noticed(known: Items, name: str) -> None:
    """Each kind, once. Kills: a break that is taken for an addition; a sentence for every part of what is gone."""
    breaks, words, plant = PLANTED[name]
    changed = copy.deepcopy(known)
    plant(changed)
    assert changes(known, changed) == [(breaks, words)]


def test_facts_are_those_of_the_code() -> None:
    """Kills: a method, a property, a field or a parameter that is not read."""

    class Old:
        size: int

        def make(self, a: int, *, b: str | None = None) -> str:
            return f"{a}{b}"

        @property
        def length(self) -> float:
            return 0.0

    class New:
        def make(self, a: int, c: int, *, b: str = "x") -> str | None:
            return f"{a}{b}{c}" or None

    Old.__module__ = New.__module__ = "rvjax.made_up"
    known: SimpleNamespace = SimpleNamespace(old={}, new={})
    described("python X", Old, known.old)
    described("python X", New, known.new)
    assert changes(known.old, known.new) == [
        (True, "python X.length: removed"),
        (True, "python X.size: removed"),
        (True, "python X.make(c): new and required"),
        (True, "python X.make: may give None now"),
        (True, "python X.make(b): default None → 'x'"),
        (True, "python X.make(b): narrower, no longer None"),
    ]


if __name__ == "__main__":
    FILE.write_text(written(items()), encoding="utf-8")
