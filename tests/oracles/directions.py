"""Slow, obvious twins of the kernels of direction fields: whole matrices, and arrays over all corners."""

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from surftex.geodesics.connection import Connection
from surftex.kernels.multigrid import DAMPING, HUB, STRONG


def laplacian(connection: Connection, least: float, most: float) -> NDArray[np.complex128]:
    """(n, n) entries of both ends of each edge, added up face by face."""
    surface = connection.surface
    result = np.zeros((len(surface.vertices),) * 2, complex)
    for face, corners in enumerate(surface.faces):
        for i in range(3):
            total = 0.5 / np.tan(surface.corner_angle[face, i - 1])
            other, j = surface.neighbor[face, i], surface.neighbor_edge[face, i]
            if other >= 0:
                total += 0.5 / np.tan(surface.corner_angle[other, j - 1])
            weight = np.clip(total, least, most) * (0.5 if other >= 0 else 1.0)
            start, end = corners[i], corners[(i + 1) % 3]
            carried = np.exp(1j * connection.symmetry * connection.edge_turn[face, i])
            result[start, start] += weight
            result[end, end] += weight
            result[end, start] -= weight * carried
            result[start, end] -= weight * carried.conj()
    alone = np.flatnonzero(np.diag(result) == 0)
    result[alone, alone] = 1.0
    return result


def gathered(connection: Connection, value: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """(n,) means at the vertices of what stands in the faces around them, weighted by the angles of their corners."""
    surface = connection.surface
    every = np.arange(len(surface.faces), dtype=np.int32)
    weight = surface.corner_angle
    there = weight * value[:, None] * np.exp(-1j * connection.symmetry * connection.corner_turn(every))
    total, angles = np.zeros(len(surface.vertices), complex), np.zeros(len(surface.vertices))
    np.add.at(total, surface.faces, there)
    np.add.at(angles, surface.faces, weight)
    return total / np.where(angles > 0, angles, 1.0)


def strong(matrix: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """(n, n) which vertices hang together."""
    beside = np.abs(matrix - np.diag(np.diag(matrix)))
    largest = beside.max(axis=1)
    return beside > STRONG * np.sqrt(np.outer(largest, largest))


def aggregates(matrix: NDArray[np.complex128]) -> tuple[NDArray[np.int32], NDArray[np.complex128]]:
    """(n,) aggregate of each vertex, and the unit number that carries the aggregate's value to it."""
    together, count = strong(matrix), 0
    owner, turn = np.full(len(matrix), -1), np.ones(len(matrix), complex)
    for v in range(len(matrix)):
        if owner[v] < 0 and (owner[together[v]] < 0).all():
            beside = np.flatnonzero(together[v])
            owner[v], owner[beside] = count, count
            turn[beside] = -matrix[beside, v] / np.abs(matrix[beside, v])
            count += 1
    before = owner.copy()
    for v in np.flatnonzero(before < 0):
        beside = [w for w in np.flatnonzero(matrix[v]) if before[w] >= 0]
        best = max(beside, key=lambda w: abs(matrix[v, w]))
        owner[v], turn[v] = owner[best], -matrix[v, best] / abs(matrix[v, best]) * turn[best]
    return owner.astype(np.int32), turn


def interpolation(
    matrix: NDArray[np.complex128], owner: NDArray[np.int32], turn: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """(n, aggregates) values of the aggregates carried to the vertices, and a Jacobi step with the strong entries alone."""
    plain = np.zeros((len(matrix), owner.max() + 1), complex)
    plain[np.arange(len(matrix)), owner] = turn
    diagonal = np.diag(matrix).real
    kept = np.where(strong(matrix), matrix, 0.0)
    weak = np.abs(matrix - np.diag(np.diag(matrix)) - kept).sum(axis=1)
    kept += np.diag(diagonal - weak)
    step = DAMPING / np.maximum(diagonal - weak, 0.5 * diagonal)
    step[(matrix != 0).sum(axis=1) > HUB] = 0.0
    return plain - step[:, None] * (kept @ plain)


def best_of_three(
    inner: NDArray[np.complex128], energy: NDArray[np.complex128]
) -> tuple[NDArray[np.complex128], float]:
    """(3,) factors of the sum of least energy and size 1, and that energy; inner and energy are whole."""
    levels, vectors = scipy.linalg.eigh(energy, inner)
    return vectors[:, 0], levels[0]
