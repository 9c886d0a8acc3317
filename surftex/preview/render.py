"""Off-screen stills: what a mesh or a bake looks like, lit by soft boxes, without a display or a graphics card.

Rays meet triangles in a compiled loop, and every sample is shaded in numpy: the same picture, to the byte, on
any machine of one kind, and no driver is needed.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.errors import RecipeError
from surftex.files.scene import Body
from surftex.kernels.pool import slices
from surftex.preview.bodies import bodies_of, factors_of, pyramid_of
from surftex.preview.camera import UPS, VIEWS, Camera, camera_for
from surftex.preview.pictures import check_picture, save_picture
from surftex.preview.section import blended
from surftex.preview.shading import Lit, lit, shaded
from surftex.preview.studio import Studio, lamps_of, studio_named

_BAND, _CHUNK = 64, 200_000
_FLOOR, _FLOOR_GRID = 3.0, 289
"""Reach of the floor in radii of the subject, and lines of the grid on which its shadow is found."""


def render(
    subject: Any,
    *,
    size: tuple[int, int] = (1280, 960),
    view: str | tuple[float, float] = "three-quarter",
    light: str | Studio = "studio",
    zoom: float = 1.0,
    target: ArrayLike | None = None,
    background: str | ArrayLike = "#e9e7e4",
    up: str = "y",
    floor: bool | None = None,
    samples: int = 2,
) -> NDArray[np.uint8]:
    """Draw a still.

    Parameters
    ----------
    subject : path, MapSet, Surface or (vertices, faces)
        GLB and glTF come with colour, roughness, normals and specular; other meshes look like clay.
    size : (2,) int
        Width and height in pixels.
    view : str or (2,) float
        Name such as "front", "left", "top" or "three-quarter", or azimuth and elevation in degrees.
    light : str or Studio
        "studio" flatters products, "portrait" faces; "raking" grazes from the left and shows relief.
    zoom : float
        1 shows everything, 10 a tenth of it.
    target : (3,) float, optional
        Place in millimetres to have in the middle.
    background : str or (3,) float
        "#rrggbb", or linear light.
    up : str
        Axis that points up: x, y or z.
    floor : bool, optional
        Whether the subject stands on a floor that takes its shadow; without it, where it is seen whole from above.
    samples : int
        Samples along each side of a pixel.

    Returns
    -------
    picture : (height, width, 3) uint8
        sRGB codes.

    Raises
    ------
    InputError
        If the subject cannot be drawn.
    RecipeError
        If an option is none, or nothing of the subject is in view.
    """
    bodies = bodies_of(subject)
    shot = Shot.of(
        bodies, size=size, view=view, light=light, zoom=zoom, target=target, background=background, up=up, floor=floor,
        samples=samples,
    )  # fmt: skip
    _refuse_empty(shot.face, *_joined(bodies))
    return shot.drawn(bodies)


def _refuse_empty(face: NDArray[np.int32], vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> None:
    """Refuse a picture of nothing; say where the subject is."""
    if (face >= 0).any():
        return
    seen = vertices[np.unique(faces)]
    spans = (
        f"{axis} {low:.4g} to {high:.4g}"
        for axis, low, high in zip("xyz", seen.min(axis=0), seen.max(axis=0), strict=True)
    )
    raise RecipeError(f"nothing is in view; the subject spans {', '.join(spans)}: aim there, or zoom out")


@dataclass(frozen=True, eq=False)
class Shot:
    """A camera that stands and lamps that are lit: draws one shape in whatever colours it comes.

    Attributes
    ----------
    size : (2,) int
        Of the picture, in pixels.
    samples : int
        Along each side of a pixel.
    camera : Camera
        Where from.
    face : (h, w) int32
        What each sample shows; -1 where it is nothing.
    weight : (h, w, 3) float32
        Of the face's corners.
    scene : Lit
        The lamps.
    backdrop : (h, w, 3) float32
        Background and floor, linear.
    """

    size: tuple[int, int]
    samples: int
    camera: Camera
    face: NDArray[np.int32]
    weight: NDArray[np.float32]
    scene: Lit
    backdrop: NDArray[np.float32]

    @staticmethod
    def of(
        subject: Any,
        *,
        size: tuple[int, int] = (1280, 960),
        view: str | tuple[float, float] = "three-quarter",
        light: str | Studio = "studio",
        zoom: float = 1.0,
        target: ArrayLike | None = None,
        background: str | ArrayLike = "#e9e7e4",
        up: str = "y",
        floor: bool | None = None,
        samples: int = 2,
    ) -> "Shot":
        """Aim at a subject.

        Parameters
        ----------
        subject : as for `render`
            What is to be seen.
        size, view, light, zoom, target, background, up, floor, samples
            As for `render`.

        Returns
        -------
        shot : Shot
            Ready to draw it.

        Raises
        ------
        InputError
            As `render`.
        RecipeError
            As `render`.
        """
        if samples not in range(1, 9):
            raise RecipeError(f"samples is {samples}; it takes 1 to 8")
        if len(size) != 2 or min(size) < 1 or max(size) * samples > 32768:
            raise RecipeError(f"size is {tuple(size)}; it takes width and height, at most {32768 // samples}")
        studio, behind = studio_named(light), _color(background)
        vertices, faces = _joined(bodies_of(subject))
        seen = np.unique(faces)
        fine = (size[0] * samples, size[1] * samples)
        camera = camera_for(vertices[seen], fine, view=view, zoom=zoom, target=target, up=up)
        face, weight = _visible(camera.project(vertices)[faces], fine)
        around = _facing(vertices, faces, face, camera) if studio.grazes else camera.axes
        stands = floor if floor is not None else (zoom <= 1.5 and camera.axes[2] @ UPS[up] > 0.02)
        shown = vertices[seen] if stands else _shown(vertices, faces, face, weight)
        scene = lit(vertices, faces, studio, lamps_of(studio, around, UPS[up]), UPS[up], shown)
        backdrop = np.broadcast_to(behind, (*face.shape, 3)).astype(np.float32).copy()
        if stands:
            _stand(backdrop, face, scene, camera, float((vertices[seen] @ UPS[up]).min()))
        return Shot(size, samples, camera, face, weight, scene, backdrop)

    def drawn(self, subject: Any) -> NDArray[np.uint8]:
        """Draw the subject, or another of the same shape.

        Parameters
        ----------
        subject : as for `render`
            With the triangles of the one that was aimed at.

        Returns
        -------
        picture : (height, width, 3) uint8
            sRGB codes.
        """
        picture = self.backdrop.copy()
        _paint(picture, self.face, self.weight, bodies_of(subject), self.scene, self.camera)
        width, height = self.size
        return _codes(picture.reshape(height, self.samples, width, self.samples, 3).mean(axis=(1, 3)))


def _joined(bodies: list[Body]) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Vertices and faces of all bodies."""
    start = np.cumsum([0] + [len(body.vertices) for body in bodies])
    faces = [body.faces + at for body, at in zip(bodies, start[:-1], strict=True)]
    return np.concatenate([body.vertices for body in bodies]), np.concatenate(faces).astype(np.int32)


