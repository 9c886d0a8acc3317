"""What lies in one face side by side, samples and rows: what one has read, the next finds at hand."""

from surftex.kernels.jit import kernel


@kernel
def order_by_face(face, place, order):
    """Sort samples by face; those of a face stay in their order.

    face (n,) int32; place (m+1,) int64, zeros: room to count in -> order (n,) int32.
    """
    for i in range(len(face)):
        place[face[i] + 1] += 1
    for f in range(1, len(place)):
        place[f] += place[f - 1]
    for i in range(len(face)):
        f = face[i]
        order[place[f]] = i
        place[f] += 1


@kernel
def count_faces(row_id, place):
    """Add the rows of each face, row_id (r, 3) int32, to place[face + 1] (m+1,) int64."""
    for r in range(len(row_id)):
        place[row_id[r, 0] + 1] += 1


@kernel
def put_by_face(row, row_id, place, row_there, row_id_there):
    """Put rows (r, 10) and row_id (r, 3) where the rows of their faces begin, place (m+1,) int64, and move these on."""
    for r in range(len(row_id)):
        to = place[row_id[r, 0]]
        place[row_id[r, 0]] = to + 1
        for c in range(row.shape[1]):
            row_there[to, c] = row[r, c]
        for c in range(row_id.shape[1]):
            row_id_there[to, c] = row_id[r, c]
