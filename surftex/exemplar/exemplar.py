"""`Exemplar`: the picture that a texture is learnt from, ready to be asked for the shares of any clique."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.exemplar.lattice import MISSING, Plane
from surftex.exemplar.measure import distance, level_shares, pair_shares, quad_shares

_MOST_SITES = 2**18
_PARTS = 8


@dataclass(frozen=True, eq=False)
class Exemplar:
    """Levels of a picture; make one with `Exemplar.of`.

    Attributes
    ----------
    plane : Plane
        Where they lie; it ends at the picture's borders.
    level : (c, places) uint8
        `MISSING` where the mask is not.
    site : (n,) int32
        Heads that are counted: pixels of the mask, every few rows of large pictures.
    """

    plane: Plane
    level: NDArray[np.uint8]
    site: NDArray[np.int32]
    threads: int | None

    @staticmethod
    def of(
        level: NDArray[np.uint8],
        inside: NDArray[np.bool_],
        margin: int,
        threads: int | None = None,
    ) -> "Exemplar":
        """Lay levels of a picture out to be counted.

        Parameters
        ----------
        level : (c, h, w) uint8
            Of `Bands.levels_of`.
        inside : (h, w) bool
            Pixels that count.
        margin : int
            Longest step of an offset.
        threads : int, optional
            None means every core; cannot change a share.

        Returns
        -------
        exemplar : Exemplar
            Ready.
        """
        level = np.where(inside, level, np.uint8(MISSING))
        plane = Plane.of(level.shape[1], level.shape[2], margin, wrap=False)
        counted = inside.copy()
        every = -(-int(inside.sum()) // _MOST_SITES)
        counted[np.arange(len(counted)) % every > 0] = False
        return Exemplar(plane, plane.hold(level), plane.site[counted.ravel()], threads)

    def levels(self, count: int) -> NDArray[np.float32]:
        """Measure levels.

        Parameters
        ----------
        count : int
            Levels that there can be.

        Returns
        -------
        share : (1, c, count) float32
            Sums of 1.
        """
        return level_shares(self.plane, self.level, count, site=self.site)

    def pairs(
        self, pair_type: NDArray[np.int32], code: tuple[int, int], site: NDArray[np.int32] | None = None
    ) -> NDArray[np.float32]:
        """Measure pairs.

        Parameters
        ----------
        pair_type : (k, 4) int32
            As in `Target`.
        code : (int, int)
            As `Target.code`.
        site : (n,) int32, optional
            Heads; all that are counted without it.

        Returns
        -------
        share : (k, 64) float32
            Sums of 1.
        """
        site = self.site if site is None else site
        return pair_shares(self.plane, self.level, pair_type, code=code, site=site, threads=self.threads)[0]

    def noise(self, pair_type: NDArray[np.int32], code: tuple[int, int]) -> NDArray[np.float64]:
        """Tell how exactly the picture knows the shares of pairs, from how its parts differ.

        Parameters
        ----------
        pair_type : (k, 4) int32
            As in `Target`.
        code : (int, int)
            As `Target.code`.

        Returns
        -------
        noise : (k,) float64
            Standard error of the distance of each type.
        """
        whole = self.pairs(pair_type, code)
        spread = [
            distance(self.pairs(pair_type, code, part), whole) for part in np.array_split(self.site, _PARTS)
        ]
        return np.sqrt(np.mean(np.square(spread), axis=0) / _PARTS)

    def quads(
        self, band: NDArray[np.int32], shape: NDArray[np.int32], quarter: NDArray[np.uint8]
    ) -> NDArray[np.float32]:
        """Measure quads.

        Parameters
        ----------
        band : (j,) int32
            As in `Target`.
        shape : (j, 4, 2) int32
            As in `Target`.
        quarter : (1, c, 256) uint8
            As in `Target`.

        Returns
        -------
        share : (1, j, 256) float32
            Sums of 1.
        """
        return quad_shares(self.plane, self.level, band, shape, quarter, site=self.site, threads=self.threads)
