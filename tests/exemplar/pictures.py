"""Small pictures to learn from, made here so that tests need no files."""

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

from surftex.randomness import stream


def pebbles(side=128, spacing=8.0, seed=1):
    """Rounded stones with dark gaps between, lit from the upper left; (side, side) uint8."""
    random = stream(seed, "test", "pebbles")
    count = int((side / spacing) ** 2 * 1.2)
    middle = side * random.uniform(count, 2)
    tone = random.uniform(count, 1, first=count)[:, 0]
    down, right = np.mgrid[:side, :side] + 0.5
    shift = side * np.array([(u, v) for u in (-1, 0, 1) for v in (-1, 0, 1)])
    tree = cKDTree((middle + shift[:, None]).reshape(-1, 2))
    near, which = tree.query(np.stack([right, down], axis=-1), k=2)
    gap = near[..., 1] - near[..., 0]
    owner = which[..., 0] % count
    height = np.sqrt(np.clip(gap / (0.5 * spacing), 0, 1))
    light = 0.5 + 0.35 * np.gradient(gaussian_filter(height, 0.7))[0] * spacing / 2
    grey = (0.25 + 0.5 * tone[owner]) * height + 0.25 * light * height
    return np.clip(255 * grey, 0, 255).astype(np.uint8)


def noise(side=96, seed=1, bands=None):
    """Independent pixels; (side, side) or (side, side, bands) uint8."""
    numbers = 255 * stream(seed, "test", "noise").uniform(side * side, bands or 1)
    return numbers.reshape((side, side) if bands is None else (side, side, bands)).astype(np.uint8)


def echo(side=128, right=7, down=3, seed=2):
    """Noise added to itself shifted: only one offset has anything to tell."""
    first = noise(side, seed).astype(float)
    return ((first + np.roll(first, (down, right), (0, 1))) / 2).astype(np.uint8)


def patches(side=128, size=7.0, labels=2, seed=4):
    """Blobs of labels of the same share; (side, side) uint8."""
    fields = stream(seed, "test", "patches").uniform(labels * side * side).reshape(labels, side, side)
    smooth = np.stack([gaussian_filter(each, size, mode="wrap") for each in fields])
    return smooth.argmax(axis=0).astype(np.uint8)


def cracks(side=192, cells=40, width=3.0, seed=5):
    """A net of thin lines: 1 where there is a crack; (side, side) uint8."""
    middle = side * stream(seed, "test", "cracks").uniform(cells, 2)
    down, right = np.mgrid[:side, :side] + 0.5
    shift = side * np.array([(u, v) for u in (-1, 0, 1) for v in (-1, 0, 1)])
    near = cKDTree((middle + shift[:, None]).reshape(-1, 2)).query(np.stack([right, down], axis=-1), k=2)[0]
    return (near[..., 1] - near[..., 0] < width).astype(np.uint8)


def patchwork(label, seed=6):
    """A texture for each label: darker and rougher the higher the label; (h, w) uint8."""
    numbers = stream(seed, "test", "patchwork").uniform(label.size)[:, 0].reshape(label.shape) - 0.5
    fine, coarse = 0.6 * numbers, 4.0 * gaussian_filter(numbers, 2.0, mode="wrap")
    tone = 210 - 70.0 * label + 60 * np.where(label % 2 == 0, coarse, fine)
    return np.clip(tone, 0, 255).astype(np.uint8)
