"""`Desk`: a session, its page and its worker under one roof; window and web page are views of it.

A view tells the desk what its user does, and draws what the desk holds whenever `version` has grown.
"""

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from surftex.bake.stack import Stack
from surftex.errors import InputError, SurftexError
from surftex.geodesics.paths import shortest_path
from surftex.preview.live import Frame, Live
from surftex.preview.section import Section, curve_points
from surftex.preview.session import Session, Use
from surftex.preview.studio import STUDIOS
from surftex.preview.worker import Worker
from surftex.recipe.layer import all_presets
from surftex.recipe.model import Recipe
from surftex.recipe.read import load_recipe, recipe_files
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.surface import Surface

Tool = Literal["turn", "stroke", "lines", "spots", "section"]

TOOLS: dict[str, str] = {
    "turn": "Turn the surface.",
    "stroke": "Draw a direction: click along it, then press done.",
    "lines": "Draw a line such as a wrinkle: click along it, then press done.",
    "spots": "Pick single places: moles of skin.",
    "section": "Cut: click two places.",
}
"""What a click on the surface does."""

OVERLAYS = ("seams", "charts", "regions", "features", "drawn")

FIELD = {"stroke": "grain", "lines": "drawn", "spots": "spots"}
"""Name of the field that each tool draws into."""


