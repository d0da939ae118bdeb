"""How Sphinx builds the site from docs/*.md. `python docs/build.py` calls it.

The pages are plain Markdown, which a repository shows as well. The navigation is that of index.md: each heading of level two is
a part, and its links are the pages.
"""

from __future__ import annotations

import posixpath
import re
import runpy
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
reference = runpy.run_path(str(DOCS / "reference.py"))

project = "rvjax"
author = "rvjax contributors"
copyright = author
release = re.findall(r'^__version__ = "(.*)"', (DOCS.parent / "rvjax" / "__init__.py").read_text(encoding="utf-8"), re.MULTILINE)[
    0
]
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build"]
myst_heading_anchors = 4
myst_links_external_new_tab = False
html_theme = "furo"
html_title = f"rvjax {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
highlight_language = "text"
suppress_warnings = ["misc.highlighting_failure"]  # outputs and fragments are shown as they are

MARKER = "<!-- generated pages -->"
REFERENCE = {
    "keys": "every key of a campaign file",
    "commands": "every command and option",
    "api": "public functions and classes, with their docstrings",
    **dict.fromkeys(reference["FAMILIES"], "equations, units, defaults, examples"),
    "distributions": "how a draw is written",
    "equations": "the chapters of the model",
}
TITLES = {"keys": "Campaign keys", "api": "Python"}
HIDDEN = "\n\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n{pages}\n```\n"


def read(app: Any, page: str, source: list[str]) -> None:
    """Links to files at the root of the repository go to their pages of the site; index.md gets its navigation."""
    del app
    up = posixpath.relpath("generated", posixpath.dirname(page) or ".")
    for name, file in reference["PROJECT"].items():
        source[0] = re.sub(rf"\]\((?:\.\./)+{re.escape(file)}", f"]({up}/{name}.md", source[0])
    if page == "index":
        source[0] = navigated(source[0])


def navigated(text: str) -> str:
    """index.md with a list of the generated pages, and with a hidden table of contents for each part."""
    rows = [f"- [{TITLES.get(name, name.capitalize())}](generated/{name}.md): {what}" for name, what in REFERENCE.items()]
    text = text.replace(MARKER, "\n".join(rows))
    parts = re.split(r"^(?=## )", text, flags=re.MULTILINE)
    for part in parts[1:]:
        pages = dict.fromkeys(re.findall(r"\]\(([\w/-]+)\.md\)", part))
        text += HIDDEN.format(caption=part.partition("\n")[0].removeprefix("## "), pages="\n".join(pages))
    return text


def setup(app: Any) -> None:
    reference["write"]()
    app.connect("source-read", read)
