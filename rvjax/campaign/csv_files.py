"""CSV files that a campaign names: in any mapping with the key `csv`, the table replaces the name of the file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from rvjax.campaign.csv_text import CsvFile, decoded, parsed
from rvjax.campaign.named_files import NamedFiles, RefusedFile, plain_path
from rvjax.campaign.plain_values import Place, describe, is_list, is_mapping
from rvjax.campaign.source import Source
from rvjax.errors import Finding

KEY = "csv"
_ACCEPTED = "accepted: the name of a CSV file in the campaign's folder or below it"


def attach_tables(source: Source, files: NamedFiles) -> list[Finding]:
    """Replaces the name of every CSV file in the values of a source by its table; returns a finding at the key `csv` of each file
    that cannot be read."""
    tables = _Tables(files)
    findings: list[Finding] = []
    for place, mapping in list(mappings_with(KEY, source.value)):
        try:
            mapping[KEY] = tables.table(mapping[KEY])
        except RefusedFile as refused:
            findings.append(source.finding((*place, KEY), refused.message, refused.accepted, key=True))
            mapping[KEY] = CsvFile(describe(mapping[KEY]), readable=False)
    return findings


def mappings_with(key: str, value: Any, place: Place = ()) -> Iterator[tuple[Place, dict[str, Any]]]:
    """(place, mapping) of every mapping with a key."""
    if is_mapping(value):
        if key in value:
            yield place, value
        for name, item in value.items():
            yield from mappings_with(key, item, (*place, name))
    elif is_list(value):
        for index, item in enumerate(value):
            yield from mappings_with(key, item, (*place, index))


@dataclass
class _Tables:
    """Reads each table once."""

    files: NamedFiles
    found: dict[str, CsvFile | RefusedFile] = field(default_factory=dict[str, "CsvFile | RefusedFile"])

    def table(self, given: object) -> CsvFile:
        if isinstance(given, CsvFile):
            self.files.read(given.name, _ACCEPTED)
            return given
        name = plain_path(given, _ACCEPTED)
        if name not in self.found:
            try:
                self.found[name] = parsed(name, decoded(name, self.files.read(name, _ACCEPTED)))
            except RefusedFile as refused:
                self.found[name] = refused
        table = self.found[name]
        if isinstance(table, RefusedFile):
            raise table
        return table