class Desk:
    """Everything that a preview is, but for its pictures on a screen.

    Parameters
    ----------
    recipe : Recipe
        To start from.
    surface : Surface
        What is looked at.
    resolution : int
        Side of the page in texels.
    threads : int, optional
        None means every core.
    """

    def __init__(
        self, recipe: Recipe, surface: Surface, *, resolution: int = 1024, threads: int | None = None
    ) -> None:
        self.surface = surface
        self.session = Session(recipe, surface)
        self.live = Live(surface, recipe, resolution=resolution, threads=threads)
        self.lock = threading.Lock()
        self.version = 0
        self.changed = set[str]()
        self.frame: Frame | None = None
        self.message, self._held = "placing features", False
        self.layer, self.group = 0, ""
        self.tool: Tool = "turn"
        self.overlays = {"drawn"}
        self.light = "studio"
        self.points: list[SurfacePoints] = []
        self.path: NDArray[np.float64] | None = None
        self.section: Section | None = None
        self.listeners: list[Callable[[], None]] = []
        self.look_at = surface.vertices[surface.faces].mean(axis=1)[_foremost(surface)]
        self.worker = Worker(self.live, self._arrived, self._troubled)
        self._refresh()

    def close(self) -> None:
        """End all work."""
        self.worker.close()
        self.session.close()

    @property
    def groups(self) -> tuple[str, ...]:
        """Groups of the chosen layer's parameters."""
        return tuple(dict.fromkeys(control.group for control in self.session.controls(self.layer)))

    @property
    def stack(self) -> Stack:
        """Patterns and masks as last drawn in full."""
        return self.live.stack

    def presets(self) -> list[str]:
        """List the presets of the chosen layer's material.

        Returns
        -------
        names : list of str
            In the order of the shelf.
        """
        return list(all_presets().get(self.session.recipe.layer[self.layer].kind, {}))

    def do(self, name: str, *arguments: Any, **options: Any) -> None:
        """Run a command of the session, and show what comes of it; what is wrong with it becomes the message.

        Parameters
        ----------
        name : str
            Such as ``set``, ``undo``, ``preset``.
        *arguments : Any
            Of the command.
        **options : Any
            Of the command.
        """
        self._held = False
        try:
            result = getattr(self.session, name)(*arguments, **options)
            if name in ("undo", "redo"):
                self.message = f"{name}: {result}" if result else f"nothing to {name}"
            elif name == "save":
                self.message = f"saved{_elsewhere(result[-1])} {result[-1]}"
                self._tell()
                return
        except SurftexError as problem:
            self.message, self._held = (
                str(problem),
                True,
            )  # work at hand goes on, and must not talk over it
            self._tell()
            return
        self.layer = min(self.layer, len(self.session.recipe.layer) - 1)
        self._refresh()

    def choose(self, **choices: Any) -> None:
        """Choose a layer, group, tool, light or overlay.

        Parameters
        ----------
        **choices : Any
            ``layer=1``, ``group="pores"``, ``tool="section"``, ``light="raking"``, or ``overlay="seams"`` to switch
            it on or off.

        Raises
        ------
        InputError
            If there is none of that name.
        """
        self._held = False
        for key, value in choices.items():
            known: Any = {
                "layer": range(len(self.session.recipe.layer)), "group": self.groups, "tool": TOOLS, "light": STUDIOS,
                "overlay": OVERLAYS,
            }.get(key)  # fmt: skip
            if known is None or value not in known:
                raise InputError(f"there is no {key} {value!r}")
            if key == "overlay":
                self.overlays ^= {value}
                if value in ("charts", "regions") and value in self.overlays:
                    self.overlays -= {"charts", "regions"} - {value}
                self.changed.add("base_color")
            else:
                setattr(self, key, value)
            if key == "tool":
                self.points, self.path, self.section = [], None, None
                self.message = TOOLS[value]
            if key == "layer":
                self.group = ""
        self._tell()

    def click(self, point: SurfacePoints) -> None:
        """Take a place that was clicked, as the tool says.

        Parameters
        ----------
        point : SurfacePoints
            One place.
        """
        self.look_at = point.positions(self.surface)[0]
        if self.tool == "spots":
            name = self.session.free_name(FIELD["spots"], "distance")
            self._keep("pick", name, ("mole_points",), point)
        elif self.tool in ("stroke", "lines"):
            self.points.append(point)
            self.message = f"{len(self.points)} places; press done to keep the stroke"
        elif self.tool == "section":
            self.points = [*self.points, point] if len(self.points) < 2 else [point]
            if len(self.points) == 2:
                self._cut()
        self._tell()

    def done(self) -> None:
        """Keep the stroke that is being drawn, and let the chosen layer follow it where it follows none."""
        if self.tool in ("stroke", "lines") and len(self.points) > 1:
            use: Use = "direction" if self.tool == "stroke" else "curves"
            points = SurfacePoints(
                np.concatenate([point.face for point in self.points]),
                np.concatenate([point.barycentric for point in self.points]),
            )
            wanted = ("direction", "stress") if use == "direction" else ("wrinkle_curves",)
            self._keep("stroke", self.session.free_name(FIELD[self.tool], use), wanted, points, use)
        self.points = []
        self._tell()

    def _keep(self, command: str, name: str, keys: tuple[str, ...], *drawn: Any) -> None:
        """Keep what was drawn, and let the chosen layer take it where it takes nothing else, all in one step."""
        with self.session.one_step():
            self.do(command, name, *drawn)
            material: Any = self.session.recipe.layer[self.layer].material
            for key in keys:
                if not self._held and getattr(material, key, name) is None:
                    self.do("set", key, name, self.layer)
        layer = self.session.recipe.layer[self.layer]
        taken = [getattr(layer.material, key) for key in keys if hasattr(layer.material, key)]
        if not self._held and name not in taken:
            why = f"takes {taken[0]!r}" if taken else f"has no {keys[0]}"
            self.message, self._held = f"kept as {name!r}; {layer.kind} {why}", True

    def _cut(self) -> None:
        """Take the section between the two places."""
        start, end = self.points
        pieces, length = shortest_path(self.surface, start, end)
        if not np.isfinite(length[0]) or not len(pieces):
            self.message, self.path, self.section = "no way leads from one place to the other", None, None
            return
        step = float(length[0]) / 400
        points, along = curve_points(self.surface, pieces, step)
        stack = self.stack
        if not stack.patterns:
            return
        samples = Samples(points, np.full(len(points), step, np.float32))
        height = stack.at(samples, ("height_mm",))["height_mm"].astype(np.float64)
        self.path, self.section = points.positions(self.surface), Section(along, height)
        self.message = (
            f"{length[0]:.4g} mm; {1000 * height.min():.0f} to {1000 * height.max():.0f} micrometres"
        )

    def _refresh(self) -> None:
        if self.worker.live.effort(self.session.recipe) in ("placed", "gathered"):
            self.message = "placing features"
        self.worker.ask(self.session.recipe, self.look_at)
        self._tell()

    def _arrived(self, frame: Frame) -> None:
        with self.lock:
            self.frame = frame
            self.changed |= frame.changed
            counts = ", ".join(f"{count:,} {kind}" for kind, count in frame.features.items() if count)
            if not self._held:
                self.message = "a first look; the rest follows" if frame.first_look else counts or "ready"
        if self.tool == "section" and len(self.points) == 2 and not frame.first_look:
            self._cut()
        self._tell()

    def _troubled(self, text: str) -> None:
        self.message = text
        self._tell()

    def _tell(self) -> None:
        self.version += 1
        for listener in list(self.listeners):
            listener()


def _elsewhere(path: Path) -> str:
    """Say what a saved recipe takes to be baked where its mesh or other files lie outside its folder."""
    recipe = load_recipe(path, allow_outside=True)
    files = [*recipe_files(recipe), *([Path(recipe.mesh.path)] if recipe.mesh.path else [])]
    if all(file.resolve().is_relative_to(path.parent.resolve()) for file in files):
        return ""
    return "; bake it with --allow-outside:"


def _foremost(surface: Surface) -> int:
    """Face whose middle is nearest to the viewer's side, up and front."""
    middle = surface.vertices[surface.faces].mean(axis=1)
    return int((middle @ np.array([0.4, 0.5, 0.75])).argmax())
