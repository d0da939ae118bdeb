"""Rare failures of a requirement: the flights of a search, the search itself, and the regions where flights fail."""

from rvjax.execution.rare.search import search_all

__all__ = ["search_all"]
