"""A net of furrows over a surface: cells in space, cut by the surface, longer along a direction of tension.

There is no site to be placed, so that millions of cells cost nothing but the samples that look at them. Cells are those of one
random point per cube; at the scale of a cell a surface is flat, and walking is straight.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen, read_only_view
from surftex.randomness import Stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_CUBE = 1.2
"""Side of a cube, in mean widths of the cells in a plane section: there are 1.46 of them to a cube's side squared."""


@dataclass(frozen=True, eq=False)
class FurrowNet:
    """A net on a surface; make it with `FurrowNet.over`.

    Attributes
    ----------
    surface : Surface
        n vertices.
    tension : (n, 6) float64
        Entries of t t^T at the vertices, see `surftex.kernels.furrows`.
    spacing_mm : float
        Mean width of a cell.
    stretch : float
        Length of cells over their width, at least 1.
    stream : Stream
        Of the sites.
    """

    surface: Surface
    tension: NDArray[np.float64]
    spacing_mm: float
    stretch: float
    stream: Stream

    @staticmethod
    def over(
        surface: Surface, angle_rad: NDArray[np.float64], spacing_mm: float, stretch: float, stream: Stream
    ) -> "FurrowNet":
        """Lay a net over a surface.

        Parameters
        ----------
        surface : Surface
            m faces.
        angle_rad : (m,) float64
            Direction of tension in the frame of each face; only its line matters.
        spacing_mm : float
            Mean width of a cell.
        stretch : float
            Length of cells over their width: 1 to 1.5 or so.
        stream : Stream
            Of the sites.

        Returns
        -------
        net : FurrowNet
            Ready to be asked.
        """
        along = (
            np.cos(angle_rad)[:, None] * surface.frame[:, 0]
            + np.sin(angle_rad)[:, None] * surface.frame[:, 1]
        )
        i, j = np.triu_indices(3)
        entries = (along[:, i] * along[:, j]) * surface.face_area_mm2[:, None]
        count = len(surface.vertices)
        total = np.stack(
            [np.bincount(surface.faces.ravel(), np.repeat(e, 3), count) for e in entries.T], axis=1
        )
        area = np.bincount(surface.faces.ravel(), np.repeat(surface.face_area_mm2, 3), count)
        return FurrowNet(
            surface, frozen(total / np.maximum(area, 1e-300)[:, None]), spacing_mm, stretch, stream
        )

    def at(
        self, points: SurfacePoints, position: NDArray[np.float64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """Locate points in the net.

        Parameters
        ----------
        points : SurfacePoints
            n points.
        position : (n, 3) float64
            Their places in space.

        Returns
        -------
        border_mm : (n, 2) float32
            To the borders with the two nearest neighbours.
        along : (n, 2) float32
            How well those lie along the tension, 0 to 1.
        inner_mm : (n,) float32
            To the border between these two neighbours: it parts the cell into fields.
        """
        from surftex.kernels.barycentric import interpolate
        from surftex.kernels.furrows import furrow_net

        count = len(points)
        face, weight = read_only_view(points.face, np.int32), read_only_view(points.barycentric, np.float64)
        normal, tension = np.zeros((count, 3)), np.zeros((count, 6))
        interpolate(face, weight, self.surface.faces, self.surface.vertex_normal, normal)
        interpolate(face, weight, self.surface.faces, self.tension, tension)
        length = np.sqrt(np.einsum("pi,pi->p", normal, normal))
        normal /= np.maximum(length, 1e-12)[:, None]
        border, along = np.zeros((count, 2), np.float32), np.zeros((count, 2), np.float32)
        inner = np.zeros(count, np.float32)
        furrow_net(
            0, count, read_only_view(position, np.float64), frozen(normal), frozen(tension),
            self.spacing_mm * _CUBE, 1 - 1 / self.stretch**2, np.uint64(self.stream.key),
            border, along, inner,
        )  # fmt: skip
        return border, along, inner
