"""Slow, obvious twin of the shortest path: Dijkstra over points sown on every edge."""

import heapq

import numpy as np


def sown_distance(vertices, faces, face_a, weights_a, face_b, weights_b, per_edge=24):
    """Upper bound of the distance from one point to another, closing in on it as `per_edge` grows."""
    names, places, members = {}, [], [[] for _ in faces]

    def node(key, place):
        if key not in names:
            names[key] = len(places)
            places.append(place)
        return names[key]

    for f, triangle in enumerate(faces):
        for i in range(3):
            a, b = sorted((int(triangle[i]), int(triangle[(i + 1) % 3])))
            for k in range(per_edge + 1):
                key = (a,) if k == 0 else (b,) if k == per_edge else (a, b, k)
                share = k / per_edge
                members[f].append(node(key, (1 - share) * vertices[a] + share * vertices[b]))
    start = node("start", weights_a @ vertices[faces[face_a]])
    goal = node("goal", weights_b @ vertices[faces[face_b]])
    members[face_a].append(start)
    members[face_b].append(goal)
    around = [[] for _ in places]
    for f, nodes in enumerate(members):
        for k in set(nodes):
            around[k].append(f)
    distance = np.full(len(places), np.inf)
    distance[start] = 0
    heap = [(0.0, start)]
    while heap:
        reached, k = heapq.heappop(heap)
        if k == goal:
            return reached
        if reached > distance[k]:
            continue
        for f in around[k]:
            for other in members[f]:
                onward = reached + np.linalg.norm(places[k] - places[other])
                if onward < distance[other]:
                    distance[other] = onward
                    heapq.heappush(heap, (onward, other))
    return np.inf
