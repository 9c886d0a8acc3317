"""Placing a leather: cells, then what hangs on their Voronoi graph, then pores and crowns, a stream for each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from surftex.errors import naming
from surftex.features.curves import with_drawn
from surftex.features.poisson import Sites, expected_sites, poisson_disk
from surftex.features.relax import relaxed
from surftex.features.uniform import scatter
from surftex.fields.fieldset import FieldSet
from surftex.fields.noise import Noise
from surftex.fields.sized import sized
from surftex.fields.sources import SpannedField
from surftex.geodesics.directions import DirectionField
from surftex.geodesics.records import Records
from surftex.geodesics.tracing import trace
from surftex.kernels.pool import Tick
from surftex.materials.leather.cells import flood_cells, shape_length
from surftex.materials.leather.model import Leather
from surftex.materials.limits import Expected, refuse_more
from surftex.randomness import stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

PORE_PER_MM2 = 400.0
"""Highest density of pores that an expression may reach."""

POCKETS_PER_CELL, CRACKS_PER_CELL = 2.0, 6.0
"""Corners of a Voronoi graph, and ends of its edges, for each cell: three edges meet at a corner."""

_PATCH, _SPREAD = 4.0, 1.8
"""Wavelength of the sizes in cells, and what makes noise reach -1 and 1 now and then."""

_DISKS_PER_MM2 = 0.70
"""Sites of a full surface, for a least distance of 1 mm."""


def place(
    leather: Leather,
    surface: Surface,
    seed: int,
    *,
    fields: FieldSet | None,
    max_features: int,
    threads: int | None,
    tick: Tick | None,
) -> tuple[dict[str, NDArray], Records | None]:
    """Place every element.

    Parameters
    ----------
    leather : Leather
        What to place.
    surface : Surface
        Where.
    seed : int
        Of all streams.
    fields : FieldSet, optional
        Named numbers and directions.
    max_features : int
        Refuse beyond it.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    features : dict of str to structured array
        By kind; each row has `face` and `barycentric`.
    records : Records or None
        From `flood_cells`, where placing has asked for it.

    Raises
    ------
    RecipeError
        If about more than `max_features` would be placed; told before any is.
    """
    names = fields or FieldSet(surface)
    told = tick or (lambda share: None)
    refuse_more("leather", expected_features(leather, surface, seed, names), surface.area_mm2, max_features)
    direction = _direction(leather, surface, names)
    sites = poisson_disk(
        surface, _size(leather, surface, seed, names), stream(seed, "leather", "cells"),
        ratio=_ratio(leather, names), direction=direction, max_sites=max_features,
        threads=threads, tick=lambda share: told((0.1 if leather.regularity else 0.5) * share),
    )  # fmt: skip
    if leather.regularity:
        sites = relaxed(
            surface, sites, stream(seed, "leather", "evening out"), rounds=leather.regularity, threads=threads,
            length=None if leather.cell_shape == "round" else shape_length(leather.cell_shape, sites),
            tick=lambda share: told(0.1 + 0.5 * share),
        )  # fmt: skip
    features, records = {"cell": sites.features}, None
    count, cracked = _wrinkle_count(leather, surface, seed), leather.invasion != 0
    if len(sites) and (count or cracked or leather.pocket_depth > 0):
        records = flood_cells(leather, surface, features["cell"], threads)
        told(0.7)
        features |= _on_the_graph(leather, surface, seed, names, sites, records, direction, threads)
    told(0.9)
    pores = _pores(leather, surface, seed, names, threads)
    if leather.wrinkle_curves is not None:
        with naming("leather.wrinkle_curves"):
            curves = names.curves(leather.wrinkle_curves)
        features["wrinkle"] = with_drawn(features.get("wrinkle", curves[:0]), curves)
    if len(pores):
        features["pore"] = point_table(pores)
    if leather.crown_spacing > 0:
        crowns = poisson_disk(
            surface,
            leather.crown_spacing,
            stream(seed, "leather", "crowns"),
            max_sites=max_features,
            threads=threads,
        )
        features["crown"] = point_table(crowns.points)
    told(1.0)
    return features, records


def expected_features(leather: Leather, surface: Surface, seed: int, names: FieldSet) -> tuple[Expected, ...]:
    """Tell about how many features would be placed.

    Parameters
    ----------
    leather : Leather
        What would be placed.
    surface : Surface
        Where.
    seed : int
        Of all streams.
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
    ratio = _ratio(leather, names)
    cells = expected_sites(surface, _size(leather, surface, seed, names), ratio)
    pockets = POCKETS_PER_CELL * cells if leather.pocket_depth > 0 else 0.0
    cracks = CRACKS_PER_CELL * cells * _cracked_share(leather, surface, names)
    crowns = expected_sites(surface, leather.crown_spacing, 1.0) if leather.crown_spacing > 0 else 0.0
    by_area = int(_wrinkle_count(leather, surface, seed) - leather.wrinkle_count)
    drawn = 0
    if leather.wrinkle_curves is not None:
        with naming("leather.wrinkle_curves"):
            drawn = len(np.unique(names.curves(leather.wrinkle_curves)["curve"]))
    return (
        Expected("cell", cells, "cell_size", leather.cell_size, -2, effort=_overlap(surface, ratio)),
        Expected("pocket", pockets, "cell_size", leather.cell_size, -2),
        Expected("crack", cracks, "cell_size", leather.cell_size, -2),
        Expected("wrinkle", leather.wrinkle_count, "wrinkle_count", leather.wrinkle_count),
        Expected("wrinkle", by_area, "wrinkle_density", leather.wrinkle_density),
        Expected("wrinkle", drawn, "wrinkle_curves", leather.wrinkle_curves or ""),
        Expected("pore", _expected_pores(leather, surface, names), "pore_density", leather.pore_density),
        Expected("crown", crowns, "crown_spacing", leather.crown_spacing, -2),
    )


