"""The panel beside the view: which buttons and sliders stand where, and what the mouse does to them. It draws nothing."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from surftex.preview.controls import Control
from surftex.preview.desk import OVERLAYS, TOOLS, Desk
from surftex.preview.studio import STUDIOS
from surftex.recipe.fields import CURVES, DIRECTIONS

ROW, PAD, CHIP = 22, 12, 7.4
"""Height of a row, margin, and width of a letter, in pixels."""


@dataclass(frozen=True)
class Item:
    """One thing on the panel.

    Attributes
    ----------
    kind : str
        title, label, chip, slider or swatch.
    left, top, width, height : float
        In pixels from the panel's upper left corner.
    text : str
        On it, or left above it.
    value : str
        Right above a slider.
    share : float
        Where a slider stands, 0 to 1.
    lit : bool
        Whether a chip is chosen.
    action : tuple
        What a click does; empty for none. ``("slide", control, part)`` follows the mouse.
    color : (3,) tuple
        Of a swatch, sRGB 0 to 1.
    """

    kind: Literal["title", "label", "chip", "slider", "swatch"]
    left: float
    top: float
    width: float
    height: float = ROW
    text: str = ""
    value: str = ""
    share: float = 0.0
    lit: bool = False
    action: tuple[Any, ...] = ()
    color: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def holds(self, x: float, y: float) -> bool:
        """Tell whether a place lies on it."""
        return self.left <= x <= self.left + self.width and self.top <= y <= self.top + self.height


def layout(desk: Desk, width: float, height: float, skipped: int = 0) -> list[Item]:
    """Lay the panel out.

    Parameters
    ----------
    desk : Desk
        What is to be shown.
    width : float
        Of the panel in pixels.
    height : float
        Of the panel.
    skipped : int
        Parameters of the group that are scrolled away; what does not fit below comes with the button *more*.

    Returns
    -------
    items : list of Item
        From top to bottom.
    """
    recipe, items = desk.session.recipe, list[Item]()
    inner = width - 2 * PAD
    top = float(PAD)

    def chips(chosen: list[tuple[str, bool, tuple[Any, ...]]], top: float) -> float:
        x = float(PAD)
        for text, lit, action in chosen:
            wide = CHIP * len(text) + 14
            if x + wide > PAD + inner and x > PAD:
                x, top = float(PAD), top + ROW + 4
            items.append(Item("chip", x, top, wide, text=text, lit=lit, action=action))
            x += wide + 5
        return top + ROW + 8

    items.append(Item("title", PAD, top, inner, text=f"{desk.surface.name}  {recipe.layer[desk.layer].kind}"))
    top += ROW + 4
    items.append(Item("label", PAD, top, inner, text=_fitted(desk.message, inner)))
    top += ROW + 6
    top = chips(
        [
            ("undo", False, ("do", "undo")),
            ("redo", False, ("do", "redo")),
            ("save", False, ("save",)),
            (f"seed {recipe.seed}", False, ("do", "seed", recipe.seed + 1)),
        ],
        top,
    )
    if len(recipe.layer) > 1:
        for i, layer in enumerate(recipe.layer):
            shown = i not in desk.session.state.hidden
            name = f"{i + 1} {layer.preset or layer.kind}"
            top = chips(
                [
                    ("on" if shown else "off", shown, ("do", "toggle", i)),
                    (name, i == desk.layer, ("choose", "layer", i)),
                ],
                top,
            )
    names = desk.presets()
    if names:
        now = recipe.layer[desk.layer].preset
        at = names.index(now) if now in names else -1
        before, after = names[(at - 1) % len(names)], names[(at + 1) % len(names)]
        top = chips(
            [
                ("<", False, ("do", "preset", before, desk.layer)),
                (now or "no preset", True, ()),
                (">", False, ("do", "preset", after, desk.layer)),
            ],
            top,
        )
    group = desk.group or desk.groups[0]
    top = chips([(each, each == group, ("choose", "group", each)) for each in desk.groups], top + 4) + 4
    below = _feet(desk, inner, height)
    chosen = [control for control in desk.session.controls(desk.layer) if control.group == group]
    first = min(max(skipped, 0), len(chosen) - 1)
    if first:
        top = chips([("back", False, ("skip", -first))], top)
    for k, control in enumerate(chosen[first:]):
        rows = _rows(desk, control, top, inner)
        if rows[-1].top + rows[-1].height > below[0].top - ROW - 8 and first + k + 1 < len(chosen):
            chips([("more", False, ("skip", max(k, 1)))], top)
            break
        items += rows
        top = rows[-1].top + rows[-1].height + 8
    return items + below


def _feet(desk: Desk, inner: float, height: float) -> list[Item]:
    """Tools, overlays and lights, at the bottom."""
    rows: list[list[tuple[str, bool, tuple[Any, ...]]]] = [
        [(name, name == desk.tool, ("choose", "tool", name)) for name in TOOLS]
        + ([("done", False, ("done",))] if desk.points and desk.tool in ("stroke", "lines") else []),
        [(name, name in desk.overlays, ("choose", "overlay", name)) for name in OVERLAYS],
        [(name, name == desk.light, ("choose", "light", name)) for name in STUDIOS],
    ]
    items, top = [], height - PAD - len(rows) * (ROW + 5)
    for row in rows:
        x = float(PAD)
        for text, lit, action in row:
            wide = CHIP * len(text) + 14
            items.append(Item("chip", x, top, wide, text=text, lit=lit, action=action))
            x += wide + 5
        top += ROW + 5
    return items


def _rows(desk: Desk, control: Control, top: float, inner: float) -> list[Item]:
    """Items of one parameter."""
    value = desk.session.value(control.key, desk.layer)
    label = Item("label", PAD, top, inner, 18, text=control.label, value=control.shown(value))
    under = top + 18
    if control.kind in ("number", "whole") and isinstance(value, (int, float)):
        return [Item("slider", PAD, top, inner, 34, control.label, control.shown(value), _share(control, value),
                     action=("slide", control, -1))]  # fmt: skip
    if control.kind == "range":
        return [
            Item("slider", PAD, top + 36 * k, inner, 34, control.label if k == 0 else "", control.shown(each),
                 _share(control, each), action=("slide", control, k))
            for k, each in enumerate(value)
        ]  # fmt: skip
    if control.kind == "colour":
        codes = [float(each) for each in screen_codes(value)]
        third = (inner - 46) / 3
        swatch = Item("swatch", PAD, under + 2, 36, 18, color=(codes[0], codes[1], codes[2]))
        return [
            Item("label", PAD, top, inner, 18, text=control.label), swatch,
            *(Item("slider", PAD + 44 + k * third, under - 14, third - 8, 34, share=codes[k],
                   action=("slide", control, k)) for k in range(3)),
        ]  # fmt: skip
    options: list[tuple[str, Any]] = []
    if control.kind == "choice":
        options = [(each, each) for each in control.choices]
    elif control.kind == "switch":
        options = [("yes", True), ("no", False)]
    elif value is None or isinstance(value, str):
        entries = desk.session.recipe.fields_.items()
        taken = CURVES if control.key.endswith("_curves") else DIRECTIONS if control.key in _DIRECTED else ()
        fields = [name for name, entry in entries if isinstance(entry, taken) or value == name]
        options = [(each, each) for each in fields]
    x, items = float(PAD), [label]
    for text, each in options:
        wide = CHIP * len(text) + 14
        if x + wide > PAD + inner:
            break
        action = ("do", "set", control.key, each, desk.layer)
        items.append(Item("chip", x, under, wide, text=text, lit=value == each, action=action))
        x += wide + 5
    return items


_DIRECTED = (
    "direction",
    "stress",
    "drift",
    "follicle_direction",
    "wrinkle_direction",
    "wrinkle_vectors",
    "relief_direction",
)


def hit(items: list[Item], x: float, y: float) -> Item | None:
    """Find what lies under the mouse.

    Parameters
    ----------
    items : list of Item
        From `layout`.
    x : float
        From the panel's left, pixels.
    y : float
        From its top.

    Returns
    -------
    item : Item or None
        One that does something.
    """
    return next((item for item in items if item.action and item.holds(x, y)), None)


def slide(desk: Desk, item: Item, x: float) -> None:
    """Set the parameter of a slider to where the mouse is.

    Parameters
    ----------
    desk : Desk
        Whose parameter.
    item : Item
        The slider.
    x : float
        From the panel's left, pixels.
    """
    _, control, part = item.action
    share = float(np.clip((x - item.left) / item.width, 0, 1))
    if control.kind == "colour":
        codes = screen_codes(desk.session.value(control.key, desk.layer))
        codes[part] = share
        linear = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
        desk.do("set", control.key, [float(each) for each in linear], desk.layer)
        return
    span = control.high - control.low
    number = control.low + round(share * span / control.step) * control.step
    number = float(np.clip(round(number, 9), control.low, control.high))
    value: Any = int(number) if control.kind == "whole" else number
    if control.kind == "range":
        value = [*desk.session.value(control.key, desk.layer)]
        value[part] = number
    desk.do("set", control.key, value, desk.layer)


def _share(control: Control, value: float) -> float:
    return float(np.clip((value - control.low) / max(control.high - control.low, 1e-12), 0, 1))


def screen_codes(linear: Any) -> np.ndarray:
    """Encode a colour as screens show it.

    Parameters
    ----------
    linear : (3,) float
        Linear light, 0 to 1.

    Returns
    -------
    codes : (3,) float64
        sRGB, 0 to 1.
    """
    value = np.asarray(linear, float)
    return np.where(value <= 0.0031308, 12.92 * value, 1.055 * np.maximum(value, 1e-9) ** (1 / 2.4) - 0.055)


def _fitted(text: str, width: float) -> str:
    most = int(width / 6.6)
    return text if len(text) <= most else text[: most - 3] + "..."
