"""Reads the files that a campaign names: CSV tables, and Python files with components."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from rvjax.campaign.csv_files import attach_tables
from rvjax.campaign.named_files import NamedFiles
from rvjax.campaign.python_files import attach_code
from rvjax.campaign.source import Source


def attach(source: Source) -> Source:
    """The source with every file that it names, and a finding for each file that cannot be read. Files that the source already
    holds are not read again."""
    if source.value is None:
        return source
    files = NamedFiles(Path(source.name).parent, source.inputs)
    findings = [*attach_tables(source, files), *attach_code(source, files)]
    return replace(source, findings=(*source.findings, *findings), inputs=files.inputs)
