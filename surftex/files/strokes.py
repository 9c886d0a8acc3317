"""Strokes and picked points in a JSON file: what an artist drew on a mesh, to be read back onto its surface.

::

    {
      "surftex": 1,
      "faces": 17684,
      "strokes": [
        [[x, y, z], [x, y, z], ...],
        {"name": "crow", "points": [...], "width_mm": 1.2, "depth_mm": 0.3}
      ],
      "points": {"nose_tip": [x, y, z], "chin": {"face": 12, "barycentric": [0.2, 0.3, 0.5]}}
    }

A place is three coordinates in the mesh file's own axes and unit, which are laid onto the nearest point of the
surface, or a face of the loaded surface with weights; one that has both (``xyz`` beside ``face``) is taken by its
face on a surface of as many ``faces``, and by its coordinates on any other. All keys may be left out but for the
places themselves; ``points`` may be a list; a stroke may carry any further numbers.
"""

import json
import math
import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import RecipeError, WorkError
from surftex.files.reading import printable
from surftex.surface.closest import closest_points
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

LARGEST_BYTES = 64 * 2**20
"""Longest file that is read."""

VERSION = 1
"""Of the file, its ``surftex``; without one it counts as this."""

WIDEST_MM = 1000.0
"""Greatest ``width_mm`` and ``depth_mm`` of a stroke."""

MOST_PLACES = 1_000_000
"""Most places in a file."""


@dataclass(frozen=True, eq=False)
class Stroke:
    """A line that was drawn on a surface.

    Attributes
    ----------
    points : SurfacePoints
        Places in the order of drawing, at least one.
    name : str
        May be empty.
    numbers : mapping of str to float
        Whatever else was said of it, such as ``width_mm``.
    """

    points: SurfacePoints
    name: str = ""
    numbers: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Strokes:
    """What a file of strokes holds.

    Attributes
    ----------
    strokes : tuple of Stroke
        Lines, in the order of the file.
    points : mapping of str to SurfacePoints
        Single places by name; those of a list are called ``"1"``, ``"2"`` and so on.
    """

    strokes: tuple[Stroke, ...] = ()
    points: Mapping[str, SurfacePoints] = field(default_factory=dict)


def read_strokes(path: str | Path, surface: Surface) -> Strokes:
    """Read strokes and points, and lay them onto a surface.

    Parameters
    ----------
    path : path
        Of a JSON file.
    surface : Surface
        What they were drawn on.

    Returns
    -------
    strokes : Strokes
        With every place on the surface.

    Raises
    ------
    RecipeError
        If the file cannot be read or is of another version, a place is none or far from the surface, or a width or depth
        has no sense; with file and key.
    """
    file = Path(path)
    content = _content(file)
    if (version := content.get("surftex", VERSION)) != VERSION:
        told = printable(repr(version), longest=40)
        raise RecipeError(f"{file.name}: surftex is {told}; this program reads strokes of surftex {VERSION}")
    places = _Places(file.name, surface, content.get("faces"))
    lines = content.get("strokes", [])
    spots = content.get("points", {})
    if not isinstance(lines, list) or not isinstance(spots, (dict, list)) or not (lines or spots):
        raise RecipeError(
            f'{file.name} holds no strokes; write {{"strokes": [[[x, y, z], ...], ...]}} or "points"'
        )
    found = []
    for i, line in enumerate(lines):
        table = line if isinstance(line, dict) else {"points": line}
        key = f"strokes[{i}]"
        listed = table.get("points")
        if not isinstance(listed, list) or not listed:
            raise RecipeError(f"{file.name}: {key} holds no strokes: it takes a list of places")
        first = places.count
        for k, place in enumerate(listed):
            places.add(place, f"{key}[{k}]")
        numbers = {
            printable(name, longest=40): _finite(value, f"{file.name}: {key}.{name}")
            for name, value in table.items()
            if name not in ("points", "name")
        }
        _check_size(numbers, f"{file.name}: {key}")
        found.append((first, places.count, printable(str(table.get("name", "")), longest=80), numbers))
    named = (
        spots.items() if isinstance(spots, dict) else ((str(k + 1), place) for k, place in enumerate(spots))
    )
    single = {}
    for name, place in named:
        single[printable(name, longest=80)] = places.count
        places.add(place, f"points.{name}")
    every = places.laid()
    return Strokes(
        tuple(Stroke(_part(every, first, last), name, numbers) for first, last, name, numbers in found),
        {name: _part(every, at, at + 1) for name, at in single.items()},
    )