def point_table(points: SurfacePoints) -> NDArray:
    """Rows of features that are nothing but points.

    Parameters
    ----------
    points : SurfacePoints
        n points.

    Returns
    -------
    table : (n,) structured array
        `face`, `barycentric`.
    """
    table = np.zeros(len(points), [("face", "i4"), ("barycentric", "f8", 3)])
    table["face"], table["barycentric"] = points.face, points.barycentric
    return table


def _ratio(leather: Leather, names: FieldSet) -> float | Callable[[SurfacePoints], NDArray]:
    return sized(names, leather.cell_ratio, "leather.cell_ratio", least=1.0)


def _size(
    leather: Leather, surface: Surface, seed: int, names: FieldSet
) -> float | Callable[[SurfacePoints], NDArray]:
    """Size of the cells; where it varies, patches of larger and of smaller ones lie beside one another."""
    size = sized(names, leather.cell_size, "leather.cell_size")
    if leather.size_variation == 0:
        return size
    measured = size if callable(size) else names.scalar(size)
    typical = float(np.median(measured(scatter(surface, stream(seed, "leather", "typical size"), count=256))))
    noise = Noise(stream(seed, "leather", "size"), max(_PATCH * typical, 1e-9), 2)

    def varied(points: SurfacePoints) -> NDArray:
        drift = np.clip(_SPREAD * noise.at(points.positions(surface)), -1, 1)
        return measured(points) * (1 + leather.size_variation * drift)

    return varied


def _direction(leather: Leather, surface: Surface, names: FieldSet) -> DirectionField | None:
    """Direction of the cells; None where none is needed."""
    if leather.direction is not None:
        return names.direction(leather.direction)
    if leather.cell_ratio == 1.0 and leather.cell_shape == "round" and leather.scale_overlap == 0:
        return None
    return DirectionField.smoothest(surface)


def _wrinkle_count(leather: Leather, surface: Surface, seed: int) -> int:
    """Tell how many wrinkles a surface gets; what its density leaves of a whole one is drawn."""
    share = float(stream(seed, "leather", "wrinkle count").uniform(1)[0, 0])
    return leather.wrinkle_count + int(share + leather.wrinkle_density * surface.area_mm2 / 1000)


