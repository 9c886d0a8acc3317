"""The preview as a page: the same desk and the same scene, drawn here and sent to a browser by trame.

Nothing is answered without the token of the address: no page, no file, no socket. The server listens on this
machine alone unless it is told otherwise.
"""

import asyncio
import base64
import contextlib
import hmac
import math
import os
import secrets
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from surftex.errors import InputError, WorkError
from surftex.files.images import jpeg_bytes
from surftex.preview.controls import Control
from surftex.preview.desk import OVERLAYS, TOOLS, Desk
from surftex.preview.scene import Scene
from surftex.preview.studio import STUDIOS

_COMMANDS = ("preset", "redo", "seed", "toggle", "undo")
"""What the page may ask of the session beside `set` and `save`, which are told nothing but values."""

_SIZE = (960, 760)
_SHOWN = "[$event.target.clientWidth, $event.target.clientHeight]"
_PROMPT_S, _REST_S = 0.1, 0.25
"""Drawing that takes longer is done small at first; and how long nothing must change before it is done in full."""


def check_web() -> None:
    """Find out whether the page can be served, before any work.

    Raises
    ------
    WorkError
        If a library is missing; the message says how to install it.
    """
    try:
        import trame.app
        import trame.widgets.vuetify3  # noqa: F401
    except ImportError:
        raise WorkError("--web needs trame; install it with: pip install 'surftex[web]'") from None
    from surftex.preview.scene import check_display

    check_display(off_screen=True)


def serve(
    desk: Desk, *, host: str = "127.0.0.1", port: int = 0, save_as: Path = Path("preview.toml"),
    ready: Callable[[str], None] = lambda address: None, token: str | None = None,
) -> None:  # fmt: skip
    """Serve a desk until interrupted.

    Parameters
    ----------
    desk : Desk
        What is shown.
    host : str
        Name or number of the interface to listen on.
    port : int
        0 takes any that is free.
    save_as : Path
        What ``save`` writes.
    ready : callable
        ``ready(address)`` is told the address with its token.
    token : str, optional
        Any text that cannot be guessed; a new one without it.

    Raises
    ------
    WorkError
        If the server cannot listen there, or there is no OpenGL.
    """
    check_web()
    page = Page(desk, save_as)
    try:
        asyncio.run(page.run(host, port, ready, token or secrets.token_urlsafe(24)))
    except OSError as problem:
        raise WorkError(f"cannot listen on {host}:{port}: {problem.strerror or problem}") from None
    finally:
        page.scene.close()


