"""Light from all around, as a picture: the soft boxes of a `Studio`, its ceiling and its floor."""

import numpy as np
from numpy.typing import NDArray

from surftex.preview.studio import Studio

_FRONT = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]])
"""Right, up and outward of the room."""


def environment(studio: Studio, height: int = 256) -> NDArray[np.float32]:
    """Draw a room as longitude and latitude.

    Parameters
    ----------
    studio : Studio
        Its boxes are placed as seen from the front, +z.
    height : int
        Rows; there are twice as many columns.

    Returns
    -------
    picture : (height, 2 height, 3) float32
        Linear radiance; row 0 looks up, +y; the middle column looks to the front, +z, the one right of it towards +x.
    """
    row, column = np.mgrid[0:height, 0 : 2 * height]
    up = np.cos((row + 0.5) / height * np.pi)
    flat = np.sqrt(1 - up**2)
    turn = ((column + 0.5) / height - 1) * np.pi
    direction = np.stack([flat * np.sin(turn), up, flat * np.cos(turn)], axis=2)
    edge = 0.5 + 0.5 * np.tanh(up / 0.35)
    picture = np.repeat((studio.below + (studio.above - studio.below) * edge)[..., None], 3, axis=2)
    for box in studio.boxes:
        towards = np.asarray(box.towards, float) @ _FRONT
        towards /= np.linalg.norm(towards)
        right = np.cross([0.0, 1.0, 0.0], towards)
        right /= np.linalg.norm(right)
        ahead = direction @ towards
        safe = np.maximum(ahead, 0.05)
        across, along = direction @ right / safe, direction @ np.cross(towards, right) / safe
        inside = (ahead > 0.05) * _edge(across, box.half[0]) * _edge(along, box.half[1])
        radiance = box.strength * np.pi / (4 * box.half[0] * box.half[1])
        picture += (inside * radiance)[..., None] * np.asarray(box.color)
    return (studio.exposure * picture).astype(np.float32)


def _edge(place: NDArray[np.float64], half: float) -> NDArray[np.float64]:
    """1 within a box, 0 outside, softly over its rim."""
    return np.clip((half - np.abs(place)) / (0.25 * half) + 0.5, 0, 1)
