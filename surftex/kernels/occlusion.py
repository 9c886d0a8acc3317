"""How much of the sky each place of a relief sees."""

from surftex.kernels.jit import kernel


@kernel
def open_sky(first, last, place, height, host, stretch, direction, jump, step, share, radius, sky):
    """Find the share of an even sky's light that reaches each texel, by the horizons in some directions.

    place (t,) int64: of each texel in `height` (float32, mm, NaN where there is no surface, with a rim as
    wide as the farthest step); host (t,) int32; stretch (m, 3) float64; direction (d, 2) float64: one texel
    right and up; step (k,) float64: how many of those, squared, ascending from 1; share (k,): 1 over how
    many; jump (d, k) int64: what that adds to a place; radius mm: relief farther off does not count -> sky
    (t,) float32: rows first to last. Horizons are measured from the slope at the texel, so that a tilted
    plane is open, and each direction counts by its angle on the surface.
    """
    for i in range(first, last):
        here = height[place[i]]
        xx, xy, yy = stretch[host[i], 0], stretch[host[i], 1], stretch[host[i], 2]
        shut, total = 0.0, 0.0
        for d in range(len(direction)):
            right, up = direction[d, 0], direction[d, 1]
            x, y = xx * right + xy * up, xy * right + yy * up
            squared = x * x + y * y
            back = here - height[place[i] - jump[d, 0]]
            slope = height[place[i] + jump[d, 0]] - here
            if back == back:
                slope = 0.5 * (slope + back)
            fall = squared / (radius * radius)
            horizon = 0.0
            for k in range(len(step)):
                rise = height[place[i] + jump[d, k]] - here
                near = fall * step[k]
                fade = 1.0 - near * near
                if rise != rise or fade <= 0.0:
                    break
                horizon = max(horizon, (rise * share[k] - slope) * fade)
            weight = (right * right + up * up) / squared
            total += weight
            shut += weight * horizon * horizon / (squared + horizon * horizon)
        sky[i] = 1.0 - shut / total
