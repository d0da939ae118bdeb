"""The picture of the frames of the start is that of its script."""

from __future__ import annotations

import runpy
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


def test_the_picture_is_that_of_its_script() -> None:
    """Kills: a script that was changed without its picture."""
    script = runpy.run_path(str(DOCS / "start_frames.py"))
    assert (DOCS / "start-frames.svg").read_text(encoding="utf-8") == script["picture"](), "run: python docs/start_frames.py"
