"""A headless Chromium, driven through its debugging protocol; nothing but aiohttp, which the page itself needs."""

import asyncio
import base64
import itertools
import json
import os
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome")


def found() -> str | None:
    """Path of a Chromium; None where there is none."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


class Browser:
    """One page of a browser; use it as an asynchronous context."""

    def __init__(self, folder: Path, size: tuple[int, int] = (1280, 800)) -> None:
        self.folder, self.size = folder, size
        self.numbers = itertools.count(1)

    async def __aenter__(self) -> "Browser":
        import aiohttp

        sandbox = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
        self.process = subprocess.Popen(
            [found() or "chromium", "--headless=new", "--remote-debugging-port=0", *sandbox,
             f"--user-data-dir={self.folder}", f"--window-size={self.size[0]},{self.size[1]}", "--disable-gpu",
             "--no-first-run", "--disable-dev-shm-usage", "--disable-extensions", "about:blank"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        told = self.folder / "DevToolsActivePort"
        for _ in range(600):
            if told.exists() and told.read_text().count("\n"):
                break
            await asyncio.sleep(0.1)
        port = int(told.read_text().split("\n")[0])
        self.client = aiohttp.ClientSession()
        async with self.client.get(f"http://127.0.0.1:{port}/json") as answer:
            page = next(each for each in await answer.json() if each["type"] == "page")
        self.socket = await self.client.ws_connect(page["webSocketDebuggerUrl"], max_msg_size=0)
        await self.send("Page.enable")
        return self

    async def __aexit__(self, *problem: object) -> None:
        await self.socket.close()
        await self.client.close()
        self.process.terminate()
        self.process.wait(20)

    async def send(self, method: str, **parameters: Any) -> Any:
        """Call a method of the protocol."""
        number = next(self.numbers)
        await self.socket.send_json({"id": number, "method": method, "params": parameters})
        while True:
            answer = json.loads((await self.socket.receive(timeout=60)).data)
            if answer.get("id") == number:
                assert "error" not in answer, answer["error"]
                return answer["result"]

    async def open(self, address: str) -> None:
        await self.send("Page.navigate", url=address)

    async def ask(self, script: str) -> Any:
        """Value of an expression on the page."""
        answer = await self.send("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        return answer["result"].get("value")

    async def until(self, script: str, seconds: float = 60.0) -> float:
        """Seconds until an expression is true."""
        start = time.perf_counter()
        while not await self.ask(script):
            assert time.perf_counter() - start < seconds, f"never true: {script}"
            await asyncio.sleep(0.02)
        return time.perf_counter() - start

    async def press(self, x: float, y: float) -> None:
        for kind in ("mousePressed", "mouseReleased"):
            await self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    async def place(self, selector: str, across: float = 0.5) -> tuple[float, float]:
        """Somewhere on an element."""
        box = await self.ask(
            f"(() => {{ const b = document.querySelector({json.dumps(selector)}).getBoundingClientRect();"
            " return [b.left, b.top, b.width, b.height]; })()"
        )
        return box[0] + across * box[2], box[1] + box[3] / 2

    async def picture(self) -> bytes:
        """PNG of what is seen."""
        return base64.b64decode((await self.send("Page.captureScreenshot", format="png"))["data"])