def render_file(
    path: str | os.PathLike[str],
    out: str | os.PathLike[str],
    **options: Any,
) -> Path:
    """Draw a mesh file or a bake's GLB into a PNG.

    Parameters
    ----------
    path : path
        Of the mesh.
    out : path
        Of the picture; an existing file is replaced, whole.
    **options
        Of `render`.

    Returns
    -------
    path : Path
        Of the picture.

    Raises
    ------
    InputError
        If the name does not end in .png.
    WorkError
        If it cannot be written.
    """
    target = check_picture(out)
    return save_picture(target, render(path, **options))


def render_files(
    path: str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    views: Sequence[str | tuple[float, float]] = ("three-quarter",),
    lights: Sequence[str] = ("studio",),
    turntable: int | None = None,
    sheet: bool = False,
    **options: Any,
) -> list[Path]:
    """Draw a mesh file or a bake's GLB from several sides, or in several lights.

    Parameters
    ----------
    path : path
        Of the mesh; read once.
    out : path
        Of the picture. Several get names of their own: ``shoe.png`` makes ``shoe-front.png``, or ``shoe-000.png`` and
        so on for a turntable. Existing files are replaced, whole.
    views : sequence of str or (2,) float
        As for `render`.
    lights : sequence of str
        As for `render`.
    turntable : int, optional
        So many pictures, once around from the first view.
    sheet : bool
        Lay all pictures out in one, with their names.
    **options
        Of `render`.

    Returns
    -------
    paths : list of Path
        Of the pictures, in their order.

    Raises
    ------
    InputError
        If the name does not end in .png.
    RecipeError
        If an option is none.
    WorkError
        If a picture cannot be written.
    """
    target = check_picture(out)
    shots = _shots(views, lights, turntable)
    bodies = bodies_of(path)
    if len(shots) > 1:
        _check_views(bodies, shots, **options)
    pictures: list[NDArray[np.uint8]] = []
    paths: list[Path] = []
    for name, view, light in shots:
        picture = render(bodies, view=view, light=light, **options)
        if sheet:
            pictures.append(picture)
        else:
            place = target if len(shots) == 1 else target.with_name(f"{target.stem}-{name}.png")
            paths.append(save_picture(place, picture))
    if sheet:
        from surftex.preview.sheet import contact_sheet

        paths = [save_picture(target, contact_sheet(pictures, [name.upper() for name, *_ in shots]))]
    return paths


