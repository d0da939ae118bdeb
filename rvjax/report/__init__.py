"""The report: run folder → one self-contained page. It needs neither JAX nor a network."""

from __future__ import annotations

from rvjax.report.compose import build, write
from rvjax.report.run_view import assemble_run

__all__ = ["assemble_run", "build", "write"]
