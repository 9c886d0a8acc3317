"""Pictures to learn from that we make ourselves: a breccia, grass, and ground of grass, sand and stones, with labels."""

import numpy as np
from PIL import Image, ImageDraw
from scipy.ndimage import binary_dilation, gaussian_filter
from scipy.spatial import cKDTree

from surftex.randomness import stream


def noise(side, scale, *names, aspect=1.0):
    """Smooth noise that tiles, with a deviation of 1."""
    numbers = stream(1, "made", *names).uniform(side * side)[:, 0].reshape(side, side) - 0.5
    smooth = gaussian_filter(numbers, (scale, scale * aspect), mode="wrap")
    return smooth / smooth.std()


def cells(side, count, *names, waver=3.0):
    """Number of the nearest of scattered places, wavering, and how much farther the next one is."""
    place = side * stream(1, "made", *names).uniform(count, 2)
    down, right = np.mgrid[:side, :side].astype(float)
    bent = np.stack(
        [axis + waver * noise(side, 5, *names, k) + noise(side, 1.5, *names, k, "fine")
         for k, axis in enumerate((down, right))], axis=-1,
    )  # fmt: skip
    shift = side * np.array([(u, v) for u in (-1, 0, 1) for v in (-1, 0, 1)])
    away, which = cKDTree((place + shift[:, None]).reshape(-1, 2)).query(bent % side, k=2)
    return which[..., 0] % count, away[..., 1] - away[..., 0]


def breccia(side=320, stones=70):
    """A breccia of grey and pale stones in a red ground, with cracks; (side, side, 3), and labels 0 to 3."""
    which, gap = cells(side, stones, "stones")
    numbers = stream(1, "made", "kinds").uniform(stones, 2)
    kind = 1 + (numbers[:, 0] < 0.45)
    label = np.where(gap < (2.5 + 9 * numbers[:, 1] ** 2)[which], 0, kind[which])
    crack = binary_dilation((np.abs(noise(side, 9, "crack")) < 0.035) & (noise(side, 16, "cracked") > -0.2))
    grain = 0.6 * noise(side, 0.7, "grain") + 0.5 * noise(side, 2, "cloud")
    layers = (
        np.array([176, 128, 112]) + grain[..., None] * [16, 15, 13],
        np.array([120, 118, 120]) + noise(side, 0.8, "veins", aspect=6.0)[..., None] * [13, 13, 14],
        np.array([212, 196, 178]) + noise(side, 1.4, "spots")[..., None] * [9, 10, 12],
    )
    color = np.choose(label[..., None], layers)
    rim = gaussian_filter((label > 0).astype(float), 1.2)
    color = color - 26 * np.exp(-(((rim - 0.5) / 0.18) ** 2))[..., None]
    color = gaussian_filter(color, (0.5, 0.5, 0))
    color[crack] = np.array([34, 28, 26]) + 6 * grain[crack, None]
    return np.clip(color, 0, 255).astype(np.uint8), np.where(crack, 3, label).astype(np.uint8)


def grass(side=256, blades=9000):
    """Blades of grass, seen from above; (side, side, 3)."""
    numbers = stream(1, "made", "blades").uniform(blades, 6)
    picture = Image.new("RGB", (2 * side, 2 * side), (28, 38, 14))
    pen = ImageDraw.Draw(picture)
    for depth, (x, y, turn, long, tone, hue) in enumerate(numbers):
        angle = -np.pi / 2 + 1.1 * (turn - 0.5) + 0.8 * np.sin(9 * x)
        light = (0.35 + 0.65 * depth / blades) * (0.6 + 0.4 * tone)
        color = tuple(int(light * each) for each in (112 + 70 * hue, 160 + 30 * hue, 52 + 20 * hue))
        for across in (-2 * side, 0, 2 * side):
            for below in (-2 * side, 0, 2 * side):
                a, b = 2 * side * x + across, 2 * side * y + below
                reach = 14 + 22 * long
                pen.line([a, b, a + reach * np.cos(angle), b + reach * np.sin(angle)], fill=color, width=2)
    return np.asarray(picture.resize((side, side), Image.Resampling.BOX))


def ground(side=320):
    """Ground of grass (0), sand (1) and stones (2); (side, side, 3) and labels."""
    height = noise(side, 14, "ground") + 0.25 * noise(side, 4, "ragged")
    label = np.digitize(height, [-0.35, 0.75])
    which, gap = cells(side, 900, "pebbles", waver=0.5)
    tone = stream(1, "made", "pebble tones").uniform(900)[:, 0][which]
    light = np.clip(gap / 4, 0, 1) ** 0.6 * (0.55 + 0.45 * tone)
    sand = np.array([196, 172, 128]) + (8 * noise(side, 0.6, "sand") + 6 * noise(side, 3, "drift"))[..., None]
    stones = 30 + light[..., None] * [170, 165, 158]
    color = np.choose(label[..., None], (grass(side).astype(float), sand, stones))
    return np.clip(gaussian_filter(color, (0.4, 0.4, 0)), 0, 255).astype(np.uint8), label.astype(np.uint8)