def _check_views(
    bodies: list[Body],
    shots: list[tuple[str, str | tuple[float, float], str]],
    *,
    size: tuple[int, int] = (1280, 960),
    zoom: float = 1.0,
    target: ArrayLike | None = None,
    up: str = "y",
    samples: int = 2,
    **_: Any,
) -> None:
    """Refuse views of nothing before the first picture is drawn."""
    vertices, faces = _joined(bodies)
    seen, fine = vertices[np.unique(faces)], (size[0] * samples, size[1] * samples)
    for view in {view for _, view, _ in shots}:
        camera = camera_for(seen, fine, view=view, zoom=zoom, target=target, up=up)
        _refuse_empty(_visible(camera.project(vertices)[faces], fine)[0], vertices, faces)


def _shots(
    views: Sequence[str | tuple[float, float]], lights: Sequence[str], turntable: int | None
) -> list[tuple[str, str | tuple[float, float], str]]:
    """Name every picture, and say from where and in which light it is taken."""
    if turntable is not None:
        if not 2 <= turntable <= 3600 or len(views) > 1:
            raise RecipeError(
                f"a turntable takes 2 to 3600 pictures and one view, not {turntable} and {len(views)}"
            )
        first = views[0]
        if isinstance(first, str):
            if first not in VIEWS:
                raise RecipeError(
                    f"no view {first!r}; known are {', '.join(VIEWS)}, or azimuth and elevation"
                )
            first = VIEWS[first]
        turns = [(first[0] + 360.0 * k / turntable, first[1]) for k in range(turntable)]
        named: list[tuple[str, str | tuple[float, float]]] = [
            (f"{k:0{max(3, len(str(turntable - 1)))}d}", turn) for k, turn in enumerate(turns)
        ]
    else:
        named = [(view if isinstance(view, str) else f"{view[0]:g}_{view[1]:g}", view) for view in views]
    return [
        (name if len(lights) == 1 else f"{name}-{light}", view, light)
        for name, view in named
        for light in lights
    ]


