"""The flood itself: primitives in, rows out, over slices of sources in a few threads."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import checked, frozen, read_only_view
from surftex.errors import WorkError
from surftex.geodesics.packed import packed
from surftex.kernels.pool import Tick, slices
from surftex.surface.surface import Surface

SOURCES_A_SLICE = 256

_FEW_ROWS, _MANY_ROWS = 1 << 12, 1 << 16
"""Rows of a worker's first block and of its later ones."""

MOST_WINDOWS = 50_000_000
"""Windows of one source; more means a mesh beyond repair, or a reach that only heat can serve."""


class _Worker:
    """Buffers that one worker floods in; none of them outlives the call."""

    def __init__(self, surface: Surface) -> None:
        vertices, corners = len(surface.vertices), 3 * len(surface.faces)
        self.stamp = 1  # 0 is no stamp: zeros are lent by the system, and cleared only where a flood comes
        self.marks = np.zeros(vertices), np.zeros(vertices, np.int32), np.zeros(vertices, np.int32)
        self.splits = np.zeros((corners, 2)), np.zeros((corners, 3), np.int32)
        self.count = np.zeros(6, np.int64)
        self.queue = _queue(1 << 10)
        self.rows = _rows(_FEW_ROWS)
        self.taken = 0

    def longer_queue(self) -> None:
        """Double the room for windows that wait."""
        self.queue = _queue(2 * len(self.queue[0]))

    def take_rows(self) -> list[tuple[NDArray[np.float64], NDArray[np.int32]]]:
        """Give away the rows found since they were last taken; the block that they lie in is not written there again."""
        first, last = self.taken, int(self.count[3])
        self.taken = last
        return [(self.rows[0][first:last], self.rows[1][first:last])] if last > first else []

    def new_rows(self) -> None:
        """Go on in another block; a longer one, as one source may fill the whole."""
        size = len(self.rows[0])
        self.rows = _rows(2 * size if self.taken == 0 else min(2 * size, _MANY_ROWS))
        self.taken = self.count[3] = 0

    def pass_stamps(self, count: int) -> None:
        """Never use a stamp twice."""
        self.stamp += count
        if self.stamp >= 2**31 - 2 * count:
            self.stamp = 1
            for stamps in (*self.marks[1:], self.splits[1]):
                stamps.fill(0)


def _queue(size: int) -> tuple[NDArray[Any], ...]:
    """Room for windows that wait: heap, links, windows."""
    return np.zeros(size), np.zeros((size, 2), np.int32), np.zeros((size, 8)), np.zeros((size, 5), np.int32)


def _rows(size: int) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    return np.zeros((size, 10)), np.zeros((size, 3), np.int32)


def flood_primitives(
    surface: Surface,
    start: NDArray[np.int64],
    face: NDArray[np.int32],
    primitive: NDArray[np.float64],
    radius: NDArray[np.float64],
    bound: NDArray[np.float64],
    wanted: NDArray[np.bool_] | None,
    threads: int | None,
    tick: Tick | None,
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Flood sources, each made of one primitive or several.

    Parameters
    ----------
    surface : Surface
        m faces.
    start : (n + 1,) int64
        Primitives of each source.
    face : (p,) int32
        Face of each primitive.
    primitive : (p, 8) float64
        Start, end and wedge, in the frame of the face (`surftex.kernels.windows.flood`).
    radius : (n,) float64
        Read-only.
    bound : (m,) float64
        Read-only.
    wanted : (m,) bool or None
        Faces that need rows; None for all.
    threads : int or None
        None means every core.
    tick : callable or None
        Told the finished share.

    Returns
    -------
    row : (r, 10) float64
        Face by face, and source by source in each, neighbour sources together; read-only.
    row_id : (r, 3) int32
        Face, primitive, kind; read-only.

    Raises
    ------
    WorkError
        If one source sends more windows than any sound mesh asks for.
    """
    from surftex.kernels.ordering import count_faces, put_by_face
    from surftex.kernels.windows import flood

    count, faces = len(start) - 1, len(surface.faces)
    asked = np.ones(faces, bool) if wanted is None else checked(wanted, "wanted", (faces,), np.bool_)
    most = MOST_WINDOWS
    first_face = face[np.minimum(start[:-1], len(face) - 1)] if len(face) else np.zeros(count, np.int32)
    mesh = packed(surface)
    # neighbours follow one another: what one has read of the mesh, the next finds at hand
    order = frozen(np.argsort(mesh.place[first_face], kind="stable"))
    given = (order, frozen(start), read_only_view(face, np.int32), frozen(primitive), radius, most)
    faced = (*mesh[:-1], frozen(asked.astype(np.uint8)), bound)
    workers: list[_Worker] = []

    def work(first: int, last: int) -> list[tuple[NDArray[np.float64], NDArray[np.int32]]]:
        worker = workers.pop() if workers else _Worker(surface)
        found, full = [], -1
        while full:
            room = (*worker.marks, *worker.splits, worker.count, *worker.queue, *worker.rows)
            first, full = flood(first, last, worker.stamp, *given, *faced, *room)
            worker.pass_stamps(count)
            if full == 1:
                worker.longer_queue()
            elif full == 2:
                found += worker.take_rows()
                worker.new_rows()
            elif full == 3:
                source = int(order[first])
                raise WorkError(
                    f"source {source} of {count} sends more than {most} windows within {radius[source]:g} mm; "
                    "ask for a smaller radius, or use method='heat'"
                )
        found += worker.take_rows()
        workers.append(worker)
        return found

    found = slices(work, count, size=SOURCES_A_SLICE, threads=threads, tick=tick)
    parts = [part for slice_parts in found for part in slice_parts]
    found.clear()
    workers.clear()
    parts.reverse()
    place = np.zeros(faces + 1, np.int64)
    for _, ids in parts:
        count_faces(ids, place)
    place = np.cumsum(place)
    row, row_id = np.zeros((place[-1], 10)), np.zeros((place[-1], 3), np.int32)
    while parts:  # a part goes as soon as it is copied, so that the rows are never held twice
        put_by_face(*parts.pop(), place, row, row_id)
    return frozen(row), frozen(row_id)
