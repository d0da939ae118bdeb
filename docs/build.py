"""Builds the site: `python docs/build.py`, after `pip install -e '.[docs]'`. Warnings and broken links are errors.

--pdf: the whole documentation on one page, printed by Chromium (RVJAX_CHROMIUM names another browser of its kind).
The site is build/docs/site/index.html, the PDF is build/docs/rvjax.pdf.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

DOCS = Path(__file__).parent
BUILD = DOCS.parent / "build" / "docs"
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
QUIET = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--no-pdf-header-footer"),
)


def sphinx(builder: str, place: Path) -> None:
    """Builds with one builder; every warning is an error."""
    options = ("-W", "--keep-going", "-n", "-q", "-b", builder, "-d", str(place.parent / f"trees-{builder}"))
    subprocess.run([sys.executable, "-m", "sphinx", *options, str(DOCS), str(place)], check=True)


def pdf(build: Path) -> Path:
    """The documentation as one PDF. Errors: SystemExit without a browser."""
    named = [os.environ.get("RVJAX_CHROMIUM"), *map(shutil.which, BROWSERS)]
    browser = next(filter(None, named), None)
    if browser is None:
        raise SystemExit(f"--pdf needs one of {', '.join(BROWSERS)}, or RVJAX_CHROMIUM")
    sphinx("singlehtml", build / "single")
    target = build / "rvjax.pdf"
    with tempfile.TemporaryDirectory() as profile:
        page = (build / "single" / "index.html").as_uri()
        subprocess.run([browser, *QUIET, f"--user-data-dir={profile}", f"--print-to-pdf={target}", page], check=True)
    return target


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--pdf", action="store_true")
    options.add_argument("--out", type=Path, default=BUILD)
    given = options.parse_args()
    build = given.out.resolve()
    build.mkdir(parents=True, exist_ok=True)
    sphinx("html", build / "site")
    print(build / "site" / "index.html")
    if given.pdf:
        print(pdf(build))


if __name__ == "__main__":
    main()
