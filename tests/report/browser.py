"""A headless Chromium for tests: the DevTools protocol over two pipes, one page at a time.

flags   --remote-debugging-pipe: JSON ended by NUL, in on descriptor 3, out on 4
WebGL2  by SwiftShader, on the processor; the page itself is drawn without it, which is several times faster
"""

from __future__ import annotations

import base64
import json
import os
import select
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import pytest

from rvjax.errors import UsageError
from rvjax.report import pdf

FLAGS = (
    "--headless=new", "--no-sandbox", "--disable-gpu-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-extensions",
    "--disable-gpu-rasterization", "--hide-scrollbars", "--mute-audio", "--force-device-scale-factor=1",
    "--disable-dev-shm-usage",
)  # fmt: skip
PATIENCE_S = 120.0


def executable() -> str | None:
    """The path of a Chromium, or None."""
    try:
        return pdf.browser()
    except UsageError:
        return None


def required() -> None:
    """Skips the test where there is no Chromium; fails where RVJAX_BROWSER_TESTS asks for it."""
    if executable() is None:
        assert not os.environ.get("RVJAX_BROWSER_TESTS"), "no Chromium, though RVJAX_BROWSER_TESTS asks for these tests"
        pytest.skip(f"no Chromium on the PATH, and none in {pdf.CHOSEN}")


class Browser:
    """A browser with a page. console: what the page has logged, thrown or been refused; requests: every address it asked for."""

    def __init__(self, profile: Path, flags: Sequence[str] = ()) -> None:
        program = executable()
        assert program is not None
        to_browser, to_us = os.pipe(), os.pipe()
        command = [program, *FLAGS, *flags, f"--user-data-dir={profile}", "--remote-debugging-pipe", "about:blank"]
        shell = f'exec 3<&{to_browser[0]} 4>&{to_us[1]}; exec "$@"'
        self._process = subprocess.Popen(
            ["bash", "-c", shell, "browser", *command],
            pass_fds=(to_browser[0], to_us[1]),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_browser[0])
        os.close(to_us[1])
        self._out, self._in, self._rest, self._number = to_browser[1], to_us[0], b"", 0
        self._session: str | None = None
        self.console: list[str] = []
        self.requests: list[str] = []
        targets = self.send("Target.getTargets")["targetInfos"]
        page = next(target["targetId"] for target in targets if target["type"] == "page")
        self._session = self.send("Target.attachToTarget", targetId=page, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.send(f"{domain}.enable")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._process.terminate()
        try:
            self._process.wait(20)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self._out)
        os.close(self._in)

    def send(self, method: str, **parameters: Any) -> dict[str, Any]:
        """A command and its answer; what the page reports meanwhile is kept."""
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self._out, data) :]
        while True:
            answer = self._receive(PATIENCE_S)
            if answer.get("id") == self._number:
                assert "error" not in answer, answer["error"]
                return answer["result"]

    def _receive(self, patience_s: float) -> dict[str, Any]:
        end = time.monotonic() + patience_s
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._in], [], [], max(end - time.monotonic(), 0.0))
            assert ready, "the browser does not answer"
            part = os.read(self._in, 1 << 20)
            assert part, "the browser has ended"
            self._rest += part
        line, _, self._rest = self._rest.partition(b"\0")
        message = json.loads(line)
        self._note(message.get("method"), message.get("params", {}))
        return message

    def _note(self, method: str | None, told: dict[str, Any]) -> None:
        if method == "Runtime.consoleAPICalled":
            self.console.append(" ".join(str(part.get("value", part.get("description"))) for part in told["args"]))
        elif method == "Runtime.exceptionThrown":
            details = told["exceptionDetails"]
            self.console.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Log.entryAdded":
            self.console.append(told["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(told["request"]["url"])

    def run(self, script: str) -> Any:
        """The value of an expression in the page; a promise is waited for."""
        told = self.send("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in told, told["exceptionDetails"]
        return told["result"].get("value")

    def wait(self, script: str) -> None:
        """Until an expression holds."""
        self.until(lambda: bool(self.run(script)), script)

    @staticmethod
    def until(holds: Callable[[], bool], words: str) -> None:
        """Until something holds."""
        end = time.monotonic() + PATIENCE_S
        while not holds():
            assert time.monotonic() < end, f"never: {words}"
            time.sleep(0.02)

    def open(self, path: Path, fragment: str = "", ready: str = "rvjax.ready > 0") -> None:
        """Loads a file from scratch."""
        self.blank()
        self.console.clear()
        self.requests.clear()
        self.send("Page.navigate", url=path.resolve().as_uri() + fragment)
        self.wait("location.protocol === 'file:' && document.readyState === 'complete'")
        self.wait(ready)

    def blank(self) -> None:
        """Leaves the page."""
        self.send("Page.navigate", url="about:blank")
        self.wait("location.href === 'about:blank'")

    def size(self, width: int, height: int) -> None:
        """Of the window."""
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def media(self, medium: str = "", **features: str) -> None:
        """Emulates a medium and its features: prefers_color_scheme="dark"."""
        given = [{"name": name.replace("_", "-"), "value": value} for name, value in features.items()]
        self.send("Emulation.setEmulatedMedia", media=medium, features=given)

    def picture(self, selector: str | None = None) -> bytes:
        """A PNG of an element, or of the whole page."""
        if selector is None:
            size = self.send("Page.getLayoutMetrics")["cssContentSize"]
            clip = {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}
        else:
            box = self.run(
                f"(() => {{ const b = document.querySelector({json.dumps(selector)}).getBoundingClientRect();"
                " return {x: b.x + scrollX, y: b.y + scrollY, width: b.width, height: b.height, scale: 1}; })()"
            )
            clip = box
        shot = self.send("Page.captureScreenshot", format="png", clip=clip, captureBeyondViewport=True)
        return base64.b64decode(shot["data"])

    def key(self, key: str, code: str = "", text: str = "") -> None:
        """Presses a key."""
        given = {"key": key, "code": code or key, "windowsVirtualKeyCode": {" ": 32}.get(key, 0)}
        self.send("Input.dispatchKeyEvent", type="keyDown", text=text, **given)
        self.send("Input.dispatchKeyEvent", type="keyUp", **given)

    def drag(self, selector: str, begin: tuple[float, float], end: tuple[float, float]) -> None:
        """Drags over an element from one place to another, as shares of its width and height."""
        script = f"document.querySelector({json.dumps(selector)})"
        self.run(f"{script}.scrollIntoView({{block: 'center', behavior: 'instant'}})")
        box = self.run(f"(() => {{ const b = {script}.getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; }})()")
        a, b = ([box[0] + s * box[2], box[1] + t * box[3]] for s, t in (begin, end))
        self.send("Input.dispatchMouseEvent", type="mousePressed", x=a[0], y=a[1], button="left", buttons=1, clickCount=1)
        self.send("Input.dispatchMouseEvent", type="mouseMoved", x=b[0], y=b[1], button="left", buttons=1)
        self.send("Input.dispatchMouseEvent", type="mouseReleased", x=b[0], y=b[1], button="left", clickCount=1)
