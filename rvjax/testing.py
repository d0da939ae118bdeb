"""Checks of your components for pytest.

def test_my_law():
    rvjax.testing.check_component("my_law.py")
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rvjax.execution.component_check import Checked

__all__ = ["check_component"]


def check_component(file: str | Path, parameters: Mapping[str, Any] | None = None) -> tuple[Checked, ...]:
    """Checks the components of a Python file as `rvjax check-component` does; returns what it has found about each.

    file: `my_law.py`, or `my_law.py:NAME` for one of several. parameters: as a campaign says them; without them the defaults, and
    an example of what has no default.

    Errors: CampaignError with file, line and what is wrong.
    """
    from rvjax.execution.component_check import check_file

    return check_file(file, parameters)
