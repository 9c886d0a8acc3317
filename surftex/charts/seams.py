"""Seams, measured: how much a map jumps where two charts meet, per map and mip.

The yardstick is what bilinear lookup gets wrong inside the charts anyway.
Every seam edge is sampled twice per texel; both its sides are looked up bilinearly, as a renderer does.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import read_only_view
from surftex.charts.atlas import Atlas, tile_origin
from surftex.charts.lookup import bilinear, bilinear_tiles, half
from surftex.charts.texels import Texels
from surftex.paged import blocks, let_go
from surftex.randomness import stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

Decode = Callable[[NDArray[np.float64], SurfacePoints], NDArray[np.float64]]
"""Turns looked-up values, and the places on the side of the seam they were looked up for, into what is compared."""

HARD_DEGREES = 1.0
"""Angle between the shading normals of two sides from which on an edge counts as hard."""


@dataclass(frozen=True, eq=False)
class SeamSamples:
    """Places along the seams, each seen from both sides.

    Attributes
    ----------
    here, there : SurfacePoints
        The same s places, on the faces of either side.
    here_uv, there_uv : (s, 2) float64
        Where the two sides lie, each on its page.
    length_mm : (s,) float64
        Piece of seam that a sample stands for.
    hard : (s,) bool
        Whether the mesh's own shading normals part there by more than `HARD_DEGREES`.
    here_tile, there_tile : (s,) int64
        UDIM numbers of their pages.
    """

    here: SurfacePoints
    there: SurfacePoints
    here_uv: NDArray[np.float64]
    there_uv: NDArray[np.float64]
    length_mm: NDArray[np.float64]
    hard: NDArray[np.bool_]
    here_tile: NDArray[np.int64]
    there_tile: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.here)

    def soft(self) -> "SeamSamples":
        """Leave out hard edges, where normals jump because the mesh does.

        Returns
        -------
        samples : SeamSamples
            The others.
        """
        if not self.hard.any():
            return self
        kept = ~self.hard
        here, there = (
            SurfacePoints.trusted(side.face[kept], side.barycentric[kept]) for side in (self.here, self.there)
        )
        return SeamSamples(
            here, there, self.here_uv[kept], self.there_uv[kept], self.length_mm[kept], self.hard[kept],
            self.here_tile[kept], self.there_tile[kept],
        )  # fmt: skip


@dataclass(frozen=True)
class Jump:
    """How much a map jumps across the seams at one mip: root mean square, 99th percentile and maximum."""

    rms: float
    p99: float
    max: float

    @staticmethod
    def of(difference: NDArray[np.float64]) -> "Jump":
        """Sum up differences.

        Parameters
        ----------
        difference : (s,) float64
            One per sample, at least 0.

        Returns
        -------
        jump : Jump
            Zero where there are no seams.
        """
        if len(difference) == 0:
            return Jump(0.0, 0.0, 0.0)
        return Jump(
            float(np.sqrt((difference**2).mean())),
            float(np.percentile(difference, 99)),
            float(difference.max()),
        )

    def as_dict(self) -> dict[str, float]:
        """Give plain numbers for a report.

        Returns
        -------
        numbers : dict
            ``rms``, ``p99``, ``max``.
        """
        return {"rms": self.rms, "p99": self.p99, "max": self.max}


def seam_samples(surface: Surface, atlas: Atlas, resolution: int, *, per_texel: float = 2.0) -> SeamSamples:
    """Place samples along the seams.

    Parameters
    ----------
    surface : Surface
        What is unwrapped.
    atlas : Atlas
        Its unwrap.
    resolution : int
        Side of the page in texels.
    per_texel : float
        Samples per texel of seam length on the page; at least two per edge.

    Returns
    -------
    samples : SeamSamples
        Borders of the mesh have none.
    """
    face, edge = np.nonzero(atlas.seam & (surface.neighbor >= 0))
    other, other_edge = surface.neighbor[face, edge], surface.neighbor_edge[face, edge]
    once = face < other
    face, edge, other, other_edge = face[once], edge[once], other[once], other_edge[once]
    ends = atlas.corner_uv[face, edge] - atlas.corner_uv[face, (edge + 1) % 3]
    back = atlas.corner_uv[other, other_edge] - atlas.corner_uv[other, (other_edge + 1) % 3]
    texels = np.maximum(np.linalg.norm(ends, axis=1), np.linalg.norm(back, axis=1)) * resolution
    count = np.maximum(2, np.ceil(per_texel * texels)).astype(np.int64)
    index = np.repeat(np.arange(len(face)), count)
    step = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    along = (step + 0.5) / count[index]

    def side(faces: NDArray, edges: NDArray, share: NDArray) -> tuple[SurfacePoints, NDArray[np.float64]]:
        weight = np.zeros((len(share), 3))
        row = np.arange(len(share))
        weight[row, edges] = 1 - share
        weight[row, (edges + 1) % 3] = share
        points = SurfacePoints.trusted(faces.astype(np.int32), weight)
        return points, _of_corners(points, atlas.corner_uv) - tile_origin(atlas.tile[faces])

    here, here_uv = side(face[index], edge[index], along)
    there, there_uv = side(other[index], other_edge[index], 1 - along)
    normal = [_of_corners(points, surface.shading_normal) for points in (here, there)]
    length = np.linalg.norm(normal, axis=2).prod(axis=0)
    hard = (normal[0] * normal[1]).sum(axis=1) < np.cos(np.radians(HARD_DEGREES)) * length
    length_mm = surface.edge_length[face, edge][index] / count[index]
    tile = atlas.tile
    return SeamSamples(here, there, here_uv, there_uv, length_mm, hard, tile[here.face], tile[there.face])


def _of_corners(points: SurfacePoints, value: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weigh what the corners of faces have, (m, 3, d), at points in them: (n, d)."""
    from surftex.kernels.barycentric import interpolate

    result = np.zeros((len(points), value.shape[2]))
    face, weight = read_only_view(points.face, np.int32), read_only_view(points.barycentric, np.float64)
    corner = read_only_view(np.arange(3 * len(value)).reshape(-1, 3), np.int32)
    interpolate(face, weight, corner, read_only_view(value, np.float64).reshape(len(value) * 3, -1), result)
    return result


