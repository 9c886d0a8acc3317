"""Curves of a skin: vessels that wander and fork, wrinkles that grow along a direction."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from surftex.errors import naming
from surftex.features.curves import ROW, curve_table
from surftex.features.growth import grow
from surftex.features.uniform import scatter
from surftex.fields.noise import Noise
from surftex.fields.sources import Field
from surftex.fields.vectors import VectorField
from surftex.geodesics.directions import DirectionField
from surftex.geodesics.tracing import trace
from surftex.materials.skin.kinds import setting
from surftex.materials.skin.model import Skin
from surftex.randomness import Stream, stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

LINE = np.dtype([*ROW.descr, ("width_mm", "f8"), ("depth_mm", "f8"), ("side", "f8")])
"""A piece of a curve, with what its whole curve has in common; `side` is where its fold rises, 1 (left) or -1."""

_STEPS = 14
_FORK_RAD = 0.6

FORKS = 0.8
"""How likely each of the two branches of a fork grows."""


def vessels(
    skin: Skin, surface: Surface, where: Field | None, random: Stream, threads: int | None
) -> NDArray:
    """Grow vessels: trunks that wander, and fork into ever thinner branches.

    Parameters
    ----------
    skin : Skin
        How many, how long, how wide.
    surface : Surface
        Where.
    where : Field, optional
        How likely trunks start at points.
    random : Stream
        Of the vessels.
    threads : int, optional
        None means every core.

    Returns
    -------
    table : (p,) structured array
        See `LINE`.
    """
    points = _starts(skin, surface, "vessel", where, random)
    count = len(points)
    heading = 2 * np.pi * stream(random.key, "heading").uniform(count)[:, 0]
    length, width = np.full(count, skin.vessel_length), np.full(count, skin.vessel_width)
    parts: list[NDArray] = []
    for generation in range(skin.vessel_branches + 1):
        if not len(points) or skin.vessel_length <= 0:
            break
        own = stream(random.key, "generation", generation)
        turn = np.radians(skin.vessel_wander) * (2 * own.uniform(len(points) * _STEPS)[:, 0] - 1)
        turns = turn.reshape(_STEPS, len(points))
        table, places, headings = _walked(
            surface, points, heading, length, lambda step, _points, angle, t=turns: angle + t[step], threads
        )
        line = np.zeros(len(table), LINE)
        for column in ROW.names or ():
            line[column] = table[column]
        line["width_mm"], line["depth_mm"], line["side"] = width[table["curve"]], skin.vessel_blood, 1.0
        line["curve"] += sum(map(_curves, parts))
        parts.append(line)
        numbers = stream(random.key, "fork", generation).uniform(2 * len(points), 3)
        parent = np.repeat(np.arange(len(points)), 2)
        step = 2 + (numbers[:, 0] * (_STEPS - 4)).astype(np.int64)
        kept = numbers[:, 2] < FORKS
        parent, step, numbers = parent[kept], step[kept], numbers[kept]
        fork = (
            np.where(np.arange(2 * len(points))[kept] % 2, 1.0, -1.0)
            * _FORK_RAD
            * (0.6 + 0.8 * numbers[:, 1])
        )
        face = np.stack([place.face for place in places])
        barycentric = np.stack([place.barycentric for place in places])
        points = SurfacePoints.trusted(face[step, parent], barycentric[step, parent])
        heading = np.stack(headings)[step, parent] + fork
        length, width = 0.6 * length[parent], 0.7 * width[parent]
    return np.concatenate([np.zeros(0, LINE), *parts])


def wrinkles(
    skin: Skin,
    surface: Surface,
    where: Field | None,
    along: Callable[[], DirectionField | VectorField],
    random: Stream,
    threads: int | None,
) -> NDArray:
    """Grow wrinkles along a direction field, or along vectors as long as these are.

    Parameters
    ----------
    skin : Skin
        How many, how long, wide and deep.
    surface : Surface
        Where.
    where : Field, optional
        How likely they start at points.
    along : callable
        Gives the field, when there are any; where a vector is 0 no wrinkle starts.
    random : Stream
        Of the wrinkles.
    threads : int, optional
        None means every core.

    Returns
    -------
    table : (p,) structured array
        See `LINE`.
    """
    points = _starts(skin, surface, "wrinkle", where, random)
    count = len(points)
    if not count:
        return np.zeros(0, LINE)
    field = along()
    vectors = field if isinstance(field, VectorField) else _of_length(skin, field, random)
    numbers = stream(random.key, "size").uniform(count, 3)
    width, depth = (
        low + (high - low) * numbers[:, i]
        for i, (low, high) in enumerate((skin.wrinkle_width, skin.wrinkle_depth))
    )
    side = np.where(numbers[:, 2] < 0.5, 1.0, -1.0)
    starts = np.hypot(*vectors.at(points).T) > 0
    points = SurfacePoints.trusted(points.face[starts], points.barycentric[starts])
    if not len(points):
        return np.zeros(0, LINE)
    pieces = grow(surface, points, vectors.at, threads=threads)
    return curve_table(surface, pieces, width_mm=width[starts], depth_mm=depth[starts], side=side[starts])


def drawn_lines(table: NDArray, random: Stream) -> NDArray:
    """Take drawn curves for wrinkles.

    Parameters
    ----------
    table : (p,) structured array
        Rows of `surftex.features.curves`, with ``width_mm`` and ``depth_mm``.
    random : Stream
        Decides on which side each has its fold.

    Returns
    -------
    lines : (p,) structured array
        See `LINE`.
    """
    lines = np.zeros(len(table), LINE)
    for name in table.dtype.names or ():
        lines[name] = table[name]
    lines["side"] = np.where(random.uniform(_curves(table))[:, 0] < 0.5, 1.0, -1.0)[table["curve"]]
    return lines


def _of_length(skin: Skin, field: DirectionField, random: Stream) -> VectorField:
    """Vectors along a direction, of lengths that vary from place to place."""
    least, most = skin.wrinkle_length
    noise = Noise(stream(random.key, "length"), max(2 * most, 1e-3))

    def length_mm(points: SurfacePoints) -> NDArray[np.float64]:
        share = 0.5 + 0.8 * noise.at(points.positions(field.surface)).astype(np.float64)
        return least + (most - least) * np.clip(share, 0, 1)

    return VectorField.along(field, length_mm)


def _starts(skin: Skin, surface: Surface, kind: str, where: Field | None, random: Stream) -> SurfacePoints:
    own = stream(random.key, "count"), stream(random.key, "density")
    count, per_mm2 = setting(skin, kind, "count"), setting(skin, kind, "density") / 1000
    with naming(f"skin.{kind}_where"):
        parts = [
            scatter(surface, own[0], count=count, weight=where) if count else None,
            scatter(surface, own[1], density_per_mm2=per_mm2, weight=where) if per_mm2 else None,
        ]
    found = [part for part in parts if part is not None]
    face = np.concatenate([np.zeros(0, np.int32), *[part.face for part in found]])
    return SurfacePoints.trusted(
        face, np.concatenate([np.zeros((0, 3)), *[part.barycentric for part in found]])
    )


def _walked(
    surface: Surface,
    points: SurfacePoints,
    angle: NDArray,
    length: NDArray,
    onward: Callable[[int, SurfacePoints, NDArray], NDArray],
    threads: int | None,
) -> tuple[NDArray, list[SurfacePoints], list[NDArray]]:
    """Walk curves step by step: their rows, and where and how they went at every step."""
    tables, places, headings = [], [points], [angle]
    for step in range(_STEPS):
        angle = onward(step, points, angle)
        walk = trace(surface, points, angle, length / _STEPS, threads=threads)
        tables.append(curve_table(surface, walk.pieces))
        points, angle = walk.end, walk.angle_rad
        places.append(points)
        headings.append(angle)
    done = np.zeros(len(length))
    for table in tables:
        own = np.bincount(table["curve"], weights=_piece_mm(surface, table), minlength=len(length))
        table["start_mm"] += done[table["curve"]]
        done = done + own
    table = np.concatenate(tables)
    table["length_mm"] = done[table["curve"]]
    return table[np.argsort(table["curve"], kind="stable")], places, headings


def _piece_mm(surface: Surface, table: NDArray) -> NDArray[np.floating]:
    corner = surface.flat[table["face"]]
    return np.linalg.norm(
        np.einsum("pk,pki->pi", table["end_barycentric"] - table["barycentric"], corner), axis=1
    )


def _curves(table: NDArray) -> int:
    return int(table["curve"].max()) + 1 if len(table) else 0
