"""A browser without a window, driven over its DevTools protocol by a pipe."""

import base64
import contextlib
import json
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest


CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


_KEYS = {
    "Enter": (13, "\r"),
    "Tab": (9, ""),
    "Escape": (27, ""),
    "Delete": (46, ""),
    "ArrowLeft": (37, ""),
    "ArrowUp": (38, ""),
    "ArrowRight": (39, ""),
    "ArrowDown": (40, ""),
    "Home": (36, ""),
    "End": (35, ""),
}
_MIDDLE = """(e) => {
  e.scrollIntoView({block: "nearest", inline: "nearest"});
  const r = e.getBoundingClientRect();
  const [x, y] = [r.x + r.width / 2, r.y + r.height / 2];
  const top = document.elementFromPoint(x, y);
  const bare = top && (e.contains(top) || top.contains(e));
  return r.width && bare && !e.closest(":disabled") ? [x, y] : null;
}"""
_SEEN = f"""[...document.querySelectorAll(%s)].map({_MIDDLE}).find(p => p)"""
_SAYING = f"""[...document.querySelector(%s).querySelectorAll("*")].reverse()
  .filter(e => e.textContent.trim() === %s).map({_MIDDLE}).find(p => p)"""


class Browser:
    """One tab; `events` is all that it has told of, since it was opened."""

    def __init__(self, reads: int, writes: int):
        self._reads, self._writes = reads, writes
        self._next, self._rest, self._session = 0, b"", None
        self.events: list[dict[str, Any]] = []

    def ask(self, method: str, **parameters: Any) -> Any:
        self._next += 1
        asked: dict[str, Any] = {"id": self._next, "method": method}
        asked["params"] = parameters
        if self._session is not None:
            asked["sessionId"] = self._session
        os.write(self._writes, json.dumps(asked).encode() + b"\0")
        while True:
            told = self._told()
            if told.get("id") == self._next:
                assert "error" not in told, told["error"]
                return told["result"]
            self.events.append(told)

    def _told(self) -> Any:
        while b"\0" not in self._rest:
            more = os.read(self._reads, 1 << 20)
            assert more, "the browser has ended"
            self._rest += more
        one, _, self._rest = self._rest.partition(b"\0")
        return json.loads(one)

    def open(self, page: Path | str, width: int = 1280, height: int = 900) -> None:
        """Open a file or an address, and wait until it is whole."""
        if self._session is None:
            target = self.ask("Target.createTarget", url="about:blank")["targetId"]
            attached = self.ask("Target.attachToTarget", targetId=target, flatten=True)
            self._session = attached["sessionId"]
            for domain in ("Page", "Network", "Runtime", "Log"):
                self.ask(f"{domain}.enable")
        self.resize(width, height)
        self.events.clear()
        url = page if isinstance(page, str) else page.absolute().as_uri()
        self.ask("Page.navigate", url=url)
        while self.value("document.readyState") != "complete":
            time.sleep(0.05)

    def wait(self, condition: str, seconds: float = 30.0) -> Any:
        """Wait until an expression has a value, such as an element, and return it."""
        end = time.monotonic() + seconds
        while (value := self.value(condition)) in (None, False, ""):
            assert time.monotonic() < end, f"not within {seconds} s: {condition}"
            time.sleep(0.02)
        return value

    def click(self, selector: str, times: int = 1) -> None:
        """Click in the middle of an element, as a mouse does.

        Args:
            selector: CSS; the first that can be used, and lies beneath nothing.
            times: 2: double.
        """
        x, y = self.wait(_SEEN % json.dumps(selector))
        self.click_at(x, y, times)

    def click_at(self, x: float, y: float, times: int = 1) -> None:
        for i in range(1, times + 1):
            for kind in ("mousePressed", "mouseReleased"):
                where = {"x": x, "y": y, "button": "left", "clickCount": i}
                self.ask("Input.dispatchMouseEvent", type=kind, **where)

    def click_text(self, text: str, within: str = "body") -> None:
        """Click on the innermost element that can be seen and says just this."""
        x, y = self.wait(_SAYING % (json.dumps(within), json.dumps(text)))
        self.click_at(x, y)

    def press(self, key: str, modifiers: int = 0) -> None:
        """Press a key, such as `Tab`; modifiers: 1 Alt, 2 Ctrl, 8 Shift."""
        code, text = _KEYS.get(key, (ord(key.upper()[0]), ""))
        pressed = {"key": key, "windowsVirtualKeyCode": code, "modifiers": modifiers}
        down = {**pressed, "text": text} if text else pressed
        self.ask("Input.dispatchKeyEvent", type="keyDown", **down)
        self.ask("Input.dispatchKeyEvent", type="keyUp", **pressed)

    def type(self, text: str) -> None:
        """Type a text into what has the focus, in place of what is selected there."""
        self.ask("Input.insertText", text=text)

    def fill(self, selector: str, text: str) -> None:
        """Write into a field in place of what is there, and leave it by Enter."""
        self.click(selector)
        self.press("a", 2)
        self.type(text)
        self.press("Enter")

    def resize(self, width: int, height: int = 900) -> None:
        self.ask(
            "Emulation.setDeviceMetricsOverride",
            **{"width": width, "height": height},
            **{"deviceScaleFactor": 1, "mobile": False},
        )

    def value(self, expression: str) -> Any:
        asked = self.ask("Runtime.evaluate", expression=expression, returnByValue=True)
        return asked["result"].get("value")

    def picture(self) -> bytes:
        """The whole page as PNG."""
        told = self.ask("Page.captureScreenshot", captureBeyondViewport=True)
        return base64.b64decode(told["data"])

    def paper(self) -> bytes:
        """The page as PDF, by its print styles."""
        told = self.ask("Page.printToPDF", preferCSSPageSize=True, printBackground=True)
        return base64.b64decode(told["data"])

    @property
    def requests(self) -> list[str]:
        """Addresses that the page has asked for, but its own and what it holds."""
        urls = [
            event["params"]["request"]["url"]
            for event in self.events
            if event.get("method") == "Network.requestWillBeSent"
        ]
        return [url for url in urls if not url.startswith(("file:", "data:", "blob:"))]

    @property
    def complaints(self) -> list[Any]:
        """What stands in the console, and errors of scripts."""
        told = ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded")
        return [e["params"] for e in self.events if e.get("method") in told]


_ITS_PIPES = 'exec "$@" 3<&0 4>&1 </dev/null >/dev/null'
"""It speaks through 3 and 4. Python does not set them: JAX warns of forks."""


@contextlib.contextmanager
def browser() -> Iterator[Browser]:
    """Start one; a machine without any skips the test."""
    if CHROMIUM is None:
        pytest.skip("no chromium")
    to_it, ours = os.pipe()
    mine, from_it = os.pipe()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as home:
        process = subprocess.Popen(
            [
                *("/bin/sh", "-c", _ITS_PIPES, "sh"),
                *(CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu"),
                *("--remote-debugging-pipe", f"--user-data-dir={home}"),
                *("--no-first-run", "--disable-background-networking"),
            ],
            stdin=to_it,
            stdout=from_it,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_it)
        os.close(from_it)
        try:
            yield Browser(mine, ours)
        finally:
            process.terminate()
            process.wait(timeout=10)
            os.close(mine)
            os.close(ours)
