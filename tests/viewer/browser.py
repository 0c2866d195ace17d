# SPDX-License-Identifier: Apache-2.0
"""Headless Chromium, driven over its debugging pipe (--remote-debugging-pipe): JSON messages that a zero byte ends. No
package is needed but Debian's `chromium`."""
import base64
import json
import os
import select
import shutil
import struct
import subprocess
import tempfile
import time
import zlib

import numpy

CHROMIUM = shutil.which("chromium")


class Browser:
    def __init__(self, width=1280, height=800, scale=1, mobile=False):
        self.folder = tempfile.TemporaryDirectory(prefix="ndg-chromium-", ignore_cleanup_errors=True)
        commands_read, self.commands = os.pipe()
        self.answers, answers_write = os.pipe()

        def connect():  # the browser reads commands at 3 and answers at 4
            os.dup2(commands_read, 103)
            os.dup2(answers_write, 104)
            os.dup2(103, 3)
            os.dup2(104, 4)

        self.process = subprocess.Popen(
            [CHROMIUM, "--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
             "--disable-component-update", "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
             "--hide-scrollbars", "--remote-debugging-pipe", f"--user-data-dir={self.folder.name}", "about:blank"],
            preexec_fn=connect, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(commands_read)
        os.close(answers_write)
        self.buffer, self.count, self.messages, self.requests = b"", 0, [], []
        self.session = None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(domain + ".enable")
        self.resize(width, height, scale, mobile)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()
        self.folder.cleanup()

    def read(self, deadline):
        while b"\0" not in self.buffer:
            if not select.select([self.answers], [], [], max(0, deadline - time.time()))[0]:
                raise TimeoutError("Chromium does not answer")
            self.buffer += os.read(self.answers, 1 << 20)
        message, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, timeout=400, **parameters):
        self.count += 1
        message = {"id": self.count, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.commands, json.dumps(message).encode() + b"\0")
        deadline = time.time() + timeout
        while True:
            answer = self.read(deadline)
            if answer.get("id") == self.count:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self.event(answer)

    def event(self, answer):
        """Keeps what a page should not have: errors, warnings of the console, requests."""
        parameters = answer.get("params", {})
        if answer.get("method") == "Runtime.exceptionThrown":
            self.messages.append(json.dumps(parameters["exceptionDetails"])[:600])
        if answer.get("method") == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning", "assert"):
            self.messages.append(" ".join(str(a.get("value", a.get("description"))) for a in parameters["args"])[:600])
        if answer.get("method") == "Log.entryAdded" and parameters["entry"]["level"] == "error":
            self.messages.append(parameters["entry"]["text"])
        if answer.get("method") == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"][:200])

    def resize(self, width, height, scale=1, mobile=False):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=mobile)

    def open(self, url):
        """A page with a viewer, until all of it is there."""
        self.call("Page.navigate", url=url)
        self.wait("typeof NdgViewer === 'object' && (NdgViewer.state().problems.length > 0 || NdgViewer.state().times?.complete > 0)")

    def run(self, expression, timeout=400):
        """The value of an expression of JavaScript, promises awaited."""
        result = self.call("Runtime.evaluate", timeout, expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in result:
            raise RuntimeError(f"{expression}: {json.dumps(result['exceptionDetails'])[:600]}")
        return result["result"].get("value")

    def wait(self, expression, timeout=400):
        deadline = time.time() + timeout
        while not self.run(expression):
            if time.time() > deadline:
                raise TimeoutError(f"never true: {expression}; the page said: {self.messages}")
            time.sleep(0.05)

    def key(self, key, **more):
        text = {"text": key} if len(key) == 1 else {}
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, **text, **more)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, **more)

    def type(self, selector, text):
        """Text into an empty field."""
        self.run(f"(() => {{ const e = document.querySelector({json.dumps(selector)}); e.focus(); e.value = ''; }})()")
        self.call("Input.insertText", text=text)

    def settle(self):
        """Waits for the fine picture of what was asked for."""
        self.wait("NdgViewer.get().isFine && !NdgViewer.get().needsPicture")

    def mouse(self, kind, x, y, button="none"):
        pressed = 1 if kind == "mousePressed" or (kind == "mouseMoved" and button != "none") else 0
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, buttons=pressed, clickCount=1)

    def click(self, x, y):
        self.mouse("mouseMoved", x, y)
        self.mouse("mousePressed", x, y, "left")
        self.mouse("mouseReleased", x, y, "left")

    def click_on(self, selector):
        place = self.run(f"(() => {{ const e = document.querySelector({json.dumps(selector)}); e.scrollIntoView({{block: 'center'}}); "
                         "const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()")
        self.click(*place)

    def screenshot(self, path=None):
        """Height x width x 3 of bytes."""
        png = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        if path:
            with open(path, "wb") as file:
                file.write(png)
        return decode_png(png)


def decode_png(png):
    """Pixels of a PNG of 8 bits a channel, not interlaced, as browsers write them: height x width x channels."""
    at, data = 8, b""
    while at < len(png):
        size, kind = struct.unpack(">I4s", png[at:at + 8])
        if kind == b"IHDR":
            width, height, _, colour = struct.unpack(">IIBB", png[at + 8:at + 18])
        if kind == b"IDAT":
            data += png[at + 8:at + 8 + size]
        at += size + 12
    channels = {2: 3, 6: 4}[colour]
    rows = numpy.frombuffer(zlib.decompress(data), numpy.uint8).reshape(height, 1 + width * channels)
    image = numpy.zeros((height, width * channels), numpy.uint8)
    above = numpy.zeros(width * channels, numpy.int64)
    for y in range(height):
        kind, row = rows[y, 0], rows[y, 1:].astype(numpy.int64)
        if kind == 2:
            row = row + above
        elif kind == 1:
            row = row.reshape(width, channels).cumsum(axis=0).ravel()
        elif kind in (3, 4):
            left = numpy.zeros(channels, numpy.int64)
            corner = numpy.zeros(channels, numpy.int64)
            for x in range(0, width * channels, channels):
                up = above[x:x + channels]
                if kind == 3:
                    guess = (left + up) // 2
                else:
                    p = left + up - corner
                    a, b, c = abs(p - left), abs(p - up), abs(p - corner)
                    guess = numpy.where((a <= b) & (a <= c), left, numpy.where(b <= c, up, corner))
                left = (row[x:x + channels] + guess) & 255
                row[x:x + channels] = left
                corner = up
        above = row & 255
        image[y] = above
    return image.reshape(height, width, channels)[:, :, :3]
