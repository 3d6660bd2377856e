"""Headless Chromium, asked through its own debugging pipe: no driver and no package is needed.

https://chromedevtools.github.io/devtools-protocol/
"""

import json
import os
import shutil
import subprocess
from base64 import b64decode

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")

QUIET = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--autoplay-policy=no-user-gesture-required",
)  # fmt: skip


def program():
    """Path of a Chromium on this system, None without one, and where processes cannot be given more pipes."""
    return None if os.name == "nt" else next(filter(None, map(shutil.which, PROGRAMS)), None)


class Browser:
    """One page in a browser with a profile of its own in ``folder``; ``said`` is all that its console has said."""

    def __init__(self, folder):
        (self._theirs_in, ours_out), (ours_in, self._theirs_out) = os.pipe(), os.pipe()
        self._process = subprocess.Popen(
            [program(), *QUIET, "--remote-debugging-pipe", f"--user-data-dir={folder}", "about:blank"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            pass_fds=(3, 4),  # where it reads and writes
            preexec_fn=self._to_3_and_4,
        )
        os.close(self._theirs_in)
        os.close(self._theirs_out)
        self._out, self._in = os.fdopen(ours_out, "wb", 0), os.fdopen(ours_in, "rb")
        self._asked, self._session, self._events, self.said = 0, {}, [], []
        targets = self._ask("Target.getTargets")["targetInfos"]
        page = next(target["targetId"] for target in targets if target["type"] == "page")
        session = self._ask("Target.attachToTarget", targetId=page, flatten=True)["sessionId"]
        self._session = {"sessionId": session}
        for part in ("Page", "Runtime", "Log", "Network"):
            self._ask(f"{part}.enable")

    def _to_3_and_4(self):
        # away from 3 and 4 first: one of them may be the other's place
        reading, writing = os.dup(os.dup(self._theirs_in)), os.dup(os.dup(self._theirs_out))
        os.dup2(reading, 3)
        os.dup2(writing, 4)

    def open(self, path, width, dark=False):
        """Show the file ``path`` in a window ``width`` pixels wide, as high as it is on a phone or a screen."""
        self.said.clear()
        self._ask("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self._ask("Emulation.setEmulatedMedia", features=[scheme])
        self._events.clear()
        self._ask("Page.navigate", url=path.resolve().as_uri())
        while "Page.loadEventFired" not in self._events:
            self._take()

    def value(self, script):
        """Return what the expression ``script`` is in the page, once it is known; RuntimeError where it fails."""
        answer = self._ask("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"])
        return answer["result"].get("value")

    def type(self, text):
        """Type ``text`` into the element that has the focus."""
        self._ask("Input.insertText", text=text)

    def printed(self):
        """Return the page as it is printed, a PDF."""
        return b64decode(self._ask("Page.printToPDF", printBackground=True)["data"])

    def close(self):
        """End the browser."""
        self._process.kill()
        self._process.wait()
        self._out.close()
        self._in.close()

    def _ask(self, method, **parameters):
        self._asked += 1
        question = {"id": self._asked, "method": method, "params": parameters, **self._session}
        self._out.write(json.dumps(question).encode() + b"\0")
        while True:
            answer = self._take()
            if answer.get("id") == self._asked:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]

    def _take(self):
        letters = bytearray()
        while (letter := self._in.read(1)) != b"\0":
            if not letter:
                raise RuntimeError("the browser has ended")
            letters += letter
        message = json.loads(letters)
        self._events.append(message.get("method"))
        self._note(message.get("method"), message.get("params", {}))
        return message

    def _note(self, method, said):
        if method == "Log.entryAdded":
            self.said.append(said["entry"]["text"])
        elif method in ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Page.javascriptDialogOpening"):
            self.said.append(f"{method}: {json.dumps(said)[:500]}")
        elif method == "Network.requestWillBeSent" and not said["request"]["url"].startswith(("file:", "data:")):
            self.said.append(f"request of {said['request']['url']}")