class Page:
    """A desk as a page.

    Parameters
    ----------
    desk : Desk
        What is shown.
    save_as : Path
        What ``save`` writes.
    """

    def __init__(self, desk: Desk, save_as: Path) -> None:
        from trame.app import get_server

        self.desk, self.save_as = desk, save_as
        self.scene = Scene(desk, _SIZE)
        self.server: Any = get_server(f"surftex-{id(self)}", client_type="vue3")
        self.server.cli.parse_known_args = _no_arguments(self.server.cli)
        self._loop: Any = None
        self._waiting, self._camera_moved, self._full_s = False, True, 0.0
        self._rest: Any = None
        self.server.state.trame__title = f"surftex {desk.surface.name}"
        self.server.state.name = desk.surface.name
        self.server.state.picture = ""
        self._sync()
        self._build()

    async def run(self, host: str, port: int, ready: Callable[[str], None], token: str) -> None:
        """Listen until the task is cancelled.

        Parameters
        ----------
        host : str
            Interface.
        port : int
            0 for any.
        ready : callable
            Told the address.
        token : str
            That every request must know.
        """
        self._loop = asyncio.get_running_loop()
        self.server.controller.on_server_bind.add(lambda web: web.app.middlewares.append(_guard(token)))

        def told(**_: Any) -> None:
            shown = f"[{host}]" if ":" in host else host
            ready(f"http://{shown}:{self.server.port}/?token={token}")

        self.server.controller.on_server_ready.add(told)
        self.desk.listeners.append(self._changed)
        os.environ["WSLINK_READY_MSG"] = ""
        try:
            await self.server.start(
                host=host, port=port, exec_mode="coroutine", open_browser=False, show_connection_info=False,
                timeout=0, disable_logging=True, backend="aiohttp", thread=True,  # which leaves Ctrl-C to the command
            )  # fmt: skip
        finally:
            with contextlib.suppress(ValueError):
                self.desk.listeners.remove(self._changed)

    def _changed(self) -> None:
        """Hear from the desk, in whatever thread, that there is something new."""
        if self._loop is not None and not self._waiting:
            self._waiting = True
            self._loop.call_soon_threadsafe(self._sync)

    def _sync(self) -> None:
        """Send what is new to the browser: where drawing takes long, a small picture at once, the full one when it rests."""
        self._waiting = False
        if self.scene.refresh() or self._camera_moved:
            self._camera_moved = False
            loop = self._loop if self._full_s > _PROMPT_S else None
            self._draw(1.0 if loop is None else 0.5)
            if self._rest is not None:
                self._rest.cancel()
            self._rest = None if loop is None else loop.call_later(_REST_S, self._sharpen)
        self._tell()
        self.server.state.flush()

    def _sharpen(self) -> None:
        """Send the full picture."""
        self._rest = None
        self._draw(1.0)
        self.server.state.flush()

    def _draw(self, share: float) -> None:
        """Draw the scene at a share of its size."""
        size, start = self.scene.size, time.perf_counter()
        if share < 1:
            self.scene.resize(*(max(1, round(share * side)) for side in size))
        picture = self.scene.picture()
        if share < 1:
            self.scene.resize(*size)
        else:
            self._full_s = time.perf_counter() - start
        data = base64.b64encode(jpeg_bytes(picture)).decode()
        self.server.state.picture = f"data:image/jpeg;base64,{data}"

    def _tell(self) -> None:
        """Lay the desk out as plain numbers and words."""
        desk, state = self.desk, self.server.state
        recipe = desk.session.recipe
        group = desk.group or desk.groups[0]
        state.message, state.busy = desk.message, desk.worker.busy
        state.groups, state.group = list(desk.groups), group
        state.presets, state.preset = desk.presets(), recipe.layer[desk.layer].preset
        state.seed = recipe.seed
        state.tool, state.tools = desk.tool, list(TOOLS)
        state.overlays, state.shown = list(OVERLAYS), sorted(desk.overlays)
        state.light, state.lights = desk.light, list(STUDIOS)
        state.drawing = bool(desk.points) and desk.tool in ("stroke", "lines")
        state.layers = [
            {"name": f"{i + 1} {layer.preset or layer.kind}", "on": i not in desk.session.state.hidden}
            for i, layer in enumerate(recipe.layer)
        ]
        state.layer = desk.layer
        state.rows = [
            row
            for control in desk.session.controls(desk.layer)
            if control.group == group
            for row in self._rows(control)
        ]
        cut = desk.section
        state.section = "" if cut is None else _polyline(cut.along_mm.tolist(), cut.height_mm.tolist())

    def _rows(self, control: Control) -> list[dict[str, Any]]:
        """Lay one parameter out: a row, or one for each of its numbers."""
        value = self.desk.session.value(control.key, self.desk.layer)
        row = {
            "key": control.key, "part": -1, "label": control.label, "text": control.shown(value), "hint": control.text,
            "low": control.low, "high": control.high, "step": control.step, "kind": control.kind, "value": value,
            "choices": list(control.choices),
        }  # fmt: skip
        if control.kind == "range":
            return [
                {**row, "part": k, "kind": "number", "value": each, "text": control.shown(each),
                 "label": control.label if k == 0 else ""}
                for k, each in enumerate(value)
            ]  # fmt: skip
        if control.kind == "colour":
            from surftex.preview.panel import screen_codes

            codes = [round(255 * float(each)) for each in screen_codes(value)]
            return [{**row, "value": "#{:02x}{:02x}{:02x}".format(*codes), "text": ""}]
        if control.kind in ("number", "whole") and not isinstance(value, (int, float)):
            row["kind"] = "text"
        if row["kind"] == "text":
            row["value"] = "" if value is None else row["text"] if isinstance(value, tuple) else str(value)
        return [row]

    def _set(self, key: str, part: int, value: Any) -> None:
        """Take a value from the page."""
        desk = self.desk
        control = next((each for each in desk.session.controls(desk.layer) if each.key == key), None)
        if control is None:  # another page has chosen another layer meanwhile
            return
        if control.kind == "range":
            both = [*desk.session.value(key, desk.layer)]
            both[part] = float(value)
            value = both
        elif control.kind == "whole":
            value = int(value)
        elif control.kind == "number" and isinstance(value, (int, float)):
            value = float(value)
        elif control.kind == "text":
            value = value or None
        desk.do("set", key, value, desk.layer)

    def _do(self, name: str, *arguments: Any) -> None:
        """Take a command from the page."""
        if name in _COMMANDS:
            self.desk.do(name, *arguments)

    def _choose(self, key: str, value: Any) -> None:
        """Take a choice, unless another page has taken away meanwhile what was chosen."""
        with contextlib.suppress(InputError):
            self.desk.choose(**{key: value})

    def _pressed(self, x: float, y: float, width: float, height: float) -> None:
        """Take a click, in pixels from the upper left corner of what holds the picture: as large as fits, in its middle."""
        if self.desk.tool == "turn" or not (width > 0 and height > 0):
            return
        wide, high = self.scene.size
        scale = min(width / wide, height / high)
        column, row = (x - width / 2) / scale + wide / 2, (y - height / 2) / scale + high / 2
        if not (0 <= column < wide and 0 <= row < high):
            return
        point = self.scene.place(column, high - 1 - row)
        if point is not None:
            self.desk.click(point)

    def _moved(self, move: Callable[..., None]) -> Callable[..., None]:
        """Let a movement of the camera be followed by a picture."""

        def moved(*numbers: float) -> None:
            if not all(math.isfinite(number) for number in numbers):
                return  # a camera would not come back from there
            move(*numbers)
            self._camera_moved = True
            self._changed()

        return moved

    def _sized(self, width: float, height: float) -> None:
        """Draw as large as the page shows it."""
        if not (width > 0 and height > 0):
            return
        size = (int(np.clip(width, 64, 4096)), int(np.clip(height, 64, 4096)))
        if size != self.scene.size:
            self._moved(self.scene.resize)(*size)

    def _build(self) -> None:
        """Write the page."""
        from trame.ui.vuetify3 import VAppLayout
        from trame.widgets import client, html
        from trame.widgets import vuetify3 as v

        desk, server = self.desk, self.server
        server.trigger("set")(self._set)
        server.trigger("do")(self._do)
        server.trigger("choose")(self._choose)
        server.trigger("whole")(self._moved(self.scene.reset_camera))
        server.trigger("done")(desk.done)
        server.trigger("press")(self._pressed)
        server.trigger("size")(self._sized)
        server.trigger("turn")(self._moved(self.scene.turn))
        server.trigger("zoom")(self._moved(self.scene.zoom))
        server.trigger("save")(lambda: desk.do("save", self.save_as, overwrite=True))
        look = "position:fixed;inset:0;overflow:hidden;display:flex;background:#202022;color:#e8e6e2;font-family:sans-serif"
        with VAppLayout(server, theme="dark") as layout, html.Div(style=look, id="preview"):
            client.Style("html { overflow: hidden !important }")
            with html.Div(style="flex:1;position:relative;min-width:0"):
                html.Img(
                    src=("picture",), id="view", draggable="false", style="width:100%;height:100%;object-fit:contain",
                    __events=["load"], load=(
                        f"$event.target.dataset.size !== {_SHOWN}.join() && ($event.target.dataset.size = {_SHOWN}.join(), "
                        f"trigger('size', {_SHOWN}))"
                    ),
                    click=f"trigger('press', [$event.offsetX, $event.offsetY, ...{_SHOWN}])",
                    mousemove=(
                        "($event.buttons === 1 || $event.buttons === 4) && trigger('turn', [$event.movementX, "
                        "$event.movementY, $event.shiftKey || $event.buttons === 4])"
                    ),
                    wheel="trigger('zoom', [$event.deltaY])",
                )  # fmt: skip
                with html.Div(
                    v_if=("section",),
                    style=(
                        "position:absolute;left:16px;bottom:16px;max-width:calc(100% - 32px);background:#202022e0;"
                        "padding:8px"
                    ),
                ):
                    html.Div("{{ message }}", style="font-size:12px")
                    html.Div(v_html=("section",))
            with html.Div(
                style="width:372px;padding:12px;flex:none;display:flex;flex-direction:column", id="panel"
            ):
                html.Div("{{ name }}", style="font-size:18px;font-weight:600")
                html.Div(
                    "{{ message }}", id="message", title=("message",),
                    style="font-size:13px;opacity:.7;min-height:20px;max-height:80px;flex:none;overflow:auto;overflow-wrap:anywhere",
                )  # fmt: skip
                v.VProgressLinear(indeterminate=True, v_show=("busy",), height=2, color="#cc7338")
                html.Div(v_show=("!busy",), style="height:2px")
                with html.Div(style="display:flex;gap:6px;margin:8px 0;flex-wrap:wrap"):
                    for name in ("undo", "redo"):
                        v.VBtn(
                            name, size="small", variant="tonal", click=f"trigger('do', ['{name}'])", id=name
                        )
                    v.VBtn("save", size="small", variant="tonal", click="trigger('save')", id="save")
                    v.VBtn("whole", size="small", variant="tonal", click="trigger('whole')", id="whole")
                    v.VBtn(
                        "seed {{ seed }}", size="small", variant="tonal", id="seed",
                        click="trigger('do', ['seed', seed + 1])",
                    )  # fmt: skip
                with html.Div(
                    v_for="(each, i) in layers",
                    v_show="layers.length > 1",
                    key="i",
                    style="display:flex;gap:6px",
                ):
                    v.VBtn(
                        "{{ each.on ? 'on' : 'off' }}", size="x-small", variant="tonal",
                        click="trigger('do', ['toggle', i])",
                    )  # fmt: skip
                    v.VBtn(
                        "{{ each.name }}", size="x-small", click="trigger('choose', ['layer', i])",
                        color=("i === layer ? '#cc7338' : undefined",), variant="tonal",
                    )  # fmt: skip
                v.VSelect(
                    model_value=("preset",), items=("presets",), label="preset", density="compact", id="preset",
                    hide_details=True, variant="outlined", style="margin:8px 0;flex:none",
                    update_modelValue="trigger('do', ['preset', $event, layer])",
                )  # fmt: skip
                _chips(html, v, "groups", "each === group", "trigger('choose', ['group', each])")
                with (
                    html.Div(style="flex:1;overflow-y:auto;min-height:0;padding-right:6px"),
                    html.Div(
                        v_for="row in rows",
                        key="row.key + row.part",
                        style="margin:6px 0",
                        title=("row.hint",),
                    ),
                ):
                    with html.Div(style="display:flex;justify-content:space-between;font-size:13px"):
                        html.Span("{{ row.label }}", style="opacity:.7")
                        html.Span("{{ row.text }}")
                    v.VSlider(
                        v_if="row.kind === 'number' || row.kind === 'whole'", model_value=("row.value",),
                        min=("row.low",), max=("row.high",), step=("row.step",), hide_details=True, color="#cc7338",
                        density="compact", thumb_size=14, track_size=3, id=("'slider-' + row.key",),
                        update_modelValue="trigger('set', [row.key, row.part, $event])",
                    )  # fmt: skip
                    with v.VBtnToggle(
                        v_if="row.kind === 'choice'", model_value=("row.value",), density="compact", divided=True,
                        update_modelValue="trigger('set', [row.key, -1, $event])",
                    ):  # fmt: skip
                        v.VBtn(
                            "{{ each }}",
                            v_for="each in row.choices",
                            key="each",
                            value=("each",),
                            size="x-small",
                        )
                    v.VSwitch(
                        v_if="row.kind === 'switch'", model_value=("row.value",), hide_details=True,
                        density="compact", color="#cc7338",
                        update_modelValue="trigger('set', [row.key, -1, $event])",
                    )  # fmt: skip
                    v.VTextField(
                        v_if="row.kind === 'text'", model_value=("row.value",), hide_details=True, density="compact",
                        variant="outlined", change="trigger('set', [row.key, -1, $event.target.value])",
                    )  # fmt: skip
                    html.Input(
                        v_if="row.kind === 'colour'", type="color", value=("row.value",),
                        input="trigger('set', [row.key, -1, $event.target.value])", style="width:100%;height:26px",
                    )  # fmt: skip
                html.Hr(style="margin:12px 0;opacity:.2")
                _chips(html, v, "tools", "each === tool", "trigger('choose', ['tool', each])")
                v.VBtn("done", v_if=("drawing",), size="small", click="trigger('done')", id="done")
                _chips(html, v, "overlays", "shown.includes(each)", "trigger('choose', ['overlay', each])")
                _chips(html, v, "lights", "each === light", "trigger('choose', ['light', each])")
        self.layout = layout