def write_strokes(
    path: str | Path,
    surface: Surface,
    strokes: Sequence[Stroke] = (),
    points: Mapping[str, SurfacePoints] | None = None,
) -> None:
    """Write strokes and points so that `read_strokes` finds the same places.

    Parameters
    ----------
    path : path
        Of the file; replaced whole, or not at all.
    surface : Surface
        What they were drawn on.
    strokes : sequence of Stroke
        Lines.
    points : mapping of str to SurfacePoints
        Single places by name.

    Raises
    ------
    WorkError
        If the file cannot be written.
    """
    lines = [
        {"name": stroke.name, **stroke.numbers, "points": _written(surface, stroke.points)}
        for stroke in strokes
    ]
    spots = {name: _written(surface, place)[0] for name, place in (points or {}).items()}
    content = {"surftex": VERSION, "faces": len(surface.faces), "strokes": lines, "points": spots}
    text = json.dumps(content, indent=1, allow_nan=False)
    file = Path(path)
    try:
        handle, hidden = tempfile.mkstemp(dir=file.parent, prefix=f".{file.name}.")
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as stream:
                stream.write(text + "\n")
            Path(hidden).chmod(0o644)
            Path(hidden).replace(file)
        except BaseException:
            Path(hidden).unlink(missing_ok=True)
            raise
    except OSError as problem:
        raise WorkError(f"{printable(str(file))}: cannot be written ({problem.strerror})") from None


def _content(file: Path) -> dict[str, Any]:
    shown = printable(str(file))
    try:
        if not file.is_file():
            raise RecipeError(f"strokes {shown!r}: {'is no file' if file.exists() else 'does not exist'}")
        if file.stat().st_size > LARGEST_BYTES:
            raise RecipeError(f"{file.name} has {file.stat().st_size} bytes; are these strokes?")
        content = json.loads(file.read_bytes())
    except OSError as problem:
        raise RecipeError(f"strokes {shown!r} cannot be read: {problem.strerror}") from None
    except (ValueError, RecursionError) as problem:
        if isinstance(problem, RecipeError):
            raise
        line = f" at line {problem.lineno}" if isinstance(problem, json.JSONDecodeError) else ""
        raise RecipeError(f"{file.name}{line} holds no strokes: it is no JSON") from None
    if not isinstance(content, dict):
        raise RecipeError(f'{file.name} holds no strokes; write {{"strokes": [[[x, y, z], ...], ...]}}')
    return content


