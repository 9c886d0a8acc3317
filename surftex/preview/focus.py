"""A first look: the same recipe on the piece of the surface around what is looked at, where it is done soon."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from surftex.errors import InputError
from surftex.fields.fieldset import FieldSet
from surftex.fields.sources import carried
from surftex.geodesics.directions import DirectionField
from surftex.recipe.model import Recipe
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.repair import repair
from surftex.surface.surface import Surface

_CELLS = 4000
"""About how many cells a first look has."""

_MANY = 200_000
"""Features that a first look may have however small it is, of all kinds together."""

_SHARE = 0.15
"""Of the surface, for learnt textures; materials with neither cells nor pixels are placed as a whole as soon."""

_RIM = 2.0
"""Width of the rim that is not shown, in cells: they lack neighbours."""


@dataclass(frozen=True, eq=False)
class Piece:
    """A piece of a surface.

    Attributes
    ----------
    whole : Surface
        m faces.
    surface : Surface
        The piece, k faces in the frame of the whole.
    face : (k,) int64
        Of the whole, for each of its own.
    shown : (m,) bool
        Faces of the whole that are far enough from the rim to be shown.
    """

    whole: Surface
    surface: Surface
    face: NDArray[np.int64]
    shown: NDArray[np.bool_]

    def samples(self, samples: Samples) -> Samples:
        """Carry samples of the whole over to the piece.

        Parameters
        ----------
        samples : Samples
            On faces of the piece.

        Returns
        -------
        samples : Samples
            The same places.
        """
        own = np.full(len(self.whole.faces), -1, np.int32)
        own[self.face] = np.arange(len(self.face))
        points = SurfacePoints.trusted(own[samples.points.face], samples.points.barycentric)
        return Samples(points, samples.footprint_mm)

    def most(self, max_features: int) -> int:
        """Say how many features the piece may have: its share by area, as faces may be far larger than cells.

        Parameters
        ----------
        max_features : int
            Of the whole.

        Returns
        -------
        most : int
            Of the piece.
        """
        share = self.surface.area_mm2 / self.whole.area_mm2
        return min(max_features, max(_MANY, round(share * max_features)))

    def fields(self, fields: FieldSet) -> FieldSet:
        """Carry the fields of the whole over to the piece.

        Parameters
        ----------
        fields : FieldSet
            Of the whole.

        Returns
        -------
        fields : FieldSet
            Of the same names.
        """

        def direction(name: str) -> DirectionField:
            found = fields.direction(name)
            count = len(self.face)
            middle = SurfacePoints.trusted(np.arange(count, dtype=np.int32), np.full((count, 3), 1 / 3))
            return DirectionField.from_strokes(
                self.surface, middle, found.angle_rad[self.face], found.symmetry
            )

        return FieldSet(
            self.surface,
            {name: carried(fields.scalar(name), self.face) for name in fields.names},
            {name: (lambda name=name: direction(name)) for name in fields.direction_names},
        )


def piece_around(recipe: Recipe, surface: Surface, place_mm: NDArray[np.float64]) -> Piece | None:
    """Cut out the piece that a first look shows.

    Parameters
    ----------
    recipe : Recipe
        What is to be seen; its cells decide how large the piece is.
    surface : Surface
        Where.
    place_mm : (3,) float
        What is looked at, in the frame of `Surface.vertices`.

    Returns
    -------
    piece : Piece or None
        None where the whole surface is done as soon.
    """
    sizes = [
        float(size)
        for layer in recipe.layer
        if isinstance(size := getattr(layer.material, "cell_size", None), (int, float))
    ]
    if not sizes and not any(hasattr(layer.material, "pixel_size") for layer in recipe.layer):
        return None
    area = _CELLS * min(sizes) ** 2 / 0.7 if sizes else _SHARE * surface.area_mm2
    if 2 * area > surface.area_mm2:
        return None
    middle = surface.vertices[surface.faces].mean(axis=1)
    start = int(((middle - place_mm) ** 2).sum(axis=1).argmin())
    here, side = np.nonzero(surface.neighbor >= 0)
    there = surface.neighbor[here, side]
    step = np.linalg.norm(middle[here] - middle[there], axis=1)
    graph = coo_matrix((step, (here, there)), shape=(len(middle),) * 2).tocsr()
    way = dijkstra(graph, indices=start)
    order = np.argsort(way, kind="stable")
    kept = order[: 1 + int(np.searchsorted(np.cumsum(surface.face_area_mm2[order]), area))]
    face = np.sort(kept[np.isfinite(way[kept])])
    piece = _cut(surface, face)
    if piece is None:
        return None
    shown = np.zeros(len(middle), bool)
    shown[face] = way[face] < way[face].max() - _RIM * (min(sizes) if sizes else 0.0)
    return Piece(surface, piece, face, shown)


def _cut(surface: Surface, face: NDArray[np.int64]) -> Surface | None:
    """Make a surface of some faces, in their order; None where that cannot be."""
    vertex, corner = np.unique(surface.faces[face], return_inverse=True)
    try:
        mended = repair(surface.vertices[vertex], corner.reshape(-1, 3))
        piece = Surface.from_arrays(
            mended.vertices, mended.faces, part=surface.part[face], part_names=surface.part_names,
            labels={kind: (index[face], names) for kind, (index, names) in surface.labels.items()},
            origin_mm=surface.origin_mm, mm_per_unit=surface.mm_per_unit, name=surface.name,
        )  # fmt: skip
    except InputError:
        return None
    same = np.array_equal(piece.vertices[piece.faces], surface.vertices[surface.faces[face]])
    return piece if same else None


def for_piece(recipe: Recipe, piece: Piece) -> Recipe:
    """Take from a recipe what a piece can hold of it.

    Parameters
    ----------
    recipe : Recipe
        Of the whole.
    piece : Piece
        Part of it.

    Returns
    -------
    recipe : Recipe
        With as many of each feature to the area, and without what was drawn; not to be saved.
    """
    share = piece.surface.area_mm2 / piece.whole.area_mm2
    layers = []
    for layer in recipe.layer:
        material = layer.material
        counts: dict[str, int | None] = {
            key: round(share * value)
            for key in type(material).model_fields
            if key.endswith("_count") and isinstance(value := getattr(material, key), int)
        }
        counts |= {key: None for key in type(material).model_fields if key.endswith(("_curves", "_points"))}
        layers.append(layer.model_copy(update={"material": material.model_copy(update=counts)}))
    return recipe.model_copy(update={"layer": tuple(layers)})
