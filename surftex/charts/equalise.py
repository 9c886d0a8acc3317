"""Seams made equal: the texels beside them are moved a little, so that both sides look up the same values.

A sparse least-squares problem over the texels that bilinear lookup mixes along the seams [1]_, at mip 0 and,
through the averages that mips are, at coarser ones: jumps squared, plus a small price on moving. Inside the
charts nothing changes.

References
----------
.. [1] Liu, Ferguson, Jacobson, Gingold. Seamless: Seam erasure and seam-aware decoupling of shape from mesh
   resolution. ACM Transactions on Graphics 36 (2017).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from surftex.charts.lookup import bilinear_stencil
from surftex.charts.seams import SeamSamples
from surftex.errors import InputError

PRICE = 0.02
"""Price of moving a texel, beside that of a jump."""

STEPS = 100
"""Steps of conjugate gradients at most."""


@dataclass(frozen=True, eq=False)
class Equalised:
    """A map with equal seams.

    Attributes
    ----------
    image : (height, width) or (height, width, c) float32
        The map.
    moved_texels : int
        Texels that take part.
    moved_rms : float
        Root mean square of their changes, in the map's unit.
    moved_max : float
        The greatest change.
    """

    image: NDArray[np.float32]
    moved_texels: int
    moved_rms: float
    moved_max: float


def equalise(samples: SeamSamples, image: NDArray[Any], *, mips: int = 3, price: float = PRICE) -> Equalised:
    """Even out the jumps of a map across its seams.

    Parameters
    ----------
    samples : SeamSamples
        Places along the seams, from `seam_samples` at the map's resolution.
    image : (height, width) or (height, width, c) array
        The map; numbers that may be mixed.
    mips : int
        Levels to even out; fewer where a side is odd.
    price : float
        Of moving a texel by one unit, beside a jump of one unit; more keeps closer to the map.

    Returns
    -------
    result : Equalised
        The new map, and how far it moved.

    Raises
    ------
    InputError
        If the map has no picture's shape.
    """
    from scipy.sparse.linalg import LinearOperator, cg

    if image.ndim not in (2, 3):
        raise InputError(f"image has shape {image.shape}; it takes (height, width) or (height, width, c)")
    result = np.array(image, np.float32)
    if len(samples) == 0:
        return Equalised(result, 0, 0.0, 0.0)
    levels = _levels(samples, image.shape[0], image.shape[1], mips)
    taking_part = np.unique(np.concatenate([average.indices for _, average in levels]))
    levels = [(jump, _columns(average, taking_part)) for jump, average in levels]
    flat = result.reshape(image.shape[0] * image.shape[1], -1)
    before = flat[taking_part].astype(np.float64)

    def normal(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return sum(
            (average.T @ (jump.T @ (jump @ (average @ values))) for jump, average in levels), 0.0 * values
        )

    size = len(taking_part)

    def moved(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return normal(values.ravel()) + price * values.ravel()

    system = LinearOperator((size, size), matvec=moved, dtype=np.float64)  # pyright: ignore[reportCallIssue]
    change = np.zeros_like(before)
    for channel in range(before.shape[1]):
        change[:, channel], _ = cg(system, -normal(before[:, channel]), rtol=1e-3, maxiter=STEPS)
    flat[taking_part] = (before + change).astype(np.float32)
    return Equalised(
        result, len(taking_part), float(np.sqrt((change**2).mean())), float(np.abs(change).max(initial=0.0))
    )


def _levels(samples: SeamSamples, height: int, width: int, mips: int) -> list[tuple[csr_array, csr_array]]:
    """Write the jumps of every mip in two steps: averages of texels into the mip's texels, and jumps of those.

    A coarser mip needs fewer samples; each then counts for more.
    """
    levels = []
    for level in range(mips):
        side = 1 << level
        if height % side or width % side:
            break
        here, here_weight = bilinear_stencil(samples.here_uv[::side], width // side, height // side)
        there, there_weight = bilinear_stencil(samples.there_uv[::side], width // side, height // side)
        used, compact = np.unique(np.concatenate([here, there], axis=1), return_inverse=True)
        weight = np.concatenate([here_weight, -there_weight], axis=1) * np.sqrt(side)
        sample = np.repeat(np.arange(len(here)), 8)
        places = (sample, compact.ravel())
        jump = csr_array(coo_array((weight.ravel(), places), shape=(len(here), len(used))))
        row, column = np.divmod(used, width // side)
        down, across = np.divmod(np.arange(side * side), side)
        texel = (row[:, None] * side + down) * width + column[:, None] * side + across
        share = np.full(texel.size, 1.0 / (side * side))
        start = np.arange(len(used) + 1) * side * side
        levels.append((jump, csr_array((share, texel.ravel(), start), shape=(len(used), height * width))))
    return levels


def _columns(matrix: csr_array, kept: NDArray[np.integer]) -> csr_array:
    """Renumber the columns of a matrix by their place among those that are kept."""
    index = np.searchsorted(kept, matrix.indices)
    return csr_array((matrix.data, index, matrix.indptr), shape=(len(matrix.indptr) - 1, len(kept)))