def _on_the_graph(
    leather: Leather, surface: Surface, seed: int, names: FieldSet, sites: Sites, records: Records,
    direction: DirectionField | None, threads: int | None,
) -> dict[str, NDArray]:  # fmt: skip
    """Cracks, wrinkles and pockets: what hangs on the Voronoi graph of the cells."""
    count, cracked = _wrinkle_count(leather, surface, seed), leather.invasion != 0
    from surftex.features.voronoi_graph import VoronoiGraph
    from surftex.materials.leather.cracks import cracks
    from surftex.materials.leather.wrinkles import wrinkles

    graph = VoronoiGraph.of(surface, sites, records=records, threads=threads)
    features = {}
    if count or cracked:
        stress = (
            names.direction(leather.stress)
            if leather.stress
            else direction or DirectionField.smoothest(surface)
        )
        if cracked:
            amount = names.scalar(leather.invasion)
            relative = leather.invasion_mode == "relative"
            features["crack"] = cracks(surface, graph, stress, amount, relative=relative, threads=threads)
        if count:
            features["wrinkle"] = wrinkles(
                surface, graph, records, stress, stream(seed, "leather", "wrinkles"), count=count,
                length_mm=leather.wrinkle_length, angle_rad=np.radians(leather.wrinkle_angle),
                reach_mm=3 * float(sites.axis_mm[:, 0].max()),
            )  # fmt: skip
    if leather.pocket_depth > 0 and len(graph.vertices):
        features["pocket"] = point_table(graph.vertices)
    return {kind: table for kind, table in features.items() if len(table)}


def _cracked_share(leather: Leather, surface: Surface, names: FieldSet) -> float:
    """Tell on which share of the area furrows crack on, from the middles of the faces."""
    if not isinstance(leather.invasion, str):
        return float(leather.invasion != 0)
    with naming("leather.invasion"):
        cracked = names.scalar(leather.invasion)(_middles(surface)) > 0
    return float(surface.face_area_mm2[cracked].sum() / surface.area_mm2)


def _overlap(surface: Surface, ratio: float | Callable[[SurfacePoints], NDArray]) -> float:
    """Tell in how many exclusive regions, drawn round their long axis, a place lies, against one where they are round."""
    if not callable(ratio):
        return float(ratio) ** 2
    return float(np.average(ratio(_middles(surface)) ** 2, weights=surface.face_area_mm2))


def _middles(surface: Surface) -> SurfacePoints:
    count = len(surface.faces)
    return SurfacePoints.trusted(np.arange(count, dtype=np.int32), np.full((count, 3), 1 / 3))


def _expected_pores(leather: Leather, surface: Surface, names: FieldSet) -> float:
    """Pores to be expected, from what an expression cannot exceed on each face."""
    if not isinstance(leather.pore_density, str):
        return leather.pore_density * surface.area_mm2
    most = _pore_field(names, leather.pore_density, 1).span()[1]
    return float((np.maximum(most, 0) * surface.face_area_mm2).sum())


def _pore_field(names: FieldSet, density: str, group: int) -> SpannedField:
    """Make the field of groups of pores per mm^2."""
    return names.scalar(f"clamp({density}, 0, {PORE_PER_MM2}) / {group}")


def _pores(
    leather: Leather, surface: Surface, seed: int, names: FieldSet, threads: int | None
) -> SurfacePoints:
    """Pores, alone or in groups, by area; a mask thins them and moves none."""
    random = stream(seed, "leather", "pores")
    group, density = leather.pore_group, leather.pore_density
    field = _pore_field(names, density, group) if isinstance(density, str) else None
    groups: float | SpannedField = float(density) / group if field is None else field
    if group == 1:
        return scatter(surface, random, density_per_mm2=groups)
    most = float(density) / group if field is None else max(float(np.max(field.span()[1])), 0.0)
    if most <= 0:
        return SurfacePoints.trusted(np.zeros(0, np.int32), np.zeros((0, 3)))
    apart = float(np.sqrt(_DISKS_PER_MM2 / most))
    middle = poisson_disk(surface, apart, random, threads=threads).points
    if field is not None:
        kept = stream(seed, "leather", "pore share").uniform(len(middle))[:, 0] < field(middle) / most
        middle = SurfacePoints.trusted(middle.face[kept], middle.barycentric[kept])
    numbers = stream(seed, "leather", "pore groups").uniform(len(middle), 2)
    heading = (numbers[:, :1] + np.arange(group) / group) * 2 * np.pi
    away = leather.pore_spread * (0.8 + 0.4 * numbers[:, 1:]) * np.ones(group)
    centre = SurfacePoints.trusted(
        np.repeat(middle.face, group), np.repeat(middle.barycentric, group, axis=0)
    )
    return trace(surface, centre, heading.ravel(), away.ravel(), threads=threads).end