def _chips(html: Any, v: Any, names: str, lit: str, click: str) -> None:
    """Write a row of buttons, one for each name of a list."""
    with html.Div(style="display:flex;gap:5px;flex-wrap:wrap;margin:6px 0"):
        v.VBtn(
            "{{ each }}", v_for=f"each in {names}", key="each", size="x-small", variant="tonal", click=click,
            color=(f"{lit} ? '#cc7338' : undefined",), id=("'chip-' + each",), style="text-transform:none",
        )  # fmt: skip


def _polyline(x: list[float], y: list[float]) -> str:
    """Draw a curve as SVG."""
    low, high, far = min(y), max(y), max(x[-1], 1e-9)
    span = max(high - low, 1e-9)
    places = " ".join(
        f"{480 * a / far:.1f},{116 - 112 * (b - low) / span:.1f}" for a, b in zip(x, y, strict=True)
    )
    return (
        f'<svg viewBox="0 0 480 120" style="width:480px;max-width:100%"><polyline points="{places}" fill="none" '
        'stroke="#73adff" stroke-width="1.5"/></svg>'
    )


def _guard(token: str) -> Any:
    """Make the gate before every request: the token in the address, once, then a cookie of this browser alone."""
    from aiohttp import web

    def known(text: str | None) -> bool:
        return text is not None and hmac.compare_digest(text.encode(), token.encode())

    @web.middleware
    async def gate(request: Any, handler: Any) -> Any:
        given = request.query.get("token")
        origin = request.headers.get("Origin")
        foreign = origin is not None and origin.partition("://")[2] != request.host
        port = "".join(filter(str.isdecimal, request.host.rpartition(":")[2]))
        own = f"surftex-{port}"  # cookies do not tell ports apart, and there may be several previews
        if foreign or not (known(given) or known(request.cookies.get(own))):
            return web.Response(status=403, text="403: this address needs its token\n")
        if known(given):
            answer = web.HTTPFound("/index.html")
            answer.set_cookie(own, token, httponly=True, samesite="Strict", path="/")
            answer.headers["Referrer-Policy"] = "no-referrer"
            return answer
        return await handler(request)

    return gate


def _no_arguments(parser: Any) -> Callable[..., Any]:
    """Let the server's own parser see nothing of our command line."""
    parse = parser.parse_known_args
    return lambda arguments=None, namespace=None: parse(arguments or [], namespace)
