"""Nested dissection: an order of elimination in which the factors of equations on a mesh stay small."""

from surftex.kernels.jit import kernel, part

LEAF = 24
"""Vertices of a piece that is cut no further."""

HUB = 64
"""Neighbours beyond which a vertex, such as the apex of a fan, is eliminated last: a ring around it would be a whole piece."""


@part
def _walk(first, name, start, other, piece, queue, begin, ring):
    """Walk ring by ring through piece `name` from vertex `first`: its vertices go to `queue` from `begin` on, and to `ring`.

    ring (n,) is given as -1 for all of them. Returns the end of those in the queue.
    """
    queue[begin] = first
    ring[first] = 0
    count = begin + 1
    i = begin
    while i < count:
        v = queue[i]
        i += 1
        for e in range(start[v], start[v + 1]):
            w = other[e]
            if piece[w] == name and ring[w] < 0:
                ring[w] = ring[v] + 1
                queue[count] = w
                count += 1
    return count


@part
def _choose(count, queue, ring):
    """Choose the ring with the fewest vertices for each of the smaller side that it parts; 0 if there are no sides."""
    begin, best, least = 0, 0, 1e300
    while begin < count:
        end = begin
        while end < count and ring[queue[end]] == ring[queue[begin]]:
            end += 1
        smaller = min(begin, count - end)
        if smaller > 0 and (end - begin) / smaller < least:
            best, least = ring[queue[begin]], (end - begin) / smaller
        begin = end
    return best


@part
def _side(v, cut, ring):
    """Side of a vertex: 0 before the ring that cuts, 1 beyond it, 2 on it."""
    if ring[v] == cut:
        return 2
    return 0 if ring[v] < cut else 1


@kernel
def dissect(start, other, piece, queue, ring, stack, order):
    """Order the vertices of a graph: those of a ring that cuts it come after both sides, and so on within these.

    start (n+1,), other (e,) int32: neighbours of each vertex; piece (n,) int32: zeros; queue (n,) int32, ring (n,) int32 given
    as -1, stack (n + 1, 2) int32: room to work in; -> order (n,) int32: from the first to the last to be eliminated.

    George, Liu. An Automatic Nested Dissection Algorithm for Irregular Finite Element Problems (1978): rings are counted
    from a vertex that is about as far off as any.
    """
    n = len(piece)
    high = n
    for v in range(n - 1, -1, -1):
        if start[v + 1] - start[v] > HUB:
            high -= 1
            order[high] = v
            piece[v] = -1
    at = 0
    for v in range(n):
        if piece[v] == 0:
            order[at] = v
            at += 1
    stack[0, 0], stack[0, 1] = 0, high
    waiting, names = 1, 0
    while waiting:
        waiting -= 1
        low, high = stack[waiting, 0], stack[waiting, 1]
        if high - low <= LEAF:
            continue
        name = piece[order[low]]
        count = _walk(order[low], name, start, other, piece, queue, 0, ring)
        if count < high - low:  # parts that hang together with nothing else here
            begin, i = 0, low
            while count > begin:
                names += 1
                for k in range(begin, count):
                    piece[queue[k]] = names
                stack[waiting, 0], stack[waiting, 1] = low + begin, low + count
                waiting += 1
                begin = count
                while i < high and ring[order[i]] >= 0:
                    i += 1
                if i < high:
                    count = _walk(order[i], name, start, other, piece, queue, begin, ring)
            for i in range(count):
                order[low + i] = queue[i]
        else:
            far = queue[count - 1]
            for i in range(count):
                ring[queue[i]] = -1
            _walk(far, name, start, other, piece, queue, 0, ring)
            names += 2
            cut = _choose(count, queue, ring)
            # What touches nothing beyond the ring belongs to what lies before it.
            for i in range(count if cut > 0 else 0):
                v = queue[i]
                if ring[v] == cut:
                    ring[v] = cut - 1
                    for e in range(start[v], start[v + 1]):
                        if piece[other[e]] == name and ring[other[e]] == cut + 1:
                            ring[v] = cut
            at = low
            for side in range(3 if cut > 0 else 0):
                stack[waiting, 0] = at
                for i in range(count):
                    v = queue[i]
                    if _side(v, cut, ring) == side:
                        order[at] = v
                        at += 1
                        piece[v] = names - side if side < 2 else -1
                stack[waiting, 1] = at
                waiting += 1 if side < 2 else 0
        for i in range(count):
            ring[queue[i]] = -1
