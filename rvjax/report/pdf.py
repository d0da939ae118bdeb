"""The report as PDF, printed by a headless Chromium of this machine. It fetches nothing and keeps nothing."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from rvjax.errors import UsageError

CHOSEN = "RVJAX_CHROMIUM"
"""The environment variable that names the browser."""

NAMES = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge", "msedge"),
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    r"C:\Program Files\Google\Chrome\Application\chrome.exe",
    r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
)

FLAGS = (
    *("--headless", "--disable-gpu", "--no-first-run", "--no-default-browser-check", "--disable-extensions"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-default-apps"),
    *("--disable-domain-reliability", "--no-pings", "--metrics-recording-only", "--host-resolver-rules=MAP * ~NOTFOUND"),
    "--no-pdf-header-footer",
)

TIMEOUT_S = 180.0

_ACCEPTED = f"accepted: Chromium, Chrome or Edge on the PATH, or the path of one in the environment variable {CHOSEN}"


def browser() -> str:
    """The browser that prints; UsageError where there is none."""
    chosen = os.environ.get(CHOSEN)
    for name in (chosen,) if chosen else NAMES:
        if found := shutil.which(name):
            return found
    where = f"{CHOSEN}={chosen}" if chosen else "--pdf"
    raise UsageError(f"{where}: no Chromium that can print the report; {_ACCEPTED}")


def printed(page: bytes) -> bytes:
    """The page as PDF. UsageError where there is no browser, or it does not print."""
    command = browser()
    with tempfile.TemporaryDirectory(prefix="rvjax-pdf-", ignore_cleanup_errors=True) as place:
        source, target = Path(place) / "report.html", Path(place) / "report.pdf"
        source.write_bytes(page)
        sandbox = ["--no-sandbox"] if getattr(os, "geteuid", lambda: 1)() == 0 else []  # Chromium has none for root
        profile, to = f"--user-data-dir={place}/profile", f"--print-to-pdf={target}"
        words = [command, *FLAGS, *sandbox, profile, to, source.as_uri()]
        try:
            done = subprocess.run(words, capture_output=True, timeout=TIMEOUT_S, check=False, stdin=subprocess.DEVNULL)
        except subprocess.TimeoutExpired as error:
            raise UsageError(f"{command}: printed nothing in {TIMEOUT_S:g} s; {_ACCEPTED}") from error
        except OSError as error:
            raise UsageError(f"{command}: cannot be started ({error.strerror}); {_ACCEPTED}") from error
        if not target.exists() or not (data := target.read_bytes()).startswith(b"%PDF"):
            last = (done.stderr.decode(errors="replace").strip().splitlines() or ["it said nothing"])[-1]
            raise UsageError(f"{command}: printed no PDF (exit code {done.returncode}: {last}); {_ACCEPTED}")
        return data
