"""The shipped controllers pass the check of a user's file, and a mistake that is planted in one is named with its line."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest

from rvjax.campaign.python_files import read_file
from rvjax.components.registry import component
from rvjax.errors import CampaignError
from rvjax.testing import check_component
from tests.user_code.shipped_mistakes import CONTROLLERS, LAW, PLANTED, Planted, source_of

ALL = [(controller, planted) for controller in CONTROLLERS for planted in PLANTED]
FEW = [(name, planted) for name, planted in ALL if name == "pd_plus" or (name == "lqr_kalman" and planted.within == LAW)]
"""Every mistake in a continuous controller; in a discrete-time controller those whose result has another form."""
OTHERS = [pair for pair in ALL if pair not in FEW]


def names(pairs: Iterable[tuple[str, Planted]]) -> list[str]:
    """Their names, for pytest."""
    return [f"{controller}-{planted.name}" for controller, planted in pairs]


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_a_shipped_controller_passes_as_a_file(controller: str, tmp_path: Path) -> None:
    """Kills: a check that does not know the form of the members, or refuses a gain that another option uses."""
    (tmp_path / "law.py").write_text(source_of(controller))
    (found,) = check_component(tmp_path / "law.py")
    assert (found.name, found.family) == ("law.py:COMPONENT", "controllers")
    assert found.operations > 0


def check_named(planted: Planted, controller: str, folder: Path) -> None:
    """The mistake is named with file, line and words."""
    source = planted.edit(source_of(controller))
    assert source != source_of(controller)
    (folder / "law.py").write_text(source)
    with pytest.raises(CampaignError) as caught:
        check_component(folder / "law.py")
    (said,) = str(caught.value).splitlines()
    assert said.startswith(f"{folder / 'law.py'}:{planted.line(source)}: "), said
    for words in planted.words:
        assert words in said
    assert "rvjax_user_" not in said


@pytest.mark.parametrize(("controller", "planted"), FEW, ids=names(FEW))
def test_a_mistake_in_a_shipped_controller_is_named(controller: str, planted: Planted, tmp_path: Path) -> None:
    """Kills: a result of a member's form that nobody looks at, a line of the package instead of the user's."""
    check_named(planted, controller, tmp_path)


@pytest.mark.parametrize(("controller", "planted"), OTHERS, ids=names(OTHERS))
def test_a_mistake_in_any_other_is_named(controller: str, planted: Planted, tmp_path: Path) -> None:
    """Kills: as above, where functions are given some of their arguments or have a state."""
    check_named(planted, controller, tmp_path)


def test_what_is_built_is_of_the_family(tmp_path: Path) -> None:
    """A controller where a disturbance is wanted. Kills: an AttributeError of the flight."""
    (tmp_path / "law.py").write_text(source_of("pd_plus"))
    member = component("disturbances", read_file(tmp_path / "law.py"))
    with pytest.raises(CampaignError, match=r"law\.py:\d+: build: build returns a Controller; accepted: a Disturbance of "):
        member.build(member.parameters())


BARE = """from rvjax.components.metrics.interface import Metric

METRIC = Metric({}, lambda context: 0.0, lambda acc, step, weight, context: acc, lambda acc, context: {})
"""


def test_a_metric_without_parameters_is_no_component_of_a_file(tmp_path: Path) -> None:
    """The shipped metrics of every campaign have this form. Kills: a traceback of the registry."""
    (tmp_path / "bare.py").write_text(BARE)
    with pytest.raises(CampaignError, match=r"bare\.py:1: METRIC has no parameters; accepted: METRIC = Metric\(Parameters, "):
        check_component(tmp_path / "bare.py")
