"""`Bodies`: some of a surface's connected components as a surface of their own, with the same places and numbers."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.errors import SurfaceError
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.surface import Surface


@dataclass(frozen=True, eq=False)
class Bodies:
    """Components of a surface; make them with `Bodies.of`.

    Attributes
    ----------
    whole : Surface
        m faces.
    surface : Surface
        The bodies alone: k faces, in their order, where they lie in the whole.
    number : tuple of int
        Which components of the whole they are, ascending.
    face : (k,) int32
        Face of the whole that each own face is.
    vertex : (n,) int64
        Vertex of the whole that each own vertex is.
    own : (m,) int32
        Own face that each face of the whole is; -1 where it is none.
    """

    whole: Surface
    surface: Surface
    number: tuple[int, ...]
    face: NDArray[np.int32]
    vertex: NDArray[np.int64]
    own: NDArray[np.int32]

    @staticmethod
    def of(whole: Surface, kept: NDArray[np.bool_]) -> "Bodies":
        """Cut bodies out of a surface.

        Parameters
        ----------
        whole : Surface
            With c components.
        kept : (c,) bool
            Which of them; at least one.

        Returns
        -------
        bodies : Bodies
            With the frames, parts, UVs and attributes that their faces have in the whole.

        Raises
        ------
        SurfaceError
            If none is kept.
        """
        if not kept.any():
            raise SurfaceError("no body of the surface is kept; keep at least one")
        face = np.flatnonzero(kept[whole.component]).astype(np.int32)
        vertex, corner = np.unique(whole.faces[face], return_inverse=True)
        own = np.full(len(whole.faces), -1, np.int32)
        own[face] = np.arange(len(face))
        surface = Surface.from_arrays(
            whole.vertices[vertex], corner.reshape(-1, 3),
            corner_uv=None if whole.corner_uv is None else whole.corner_uv[face],
            corner_normal=None if whole.corner_normal is None else whole.corner_normal[face],
            part=whole.part[face], part_names=whole.part_names, origin_mm=whole.origin_mm, name=whole.name,
            sha256=whole.sha256, mm_per_unit=whole.mm_per_unit,
            attributes={name: values[face] for name, values in whole.attributes.items()},
            labels={kind: (index[face], names) for kind, (index, names) in whole.labels.items()},
            selected=whole.selected,
        )  # fmt: skip
        number = tuple(np.flatnonzero(kept).tolist())
        return Bodies(whole, surface, number, frozen(face), frozen(vertex.astype(np.int64)), frozen(own))

    def points_there(self, points: SurfacePoints) -> SurfacePoints:
        """Name places of the bodies as the whole does.

        Parameters
        ----------
        points : SurfacePoints
            On `surface`.

        Returns
        -------
        points : SurfacePoints
            The same places, on `whole`.
        """
        return SurfacePoints.trusted(self.face[points.face], points.barycentric)

    def points_here(self, points: SurfacePoints) -> SurfacePoints:
        """Pick the places on the bodies.

        Parameters
        ----------
        points : SurfacePoints
            On `whole`.

        Returns
        -------
        points : SurfacePoints
            Those on the bodies, in their order, on `surface`.
        """
        taken = points.taken(np.flatnonzero(self.own[points.face] >= 0))
        return SurfacePoints.trusted(self.own[taken.face], taken.barycentric)

    def samples_here(self, samples: Samples) -> tuple[Samples, NDArray[np.int64] | None]:
        """Pick the samples on the bodies.

        Parameters
        ----------
        samples : Samples
            n of them, on `whole`.

        Returns
        -------
        samples : Samples
            Those on the bodies, on `surface`.
        rows : (k,) int64 or None
            Which they are; None where all are.
        """
        own, rows = self.own[samples.points.face], None
        if (own < 0).any():
            rows = np.flatnonzero(own >= 0)
            samples, own = samples.taken(rows), own[rows]
        return Samples(SurfacePoints.trusted(own, samples.points.barycentric), samples.footprint_mm), rows

    def rows_there(self, features: Mapping[str, NDArray]) -> dict[str, NDArray]:
        """Name the faces of features as the whole does.

        Parameters
        ----------
        features : mapping of str to structured array
            By kind, each with a column ``face`` of `surface`.

        Returns
        -------
        features : dict of str to structured array
            The same rows, with faces of `whole`.
        """
        return {kind: _renamed(table, self.face) for kind, table in features.items()}

    def rows_here(self, features: Mapping[str, NDArray]) -> dict[str, NDArray]:
        """Name the faces of features as the bodies do.

        Parameters
        ----------
        features : mapping of str to structured array
            By kind, each with a column ``face`` of `whole`, on the bodies.

        Returns
        -------
        features : dict of str to structured array
            The same rows, with faces of `surface`.
        """
        return {kind: _renamed(table, self.own) for kind, table in features.items()}

    def curves_here(self, table: NDArray) -> NDArray:
        """Pick the curves on the bodies; none leads from one body to another.

        Parameters
        ----------
        table : (p,) structured array
            Pieces of curves: ``face`` of `whole` and ``curve``, among other columns.

        Returns
        -------
        table : (q,) structured array
            Those on the bodies, with faces of `surface`, numbered from 0.
        """
        here = _renamed(table[self.own[table["face"]] >= 0], self.own)
        here["curve"] = np.unique(here["curve"], return_inverse=True)[1]
        return here


def _renamed(table: NDArray, name: NDArray[np.int32]) -> NDArray:
    result = table.copy()
    result["face"] = name[table["face"]]
    return result