def _visible(
    corner: NDArray[np.float64], size: tuple[int, int]
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Face and weights behind each sample."""
    from surftex.kernels.view import nearest_faces

    width, height = size
    face = np.full((height, width), -1, np.int32)
    weight, near = np.zeros((height, width, 3), np.float32), np.zeros((height, width), np.float32)
    corner = np.ascontiguousarray(corner)
    slices(lambda a, b: nearest_faces(corner, a, face[a:b], weight[a:b], near[a:b]), height, size=_BAND)
    return face, weight


def _shown(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int32],
    face: NDArray[np.int32],
    weight: NDArray[np.float32],
) -> NDArray[np.float64]:
    """Points of the surface under every third sample; all vertices where none shows it."""
    face, weight = face[::3, ::3].ravel(), weight[::3, ::3].reshape(-1, 3)
    at = np.flatnonzero(face >= 0)
    if not len(at):
        return vertices[np.unique(faces)]
    return np.einsum("nk,nkc->nc", weight[at], vertices[faces[face[at]]])


def _facing(
    vertices: NDArray[np.float64], faces: NDArray[np.int32], face: NDArray[np.int32], camera: Camera
) -> NDArray[np.float64]:
    """Right, up and outward of what is seen in the middle of the picture, as rows."""
    rows, columns = face.shape
    middle = face[rows // 4 : -(rows // 4) or None, columns // 4 : -(columns // 4) or None]
    seen, count = np.unique(middle[middle >= 0], return_counts=True)
    if not len(seen):
        return camera.axes
    a, b, c = (vertices[faces[seen, k]] for k in range(3))
    normal = _unit(np.cross(b - a, c - a))
    normal *= np.where((normal * (camera.place - a)).sum(axis=1) < 0, -1.0, 1.0)[:, None]
    out = _unit((normal * count[:, None]).sum(axis=0))
    right = camera.axes[0] - (camera.axes[0] @ out) * out
    right = _unit(right) if np.linalg.norm(right) > 1e-3 else _unit(np.cross(camera.axes[1], out))
    return np.stack([right, np.cross(out, right), out])


def _stand(
    picture: NDArray[np.float32], face: NDArray[np.int32], scene: Lit, camera: Camera, level: float
) -> None:
    """Darken the background where a floor below would lie in shadow, softly: the shadow is found on a grid."""
    reach_mm = _FLOOR * 512 / scene.scale
    side = _unit(np.cross(scene.up, camera.axes[2]))
    across = np.stack([side, np.cross(side, scene.up)])
    place = np.linspace(-reach_mm, reach_mm, _FLOOR_GRID)
    base = scene.centre + (level - scene.centre @ scene.up) * scene.up
    x, y = np.meshgrid(place, place)
    point = base + x.reshape(-1, 1) * across[0] + y.reshape(-1, 1) * across[1]
    normal = np.broadcast_to(scene.up.astype(np.float32), point.shape)
    light, _ = scene.gather(point, normal, normal)
    toward = np.maximum(scene.lamps.frame[:, 2] @ scene.up, 0) * scene.lamps.share
    dark = 1 - np.clip(light.sum(axis=1) / max(float(toward.sum()), 1e-9), 0, 1)
    dark = _softened(dark.reshape(x.shape)) * np.clip((_FLOOR - np.hypot(x, y) / reach_mm * _FLOOR) / 2, 0, 1)
    row, column = np.nonzero(face < 0)
    for first in range(0, len(row), _CHUNK):
        r, c = row[first : first + _CHUNK], column[first : first + _CHUNK]
        ray = camera.rays(c.astype(np.float64) + 0.5, r.astype(np.float64) + 0.5)
        down = ray @ scene.up
        way = (level - camera.place @ scene.up) / np.where(down < -1e-6, down, -1.0)
        spot = (camera.place + way[:, None] * ray - base) @ across.T
        hit = np.flatnonzero((down < -1e-6) & (np.abs(spot).max(axis=1) < reach_mm))
        at = (spot[hit] / reach_mm + 1) / 2 * (_FLOOR_GRID - 1)
        picture[r[hit], c[hit]] *= (1 - blended(dark, at))[:, None].astype(np.float32)


def _softened(values: NDArray[np.floating]) -> NDArray[np.floating]:
    """Blur a little, along both axes."""
    for _ in range(2):
        wide = np.pad(values, ((1, 1), (0, 0)), "edge")
        values = (0.25 * (wide[:-2] + wide[2:]) + 0.5 * wide[1:-1]).T
    return values


def _paint(
    picture: NDArray[np.float32],
    face: NDArray[np.int32],
    weight: NDArray[np.float32],
    bodies: list[Body],
    scene: Lit,
    camera: Camera,
) -> None:
    """Shade every sample that shows a body."""
    base = 0
    for body in bodies:
        row, column = np.nonzero((face >= base) & (face < base + len(body.faces)))
        corner = camera.project(body.vertices)[body.faces][..., :2]
        levels = _levels(body, corner)
        for first in range(0, len(row), _CHUNK):
            r, c = row[first : first + _CHUNK], column[first : first + _CHUNK]
            picture[r, c] = _samples(body, face[r, c] - base, weight[r, c], levels, scene, camera)
        base += len(body.faces)


def _levels(body: Body, corner: NDArray[np.float64]) -> NDArray[np.float32]:
    """Which halving of the pictures fits a sample, for each face."""
    pyramid = pyramid_of(body)
    if pyramid is None or body.uv is None:
        return np.zeros(len(body.faces), np.float32)
    height, width = pyramid.levels[0].shape[:2]
    texel = body.uv[body.faces] * [width, height]

    def area(places: NDArray[np.float64]) -> NDArray[np.float64]:
        one, two = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
        return np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])

    return (0.5 * np.log2(np.maximum(area(texel), 1e-12) / np.maximum(area(corner), 1e-12)) - 0.5).astype(
        np.float32
    )


def _samples(
    body: Body,
    face: NDArray[np.int32],
    weight: NDArray[np.float32],
    levels: NDArray[np.float32],
    scene: Lit,
    camera: Camera,
) -> NDArray[np.float32]:
    """Shade samples of one body."""
    index = body.faces[face]

    def mixed(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.einsum("nk,nkc->nc", weight, values[index])

    point = mixed(body.vertices)
    a, b, c = (body.vertices[index[:, k]] for k in range(3))
    facing = _unit(np.cross(b - a, c - a))
    to_eye = _unit(camera.place - point)
    smooth = _unit(mixed(body.normals)) if body.normals is not None else facing
    material = np.broadcast_to(factors_of(body), (len(face), 13)).copy()
    normal, pyramid = smooth, pyramid_of(body)
    if pyramid is not None and body.uv is not None:
        material = pyramid.at(mixed(body.uv), levels[face])
        local = material[:, 9:12]
        material[:, 12] = np.linalg.norm(local, axis=1)
        raw = mixed(body.normals) if body.normals is not None else facing
        if body.tangents is not None:
            tangent, sign = mixed(body.tangents[:, :3]), np.sign(body.tangents[index[:, 0], 3])[:, None]
        else:
            tangent, sign = _tangents(b - a, c - a, body.uv[index], raw)
        normal = _unit(
            local[:, :1] * tangent + local[:, 1:2] * sign * np.cross(raw, tangent) + local[:, 2:] * raw
        )
    behind = np.where((facing * to_eye).sum(axis=1) < 0, -1.0, 1.0)[:, None]
    if body.normals is not None:
        point = _lifted(point, weight, body.vertices[index], body.normals[index] * behind[:, None])
    return shaded(scene, material, point, *(
        (v * k).astype(np.float32) for v, k in ((normal, behind), (smooth, behind), (to_eye, 1.0))
    ))  # fmt: skip


def _lifted(
    point: NDArray[np.float64],
    weight: NDArray[np.float32],
    corner: NDArray[np.float64],
    normal: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Lift points from facets to about where the smooth surface lies, lest facets throw shadows on themselves.

    A point goes to the blend of its projections onto the tangent planes of its corners [1]_; where these lean by 30 degrees
    and more, the facet is meant to be one (a crate without normals), and beyond 45 nothing is lifted.

    References
    ----------
    .. [1] Hanika. Hacking the Shadow Terminator. Ray Tracing Gems II, chapter 4 (2021).
    """
    depth = np.minimum(np.einsum("nkc,nkc->nk", point[:, None] - corner, normal), 0)
    facet = _unit(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))
    lean = np.abs(np.einsum("nc,nkc->nk", facet, normal)).min(axis=1)
    share = np.clip((lean - np.cos(np.pi / 4)) / (np.cos(np.pi / 6) - np.cos(np.pi / 4)), 0, 1)
    return point - share[:, None] * np.einsum("nk,nk,nkc->nc", weight, depth, normal)


