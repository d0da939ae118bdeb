"""The report: a run folder in, one self-contained page out, without JAX and without a network."""

from __future__ import annotations

from rvjax.report.compose import build, write
from rvjax.report.run_view import opened

__all__ = ["build", "opened", "write"]
