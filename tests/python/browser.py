"""A browser without a screen for tests of pages: Chromium, spoken to by its DevTools protocol over two pipes, without other packages."""
import base64
import fcntl
import json
import os
import shutil
import subprocess

import pytest

NAMES = "chromium", "chromium-browser", "google-chrome"
READS, WRITES = 3, 4  # descriptors by which Chromium speaks with --remote-debugging-pipe
WORDS = ["--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-extensions", "--disable-background-networking",
         "--hide-scrollbars", "--remote-debugging-pipe", "--window-size=1100,1400"]


class Browser:
    """A page at a time; `errors` has what went wrong in it."""

    def __init__(self, folder):
        """folder: for what Chromium keeps. Skips the test where there is no Chromium."""
        program = next(filter(None, map(shutil.which, NAMES)), None)
        if program is None:
            pytest.skip("no Chromium here, 100 MB that only this test needs: `sh scripts/install_packages.sh chromium` brings it")
        theirs, ours = [high(end) for end in os.pipe()], [high(end) for end in os.pipe()]

        def connect():
            os.dup2(theirs[0], READS)
            os.dup2(ours[1], WRITES)
        self.process = subprocess.Popen([program, *WORDS, f"--user-data-dir={folder}", "about:blank"], preexec_fn=connect, pass_fds=(READS, WRITES),
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(theirs[0])
        os.close(ours[1])
        self.output, self.input = os.fdopen(theirs[1], "wb"), os.fdopen(ours[0], "rb")
        self.count, self.rest, self.events, self.errors = 0, b"", [], []
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self.session = {"sessionId": self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]}
        for domain in ("Page", "Runtime", "Log"):
            self.ask(f"{domain}.enable", self.session)

    def close(self):
        self.process.kill()
        self.process.wait()
        self.output.close()
        self.input.close()

    def ask(self, method, session=None, **parameters):
        """Returns the answer to a command of the protocol."""
        self.count += 1
        message = {"id": self.count, "method": method, "params": parameters, **(session or {})}
        self.output.write(json.dumps(message).encode() + b"\0")
        self.output.flush()
        while True:
            answer = self.read()
            if answer.get("id") == self.count:
                assert "error" not in answer, (method, answer["error"])
                return answer["result"]

    def read(self):
        """Returns the next message; those about errors are kept."""
        while b"\0" not in self.rest:
            piece = os.read(self.input.fileno(), 1 << 20)
            assert piece, "Chromium has ended"
            self.rest += piece
        text, _, self.rest = self.rest.partition(b"\0")
        message = json.loads(text)
        method, about = message.get("method"), message.get("params", {})
        self.events.append(method)
        if method == "Runtime.exceptionThrown" or method == "Log.entryAdded" and about["entry"]["level"] == "error" \
                or method == "Runtime.consoleAPICalled" and about["type"] in ("error", "warning"):
            self.errors.append(json.dumps(about)[:1000])
        return message

    def open(self, path):
        """Opens a file and waits until it has been read."""
        self.events, self.errors = [], []
        self.ask("Page.navigate", self.session, url=path.resolve().as_uri())
        while "Page.loadEventFired" not in self.events:
            self.read()

    def value(self, script):
        """Returns the value of an expression, or of the promise that it is, in the page."""
        found = self.ask("Runtime.evaluate", self.session, expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def picture(self, path):
        """Writes what is seen of the whole page as a PNG."""
        size = self.ask("Page.getLayoutMetrics", self.session)["cssContentSize"]
        found = self.ask("Page.captureScreenshot", self.session, captureBeyondViewport=True, clip={**size, "scale": 1})
        path.write_bytes(base64.b64decode(found["data"]))


def high(descriptor):
    """Returns another number for a descriptor, beyond those that Chromium speaks by."""
    found = fcntl.fcntl(descriptor, fcntl.F_DUPFD_CLOEXEC, 10)
    os.close(descriptor)
    return found
