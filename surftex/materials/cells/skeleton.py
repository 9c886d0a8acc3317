"""Placing grown cells: particles, the cells between them, then wrinkles along their sides, a stream for each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError, RecipeError, naming
from surftex.features.cell_mesh import kept_apart, paired
from surftex.features.cell_planes import CellPlanes, surface_cells
from surftex.features.cell_walks import sides_of, walks
from surftex.features.cells_surface import surface_triangles
from surftex.features.curves import curve_table, with_drawn
from surftex.features.growth_surface import SurfaceGround
from surftex.features.near_logs import path_angles
from surftex.features.particle_growth import ATTRACTED, Ground, Particles, grow, on_top
from surftex.fields.fieldset import FieldSet
from surftex.geodesics.directions import DirectionField
from surftex.geodesics.paths import polyline, shortest_path
from surftex.geodesics.pieces import CurvePieces
from surftex.geodesics.tracing import trace
from surftex.kernels.pool import PartTick, Tick
from surftex.materials.cells.model import Cells
from surftex.materials.limits import Expected, refuse_more
from surftex.materials.parameters import RATIOS
from surftex.randomness import stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

PARTICLE = np.dtype(
    [
        ("face", "i4"), ("barycentric", "f8", 3), ("place_mm", "f8", 2), ("height_mm", "f8"), ("velocity", "f8", 3),
        ("angle_rad", "f8"), ("diameter_mm", "f8"), ("scale_mm", "f8"), ("aspect", "f8"), ("born", "i4"),
        ("generation", "i4"),
    ]
)  # fmt: skip
"""A particle: where its foot is, then its whole state, so that a growth can go on from it."""

CELL = np.dtype(
    [
        ("face", "i4"), ("barycentric", "f8", 3), ("corner_mm", "f8", (4, 2)), ("sides", "i4"), ("scale_mm", "f8"),
        ("corner", "i4", 4), ("bend_mm", "f8", (4, 2)),
    ]
)  # fmt: skip
"""A cell: its centre, its corners in the log map there, which particles they are (-1: none, or the rim), its bends."""

CELLS_PER_SIZE = 1.81
"""Cells of a full growth for each square of the largest diameter: measured."""

_BY_PAIRS = 0.55
"""Share of the work for a round particle that grows with the number of those around it: measured."""

_GROWTH = 0.6
_SLOPE = 0.05
"""Step, in cell sizes, over which the slope of a potential is measured."""


def place(
    cells: Cells,
    surface: Surface,
    seed: int,
    *,
    fields: FieldSet | None,
    features: Mapping[str, NDArray] | None,
    max_features: int,
    threads: int | None,
    tick: Tick | None,
) -> dict[str, NDArray]:
    """Grow particles, and join them to cells.

    Parameters
    ----------
    cells : Cells
        What to place.
    surface : Surface
        Where.
    seed : int
        Of all streams.
    fields : FieldSet, optional
        Named numbers and directions.
    features : mapping of str to structured array, optional
        Particles to go on from.
    max_features : int
        Refuse beyond it.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share, and the count of particles.

    Returns
    -------
    features : dict of str to structured array
        By kind; each row has `face` and `barycentric`.
    """
    names = fields or FieldSet(surface)
    refuse_more("cells", expected_features(cells, surface, seed, names), surface.area_mm2, max_features)
    creases = _creases(cells, surface, seed, names, threads)
    ground = ground_of(cells, surface, names, creases)
    start = None if features is None or "particle" not in features else particles_of(features["particle"])
    if start is not None and len(start) and int(start.face.max()) >= len(surface.faces):
        raise RecipeError(
            "cells: the saved particles lie on faces that the mesh does not have; was it another mesh?"
        )
    particles = grown(
        cells,
        ground,
        seed,
        start=start,
        most=max_features,
        threads=threads,
        tick=PartTick(tick, 0.0, _GROWTH),
    )
    made: dict[str, NDArray] = {"particle": particle_table(particles, ground.points(particles))}
    top = chosen(cells, ground, particles, threads)
    if len(top):
        points = ground.points(top)
        corners = surface_triangles(surface, points, top.scale, top.aspect, top.angle, threads=threads)
        regions = paired(corners.triangles, share=cells.quads, most_rad=np.radians(cells.squareness))
        planes, centre = surface_cells(surface, regions, corners, top.scale, threads=threads)
        made["cell"] = cell_table(planes, centre, np.where(regions < len(top), regions, -1))
        lines = creases
        if lines is None:
            lines = _wrinkles(cells, surface, seed, names, points, regions, threads)
        if cells.wrinkle_curves is not None:
            lines = with_drawn(lines, names.curves(cells.wrinkle_curves))
        if len(lines):
            made["wrinkle"] = lines
    else:
        made["cell"] = np.zeros(0, CELL)
    if tick is not None:
        tick(1.0)
    return made


def expected_features(cells: Cells, surface: Surface, seed: int, names: FieldSet) -> tuple[Expected, ...]:
    """Tell about how many particles would be born, and what is made of them.

    Parameters
    ----------
    cells : Cells
        What would grow.
    surface : Surface
        Where.
    seed : int
        Of everything random.
    names : FieldSet
        Named numbers.

    Returns
    -------
    expected : tuple of Expected
        Of each kind.

    Raises
    ------
    RecipeError
        If an expression does not fit.
    """
    size = _number(names, cells.cell_size, "cell_size")
    with naming("cells.cell_size"):
        ground = SurfaceGround(surface, size)
        births, grown_up = cells.law.total_births(ground.area), CELLS_PER_SIZE * ground.area
    by_area = wrinkle_count(cells, surface.area_mm2, seed) - cells.wrinkle_count
    drawn = 0
    if cells.wrinkle_curves is not None:
        with naming("cells.wrinkle_curves"):
            drawn = len(np.unique(names.curves(cells.wrinkle_curves)["curve"]))
    return (
        Expected(
            "particle",
            births,
            "cell_size",
            cells.cell_size,
            -2,
            effort=_particle_effort(cells, surface, names),
        ),
        Expected("cell", grown_up, "cell_size", cells.cell_size, -2),
        Expected("wrinkle", cells.wrinkle_count, "wrinkle_count", cells.wrinkle_count),
        Expected("wrinkle", by_area, "wrinkle_density", cells.wrinkle_density),
        Expected("wrinkle", drawn, "wrinkle_curves", cells.wrinkle_curves or ""),
    )


def _particle_effort(cells: Cells, surface: Surface, names: FieldSet) -> float:
    """Count the generations that a particle lives, longer ones and such as attract for as many more as lie in their reach."""
    ratio = _number(names, cells.cell_ratio, "cell_ratio")
    each = np.asarray(ratio(_middles(surface)) if callable(ratio) else ratio, np.float64)
    area = surface.face_area_mm2 if each.ndim else None
    reach = float(np.average(np.maximum(each, 1 / each), weights=area))
    if cells.attraction > 0:
        reach *= ATTRACTED**2
    return cells.law.mean_life() * (1 - _BY_PAIRS + _BY_PAIRS * reach)


def ground_of(
    cells: Cells, surface: Surface, names: FieldSet, creases: NDArray | None = None
) -> SurfaceGround:
    """Describe what particles grow on.

    Parameters
    ----------
    cells : Cells
        What grows.
    surface : Surface
        Where.
    names : FieldSet
        Named numbers and directions.
    creases : (p,) structured array, optional
        Wrinkles that drive particles away.

    Returns
    -------
    ground : SurfaceGround
        For `grown`.
    """
    size, ratio = _number(names, cells.cell_size, "cell_size"), _number(names, cells.cell_ratio, "cell_ratio")
    direction = None
    if cells.direction is not None:
        direction = names.direction(cells.direction)
    elif cells.cell_ratio != 1.0:
        direction = DirectionField.smoothest(surface)
    potential = _potential(cells, surface, names, size, creases)
    return SurfaceGround(surface, size, ratio, direction, _force(cells, surface, names, size, potential))


def grown(
    cells: Cells,
    ground: Ground,
    seed: int,
    *,
    start: Particles | None = None,
    until: int | None = None,
    most: int = 5_000_000,
    threads: int | None = None,
    tick: Tick | None = None,
    watch: Callable[[Particles], None] | None = None,
) -> Particles:
    """Let the particles of a material grow.

    Parameters
    ----------
    cells : Cells
        Their law.
    ground : Ground
        Where.
    seed : int
        Of their births.
    start : Particles, optional
        Go on from these.
    until : int, optional
        Stop after so many generations.
    most : int
        Refuse to give birth to more.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share, and the count of particles.
    watch : callable, optional
        Told the particles after each generation.

    Returns
    -------
    particles : Particles
        After the last generation.

    Raises
    ------
    RecipeError
        If there would be too many, or `start` is older than the growth is to be.
    """
    law = cells.law
    if start is not None and start.generation > law.generations:
        raise RecipeError(
            f"cells.generations: the saved growth is {start.generation} generations old, beyond the {law.generations} "
            "asked for; ask for as many, or begin anew"
        )
    told = PartTick(tick)

    def seen(particles: Particles) -> None:
        told.detail(f"{len(particles):,} particles, generation {particles.generation}")
        told(particles.generation / law.generations)
        told.keep(
            particles.generation,
            law.generations,
            lambda: {"particle": particle_table(particles, ground.points(particles))},
        )
        if watch is not None:
            watch(particles)

    try:
        return grow(
            ground,
            law,
            stream(seed, "cells", "births"),
            start=start,
            until=until,
            most=most,
            threads=threads,
            watch=seen,
        )
    except RecipeError:
        raise
    except InputError as problem:
        raise RecipeError(f"cells.cell_size: {problem}") from None


def chosen(cells: Cells, ground: Ground, particles: Particles, threads: int | None) -> Particles:
    """Pick the particles that make cells: those on top, without those that lie too close under others.

    Parameters
    ----------
    cells : Cells
        Their law.
    ground : Ground
        What they grew on.
    particles : Particles
        n of them.
    threads : int, optional
        None means every core.

    Returns
    -------
    top : Particles
        Some of them.
    """
    top = particles.chosen(on_top(ground, cells.law, particles, threads=threads))
    if len(top) == 0:
        return top
    radius = top.radius(cells.law)
    across = radius / np.sqrt(np.maximum(top.aspect, 1 / top.aspect))
    near = ground.neighbours(top, radius, 1.0, float(np.ptp(top.height)), threads)
    row = np.arange(near.index.shape[1])[None] < near.count[:, None]
    first, second = np.nonzero(row)[0], near.index[row].astype(np.int64)
    distance = ground.apart(top, first, second)
    return top.chosen(kept_apart(first, second, distance, across, top.height + radius))


def particle_table(particles: Particles, points: SurfacePoints) -> NDArray:
    """Write particles as rows of features.

    Parameters
    ----------
    particles : Particles
        n of them.
    points : SurfacePoints
        Their feet.

    Returns
    -------
    table : (n,) structured array
        See `PARTICLE`.
    """
    table = np.zeros(len(particles), PARTICLE)
    table["face"], table["barycentric"] = points.face, points.barycentric
    for name, column in _STATE.items():
        table[column] = getattr(particles, name)
    table["generation"] = particles.generation
    return table


def particles_of(table: NDArray) -> Particles:
    """Read particles from rows of features.

    Parameters
    ----------
    table : (n,) structured array
        As `particle_table` writes it.

    Returns
    -------
    particles : Particles
        n of them, as they were.

    Raises
    ------
    RecipeError
        If the rows are no particles.
    """
    missing = sorted(set(PARTICLE.names or ()) - set(table.dtype.names or ()))
    if missing:
        raise RecipeError(
            f"cells: saved particles lack {', '.join(missing)}; were they saved by another material?"
        )
    state: dict[str, Any] = {
        name: np.ascontiguousarray(table[column], np.int64 if name == "born" else np.float64)
        for name, column in _STATE.items()
    }
    face = np.ascontiguousarray(table["face"], np.int32)
    return Particles(int(table["generation"].max(initial=0)), face, **state)


_STATE = {
    "place": "place_mm", "height": "height_mm", "velocity": "velocity", "angle": "angle_rad",
    "diameter": "diameter_mm", "scale": "scale_mm", "aspect": "aspect", "born": "born",
}  # fmt: skip


def cell_table(planes: CellPlanes, centre: SurfacePoints, corner: NDArray[np.int64]) -> NDArray:
    """Write cells as rows of features.

    Parameters
    ----------
    planes : CellPlanes
        c cells.
    centre : SurfacePoints
        Origins of their planes.
    corner : (c, 4) int64
        Particles at their corners.

    Returns
    -------
    table : (c,) structured array
        See `CELL`.
    """
    table = np.zeros(len(planes), CELL)
    table["face"], table["barycentric"] = centre.face, centre.barycentric
    table["corner_mm"], table["bend_mm"] = planes.corner, planes.bend
    table["sides"], table["scale_mm"] = planes.sides, planes.scale
    table["corner"] = corner
    return table


def _number(names: FieldSet, value: float | str, key: str) -> float | Callable[[SurfacePoints], NDArray]:
    """Take a number as it is, an expression as a function of points."""
    if not isinstance(value, str):
        return value
    try:
        field = names.scalar(value)
    except RecipeError as problem:
        raise RecipeError(f"cells.{key}: {problem}") from None
    values = field(_middles(names.surface))
    least = float(np.min(values))
    if key == "cell_ratio":
        for ratio in (least, float(np.max(values))):
            if not RATIOS[0] <= ratio <= RATIOS[1]:
                raise RecipeError(
                    f"cells.{key}: {value!r} gives {ratio:g}, not between {RATIOS[0]:g} and {RATIOS[1]:g}"
                )
    if not least > 0:
        raise RecipeError(f"cells.{key}: {value!r} falls to {least:g}; it must stay above 0")
    return field


def _middles(surface: Surface) -> SurfacePoints:
    count = len(surface.faces)
    return SurfacePoints.trusted(np.arange(count, dtype=np.int32), np.full((count, 3), 1 / 3))


def _creases(
    cells: Cells, surface: Surface, seed: int, names: FieldSet, threads: int | None
) -> NDArray | None:
    """Wrinkles that are there before the growth; None where wrinkles come after it."""
    if cells.wrinkle_potential <= 0:
        return None
    from surftex.materials.cells.creases import laid_creases

    size = _usual(_number(names, cells.cell_size, "cell_size"), surface)
    table = laid_creases(cells, surface, seed, names, size, threads)
    as_material = np.zeros(len(table), [*table.dtype.descr, ("width_mm", "f8"), ("depth_mm", "f8")])
    for name in table.dtype.names or ():
        as_material[name] = table[name]
    return as_material


def _usual(size: float | Callable[[SurfacePoints], NDArray], surface: Surface) -> float:
    return float(np.median(size(_middles(surface)))) if callable(size) else float(size)


def _potential(
    cells: Cells, surface: Surface, names: FieldSet, size: float | Callable[[SurfacePoints], NDArray],
    creases: NDArray | None,
) -> Callable[[SurfacePoints], NDArray] | None:  # fmt: skip
    """Potential of the material's own expression, and of creases, whichever is higher."""
    own = None
    if cells.potential_force <= 0:
        return None
    if cells.potential is not None:
        try:
            own = names.scalar(cells.potential)
        except RecipeError as problem:
            raise RecipeError(f"cells.potential: {problem}") from None
    if creases is None or not len(creases):
        return own
    from surftex.materials.cells.creases import crease_potential

    laid = crease_potential(surface, creases, _usual(size, surface), cells.wrinkle_potential)
    return laid if own is None else lambda points: np.maximum(own(points), laid(points))


