"""Equations on a mesh solved nearly, in time that grows as the mesh does; that of factors grows faster.

The lowest mode of 35,000 vertices takes 15 such solves of 2 ms, and 30 ms before the first; with factors 10 solves of
11 ms, and 200 ms before them.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from surftex.geodesics.factors import Factors

FACTORED_AT_MOST = 1000
"""Vertices up to which equations are factored."""


class Multigrid:
    """Near inverse of a Hermitian positive matrix over the vertices of a mesh, by smoothed aggregation [1]_.

    Parameters
    ----------
    matrix : (n, n) sparse
        Complex128; neighbours beside the diagonal, and numbers there that are not less than those beside.

    References
    ----------
    .. [1] Vaněk, Mandel, Brezina. Algebraic Multigrid by Smoothed Aggregation for Second and Fourth Order Elliptic
       Problems. Computing 56 (1996).
    """

    def __init__(self, matrix: Any) -> None:
        from surftex.kernels.multigrid import aggregate, interpolate

        rows = csr_array(matrix)
        rows.sum_duplicates()
        self.start, self.other, self.entry = rows.indptr, rows.indices, rows.data
        count, size = len(self.start) - 1, len(self.other)
        self.middle, self.scale = np.zeros(count, np.int32), np.zeros(count)
        largest, owner, turn = np.zeros(count), np.zeros(count, np.int32), np.zeros(count, complex)
        parts = self.start, self.other, self.entry
        aggregates = aggregate(*parts, self.middle, self.scale, largest, owner, turn)
        row_start, column = np.zeros(count + 1, np.int32), np.zeros(count + size, np.int32)
        value, slot = np.zeros(count + size, complex), np.full(aggregates, -1, np.int32)
        size = interpolate(*parts, self.scale, largest, owner, turn, slot, row_start, column, value)
        self.onto = csr_array((value[:size], column[:size], row_start), shape=(count, aggregates))
        self.back = csr_array(self.onto.conj().T)
        coarse = self.back @ (rows @ self.onto)
        self.coarse = near_inverse(coarse) if aggregates < 0.8 * count else Factors(coarse)

    def solve(self, right: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Solve nearly for one right-hand side: a fixed, Hermitian, positive map of it.

        Parameters
        ----------
        right : (n,) complex128
            Any.

        Returns
        -------
        solution : (n,) complex128
            The part of it that no sweep would change is exact.
        """
        from surftex.kernels.multigrid import sweep_down, sweep_up

        value, left = np.zeros_like(right), np.zeros_like(right)
        sweep_down(self.start, self.middle, self.other, self.entry, self.scale, right, value, left)
        value += self.onto @ self.coarse.solve(self.back @ left)
        sweep_up(self.start, self.other, self.entry, self.scale, right, value)
        return value


def near_inverse(matrix: Any) -> Multigrid | Factors:
    """Choose factors for few vertices, multigrid for many.

    Parameters
    ----------
    matrix : (n, n) sparse
        As for `Multigrid`.

    Returns
    -------
    inverse : Multigrid or Factors
        What solves nearly, or exactly.
    """
    return Multigrid(matrix) if matrix.shape[0] > FACTORED_AT_MOST else Factors(matrix)
