"""Every fence of every document is right, and a wrong one of each kind is noticed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.test_explain import pasted
from tests.docs.fences import SHOWN, Fence, all_fences, commands, fences_of, wrong
from tests.program import Run

BESIDES = {
    "correlate:": "pursuer:\n  mass_kg: {uniform: [80, 120]}\n  inertia_kgm2: {moments: [{uniform: [20, 24]}, 20, 22]}\n",
    "require:\n  - {name: lateral misalignment": "metrics: [{use: contact, interface_m: [-1.2, 0, 0]}]\n",
    "laws:\n  healthy: {faults.effectiveness.remaining: {uniform: [0.3": (
        "samples: 1248\nfaults: [{use: effectiveness, onset_s: 30, remaining: {uniform: [0.1, 1]}}]\n"
    ),
    "target:\n  port_m: [5, 0, 0]\n  hull:": "start: {frame: port, position_m: [20, 0, 0]}\n",
}
"""Beginning of a fence → the sections of the campaign that its page speaks of."""

IN_PLACE = {"pursuer:\n  hull:": "pursuer:\n  mass_kg: 100\n  inertia_kgm2: {principal: [22, 20, 23]}\n  hull:"}
"""Keys that a fence leaves out of a section."""

Check = Callable[[Fence], str]


@pytest.fixture
def check(rvjax: Run, tmp_path: Path, request: pytest.FixtureRequest) -> Check:
    """What is wrong with a fence."""
    parser = request.config._parser
    groups = [parser._anonymous, *parser._groups]
    options = {name for group in groups for option in group.options for name in option.names()}

    def validate(text: str) -> str:
        (tmp_path / "vent.csv").write_text("t_s,fx_N\n0,0\n400,0.1\n")
        place = tmp_path / "campaign.yaml"
        whole = "".join(more for beginning, more in BESIDES.items() if text.startswith(beginning)) + text
        for short, long in IN_PLACE.items():
            whole = whole.replace(short, long)
        place.write_text(pasted(whole))
        code, _, err = rvjax("validate", place)
        return err if code else ""

    return lambda fence: wrong(fence, validate, options)


@pytest.mark.parametrize("fence", all_fences(), ids=str)
def test_a_fence_is_right(fence: Fence, check: Check) -> None:
    """Kills: an option, a key, an extra or a name that was renamed in the program and not on the page."""
    assert check(fence) == ""


def test_there_are_many_fences() -> None:
    """Kills: a search for fences that finds nothing, or misses indented ones."""
    kinds = Counter(fence.language for fence in all_fences())
    checked = sum(count for language, count in kinds.items() if language not in SHOWN)
    assert checked >= 95, kinds
    assert any(fence.document == "docs/releasing.md" for fence in all_fences())
    raw = sum(path.count("```") for path in {Path(f.document).read_text() for f in all_fences()})
    assert raw == 2 * len(all_fences())


WRONG = [
    ("sh", "rvjax run campaign.yaml --sample 4\n", "does not have ['--sample']"),
    ("sh", "rvjax validate x.yaml && rvjax fly campaign.yaml\n", "the command fly"),
    ("sh", "rvjax compare\n", "compare"),
    ("sh", "rvjax run campaign.yaml --samples many  # how many\n", "many"),
    ("console", "rvjax export reports/a --too x.csv\n", "--too"),
    ("sh", "pip install 'rvjax[clouds]'\n", "no extra {'clouds'}"),
    ("sh", "pytest --rvjaxx campaigns/ci/\n", "--rvjaxx"),
    ("sh", "python -m benchmarks.basilisc\n", "no module"),
    ("sh", "python docs/pages.py\n", "no file"),
    ("sh", "rvjx run campaign.yaml\n", "unknown program"),
    ("bash", "#!/bin/bash\nif true; then\n", "syntax error"),
    ("yaml", "pursuer: {mas_kg: 80}\n", "mas_kg"),
    ("yaml", "faults: [{use: stuk, onset_s: 30}]\n", "stuk"),
    ("yaml", "faults: [\n", "parsing"),
    ("yaml", "on: push\njobs:\n  a:\n    steps:\n      - run: rvjax check a.yaml --junit x.xml\n", "--junit"),
    ("python", "from rvjax.components import Comand\n", "no Comand"),
    ("python", "import rvjax\n\nrvjax.fly('x')\n", "no rvjax.fly"),
    ("python", "print 'x'\n", "rint"),
    ("ruby", "puts 1\n", "language 'ruby'"),
]


@pytest.mark.parametrize(("language", "text", "expected"), WRONG, ids=lambda value: str(value)[:40])
def test_a_wrong_fence_is_noticed(language: str, text: str, expected: str, check: Check) -> None:
    """Kills: a check that accepts everything of its kind."""
    (fence,) = fences_of(f"Text\n\n```{language}\n{text}```\n")
    assert expected in check(fence)


def test_comments_are_left_out() -> None:
    """Kills: a # inside quotes that ends a command; two commands taken as one."""
    text = "rvjax list; rvjax explain x   # all\nrvjax run a \\\n  --set 'b={c: \"#\"}' # two\n"
    assert list(commands(text)) == ["rvjax list", "rvjax explain x", "rvjax run a    --set 'b={c: \"#\"}'"]