def _force(
    cells: Cells, surface: Surface, names: FieldSet, size: float | Callable[[SurfacePoints], NDArray],
    potential: Callable[[SurfacePoints], NDArray] | None,
) -> Callable[[SurfacePoints], NDArray[np.float64]] | None:  # fmt: skip
    """Force of potential and drift at points, in space."""
    drift = names.direction(cells.drift) if cells.drift is not None and cells.drift_force > 0 else None
    if potential is None and drift is None:
        return None

    def force(points: SurfacePoints) -> NDArray[np.float64]:
        scale = np.asarray(size(points), np.float64) if callable(size) else np.full(len(points), size)
        flat = np.zeros((len(points), 2))
        if potential is not None:
            step = _SLOPE * scale
            here = np.asarray(potential(points), np.float64)
            for axis in (0, 1):
                there = trace(surface, points, axis * np.pi / 2, step, threads=1).end
                flat[:, axis] = (potential(there) - here) / step
            flat *= (cells.potential_height * scale)[:, None]
            flat *= -(cells.potential_force * scale / np.sqrt(1 + (flat**2).sum(axis=1)))[:, None]
        if drift is not None:
            angle = drift.at(points)
            flat += (cells.drift_force * scale)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return np.einsum("pi,pik->pk", flat, surface.frame[points.face][:, :2])

    return force


