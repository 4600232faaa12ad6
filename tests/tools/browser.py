"""Drives a headless Chromium through its DevTools protocol, over a pipe: no network, no further package."""

import base64
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import time


class Browser:
    """A page of a browser. What the page prints, throws or asks of the network is kept."""

    def __init__(self, width=1400, height=1000, dark=False):
        self.program = os.environ.get("WEFT_CHROMIUM") or shutil.which("chromium")
        self.profile = tempfile.TemporaryDirectory(prefix="weft-browser-")
        to_browser, from_test = os.pipe()
        from_browser, to_test = os.pipe()

        def connect():  # the browser reads file 3 and writes file 4
            os.dup2(to_browser, 200), os.dup2(to_test, 201)
            os.dup2(200, 3), os.dup2(201, 4)

        self.process = subprocess.Popen(
            [self.program, "--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--disable-gpu-sandbox",
             "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-gpu-compositing", "--no-first-run", "--disable-background-networking",
             "--disable-component-update", "--disable-dev-shm-usage", "--hide-scrollbars",
             f"--user-data-dir={self.profile.name}", f"--window-size={width},{height}", "about:blank"],
            preexec_fn=connect, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser), os.close(to_test)
        self.sink, self.source, self.buffer = from_test, from_browser, b""
        self.number, self.session, self.events = 0, None, []
        self.console, self.requests = [], []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        self.call("Emulation.setEmulatedMedia",
                  features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def close(self):
        self.process.kill()
        self.process.wait()
        os.close(self.sink), os.close(self.source)
        for _ in range(50):  # its helpers may still write into the profile
            try:
                return self.profile.cleanup()
            except OSError:
                time.sleep(0.1)

    def receive(self, timeout=120):
        while b"\0" not in self.buffer:
            chunk = os.read(self.source, 1 << 20)
            if not chunk:
                raise RuntimeError("the browser has ended")
            self.buffer += chunk
        text, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(text)

    def note(self, message):
        method, values = message["method"], message.get("params", {})
        self.events.append(method)
        if method == "Runtime.consoleAPICalled":
            self.console.append(f"{values['type']}: " + " ".join(str(a.get("value", a.get("description"))) for a in values["args"]))
        elif method == "Runtime.exceptionThrown":
            details = values["exceptionDetails"]
            self.console.append("exception: " + details.get("exception", {}).get("description", details["text"]))
        elif method == "Log.entryAdded" and "GPU stall due to ReadPixels" not in values["entry"]["text"]:  # by the browser's own compositing
            self.console.append(f"{values['entry']['level']}: {values['entry']['text']}")
        elif method == "Network.requestWillBeSent":
            self.requests.append(values["request"]["url"])

    def call(self, method, **values):
        self.number += 1
        message = {"id": self.number, "method": method, "params": values}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.sink, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.receive()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            if "method" in answer:
                self.note(answer)

    def open(self, path, place=""):
        """Returns the seconds until the page, at a place of it, had been loaded and drawn."""
        begin = time.monotonic()
        self.events.clear()
        self.call("Page.navigate", url=pathlib.Path(path).resolve().as_uri() + (f"#{place}" if place else ""))
        while "Page.loadEventFired" not in self.events:
            answer = self.receive()
            if "method" in answer:
                self.note(answer)
        self.run("""new Promise((done) => {
            const look = () => ("ready" in document.documentElement.dataset ? done() : setTimeout(look, 5));
            look();
        })""")
        self.settle()
        return time.monotonic() - begin

    def run(self, script):
        """The value of an expression in the page; promises are awaited."""
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"].get("exception", {}).get("description", "failed"))
        return answer["result"].get("value")

    def settle(self):
        self.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 30))))")

    def key(self, name):
        text = name if len(name) == 1 else ""
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=name, text=text if kind == "keyDown" else "")
        self.settle()

    def mouse(self, kind, x, y, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def click(self, x, y):
        self.mouse("mousePressed", x, y, button="left", clickCount=1)
        self.mouse("mouseReleased", x, y, button="left", clickCount=1)
        self.settle()

    def picture(self, path):
        data = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=True)["data"]
        pathlib.Path(path).write_bytes(base64.b64decode(data))
