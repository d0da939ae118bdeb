"""Sections as one self-contained HTML page. The template escapes every text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from rvjax.report.blocks import Headline, Section
from rvjax.report.figures import Picture
from rvjax.report.interactive.page_parts import Interactive
from rvjax.report.number_format import count, shown

_HERE = Path(__file__).parent


def page(top: Headline, sections: Sequence[Section], pictures: Mapping[str, Picture], live: Interactive | None = None) -> str:
    """The HTML document, with the pictures and the style sheet embedded. live: what acts where scripts
    run; None: nothing does."""
    environment = Environment(
        loader=FileSystemLoader(_HERE), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    embedded = {name: Markup(picture.inline) for name, picture in pictures.items()}  # safe: text in the figures is drawn as paths
    sheets = [_HERE / "style.css", *([_HERE / "interactive" / "interactive.css"] if live else [])]
    style = Markup("\n".join(sheet.read_text(encoding="utf-8") for sheet in sheets))
    functions = {"shown": shown, "count": count, "kind": _kind}
    template = environment.get_template("page.html")
    return template.render(top=top, sections=sections, pictures=embedded, style=style, live=live, **functions)


def _kind(item: object) -> str:
    return type(item).__name__