def seam_jumps(
    samples: SeamSamples,
    image: NDArray[Any] | Mapping[int, NDArray[Any]],
    *,
    mips: int = 3,
    decode: Decode | None = None,
) -> list[Jump]:
    """Measure one map's jumps.

    Parameters
    ----------
    samples : SeamSamples
        Places along the seams.
    image : (height, width) or (height, width, c) array, or mapping of int to such arrays
        The map; whole numbers count as shares of their type's greatest. Several pages come by their UDIM numbers.
    mips : int
        Levels, each half as large; fewer where a side is odd.
    decode : callable, optional
        ``decode(values, points)`` turns the values of one side into what is compared: tangent-space normals
        into object-space vectors, for instance.

    Returns
    -------
    jumps : list of Jump
        One per mip; differences of c channels count by their Euclidean length.
    """
    pages = dict(image) if isinstance(image, Mapping) else {1001: image}
    jumps = []
    for tile, page in pages.items():
        if page.dtype.kind in "iu":
            pages[tile] = page.astype(np.float32) / np.iinfo(page.dtype).max
    for level in range(mips):
        if any(side % 2**level for page in pages.values() for side in page.shape[:2]):
            break
        here = bilinear_tiles(pages, samples.here_uv, samples.here_tile, level)
        there = bilinear_tiles(pages, samples.there_uv, samples.there_tile, level)
        for page in pages.values():
            let_go(page)
        if decode is not None:
            here, there = decode(here, samples.here), decode(there, samples.there)
        difference = here - there
        jumps.append(
            Jump.of(np.abs(difference) if difference.ndim == 1 else np.linalg.norm(difference, axis=1))
        )
    return jumps


def seam_report(
    surface: Surface,
    atlas: Atlas,
    images: Mapping[str, NDArray[Any] | Mapping[int, NDArray[Any]]],
    *,
    mips: int = 3,
    decode: Mapping[str, Decode] | None = None,
) -> dict[str, Any]:
    """Report the jumps of maps for ``report.json``.

    Parameters
    ----------
    surface : Surface
        What was baked.
    atlas : Atlas
        Its unwrap.
    images : mapping of str to (height, width) or (height, width, c) array, or to a mapping of int to such arrays
        Maps without holes, square, of one size or several; of several pages by their UDIM numbers. Ids and labels do
        not belong here.
    mips : int
        Levels to measure.
    decode : mapping of str to callable, optional
        For maps whose values are compared as directions in space, as in `seam_jumps`; on hard edges of the mesh
        they are not compared.

    Returns
    -------
    report : dict
        ``length_mm``, ``samples``, ``hard_share`` (of them, on hard edges), ``maps``: per name ``rms``,
        ``p99``, ``max`` of mip 0 and a list ``mips``, all in the map's own unit; ``max``, ``rms``: the worst
        map's, as shares of its range of values.
    """
    report: dict[str, Any] = {
        "length_mm": atlas.seam_length_mm(surface),
        "samples": 0,
        "hard_share": 0.0,
        "max": 0.0,
        "rms": 0.0,
        "maps": {},
    }
    placed: dict[int, SeamSamples] = {}
    for name, image in images.items():
        pages = image if isinstance(image, Mapping) else {1001: image}
        one = next(iter(pages.values()))
        side = one.shape[0]
        if side not in placed:
            placed[side] = seam_samples(surface, atlas, side)
        samples = placed[side]
        told = (decode or {}).get(name)
        jumps = seam_jumps(samples.soft() if told else samples, pages, mips=mips, decode=told)
        report["maps"][name] = {**jumps[0].as_dict(), "mips": [jump.as_dict() for jump in jumps]}
        if len(samples) > report["samples"]:
            report["samples"], report["hard_share"] = len(samples), float(samples.hard.mean())
        full = np.iinfo(one.dtype).max if one.dtype.kind in "iu" else 1.0
        ends = np.array(
            [(page[rows].min(), page[rows].max()) for page in pages.values() for rows in blocks(page)],
            np.float64,
        )
        spread = (ends[:, 1].max() - ends[:, 0].min()) / full
        if spread > 0:
            report["max"] = max(report["max"], jumps[0].max / spread)
            report["rms"] = max(report["rms"], jumps[0].rms / spread)
    return report


