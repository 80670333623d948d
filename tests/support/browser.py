"""A page in headless Chromium, driven over the browser's own debugging pipe: nothing to install beside the browser.

The protocol's messages are JSON objects, each ended by a zero byte; file descriptors 3 and 4 carry them.
"""

from __future__ import annotations

import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

PROGRAMS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "headless_shell")
PATIENCE = 60.0
Message = dict[str, Any]


def program() -> str | None:
    """The first browser of the Chromium family on this machine; MICROFACET_BROWSER names another."""
    return os.environ.get("MICROFACET_BROWSER") or next(filter(None, map(shutil.which, PROGRAMS)), None)


class Page:
    """One page of one browser. `events` keeps all that the page and the network said."""

    def __init__(self, command: str, profile: Path) -> None:
        flags = ["--headless=new", "--remote-debugging-pipe", "--no-first-run", "--disable-gpu", "--hide-scrollbars"]
        flags += ["--disable-dev-shm-usage", "--disable-background-networking", f"--user-data-dir={profile}"]
        flags += ["--no-sandbox"] if os.geteuid() == 0 else []
        theirs, self.out = _pipe()
        self.inward, given = _pipe()
        self.process = subprocess.Popen(
            [command, *flags],
            preexec_fn=lambda: (os.dup2(theirs, 3), os.dup2(given, 4)),
            pass_fds=(3, 4),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(theirs)
        os.close(given)
        self.events: list[Message] = []
        self.rest, self.count, self.session = b"", 0, ""
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.ask(f"{domain}.enable")
        self.ask("Page.setLifecycleEventsEnabled", enabled=True)

    def close(self) -> None:
        """End the browser that this page started, and no other."""
        self.process.terminate()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        os.close(self.out)
        os.close(self.inward)

    def ask(self, method: str, **parameters: Any) -> Any:
        """The result of one command; what happens meanwhile goes into `events`."""
        self.count += 1
        message: Message = {"id": self.count, "method": method, "params": parameters}
        message |= {"sessionId": self.session} if self.session else {}
        os.write(self.out, json.dumps(message).encode() + b"\0")
        answer = self.wait(lambda one: one.get("id") == self.count)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']['message']}")
        return answer["result"]

    def wait(self, wanted: Any) -> Message:
        deadline = time.monotonic() + PATIENCE
        while True:
            while b"\0" in self.rest:
                first, self.rest = self.rest.split(b"\0", 1)
                message = json.loads(first)
                self.events += [message] if "method" in message else []
                if wanted(message):
                    return dict(message)
            if not select.select([self.inward], [], [], max(0.0, deadline - time.monotonic()))[0]:
                raise TimeoutError(f"the browser said nothing for {PATIENCE:g} s")
            piece = os.read(self.inward, 1 << 16)
            if not piece:
                raise RuntimeError("the browser ended by itself")
            self.rest += piece

    def look(self, width: int, height: int, **media: str) -> None:
        """A screen of this size; media features by name, as in prefers_color_scheme="dark"."""
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)
        features = [{"name": name.replace("_", "-"), "value": value} for name, value in media.items()]
        self.ask("Emulation.setEmulatedMedia", features=features)

    def open(self, path: Path) -> None:
        """Show a file and wait until it has been loaded: it, and not the page before, whose event may come late."""
        opened = self.ask("Page.navigate", url=path.resolve().as_uri())["loaderId"]
        self.wait(lambda one: one.get("method") == "Page.lifecycleEvent" and _loaded(one["params"], opened))

    def run(self, script: str) -> Any:
        """The value of a JavaScript expression; promises are waited for."""
        done = self.ask("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in done:
            raise RuntimeError(done["exceptionDetails"].get("exception", {}).get("description", "an exception"))
        return done["result"].get("value")

    def picture(self, out: Path, **clip: float) -> None:
        """A PNG of the window, or of x, y, width, height on the page."""
        options: Message = {"clip": clip | {"scale": 1}, "captureBeyondViewport": True} if clip else {}
        out.write_bytes(base64.b64decode(self.ask("Page.captureScreenshot", **options)["data"]))

    def faults(self) -> list[str]:
        """Exceptions, errors and warnings that the page has caused so far."""
        told = []
        for event in self.events:
            what = event["params"]
            if event["method"] == "Runtime.exceptionThrown":
                told.append(json.dumps(what["exceptionDetails"]))
            elif event["method"] == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning", "assert"):
                told.append(json.dumps(what["args"]))
            elif event["method"] == "Log.entryAdded" and what["entry"]["level"] in ("error", "warning"):
                told.append(what["entry"]["text"])
        return told

    def requests(self) -> list[str]:
        """Addresses that the page asked for, but for those inside the page itself."""
        asked = [e["params"]["request"]["url"] for e in self.events if e["method"] == "Network.requestWillBeSent"]
        return [url for url in asked if not url.startswith("data:")]


def _loaded(what: Message, loader: str) -> bool:
    return bool(what["name"] == "load" and what["loaderId"] == loader)


def _pipe() -> tuple[int, int]:
    """Both ends of a pipe, clear of the descriptors 3 and 4."""
    ends = os.pipe()
    moved = tuple(fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in ends)
    for end in ends:
        os.close(end)
    return moved[0], moved[1]