def _wrinkles(
    cells: Cells, surface: Surface, seed: int, names: FieldSet, points: SurfacePoints, regions: NDArray[np.int64],
    threads: int | None,
) -> NDArray:  # fmt: skip
    """Wrinkles: walks along the sides of cells that keep to the stress."""
    count = wrinkle_count(cells, surface.area_mm2, seed)
    as_material = {"width_mm": 0.0, "depth_mm": 0.0}
    none = curve_table(surface, CurvePieces.joined([]), **as_material)
    if count == 0:
        return none
    stress = names.direction(cells.stress) if cells.stress else DirectionField.smoothest(surface)
    end = sides_of(regions)
    end = end[(end < len(points)).all(axis=1)]
    first, second = (
        SurfacePoints.trusted(
            np.ascontiguousarray(points.face[end[:, k]]), np.ascontiguousarray(points.barycentric[end[:, k]])
        )
        for k in (0, 1)
    )
    pieces, length = shortest_path(surface, first, second, threads=threads)
    ahead, back = path_angles(pieces, len(end))
    leaving = np.stack([ahead - stress.at(first), back + np.pi - stress.at(second)], axis=1)
    found = walks(
        end, leaving, length, stream(seed, "cells", "wrinkles"), count=count, most_length=cells.wrinkle_length,
        most_rad=np.radians(cells.wrinkle_angle),
    )  # fmt: skip
    if not found:
        return none
    nodes = np.concatenate([np.array(path) for path in found])
    curve = np.repeat(np.arange(len(found)), [len(path) for path in found])
    along = SurfacePoints.trusted(
        np.ascontiguousarray(points.face[nodes]), np.ascontiguousarray(points.barycentric[nodes])
    )
    return curve_table(surface, polyline(surface, along, curve, threads=threads)[0], **as_material)


