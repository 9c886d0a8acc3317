"""`Polygons`: what a mesh file says, before anything is mended: corners of polygons, and labels for them."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from surftex.errors import MeshFileError
from surftex.words import by_count

MOST_FACES = 20_000_000
"""Files that unfold to more polygons or triangles are refused."""


@dataclass(eq=False)
class Polygons:
    """The geometry of a file.

    Attributes
    ----------
    vertices : (n, 3) float64
        In the file's unit; rows that no face uses may hold anything.
    start : (p+1,) int64
        Polygon i has the corners start[i]:start[i+1], at least three.
    corner : (c,) int64
        Vertex of each corner.
    uv_sets : list of (c, 2) float64
        Unwraps, v up; NaN where a corner has none.
    normals : (c, 3) float64 or None
        As the file has them; NaN where a corner has none.
    labels : dict of str to ((p,) int32, tuple of str)
        For "material", "group", "node" and the like: an index for each polygon, and the names.
    mm_per_unit : float or None
        Millimetres in a unit, where the format fixes it.
    warnings : list of str
        What the reader passed over.
    attributes : dict of str to (c,) or (c, k) float64
        Further numbers by name, at each corner; NaN where a corner has none.
    named_unit : str or None
        What comments say a unit is.
    """

    vertices: NDArray[np.float64]
    start: NDArray[np.int64]
    corner: NDArray[np.int64]
    uv_sets: list[NDArray[np.float64]] = field(default_factory=list)
    normals: NDArray[np.float64] | None = None
    labels: dict[str, tuple[NDArray[np.int32], tuple[str, ...]]] = field(default_factory=dict)
    mm_per_unit: float | None = None
    warnings: list[str] = field(default_factory=list)
    attributes: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    named_unit: str | None = None

    def selected(self, chosen: NDArray[np.bool_]) -> "Polygons":
        """Keep some of the polygons.

        Parameters
        ----------
        chosen : (p,) bool
            Which.

        Returns
        -------
        polygons : Polygons
            With the same vertices.
        """
        sizes = np.diff(self.start)
        corners = np.repeat(chosen, sizes)
        return Polygons(
            self.vertices,
            np.concatenate([[0], np.cumsum(sizes[chosen])]).astype(np.int64),
            self.corner[corners],
            [uv[corners] for uv in self.uv_sets],
            None if self.normals is None else self.normals[corners],
            {kind: (index[chosen], names) for kind, (index, names) in self.labels.items()},
            self.mm_per_unit,
            self.warnings,
            {name: values[corners] for name, values in self.attributes.items()},
        )


def starts_of(sizes: NDArray[np.integer]) -> NDArray[np.int64]:
    """Where each run begins, and where the last one ends.

    Parameters
    ----------
    sizes : (p,) int
        Length of each run.

    Returns
    -------
    start : (p+1,) int64
        Sums of the lengths before.
    """
    return np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)]).astype(np.int64)


def skipped_faces(count: int) -> str:
    """Say how many faces of a file are none.

    Parameters
    ----------
    count : int
        Of those with one corner or two.

    Returns
    -------
    warning : str
        For the surface's warnings.
    """
    return by_count(
        count, "{} face of fewer than 3 corners skipped", "{} faces of fewer than 3 corners skipped"
    )


def check_face_count(count: int, where: str) -> None:
    """Refuse files that unfold to more faces than a bake can hold.

    Parameters
    ----------
    count : int
        Faces.
    where : str
        File name for the message.

    Raises
    ------
    MeshFileError
        Beyond `MOST_FACES`.
    """
    if count > MOST_FACES:
        raise MeshFileError(
            f"{where}: unfolds to {count} faces, more than the {MOST_FACES} that surftex loads; "
            "decimate it first"
        )
