"""BRDFs by counting: bins of equal projected solid angle, what a bin holds, and the lobe of the bare surface.

A bin is a step in sin^2 of the incident zenith angle, of the outgoing one, and in the azimuth between the
outgoing direction and the one back to the light, 0 to pi (left and right of the light are alike). All bins
weigh the same, so a plain sum of squares over bins is the error integral with its cosines.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.kernels.pool import slices
from surftex.optics.border import facet_tables
from surftex.optics.paths import Paths
from surftex.optics.tissue import Tissue
from surftex.randomness import stream

_SLICE_BINS, _SLICE_PATHS, _SLICE_RAYS = 40, 4096, 65536


@dataclass(frozen=True)
class Bins:
    """How directions are binned.

    Attributes
    ----------
    zenith, azimuth : int
        Steps of the two zenith angles, and of the azimuth.
    """

    zenith: int = 10
    azimuth: int = 12

    @property
    def count(self) -> int:
        """Bins in all."""
        return self.zenith**2 * self.azimuth

    @property
    def solid_angle(self) -> float:
        """Projected solid angle of the outgoing side of a bin; those of an incident step add up to pi."""
        return np.pi / (self.zenith * self.azimuth)

    def incident(self, cosine: NDArray[np.float64]) -> NDArray[np.int64]:
        """Step of an angle of incidence, or of an outgoing one.

        Parameters
        ----------
        cosine : (n,) float64
            Of the zenith angle.

        Returns
        -------
        step : (n,) int64
            0 along the normal.
        """
        return np.minimum(((1 - cosine**2) * self.zenith).astype(np.int64), self.zenith - 1)

    def of(self, cosine: NDArray[np.float64], leaving: NDArray[np.float64]) -> NDArray[np.int64]:
        """Bin of some rays.

        Parameters
        ----------
        cosine : (n,) float64
            Of incidence, travelling along +x.
        leaving : (n, 3) float64
            Direction out.

        Returns
        -------
        bin : (n,) int64
            Incident step first, then the outgoing one, then the azimuth.
        """
        turn = np.abs(np.arctan2(leaving[:, 1], -leaving[:, 0])) / np.pi
        azimuth = np.minimum((turn * self.azimuth).astype(np.int64), self.azimuth - 1)
        return (self.incident(cosine) * self.zenith + self.incident(leaving[:, 2])) * self.azimuth + azimuth

    def facing(self, power: float) -> NDArray[np.float64]:
        """Weigh bins by how much they face the light and the eye.

        Parameters
        ----------
        power : float
            Of both cosines.

        Returns
        -------
        weight : (bins,) float64
            1 along the normal; all ones for a power of 0.
        """
        cosine = np.sqrt(1 - (np.arange(self.zenith) + 0.5) / self.zenith) ** power
        return np.repeat(np.outer(cosine, cosine).ravel(), self.azimuth)

    def symmetric(self, brdf: NDArray) -> NDArray:
        """Make a BRDF reciprocal: the mean of itself and of itself with in and out exchanged.

        Parameters
        ----------
        brdf : (..., bins)
            As sampled.

        Returns
        -------
        brdf : (..., bins)
            Of the same albedo.
        """
        cube = brdf.reshape(*brdf.shape[:-1], self.zenith, self.zenith, self.azimuth)
        return ((cube + cube.swapaxes(-3, -2)) / 2).reshape(brdf.shape)

    def albedo(self, brdf: NDArray) -> NDArray:
        """Share of even light from all sides that a BRDF returns.

        Parameters
        ----------
        brdf : (..., bins)
            In 1/sr.

        Returns
        -------
        albedo : (...)
            0 to 1.
        """
        return brdf.sum(-1) * self.solid_angle / self.zenith


def surface_lobe(
    tissue: Tissue, bins: Bins, *, rays: int = 2_000_000, seed: int = 0, threads: int | None = None
) -> NDArray[np.float64]:
    """Sample what the bare surface reflects, all orders of reflection between its folds.

    Parameters
    ----------
    tissue : Tissue
        Index of its uppermost layer, and its folds.
    bins : Bins
        Where to count.
    rays : int
        Evenly spread over the incident hemisphere.
    seed : int
        Of the walk.
    threads : int, optional
        None means every core.

    Returns
    -------
    brdf : (bins,) float64
        1/sr, made reciprocal.
    """
    from surftex.kernels.photons import reflect_border

    steepness, escape = facet_tables(tissue)
    key = np.uint64(stream(seed, "optics", "surface").key)
    cosine = np.sqrt(1 - (np.arange(rays) + 0.5) / rays)

    def work(first: int, last: int) -> NDArray[np.int64]:
        kind, leaving = np.zeros(last - first, np.int8), np.zeros((last - first, 3))
        reflect_border(
            key, first, cosine[first:last], tissue.index[0], tissue.fold, steepness, escape, kind, leaving
        )
        out = kind == 0
        return np.bincount(bins.of(cosine[first:last][out], leaving[out]), minlength=bins.count)

    counts = np.sum(slices(work, rays, size=_SLICE_RAYS, threads=threads), axis=0)
    return bins.symmetric(counts * bins.zenith / (rays * bins.solid_angle))


def sorted_into(
    weight: NDArray[np.float64], bin_of: NDArray[np.int64], count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Sort paths into bins; those of weight 0 are left out.

    Parameters
    ----------
    weight : (n,) float64
        Of each path.
    bin_of : (n,) int64
        Bin of each path.
    count : int
        Bins in all.

    Returns
    -------
    order : (k,) int64
        Paths, bin by bin.
    start : (count + 1,) int64
        Bin b owns ``order[start[b]:start[b + 1]]``.
    """
    used = np.flatnonzero(weight)
    short = np.uint16 if count <= 2**16 else np.int64  # sorted by its digits
    place = bin_of[used].astype(short)
    start = np.concatenate([[0], np.cumsum(np.bincount(place, minlength=count))])
    return used[np.argsort(place, kind="stable")], start


