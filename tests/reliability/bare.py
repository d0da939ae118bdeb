"""The program without what takes longer than a short campaign, for tests that are about none of it: reports have no sections,
and nothing is audited, so that a process which only waits for workers compiles no flight.

`python -m tests.reliability.bare ARGUMENTS` is `rvjax ARGUMENTS`.
"""

from __future__ import annotations

from rvjax.cli import main
from rvjax.execution import run
from rvjax.report import sections
from tests.reliability.plain import proved

if __name__ == "__main__":
    sections.SECTIONS = ()
    run.prove = proved
    main()
