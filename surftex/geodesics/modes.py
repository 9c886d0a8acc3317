"""The lowest mode on each component of a mesh: the field that changes least, of those of one size."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from surftex.geodesics.multigrid import near_inverse

_SETTLED = 1e-6
"""Share of itself by which one more step would change a mode."""


def lowest_mode(
    matrix: Any, mass: NDArray[np.float64], component: NDArray[np.int64], start: NDArray[np.complex128],
    *, most: int = 100,
) -> NDArray[np.complex128]:  # fmt: skip
    """Find the lowest mode by conjugate gradients that keep to what is best of three fields (LOBPCG [1]_).

    Parameters
    ----------
    matrix : (n, n) sparse
        Hermitian, not negative, of blocks for the components.
    mass : (n,) float64
        Not negative.
    component : (n,) int64
        Of each vertex.
    start : (n,) complex128
        Where several modes are equally low, one near to this is found.
    most : int
        Steps at most.

    Returns
    -------
    value : (n,) complex128
        Of unit mean square on each component, and of the start's phase.

    References
    ----------
    .. [1] Knyazev. Toward the Optimal Preconditioned Eigensolver: Locally Optimal Block Preconditioned Conjugate
       Gradient Method. SIAM J. Sci. Comput. 23 (2001).
    """
    area = np.bincount(component, mass)
    share = mass / np.where(area > 0, area, 1.0)[component]
    rows = csr_array(matrix + diags_array(1e-6 * share))
    value = _improved(rows, share, component, np.where(mass > 0, start, 0j), most)
    return value * _phase(_sums(component, share * value.conj() * start))[component]


def _improved(
    rows: csr_array, share: NDArray[np.float64], component: NDArray[np.int64],
    start: NDArray[np.complex128], most: int,
) -> NDArray[np.complex128]:  # fmt: skip
    """Mode after at most so many steps; `share` of each vertex in the area of its component."""
    from surftex.kernels.modes import best, inner_products, step

    count = int(component.max()) + 1
    field, image = np.zeros((3, len(share)), complex), np.zeros((3, len(share)), complex)
    inner, energy = np.zeros((count, 3, 3), complex), np.zeros((count, 3, 3), complex)
    moving, level = np.ones(count, bool), np.zeros(count)
    factor, room, left = np.zeros((count, 3), complex), np.zeros((2, 3, 3), complex), share * start
    inverse = near_inverse(rows)
    field[0], image[0] = start, rows @ start
    for done in range(most):
        field[1] = inverse.solve(left)
        image[1] = rows @ field[1]
        inner[:], energy[:] = 0.0, 0.0
        inner_products(component, share, field, image, inner, energy)
        if done > 0:
            moving &= np.real(inner[:, 1, 1]) > _SETTLED**2
        index = np.flatnonzero(moving[component])
        if 2 * len(index) < len(share):  # what still moves goes on alone
            if len(index) > 0:
                block, onward = rows[index][:, index], field[0, index]
                field[0, index] = _improved(block, share[index], component[index], onward, most - done)
            break
        best(moving, inner, energy, room, factor, level)
        step(component, share, factor, level, field, image, left)
    return field[0]


def _phase(number: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Give unit numbers of the same phase, 1 for 0."""
    size = np.abs(number)
    return np.where(size > 0, number / np.where(size > 0, size, 1.0), 1.0)


def _sums(component: NDArray[np.int64], value: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Sum over the vertices of each component."""
    return np.bincount(component, value.real) + 1j * np.bincount(component, value.imag)
