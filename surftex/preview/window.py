"""The window: a `Scene` with the panel beside it, drawn by VTK itself, so that no other toolkit is needed."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.preview.desk import Desk
from surftex.preview.panel import Item, hit, layout, slide
from surftex.preview.scene import Scene

PANEL = 372
"""Width of the panel in pixels."""

_PAPER, _INK, _FAINT = (0.13, 0.13, 0.14), (0.92, 0.91, 0.89), (0.60, 0.59, 0.58)
_CHIP, _LIT, _TRACK = (0.22, 0.22, 0.24), (0.80, 0.45, 0.22), (0.28, 0.28, 0.30)
_CURVE = (0.45, 0.68, 1.0)


class Window:
    """A preview in a window.

    Parameters
    ----------
    desk : Desk
        What it shows.
    size : (2,) int
        Width and height in pixels.
    off_screen : bool
        Without a window, for pictures and tests; press, drag and release do what a mouse would.
    save_as : path
        Where ``save`` writes the recipe.

    Raises
    ------
    WorkError
        If there is no display or no OpenGL; in one line.
    """

    def __init__(
        self, desk: Desk, size: tuple[int, int] = (1400, 900), *, off_screen: bool = False,
        save_as: str | Path = "preview.toml",
    ) -> None:  # fmt: skip
        from vtkmodules.vtkRenderingCore import vtkRenderer

        self.desk, self.size, self.save_as = desk, size, Path(save_as)
        self.scene = Scene(desk, size, off_screen=off_screen)
        self.side = vtkRenderer()
        self.side.SetBackground(*_PAPER)
        self.side.InteractiveOff()
        self.scene.plotter.render_window.AddRenderer(self.side)
        self._items: list[Item] = []
        self._held: Item | None = None
        self._group, self._skipped = (0, ""), 0
        self._fields = _Fields(self.side)
        self._plot = _Fields(self.scene.renderer)
        self._placed()
        self.scene.reset_camera()
        self.refresh(force=True)

    def refresh(self, *, force: bool = False) -> bool:
        """Take over what the desk holds.

        Parameters
        ----------
        force : bool
            Even if nothing has changed.

        Returns
        -------
        changed : bool
            Whether the window must be drawn.
        """
        changed = self.scene.refresh()
        if changed or force:
            if self._group != (self.desk.layer, self.desk.group):
                self._group, self._skipped = (self.desk.layer, self.desk.group), 0
            self._items = layout(self.desk, PANEL, self.size[1], self._skipped)
            self._draw_panel()
            self._draw_plot()
        return changed or force

    def picture(self, *, smooth: bool = False) -> NDArray[np.uint8]:
        """Draw the whole window.

        Parameters
        ----------
        smooth : bool
            With several samples to the pixel.

        Returns
        -------
        picture : (height, width, 3) uint8
            sRGB codes.
        """
        self.refresh()
        return self.scene.picture(smooth=smooth)

    def press(self, x: float, y: float) -> bool:
        """Press the mouse.

        Parameters
        ----------
        x : float
            From the left of the window, pixels.
        y : float
            From the top.

        Returns
        -------
        taken : bool
            Whether it was meant for the panel, or for the tool at hand.
        """
        left = x - (self.size[0] - PANEL)
        if left >= 0:
            self._held = hit(self._items, left, y)
            if self._held is not None:
                self._act(self._held, left)
            return True
        if self.desk.tool == "turn":
            return False
        point = self.scene.place(x, self.size[1] - 1 - y)
        if point is not None:
            self.desk.click(point)
        return point is not None

    def drag(self, x: float, y: float) -> bool:
        """Move the mouse while it is pressed.

        Parameters
        ----------
        x : float
            From the left of the window, pixels.
        y : float
            From the top.

        Returns
        -------
        taken : bool
            Whether a slider follows it.
        """
        if self._held is None or self._held.action[0] != "slide":
            return False
        slide(self.desk, self._held, x - (self.size[0] - PANEL))
        return True

    def release(self) -> bool:
        """Let go of the mouse.

        Returns
        -------
        taken : bool
            Whether the panel held it.
        """
        held, self._held = self._held, None
        return held is not None

    def scroll(self, parameters: int) -> None:
        """Scroll the parameters of the group.

        Parameters
        ----------
        parameters : int
            How many; below 0 goes back.
        """
        self._skipped = max(0, self._skipped + parameters)
        self.refresh(force=True)

    def show(self) -> None:
        """Open the window, and stay until it is closed."""
        self.connect()
        interactor = self.scene.plotter.iren.interactor
        self.scene.plotter.show(auto_close=False, interactive_update=True)
        interactor.CreateRepeatingTimer(30)
        interactor.Start()

    def connect(self) -> None:
        """Listen to mouse and clock."""
        window, interactor = self.scene.plotter.render_window, self.scene.plotter.iren.interactor
        tags: dict[str, int] = {}

        def where() -> tuple[float, float]:
            x, y = interactor.GetEventPosition()
            return x, self.size[1] - 1 - y

        def guarded(name: str, act: Any) -> None:
            def called(*_: Any) -> None:
                if act():
                    interactor.GetCommand(tags[name]).SetAbortFlag(1)

            tags[name] = interactor.AddObserver(name, called, 10.0)

        def wheel(parameters: int) -> bool:
            if where()[0] < self.size[0] - PANEL:
                return False
            self.scroll(parameters)
            window.Render()
            return True

        def tick() -> bool:
            if tuple(window.GetSize()) != self.size:
                self.size = tuple(window.GetSize())
                self._placed()
                self.refresh(force=True)
                window.Render()
            elif self.refresh():
                window.Render()
            return False

        guarded("LeftButtonPressEvent", lambda: self.press(*where()))
        guarded("MouseMoveEvent", lambda: self.drag(*where()))
        guarded("LeftButtonReleaseEvent", self.release)
        guarded("MouseWheelForwardEvent", lambda: wheel(-1))
        guarded("MouseWheelBackwardEvent", lambda: wheel(1))
        guarded("TimerEvent", tick)

    def close(self) -> None:
        """Close the window; the desk stays."""
        self.scene.close()

    def _placed(self) -> None:
        """Divide the window into view and panel."""
        share = 1 - PANEL / self.size[0]
        self.scene.renderer.SetViewport(0, 0, share, 1)
        self.side.SetViewport(share, 0, 1, 1)

    def _act(self, item: Item, x: float) -> None:
        what, *rest = item.action
        if what == "slide":
            slide(self.desk, item, x)
        elif what == "do":
            self.desk.do(*rest)
        elif what == "choose":
            self.desk.choose(**{rest[0]: rest[1]})
        elif what == "done":
            self.desk.done()
        elif what == "skip":
            self.scroll(rest[0])
        else:
            self.desk.do("save", self.save_as, overwrite=True)

    def _draw_panel(self) -> None:
        fields, high = self._fields, self.size[1]
        fields.clear()
        for item in self._items:
            left, top, right, bottom = item.left, item.top, item.left + item.width, item.top + item.height
            if item.kind == "title":
                fields.text(left, high - top - 17, item.text, _INK, 17, bold=True)
            elif item.kind == "label":
                fields.text(left, high - top - 14, item.text, _FAINT, 13)
                fields.text(right, high - top - 14, item.value, _INK, 13, right=True)
            elif item.kind == "chip":
                fields.box(left, high - bottom, right, high - top, _LIT if item.lit else _CHIP)
                fields.text((left + right) / 2, high - bottom + 5, item.text, _INK, 13, middle=True)
            elif item.kind == "swatch":
                fields.box(left, high - bottom, right, high - top, item.color)
            else:
                fields.text(left, high - top - 14, item.text, _FAINT, 13)
                fields.text(right, high - top - 14, item.value, _INK, 13, right=True)
                middle, knob = high - top - 25, left + item.share * item.width
                fields.box(left, middle - 2, right, middle + 2, _TRACK)
                fields.box(left, middle - 2, knob, middle + 2, _LIT)
                fields.box(knob - 5, middle - 7, knob + 5, middle + 7, _INK)
        fields.done()

    def _draw_plot(self) -> None:
        """Draw the section in the lower left corner."""
        plot, cut = self._plot, self.desk.section
        plot.clear()
        if cut is not None:
            left, low, wide, tall = 24.0, 24.0, min(520.0, self.size[0] - PANEL - 48.0), 130.0
            plot.box(left - 10, low - 10, left + wide + 10, low + tall + 24, _PAPER)
            bottom, top = float(cut.height_mm.min()), float(cut.height_mm.max())
            span = max(top - bottom, 1e-6)
            x = left + wide * cut.along_mm / max(float(cut.along_mm[-1]), 1e-9)
            y = low + tall * (cut.height_mm - bottom) / span
            plot.line(np.stack([x, y], axis=1), _CURVE)
            told = f"{cut.along_mm[-1]:.4g} mm along, {1000 * span:.0f} micrometres high"
            plot.text(left, low + tall + 6, told, _INK, 13)
        plot.done()


class _Fields:
    """Flat boxes, lines and texts in one renderer, drawn anew at each change."""

    def __init__(self, renderer: Any) -> None:
        self.renderer = renderer
        self._actors: list[Any] = []
        self._quads: list[tuple[float, float, float, float]] = []
        self._colors: list[tuple[float, float, float]] = []
        self._late: list[Any] = []

    def clear(self) -> None:
        """Take everything away."""
        for actor in self._actors:
            self.renderer.RemoveViewProp(actor)
        self._actors, self._quads, self._colors, self._late = [], [], [], []

    def box(
        self, left: float, low: float, right: float, top: float, color: tuple[float, float, float]
    ) -> None:
        """Add a box."""
        self._quads.append((left, low, right, top))
        self._colors.append(color)

    def text(
        self, x: float, y: float, text: str, color: tuple[float, float, float], size: int, *, bold: bool = False,
        right: bool = False, middle: bool = False,
    ) -> None:  # fmt: skip
        """Add a text that starts, ends or has its middle at a place."""
        from vtkmodules.vtkRenderingCore import vtkTextActor

        if not text:
            return
        actor = vtkTextActor()
        actor.SetInput(text)
        look = actor.GetTextProperty()
        look.SetFontFamilyToArial()
        look.SetFontSize(size)
        look.SetBold(bold)
        look.SetColor(*color)
        if right:
            look.SetJustificationToRight()
        if middle:
            look.SetJustificationToCentered()
        actor.SetPosition(x, y)
        self._late.append(actor)

    def line(self, places: NDArray[np.float64], color: tuple[float, float, float]) -> None:
        """Add a line through places."""
        count = len(places)
        self._late.append(_flat(places, [list(range(count))], np.array([color]), lines=True))

    def done(self) -> None:
        """Show what was added: boxes first, all else over them."""
        if self._quads:
            corners = [(a, b, c, b, c, d, a, d) for a, b, c, d in self._quads]
            places = np.array(corners).reshape(-1, 2)
            cells = np.arange(len(places)).reshape(-1, 4).tolist()
            self._actors.append(_flat(places, cells, np.array(self._colors), lines=False))
        self._actors += self._late
        for actor in self._actors:
            self.renderer.AddViewProp(actor)


def _flat(places: NDArray[np.float64], cells: list[list[int]], colors: NDArray[Any], *, lines: bool) -> Any:
    """Make an actor of flat cells, each with its colour."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D

    points, array, data = vtkPoints(), vtkCellArray(), vtkPolyData()
    points.SetData(numpy_to_vtk(np.column_stack([places, np.zeros(len(places))]), deep=True))
    for cell in cells:
        array.InsertNextCell(len(cell), cell)
    data.SetPoints(points)
    (data.SetLines if lines else data.SetPolys)(array)
    data.GetCellData().SetScalars(numpy_to_vtk((255 * colors).astype(np.uint8), deep=True))
    mapper, actor = vtkPolyDataMapper2D(), vtkActor2D()
    mapper.SetInputData(data)
    actor.SetMapper(mapper)
    if lines:
        actor.GetProperty().SetLineWidth(2)
    return actor