def _tangents(
    one: NDArray[np.float64], two: NDArray[np.float64], uv: NDArray[np.float64], normal: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Direction of u across each face, and the side of its bitangent, for files without tangents."""
    du, dv = uv[:, 1:, 0] - uv[:, :1, 0], uv[:, :1, 1] - uv[:, 1:, 1]
    twice = du[:, 0] * dv[:, 1] - du[:, 1] * dv[:, 0]
    sign = np.where(twice < 0, -1.0, 1.0)[:, None]
    tangent = sign * (one * dv[:, 1:] - two * dv[:, :1])
    tangent -= (tangent * normal).sum(axis=1, keepdims=True) * normal
    return _unit(tangent), sign


def _unit(vectors: NDArray[Any]) -> NDArray[np.float64]:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-20)


def _color(value: str | ArrayLike) -> NDArray[np.float32]:
    """Linear light of a colour."""
    from surftex.preview.texture import linear_light

    if isinstance(value, str):
        text = value.lstrip("#")
        if len(text) != 6 or any(c not in "0123456789abcdefABCDEF" for c in text):
            raise RecipeError(f"background is {value!r}; it takes '#rrggbb'")
        return linear_light(np.array([int(text[k : k + 2], 16) for k in (0, 2, 4)], np.uint8))
    color = np.asarray(value, np.float32)
    if color.shape != (3,):
        raise RecipeError(f"background is {value!r}; it takes '#rrggbb' or three numbers of linear light")
    return color


def _codes(linear: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Encode for a screen; what is brighter than white bends over instead of being cut."""
    from surftex.files.images import srgb_codes

    knee = np.float32(0.75)
    over = np.maximum(linear - knee, 0)
    return srgb_codes(np.minimum(linear, knee) + over / (1 + over / (1 - knee)))
