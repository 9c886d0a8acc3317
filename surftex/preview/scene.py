"""The surface on a graphics card: physically based, lit by a `Studio`, with its overlays. The one door to pyvista.

Textures come from a `Desk`; nothing here decides what they show. It draws into a window, or off screen through EGL
or OSMesa where there is no display.
"""

import os
import subprocess
import sys
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import WorkError
from surftex.preview.desk import Desk
from surftex.preview.environment import environment
from surftex.preview.overlays import COLOURS, distinct, feature_dots, painted, seam_lines, walked
from surftex.preview.picking import pick
from surftex.preview.session import Drawing
from surftex.preview.studio import STUDIOS
from surftex.surface.points import SurfacePoints

BEHIND = ((0.80, 0.79, 0.775), (0.94, 0.93, 0.92))
"""Colours of the background, below and above."""

DRAWN = "#2f7bff"
"""Colour of what the user draws."""

_PROBE = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(True)
window.SetSize(8, 8)
window.Render()
raise SystemExit(0 if window.SupportsOpenGL() else 1)
"""

_X_PROBE = """
import ctypes
x = ctypes.CDLL("libX11.so.6")
x.XOpenDisplay.restype = ctypes.c_void_p
raise SystemExit(0 if x.XOpenDisplay(None) else 1)
"""

_FILLED = 0.9
"""Share of the view that the whole fills at first."""
_REACH = (0.02, 20.0)
"""Least and greatest distance of the camera from what it is aimed at, in diagonals of the surface."""

_NEARER = -20.0
"""How much lines and dots are drawn before the surface that they lie on, in VTK's 16 millionths of the depth."""


