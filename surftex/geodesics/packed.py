"""A surface as the window kernels read it: few arrays, what belongs together side by side."""

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.surface.surface import Surface


class PackedSurface(NamedTuple):
    """Described in `surftex.kernels.window_queue`."""

    ids: NDArray[np.int32]
    shape: NDArray[np.float64]
    turning: NDArray[np.float64]
    fan_start: NDArray[np.int64]
    fan_corner: NDArray[np.int64]

    place: NDArray[np.int32]
    """(m,) of each face along a curve that keeps neighbours together (Morton's)."""


_packed: WeakKeyDictionary[Surface, PackedSurface] = WeakKeyDictionary()


def packed(surface: Surface) -> PackedSurface:
    """Pack a surface; the result is kept as long as the surface lives.

    Parameters
    ----------
    surface : Surface
        Immutable, so that nothing can fall out of date.

    Returns
    -------
    packed : PackedSurface
        Read-only arrays.
    """
    found = _packed.get(surface)
    if found is not None:
        return found
    fan_start, fan_corner, fan_angle = surface.fans
    before = np.zeros(3 * len(surface.faces))
    before[fan_corner] = fan_angle
    shape = np.concatenate(
        [
            surface.flat,
            surface.edge_length[..., None],
            surface.transport,
            surface.corner_angle[..., None],
            before.reshape(-1, 3, 1),
        ],
        axis=2,
    )
    ids = np.stack([surface.faces, surface.neighbor, surface.neighbor_edge], axis=2)
    straight = np.where(surface.on_border, np.pi, 2 * np.pi) * (1 + 1e-10)
    turning = (
        np.where(surface.vertex_angle > straight, np.where(surface.on_border, -1.0, 1.0), 0.0)
        * surface.vertex_angle
    )
    result = PackedSurface(
        frozen(ids), frozen(shape), frozen(turning), fan_start, fan_corner, _places(surface)
    )
    _packed[surface] = result
    return result


def _places(surface: Surface) -> NDArray[np.int32]:
    low = surface.vertices.min(axis=0)
    per_cell = 1023.0 / np.ptp(surface.vertices, axis=0).max()
    cell = ((surface.vertices[surface.faces[:, 0]] - low) * per_cell).astype(np.int64)
    number = np.arange(1024)
    spread = np.zeros(1024, np.int64)
    for bit in range(10):
        spread |= (number >> bit & 1) << 3 * bit
    return frozen((spread[cell[:, 0]] | spread[cell[:, 1]] << 1 | spread[cell[:, 2]] << 2).astype(np.int32))