class _Places:
    """Places of a file, gathered to be laid onto a surface in one go."""

    def __init__(self, name: str, surface: Surface, faces: Any) -> None:
        self.name, self.surface = name, surface
        self.same = faces is None or faces == len(surface.faces)
        self.told = faces
        self.space: list[tuple[int, list[float], str]] = []
        self.given: list[tuple[int, int, list[float]]] = []
        self.count = 0

    def add(self, place: Any, key: str) -> None:
        """Take one place, as the file has it."""
        if self.count >= MOST_PLACES:
            raise RecipeError(f"{self.name}: {key}: more than {MOST_PLACES} places; are these strokes?")
        where = f"{self.name}: {key}"
        if isinstance(place, dict) and "face" in place and (self.same or "xyz" not in place):
            self._add_weights(place, where)
        else:
            values = place.get("xyz") if isinstance(place, dict) else place
            if not isinstance(values, list) or len(values) != 3:
                raise RecipeError(
                    f"{where} holds no strokes: a place is [x, y, z] or "
                    '{"face": f, "barycentric": [a, b, c]}'
                )
            self.space.append((self.count, [_finite(value, where) for value in values], where))
        self.count += 1

    def _add_weights(self, place: dict[str, Any], where: str) -> None:
        face, weights, most = place["face"], place.get("barycentric"), len(self.surface.faces)
        if not self.same:
            raise RecipeError(
                f"{where} was drawn on a mesh of {self.told} faces, and this one has {most}; "
                "give its xyz as well"
            )
        if not isinstance(face, int) or isinstance(face, bool) or not 0 <= face < most:
            raise RecipeError(f"{where}: face {printable(repr(face), longest=40)} is none of 0 to {most - 1}")
        if not isinstance(weights, list) or len(weights) != 3:
            raise RecipeError(f"{where}: barycentric takes three numbers with sum 1")
        numbers = [_finite(value, where) for value in weights]
        if min(numbers) < -1e-6 or abs(sum(numbers) - 1) > 1e-4:
            raise RecipeError(f"{where}: barycentric {numbers} are no weights with sum 1")
        self.given.append((self.count, face, [max(value, 0.0) for value in numbers]))

    def laid(self) -> SurfacePoints:
        """Find every place on the surface."""
        face, weights = np.zeros(self.count, np.int32), np.zeros((self.count, 3))
        for at, which, numbers in self.given:
            face[at], weights[at] = which, np.array(numbers) / sum(numbers)
        if self.space:
            surface = self.surface
            rows = np.array([at for at, _, _ in self.space])
            with np.errstate(over="ignore"):
                spots = np.array([values for _, values, _ in self.space]) * surface.mm_per_unit
            spots -= surface.origin_mm
            size = float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
            beyond = np.abs(spots).max(axis=1) > 1e6 * size
            points, away = closest_points(surface, np.where(beyond[:, None], 1e6 * size, spots))
            far = np.flatnonzero(away > size)
            if len(far):
                raise RecipeError(
                    f"{self.space[far[0]][2]} lies {away[far[0]]:.4g} mm off a surface of {size:.4g} mm; "
                    "are its axes and unit those of the mesh file?"
                )
            face[rows], weights[rows] = points.face, points.barycentric
        return SurfacePoints(face, weights)


def _finite(value: Any, where: str) -> float:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        try:
            if math.isfinite(value):
                return float(value)
        except OverflowError:
            pass
        raise RecipeError(f"{where}: {value!r:.40} is not finite")
    raise RecipeError(f"{where}: {printable(repr(value), longest=40)} is no number")


def _check_size(numbers: Mapping[str, float], where: str) -> None:
    width, depth = numbers.get("width_mm", 1.0), numbers.get("depth_mm", 0.0)
    if not 0 < width <= WIDEST_MM:
        raise RecipeError(f"{where}.width_mm is {width:g}; it takes more than 0 and at most {WIDEST_MM:g}")
    if not 0 <= depth <= WIDEST_MM:
        raise RecipeError(f"{where}.depth_mm is {depth:g}; it takes 0 to {WIDEST_MM:g}")


def _part(points: SurfacePoints, first: int, last: int) -> SurfacePoints:
    return SurfacePoints(points.face[first:last], points.barycentric[first:last])


def _written(surface: Surface, points: SurfacePoints) -> list[dict[str, Any]]:
    points.check_on(surface)
    spots: NDArray[np.float64] = (points.positions(surface) + surface.origin_mm) / surface.mm_per_unit
    return [
        {"face": int(face), "barycentric": weights, "xyz": spot}
        for face, weights, spot in zip(points.face, points.barycentric.tolist(), spots.tolist(), strict=True)
    ]
