"""Campaign files that are wrong in one place: their first line, `# line:column fragment of the message`, says where and how."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rvjax.errors import CampaignError


def bad_files(folder: Path) -> list[Path]:
    """The corpus in a folder, in the order of the names."""
    return sorted(folder.glob("*.yaml"))


def check_refused(path: Path, load: Callable[[Path], object]) -> None:
    """`load` raises a CampaignError with the finding that the first line of the file expects."""
    place, _, fragment = path.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ").partition(" ")
    with pytest.raises(CampaignError) as caught:
        load(path)
    assert caught.value.exit_code == 2
    at_place = [finding for finding in caught.value.findings if finding.where == f"{path}:{place}"]
    assert any(fragment in str(finding) for finding in at_place), f"expected {place} {fragment}, got\n{caught.value}"