def probe(surface: Surface, points: SurfacePoints, wavelength_mm: float) -> NDArray[np.float64]:
    """Evaluate a test pattern: three plane waves in space, with values around 0.5 and a range of 1.

    Parameters
    ----------
    surface : Surface
        Where the points lie.
    points : SurfacePoints
        n places.
    wavelength_mm : float
        Of each wave.

    Returns
    -------
    value : (n,) float64
        Continuous over the surface.
    """
    direction = np.array([[0.8, 0.36, 0.48], [-0.48, 0.8, 0.36], [0.36, -0.48, 0.8]])
    phase = points.positions(surface) @ direction.T * (2 * np.pi / wavelength_mm)
    return 0.5 + np.sin(phase).sum(axis=1) / 6


def probe_seams(
    surface: Surface, atlas: Atlas, texels: Texels, *, mips: int = 3, waves_texels: float = 24.0
) -> list[dict[str, float]]:
    """Measure what the gutter is worth: jumps of a test pattern, and what bilinear lookup gets wrong inside charts.

    Parameters
    ----------
    surface : Surface
        What is baked.
    atlas : Atlas
        Its unwrap.
    texels : Texels
        The whole page.
    mips : int
        Levels; the pattern for level k has waves of `waves_texels` 2^k texels.
    waves_texels : float
        Wavelength at level 0.

    Returns
    -------
    levels : list of dict
        Per mip ``rms``, ``p99``, ``max`` of the jump, ``interior`` (rms of the bilinear error at points
        inside charts) and ``ratio`` (rms over interior).
    """
    from scipy.ndimage import binary_erosion

    samples = seam_samples(surface, atlas, texels.width)
    texel_mm = 1 / atlas.texels_per_mm(surface, texels.width)
    core = np.zeros(texels.width * texels.height, bool)
    core[texels.texel[texels.core]] = True
    inside = np.asarray(binary_erosion(core.reshape(texels.height, texels.width), iterations=3), bool)
    points = _spread(surface, 100_000)
    uv = np.einsum("pk,pkc->pc", points.barycentric, atlas.corner_uv[points.face])
    column = np.clip((uv[:, 0] * texels.width).astype(np.int64), 0, texels.width - 1)
    row = np.clip(((1 - uv[:, 1]) * texels.height).astype(np.int64), 0, texels.height - 1)
    levels = []
    for level in range(mips):
        if level:
            if inside.shape[0] % 2 or inside.shape[1] % 2:
                break
            inside = inside[::2, ::2] & inside[1::2, ::2] & inside[::2, 1::2] & inside[1::2, 1::2]
        wave_mm = waves_texels * texel_mm * 2**level
        image = texels.image(probe(surface, texels.points, wave_mm))
        for _ in range(level):
            image = half(image)
        jump = seam_jumps(samples, image, mips=1)[0]
        kept = np.flatnonzero(inside[row >> level, column >> level])
        chosen = SurfacePoints.trusted(points.face[kept], points.barycentric[kept])
        wrong = bilinear(image, uv[kept]) - probe(surface, chosen, wave_mm)
        interior = float(np.sqrt((wrong**2).mean())) if len(kept) else 0.0
        ratio = jump.rms / interior if interior > 0 else 0.0
        levels.append({**jump.as_dict(), "interior": interior, "ratio": ratio})
    return levels


def _spread(surface: Surface, count: int) -> SurfacePoints:
    """Spread points evenly over the area."""
    draw = stream(0, "charts", "interior").uniform(count, 3)
    cumulative = np.cumsum(surface.face_area_mm2)
    face = np.minimum(np.searchsorted(cumulative, draw[:, 0] * cumulative[-1]), len(cumulative) - 1).astype(
        np.int32
    )
    root = np.sqrt(draw[:, 1])
    weight = np.stack([1 - root, root * (1 - draw[:, 2]), root * draw[:, 2]], axis=1)
    return SurfacePoints.trusted(face, weight)