class Scene:
    """A surface in three dimensions.

    Parameters
    ----------
    desk : Desk
        What it shows.
    size : (2,) int
        Width and height in pixels.
    off_screen : bool
        Without a window.

    Raises
    ------
    WorkError
        If there is no display, or no OpenGL; in one line.
    """

    def __init__(self, desk: Desk, size: tuple[int, int] = (1000, 800), *, off_screen: bool = True) -> None:
        self.desk = desk
        self.plotter = _plotter(size, off_screen=off_screen)
        self.renderer = self.plotter.renderer
        self._drawn = -1
        self._textures: dict[str, Any] = {}
        self._extra: dict[str, Any] = {}
        self._walked: dict[Drawing, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
        self._light = ""
        self._aimed = False
        self.actor = self._surface()
        self.plotter.set_background(BEHIND[0], top=BEHIND[1])
        self.reset_camera()

    @property
    def drawn(self) -> bool:
        """Whether the scene shows what the desk holds now."""
        return self._drawn == self.desk.version

    def reset_camera(self) -> None:
        """Look at the whole from the front, half left and above, as near as it fits."""
        self._aimed = False
        self.plotter.camera_position = "xy"
        self.plotter.reset_camera()
        camera = self.plotter.camera
        camera.Azimuth(-38)
        camera.Elevation(22)
        camera.OrthogonalizeViewUp()
        surface = self.desk.surface
        out = np.array(camera.GetPosition()) - camera.GetFocalPoint()
        away = float(np.linalg.norm(out))
        out, up = out / away, np.array(camera.GetViewUp())
        place = surface.vertices[np.unique(surface.faces)] - camera.GetFocalPoint()
        depth = away - place @ out
        seen = np.stack([place @ np.cross(up, out), place @ up], axis=1) / depth[:, None]
        low, high = seen.min(axis=0), seen.max(axis=0)
        wide, tall = (high - low) / 2
        box = self.renderer.GetViewport()
        aspect = self.size[0] * (box[2] - box[0]) / (self.size[1] * (box[3] - box[1]))
        half = max(tall, wide / aspect) / _FILLED
        middle = away * (low + high) / 2
        move = middle[0] * np.cross(up, out) + middle[1] * up
        camera.SetFocalPoint(*(np.array(camera.GetFocalPoint()) + move))
        camera.SetPosition(*(np.array(camera.GetPosition()) + move))
        camera.SetViewAngle(float(np.degrees(2 * np.arctan(half))))
        self.plotter.reset_camera_clipping_range()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        width, height = self.plotter.render_window.GetSize()
        return int(width), int(height)

    def resize(self, width: int, height: int) -> None:
        """Draw larger or smaller.

        Parameters
        ----------
        width : int
            Pixels.
        height : int
            Pixels.
        """
        self.plotter.render_window.SetSize(width, height)

    def turn(self, right: float, down: float, shift: bool = False) -> None:
        """Move the camera as the mouse is dragged.

        Parameters
        ----------
        right : float
            Pixels.
        down : float
            Pixels.
        shift : bool
            Shift what is seen, and do not turn it.
        """
        camera = self.plotter.camera
        self._aimed = False
        if shift:
            x, y, z = (
                np.array(each) for each in (camera.GetPosition(), camera.GetFocalPoint(), camera.GetViewUp())
            )
            out = x - y
            side = np.cross(z, out)
            side /= max(float(np.linalg.norm(side)), 1e-12)
            size = (
                2 * float(np.linalg.norm(out)) * np.tan(np.radians(camera.GetViewAngle() / 2)) / self.size[1]
            )
            move = size * (down * z - right * side)
            camera.SetPosition(*(x + move))
            camera.SetFocalPoint(*(y + move))
        else:
            camera.Azimuth(-0.4 * right)
            camera.Elevation(float(np.clip(0.4 * down, -20, 20)))
            camera.OrthogonalizeViewUp()
        self.plotter.reset_camera_clipping_range()

    def zoom(self, wheel: float) -> None:
        """Come nearer to the surface in the middle of the view, never through it, or go away.

        From then on the camera turns about that place.

        Parameters
        ----------
        wheel : float
            Below 0 comes nearer; 100 is a notch.
        """
        camera = self.plotter.camera
        start, aim = np.array(camera.GetPosition()), np.array(camera.GetFocalPoint())
        seen = None if self._aimed else self.place(self.size[0] / 2, self.size[1] / 2)
        self._aimed = True
        if seen is not None:
            aim = start + (aim - start) * (
                (seen.positions(self.desk.surface)[0] - start)
                @ (aim - start)
                / ((aim - start) @ (aim - start))
            )
            camera.SetFocalPoint(*aim)
        away = float(np.linalg.norm(start - aim))
        size = float(np.linalg.norm(np.ptp(self.desk.surface.vertices, axis=0)))
        wanted = away * np.exp(np.clip(wheel, -400, 400) / 900)
        wanted = np.clip(wanted, _REACH[0] * size, _REACH[1] * size)
        camera.Dolly(float(away / wanted))
        self.plotter.reset_camera_clipping_range()

    def refresh(self) -> bool:
        """Take over what has changed.

        Returns
        -------
        changed : bool
            Whether the picture must be drawn anew.
        """
        desk = self.desk
        if self.drawn:
            return False
        self._drawn = desk.version
        with desk.lock:
            changed, frame = desk.changed, desk.frame
            desk.changed = set()
            if frame is not None:
                colour = next((name for name in COLOURS if name in desk.overlays), None)
                for name in changed:
                    picture = frame.pictures[name]
                    if name == "base_color" and colour is not None:
                        picture = painted(desk.live, colour)
                    self._lay(name, picture)
        self._lit()
        self._overlays()
        return True

    def picture(self, *, smooth: bool = False) -> NDArray[np.uint8]:
        """Draw.

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
        if smooth:
            self.plotter.enable_anti_aliasing("ssaa")
        self.plotter.render_window.Render()
        return _pixels(self.plotter.render_window)

    def place(self, x: float, y: float) -> SurfacePoints | None:
        """Find what lies under a pixel.

        Parameters
        ----------
        x : float
            From the left of the window.
        y : float
            From the bottom.

        Returns
        -------
        point : SurfacePoints or None
            One place of the surface.
        """
        ends = []
        for depth in (0.0, 1.0):
            self.renderer.SetDisplayPoint(x, y, depth)
            self.renderer.DisplayToWorld()
            world = np.array(self.renderer.GetWorldPoint())
            ends.append(world[:3] / world[3])
        return pick(self.desk.surface, ends[0], ends[1] - ends[0])

    def close(self) -> None:
        """Give everything back."""
        self.plotter.close()

    def _surface(self) -> Any:
        import pyvista
        from vtkmodules.util.numpy_support import numpy_to_vtk

        desk = self.desk
        surface, count = desk.surface, len(desk.surface.faces)
        corner = surface.vertices[surface.faces].reshape(-1, 3)
        cells = np.column_stack([np.full(count, 3), np.arange(3 * count).reshape(-1, 3)])
        mesh = pyvista.PolyData(corner, cells.ravel())
        data = mesh.GetPointData()
        for name, values, setter in (
            ("normal", surface.shading_normal.reshape(-1, 3), data.SetNormals),
            ("uv", desk.live.atlas.corner_uv.reshape(-1, 2), data.SetTCoords),
            ("tangent", desk.live.tangents.reshape(-1, 4)[:, :3], data.SetTangents),
        ):
            array = numpy_to_vtk(np.ascontiguousarray(values, np.float32), deep=True)
            array.SetName(name)
            setter(array)
        actor = self.plotter.add_mesh(
            mesh, color="white", pbr=True, roughness=0.5, metallic=0.0, reset_camera=False
        )
        actor.prop.SetBaseIOR(1.5)
        return actor

    def _lay(self, name: str, picture: NDArray[Any]) -> None:
        """Give a picture to the graphics card."""
        if name in self._textures:
            _fill(self._textures[name], picture)
            return
        texture = self._textures[name] = _texture(picture, screen=name == "base_color")
        prop = self.actor.prop
        if name == "base_color":
            prop.SetBaseColorTexture(texture)
        elif name == "normal":
            prop.SetNormalTexture(texture)
        else:
            prop.SetRoughness(1.0)
            prop.SetMetallic(1.0)
            prop.SetORMTexture(texture)

    def _lit(self) -> None:
        """Light the room, when another light was chosen."""
        if self._light == self.desk.light:
            return
        self._light = self.desk.light
        studio = STUDIOS[self._light]
        texture = _texture(environment(studio), screen=False)
        self.renderer.UseImageBasedLightingOn()
        self.renderer.UseSphericalHarmonicsOn()
        self.renderer.GetEnvMapPrefiltered().SetPrefilterMaxSamples(128)
        self.renderer.SetEnvironmentTexture(texture, False)
        self._extra["environment"] = texture
        self.plotter.remove_all_lights()
        import pyvista

        key = studio.boxes[0]
        right, up, out = key.towards
        light = pyvista.Light(light_type="camera light", intensity=1.5 * key.strength, color=key.color)
        light.position, light.focal_point = (10 * right, 10 * up, 10 * out + 1), (0, 0, 0)
        self.plotter.add_light(light)

    def _overlays(self) -> None:
        """Draw seams, features, what was drawn, the stroke at hand and the section."""
        desk = self.desk
        shown: dict[str, tuple[Any, dict[str, Any]]] = {}
        if "seams" in desk.overlays:
            lines = seam_lines(desk.surface, desk.live.atlas).reshape(-1, 3)
            shown["seams"] = (lines, {"color": "#ff5a36", "line_width": 2, "pairs": True})
        if "features" in desk.overlays and desk.frame is not None:
            for i, (kind, dots) in enumerate(feature_dots(desk.surface, desk.stack.features).items()):
                color = tuple(distinct(np.array([7 * i + 3]))[0] / 255)
                shown[f"feature {kind} {id(desk.stack.patterns[0])}"] = (
                    dots,
                    {"color": color, "point_size": 3},
                )
        for drawing in desk.session.state.drawings.values() if "drawn" in desk.overlays else ():
            if drawing not in self._walked:
                self._walked[drawing] = walked(desk.surface, drawing)
            lines, dots = self._walked[drawing]
            shown[f"drawn lines {id(drawing)}"] = (
                lines.reshape(-1, 3),
                {"color": DRAWN, "line_width": 3, "pairs": True},
            )
            shown[f"drawn dots {id(drawing)}"] = (dots, {"color": DRAWN, "point_size": 9})
        if desk.points:
            dots = np.concatenate([point.positions(desk.surface) for point in desk.points])
            shown[f"points {desk.version}"] = (dots, {"color": DRAWN, "point_size": 11})
        if desk.path is not None:
            shown[f"path {desk.version}"] = (desk.path, {"color": DRAWN, "line_width": 4})
        for name in [each for each in self._extra if each != "environment" and each not in shown]:
            self.plotter.remove_actor(self._extra.pop(name), render=False)
        for name, (places, looks) in shown.items():
            if name not in self._extra and len(places):
                self._extra[name] = self._drawn_over(places, **looks)

    def _drawn_over(self, places: NDArray[np.float64], *, pairs: bool = False, **looks: Any) -> Any:
        """Draw lines or dots a little in front of the surface."""
        import pyvista

        if "point_size" in looks:
            actor = self.plotter.add_points(
                places, render_points_as_spheres=True, lighting=False, reset_camera=False, **looks
            )
        else:
            step = 2 if pairs else len(places)
            cells = np.arange(len(places)).reshape(-1, step)
            mesh = pyvista.PolyData(places, lines=np.column_stack([np.full(len(cells), step), cells]).ravel())
            actor = self.plotter.add_mesh(mesh, lighting=False, reset_camera=False, **looks)
        actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        actor.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(-2, _NEARER)
        actor.mapper.SetRelativeCoincidentTopologyPointOffsetParameter(_NEARER)
        return actor


def check_display(*, off_screen: bool) -> None:
    """Find out whether there is anything to draw on, before any work.

    Parameters
    ----------
    off_screen : bool
        Whether a place in memory will do.

    Raises
    ------
    WorkError
        If there is no display, or no OpenGL.
    """
    display = os.environ.get("DISPLAY")
    displayed = _ended_well(_X_PROBE, display) if display else bool(os.environ.get("WAYLAND_DISPLAY"))
    if sys.platform.startswith("linux") and not displayed:
        if not off_screen:
            silent = (
                f"display {display} does not answer, so there is none" if display else "there is no display"
            )
            raise WorkError(
                f"{silent} for a window; surftex preview --web serves the same to a browser, and surftex render "
                "draws stills"
            )
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    if not _ended_well(_PROBE, os.environ.get("DISPLAY")):
        raise WorkError(
            "OpenGL 3.2 is missing here: install a driver, or Mesa (Debian: libegl1 and libgl1-mesa-dri); surftex "
            "render draws stills without it"
        )


@cache
def _ended_well(program: str, display: str | None) -> bool:
    """Try in a child what may end the process where libraries are missing; once for every `display`."""
    del display  # the child has it from the environment
    try:
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, timeout=120, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0


def _plotter(size: tuple[int, int], *, off_screen: bool) -> Any:
    """Open a window, or a place to draw in memory."""
    check_display(off_screen=off_screen)
    import pyvista

    plotter: Any = pyvista.Plotter(
        off_screen=off_screen, window_size=list(size), lighting="none", title="surftex"
    )
    if not off_screen:
        plotter.enable_anti_aliasing("fxaa")
    return plotter


def _pixels(window: Any) -> NDArray[np.uint8]:
    """Read what a window has drawn, without drawing it once more."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

    reader = vtkWindowToImageFilter()
    reader.SetInput(window)
    reader.SetInputBufferTypeToRGB()
    reader.ReadFrontBufferOff()
    reader.ShouldRerenderOff()
    reader.Update()
    image = reader.GetOutput()
    width, height, _ = image.GetDimensions()
    return np.ascontiguousarray(
        vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, 3)[::-1]
    )


def _texture(picture: NDArray[Any], *, screen: bool) -> Any:
    """Make a texture that does not convert its numbers; `screen` ones are sRGB codes."""
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkRenderingCore import vtkTexture

    texture = vtkTexture()
    texture.SetInputData(vtkImageData())
    _fill(texture, picture)
    texture.SetColorModeToDirectScalars()
    texture.InterpolateOn()
    texture.MipmapOn()
    texture.SetMaximumAnisotropicFiltering(8)
    texture.SetUseSRGBColorSpace(screen)
    return texture


def _fill(texture: Any, picture: NDArray[Any]) -> None:
    from vtkmodules.util.numpy_support import numpy_to_vtk

    image = texture.GetInput()
    image.SetDimensions(picture.shape[1], picture.shape[0], 1)
    array = numpy_to_vtk(np.ascontiguousarray(picture[::-1]).reshape(-1, 3), deep=True)
    image.GetPointData().SetScalars(array)
    image.Modified()
