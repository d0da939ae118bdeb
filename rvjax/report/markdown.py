"""Sections as Markdown, with references to the figures. Every text is escaped."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from rvjax.report.blocks import Cell, Code, Drawing, Headline, Mark, Named, Number, Section, Table
from rvjax.report.number_format import count, shown

_MARKUP = re.compile(r"[\\`*_\[\]#|~$]|^[-+]|:(?=//)|(?<=www)\.", re.IGNORECASE)
"""What Markdown interprets: its marks, list marks and rules at the start of a line, and bare addresses."""


def page(top: Headline, sections: Sequence[Section]) -> str:
    """The Markdown document."""
    blocks = [f"# {text(top.name)}", *([text(top.description)] if top.description else [])]
    blocks += [f"**{text(top.verdict.word)}** {text(top.sentence)}"]
    outcomes = ((label.replace("_", " "), count(number)) for label, number in top.outcomes)
    blocks.append(_table(Table("", ("", ""), (*top.facts, *outcomes))))
    for number, section in enumerate(sections, 1):
        blocks += [f"## {number}. {text(section.title)}", text(section.lead), *_body(section)]
    return "\n\n".join(blocks) + "\n"


def text(words: str) -> str:
    """The words with all that Markdown or HTML would interpret escaped."""
    words = re.sub(r"[^\S\u00a0]+", " ", words).strip()
    words = words.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    words = _MARKUP.sub(r"\\\g<0>", words)
    return re.sub(r"^(\d{1,9})([.)])(?= |$)", r"\1\\\2", words)  # a numbered list


def _body(section: Section) -> Iterator[str]:
    for block in section.body:
        if isinstance(block, Table):
            yield f"{text(block.caption)}\n\n{_table(block)}"
        elif isinstance(block, Drawing):
            yield f"![{text(block.caption)}](figures/{block.name}.svg)"
        else:
            yield text(block)


def _table(table: Table) -> str:
    lines = [map(text, table.head), ("---",) * len(table.head), *((_cell(cell) for cell in row) for row in table.rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cell(cell: Cell) -> str:
    if isinstance(cell, Number):
        value, interval = shown(cell)
        return text(f"{value} [{interval}]" if interval else value)
    if isinstance(cell, Named):
        return f"**{text(cell.name)}**<br>{text(cell.meaning)}"
    if isinstance(cell, Mark):
        return f"**{text(cell.word)}**"
    if isinstance(cell, Code):
        return _code(" ".join(cell.text.split()))
    return text(cell)


def _code(words: str) -> str:
    """The words as code; as plain text if they contain a backtick, or a mark that ends a cell in some renderers."""
    if not words or "`" in words or "\\|" in words:
        return text(words)
    return f"`{words.replace('|', chr(92) + '|')}`"