@dataclass(frozen=True, eq=False)
class Absorbers:
    """Combinations of absorbers: each of `corneum` with each of `epidermis` with each of the dermis.

    Attributes
    ----------
    corneum : (s,) float64
        Depth of absorption per unit of a path's length in the stratum corneum.
    epidermis : (e,) float64
        The same for the epidermis.
    papillary, reticular : (d,) float64
        The same for the dermis; they go in pairs.
    """

    corneum: NDArray[np.float64]
    epidermis: NDArray[np.float64]
    papillary: NDArray[np.float64]
    reticular: NDArray[np.float64]

    @property
    def shape(self) -> tuple[int, int, int]:
        """Epidermis, stratum corneum, dermis."""
        return len(self.epidermis), len(self.corneum), len(self.papillary)

    def sums(
        self,
        paths: Paths,
        weight: NDArray[np.float64],
        bin_of: NDArray[np.int64],
        share: NDArray[np.float64],
        total: NDArray[np.float64],
        *,
        threads: int | None = None,
    ) -> None:
        """Add the paths' weights to all bins, under every combination.

        Parameters
        ----------
        paths : Paths
            Their lengths.
        weight : (n,) float64
            Of each path where nothing absorbs; paths of weight 0 are skipped.
        bin_of : (n,) int64
            Bin of each path.
        share : (c,) float64
            What a path gives to each channel.
        total : (bins, c, e, s * d) float64
            What to add to.
        threads : int, optional
            None means every core; bins are added up in the order of the paths, whatever it is.
        """
        self.sorted_sums(
            paths, weight, sorted_into(weight, bin_of, len(total)), share, total, threads=threads
        )

    def sorted_sums(
        self,
        paths: Paths,
        weight: NDArray[np.float64],
        places: tuple[NDArray[np.int64], NDArray[np.int64]],
        share: NDArray[np.float64],
        total: NDArray[np.float64],
        *,
        threads: int | None = None,
    ) -> None:
        """Do as `sums` for paths that are sorted already.

        Parameters
        ----------
        paths : Paths
            Their lengths.
        weight : (n,) float64
            Of each path where nothing absorbs.
        places : pair of arrays
            From `sorted_into`.
        share : (c,) float64
            What a path gives to each channel.
        total : (bins, c, e, s * d) float64
            What to add to.
        threads : int, optional
            None means every core.
        """
        from surftex.kernels.absorb import absorb

        order, start = places

        def work(first: int, last: int) -> None:
            absorb(
                first, last, start, order, paths.lengths, weight, self.corneum, self.epidermis, self.papillary,
                self.reticular, share, total,
            )  # fmt: skip

        slices(work, len(total), size=_SLICE_BINS, threads=threads)

    def albedo(self, paths: Paths, *, threads: int | None = None) -> NDArray[np.float64]:
        """Share of the light that leaves the skin again, under every combination.

        Parameters
        ----------
        paths : Paths
            All photons that were sent.
        threads : int, optional
            None means every core.

        Returns
        -------
        albedo : (e, s, d) float64
            What the surface reflects at once is not part of it.
        """
        count = len(paths.kind)
        piece = np.arange(count) // _SLICE_PATHS
        e, s, d = self.shape
        total = np.zeros((piece[-1] + 1, 1, e, s * d))
        self.sums(paths, paths.weight, piece, np.ones(1), total, threads=threads)
        return total.sum(axis=(0, 1)).reshape(e, s, d) / count
