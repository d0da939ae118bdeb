"""Sections as one self-contained HTML page. The template escapes every text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from rvjax.report.blocks import Headline, Section
from rvjax.report.figures import Picture
from rvjax.report.number_format import count, shown

_HERE = Path(__file__).parent


def page(top: Headline, sections: Sequence[Section], pictures: Mapping[str, Picture]) -> str:
    """The HTML document, with the pictures and the style sheet embedded."""
    environment = Environment(
        loader=FileSystemLoader(_HERE), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    embedded = {name: Markup(picture.inline) for name, picture in pictures.items()}  # safe: text in the figures is drawn as paths
    style = Markup((_HERE / "style.css").read_text(encoding="utf-8"))
    functions = {"shown": shown, "count": count, "kind": _kind}
    template = environment.get_template("page.html")
    return template.render(top=top, sections=sections, pictures=embedded, style=style, **functions)


def _kind(item: object) -> str:
    return type(item).__name__
