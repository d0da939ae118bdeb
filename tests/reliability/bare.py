"""The program with reports without sections, for tests that are not about them: drawing takes longer than a short campaign.

`python -m tests.reliability.bare ARGUMENTS` is `rvjax ARGUMENTS`.
"""

from __future__ import annotations

from rvjax.cli import main
from rvjax.report import sections

if __name__ == "__main__":
    sections.SECTIONS = ()
    main()
