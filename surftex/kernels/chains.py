"""Segments that meet at nodes, put in order along the chains that they form."""

from surftex.kernels.jit import kernel


@kernel
def chains(segment, meeting, order, flipped, chain):
    """Walk along segments from node to node; a chain ends where a node is no passage, or closes on itself.

    segment (s, 2) int64 nodes of each segment; meeting (n, 2) int64 segments that pass through a node, -1 where
    it has none or is the end of chains
    -> order (s,) int64 segments, chain after chain; flipped (s,) uint8: 1 where one is walked from its second node;
    chain (s,) int64 number of each, never falling. Returns the number of chains.
    """
    count, total = 0, 0
    seen = chain  # -1 marks segments that wait; numbers are written in walking order at the end
    for i in range(len(seen)):
        seen[i] = -1
    for turn in range(2):  # first the chains with ends, then the rings
        for start in range(len(segment)):
            if seen[start] >= 0:
                continue
            side = 0
            if turn == 0 and meeting[segment[start, 0], 1] >= 0:
                side = 1
                if meeting[segment[start, 1], 1] >= 0:
                    continue
            here, node = start, segment[start, side]
            while here >= 0 and seen[here] < 0:
                seen[here] = count
                order[total] = here
                flipped[total] = 1 if segment[here, 1] == node and segment[here, 0] != node else 0
                total += 1
                node = segment[here, 0] + segment[here, 1] - node
                first, second = meeting[node, 0], meeting[node, 1]
                if second < 0:
                    break
                here = second if first == here else first
            count += 1
    return count
