"""Run folders with made-up flights."""

from tests.report.conftest import made

__all__ = ["made"]
