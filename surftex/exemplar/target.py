"""`Target`: the statistics that a picture shall have, as arrays that the sampler works on.

Groups are the labels of a composite texture; a plain texture has one. Pairs that join two groups count in a
group of their own, the last.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.exemplar.lattice import MISSING

NO_CLASS = 64
"""Class of a missing level, in quads."""


@dataclass(frozen=True, eq=False)
class Target:
    """Statistics of cliques.

    Attributes
    ----------
    levels : int
        2 to 32.
    joint : bool
        Pairs are counted by both levels (labels, at most 8) and not by their difference.
    single : (g, c, levels) float32
        Share of each level, by group and band.
    pair_type : (k, 4) int32
        Band at the head, band at the tail, steps right and down from head to tail.
    pair : (g + 1, k, 64) float32
        Share of each difference, or of both levels.
    quad_band : (j,) int32
        Band of each quad.
    quad_shape : (j, 4, 2) int32
        Places of its corners, right and down; the first is (0, 0).
    quad : (g, j, 256) float32
        Share of the four classes; the first corner's is the most significant.
    quarter : (g, c, 256) uint8
        Class of each level, 0 to 3; `NO_CLASS` for what is no level.
    pair_used, quad_used : (g + 1, k) and (g, j) bool
        Which of the types belong to which group.
    """

    levels: int
    joint: bool
    single: NDArray[np.float32]
    pair_type: NDArray[np.int32]
    pair: NDArray[np.float32]
    quad_band: NDArray[np.int32]
    quad_shape: NDArray[np.int32]
    quad: NDArray[np.float32]
    quarter: NDArray[np.uint8]
    pair_used: NDArray[np.bool_]
    quad_used: NDArray[np.bool_]

    @property
    def groups(self) -> int:
        """Labels of a composite; 1 for a plain texture."""
        return len(self.single)

    @property
    def bands(self) -> int:
        """Numbers at each site."""
        return self.single.shape[1]

    @property
    def code(self) -> tuple[int, int]:
        """Step and shift: a pair falls into bin ``tail + step * head + shift``."""
        return (8, 0) if self.joint else (-1, 31)

    @property
    def radius(self) -> int:
        """Longest step of an offset in either axis, between any two corners."""
        far = [0]
        if len(self.pair_type):
            far.append(int(np.abs(self.pair_type[:, 2:]).max()))
        if len(self.quad_shape):
            far.append(int((self.quad_shape.max(axis=1) - self.quad_shape.min(axis=1)).max()))
        return max(far)


def quarters(single: NDArray[np.floating], *, joint: bool = False) -> NDArray[np.uint8]:
    """Part levels into four classes of about the same share.

    Parameters
    ----------
    single : (c, levels) float
        Shares of the levels.
    joint : bool
        Labels: the label is the class, the fourth holds all from there on.

    Returns
    -------
    quarter : (c, 256) uint8
        Class of each level; `NO_CLASS` beyond the levels.
    """
    bands, levels = single.shape
    result = np.full((bands, MISSING + 1), NO_CLASS, np.uint8)
    if joint:
        result[:, :levels] = np.minimum(np.arange(levels), 3)
        return result
    total = np.cumsum(single, axis=1, dtype=np.float64)
    middle = total - 0.5 * single
    result[:, :levels] = np.clip(4 * middle / np.maximum(total[:, -1:], 1e-12), 0, 3).astype(np.uint8)
    return result


def no_cliques(single: NDArray[np.float32], *, joint: bool = False) -> Target:
    """Start with levels alone.

    Parameters
    ----------
    single : (g, c, levels) float32
        Their shares.
    joint : bool
        As in `Target`.

    Returns
    -------
    target : Target
        Without pairs and quads.
    """
    groups = len(single)
    quarter = np.stack([quarters(each, joint=joint) for each in single])
    nothing = np.zeros(0, np.int32)
    return Target(
        single.shape[2], joint, single,
        nothing.reshape(0, 4), np.zeros((groups + 1, 0, 64), np.float32),
        nothing, nothing.reshape(0, 4, 2), np.zeros((groups, 0, 256), np.float32), quarter,
        np.zeros((groups + 1, 0), bool), np.zeros((groups, 0), bool),
    )  # fmt: skip
