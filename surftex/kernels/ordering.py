"""Samples that lie in one face side by side: what one has read, the next finds at hand."""

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
