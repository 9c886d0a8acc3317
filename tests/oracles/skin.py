"""Slow, obvious twins of what blends the features of a skin, on a flat sheet, where the shortest way is the straight line."""

import numpy as np


def read(table, x):
    """A profile at x in [0, 1], between its knots."""
    return float(np.interp(x * (len(table) - 1), np.arange(len(table)), table))


def outline(waves, angle):
    """Radius in a direction, as a share of the mean one."""
    parts = [
        waves[2 * i] * np.cos(n * angle) + waves[2 * i + 1] * np.sin(n * angle)
        for i, n in enumerate((2, 3, 5))
    ]
    return max(1 + sum(parts), 0.2)


def blended(offset, footprint, kind, state):
    """State of one sample, of which `offset` (f, 2) leads from every feature, in that feature's frame."""
    state = np.array(state, float)
    shown = min(2 - footprint / kind.finest_mm, 1)
    shown = shown * shown * (3 - 2 * shown) if shown > 0 else 0
    for who, (x, y) in enumerate(offset):
        radius, lean, cosine, sine = kind.size[who].astype(float)
        distance, angle = np.hypot(x, y), np.arctan2(y, x)
        if kind.turned:
            off = angle - np.arctan2(sine, cosine)
            distance *= np.sqrt(np.cos(off) ** 2 / lean + np.sin(off) ** 2 * lean)
            radius *= outline(kind.outline[who].astype(float), angle)
        wide = np.sqrt(radius**2 + kind.spread * footprint**2)
        if distance >= wide:
            continue
        for change, amount, table in zip(kind.changes, kind.amount[who], kind.table, strict=True):
            v = shown * (radius / wide) ** 2 * amount * read(table, distance / wide)
            state[change] = {
                "add": state[change] + v,
                "lessen": state[change] * (1 - v),
                "cover": state[change] + (1 - state[change]) * v,
            }[kind.rules[change]]
    return state


def creased(place, footprint, lines, crease, lift, spread, fade):
    """Depth and fold at a place in the plane. lines: (knots (k, 2), half width, depth, fold, side) of each."""
    down = up = 0.0
    for knots, most, deep, fold, side in lines:
        knots = np.asarray(knots, float)
        knots = knots[np.r_[True, np.linalg.norm(np.diff(knots, axis=0), axis=1) > 1e-9]]
        step = np.diff(knots, axis=0)
        length = np.linalg.norm(step, axis=1)
        t = np.clip(((place - knots[:-1]) * step).sum(1) / length**2, 0, 1)
        away = place - (knots[:-1] + t[:, None] * step)
        distance = np.linalg.norm(away, axis=1)
        i = int(np.argmin(distance))
        along = (length[:i].sum() + t[i] * length[i]) / length.sum()
        width = 2 * most * min(along, 1 - along)
        if width <= 0:
            continue
        taper = width / most
        left = step[i, 0] * away[i, 1] - step[i, 1] * away[i, 0] > 0
        groove = np.hypot(width, np.sqrt(spread) * footprint)
        if distance[i] < groove:
            down += (deep * taper**fade * width / groove * read(crease, distance[i] / groove)) ** 4
        raised = np.hypot(3 * width, np.sqrt(spread) * footprint)
        if left == (side > 0) and distance[i] < raised:
            up += (fold * taper ** (fade + 1) * 3 * width / raised * read(lift, distance[i] / raised)) ** 4
    return down**0.25, up**0.25