def wrinkle_count(cells: Cells, area_mm2: float, seed: int) -> int:
    """Tell how many wrinkles an area gets.

    Parameters
    ----------
    cells : Cells
        Number and density.
    area_mm2 : float
        Of the ground.
    seed : int
        Decides about fractions.

    Returns
    -------
    count : int
        0 or more.
    """
    draw = float(stream(seed, "cells", "wrinkle count").uniform(1)[0, 0])
    return cells.wrinkle_count + int(draw + cells.wrinkle_density * area_mm2 / 1000)


def no_wrinkles(cells: Cells, area_mm2: float, features: Mapping[str, NDArray]) -> tuple[str, ...]:
    """Warn where wrinkles were asked for and there are none.

    Parameters
    ----------
    cells : Cells
        Number and density.
    area_mm2 : float
        Of the ground.
    features : mapping of str to structured array
        What was placed.

    Returns
    -------
    warnings : tuple of str
        One, or none.
    """
    wanted = cells.wrinkle_count + cells.wrinkle_density * area_mm2 / 1000
    if wanted <= 0 or len(features.get("wrinkle", ())):
        return ()
    return (
        f"no wrinkle was placed: {wanted:.2g} were asked for (wrinkle_density is per 1000 mm^2, and there are "
        f"{area_mm2:,.0f} mm^2); raise wrinkle_density or wrinkle_count",
    )
