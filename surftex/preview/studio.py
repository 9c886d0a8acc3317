"""Lamps: soft boxes with straight edges, and a dim room around them, placed relative to the camera.

A box lights the diffuse part through a handful of far lamps spread over it, each with a shadow; its mirror
image is the box blurred by the roughness, a product of error functions.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.errors import RecipeError


@dataclass(frozen=True)
class SoftBox:
    """A bright rectangle, far away.

    Attributes
    ----------
    towards : (3,) tuple
        Direction: right, up, and to the camera.
    half : (2,) tuple
        Half width and half height, as tangents of angles.
    strength : float
        Irradiance over pi on a plane that faces it: a white one is as bright.
    color : (3,) tuple
        Linear, mean about 1.
    lamps : int
        Lamps that stand for it.
    """

    towards: tuple[float, float, float]
    half: tuple[float, float]
    strength: float
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    lamps: int = 16


@dataclass(frozen=True)
class Studio:
    """Boxes, and the room: brightness above and below, as radiance.

    Attributes
    ----------
    boxes : tuple of SoftBox
        The lamps.
    above : float
        Radiance of the ceiling.
    below : float
        Radiance of the floor.
    exposure : float
        Factor on everything.
    grazes : bool
        Whether the boxes stand around what is seen, wherever it faces, or around the camera.
    """

    boxes: tuple[SoftBox, ...]
    above: float
    below: float
    exposure: float = 1.0
    grazes: bool = False


STUDIOS = {
    "studio": Studio(
        (
            SoftBox((-0.72, 0.95, 0.62), (0.30, 0.30), 0.92, (1.0, 0.97, 0.93), 25),
            SoftBox((1.0, 0.35, 0.30), (0.16, 0.8), 0.26, (0.95, 0.97, 1.0), 16),
            SoftBox((0.40, 0.60, -0.9), (0.25, 0.7), 0.50, (1.0, 1.0, 1.0), 9),
        ),
        above=0.24,
        below=0.10,
    ),
    "portrait": Studio(
        (
            SoftBox((-0.55, 0.55, 0.80), (0.45, 0.45), 1.05, (1.0, 0.97, 0.93), 25),
            SoftBox((0.9, 0.15, 0.55), (0.3, 0.8), 0.38, (0.97, 0.98, 1.0), 16),
            SoftBox((0.40, 0.60, -0.9), (0.25, 0.7), 0.6, (1.0, 1.0, 1.0), 9),
        ),
        above=0.3,
        below=0.16,
        exposure=1.25,
    ),
    "raking": Studio(
        (
            SoftBox((-1.0, 0.34, 0.26), (0.12, 0.18), 1.9, (1.0, 0.98, 0.95), 48),
            SoftBox((0.7, 0.5, 0.8), (0.6, 0.6), 0.08, (0.95, 0.97, 1.0), 12),
        ),
        above=0.09,
        below=0.05,
        grazes=True,
    ),
}
"""Lights by name: ``studio`` flatters products, ``portrait`` faces; ``raking`` grazes what is seen and shows its relief."""


def studio_named(light: "str | Studio") -> Studio:
    """Look up a light.

    Parameters
    ----------
    light : str or Studio
        Name in `STUDIOS`, or lamps of one's own.

    Returns
    -------
    studio : Studio
        The lamps.

    Raises
    ------
    RecipeError
        If there is no light of that name.
    """
    if isinstance(light, Studio):
        return light
    if light not in STUDIOS:
        raise RecipeError(f"no light {light!r}; known are {', '.join(STUDIOS)}")
    return STUDIOS[light]


@dataclass(frozen=True, eq=False)
class Lamps:
    """Far lamps that stand for the boxes and for the room.

    Attributes
    ----------
    frame : (l, 3, 3) float64
        Right, up and towards each lamp.
    share : (l,) float64
        Irradiance over pi on a plane that faces it.
    group : (l,) int32
        Box of each; the room is the last group.
    box : (b, 3, 3) float64
        Right, up and towards each box.
    """

    frame: NDArray[np.float64]
    share: NDArray[np.float64]
    group: NDArray[np.int32]
    box: NDArray[np.float64]


def lamps_of(studio: Studio, view: NDArray[np.float64], up: NDArray[np.float64], *, room: int = 72) -> Lamps:
    """Place the lamps.

    Parameters
    ----------
    studio : Studio
        What to place.
    view : (3, 3) float
        Right, up and backward of the camera, as rows.
    up : (3,) float
        Where the ceiling is.
    room : int
        Lamps for the room.

    Returns
    -------
    lamps : Lamps
        In the space of the scene.
    """
    frames, shares, groups, boxes = [], [], [], []
    for number, box in enumerate(studio.boxes):
        towards = _unit(np.asarray(box.towards) @ view)
        frame = _frame(towards, up)
        boxes.append(frame)
        for place in _scattered(box.lamps) * box.half:
            frames.append(_frame(_unit(towards + place @ frame[:2]), up))
            shares.append(box.strength / box.lamps)
            groups.append(number)
    turn = np.arange(room) * np.pi * (3 - 5**0.5)
    height = 1 - 2 * (np.arange(room) + 0.5) / room
    flat = np.sqrt(1 - height**2)
    side = _frame(up, view[2])
    for x, y, z in zip(flat * np.cos(turn), flat * np.sin(turn), height, strict=True):
        frames.append(_frame(_unit(x * side[0] + y * side[1] + z * up), view[2]))
        shares.append(4 / room * (studio.below + (studio.above - studio.below) * (0.5 + 0.5 * z)))
        groups.append(len(studio.boxes))
    return Lamps(np.array(frames), np.array(shares), np.array(groups, np.int32), np.array(boxes))


def _scattered(count: int) -> NDArray[np.float64]:
    """Places in a disk as large as the square from -1 to 1, few of them in line: shadows of those would meet in steps."""
    number = np.arange(count)
    turn, away = number * np.pi * (3 - 5**0.5), np.sqrt((number + 0.5) / count * 4 / np.pi)
    return np.stack([away * np.cos(turn), away * np.sin(turn)], axis=1)


def mirrored(
    studio: Studio,
    lamps: Lamps,
    up: NDArray[np.float64],
    direction: NDArray[np.float32],
    spread: NDArray[np.float32],
) -> list[NDArray[np.float32]]:
    """Brightness of boxes and room in mirror directions, blurred.

    Parameters
    ----------
    studio : Studio
        Brightness and size.
    lamps : Lamps
        Where the boxes are.
    up : (3,) float
        Where the ceiling is.
    direction : (n, 3) float32
        Unit vectors.
    spread : (n,) float32
        Standard deviation of the lobe, as a tangent.

    Returns
    -------
    radiance : list of (n,) float32
        For each box, then for the room.
    """
    from scipy.special import erf

    result = []
    for box, frame in zip(studio.boxes, lamps.box.astype(np.float32), strict=True):
        ahead = direction @ frame[2]
        safe = np.maximum(ahead, 0.05)
        x, y = direction @ frame[0] / safe, direction @ frame[1] / safe
        total = np.zeros(len(direction), np.float32)
        for share, wide in ((0.78, 1.0), (0.22, 2.8)):
            narrow = 1 / (np.sqrt(2, dtype=np.float32) * np.float32(wide) * spread)
            across = erf((x + box.half[0]) * narrow) - erf((x - box.half[0]) * narrow)
            along = erf((y + box.half[1]) * narrow) - erf((y - box.half[1]) * narrow)
            total += np.float32(0.25 * share) * across * along
        radiance = box.strength * np.pi / (4 * box.half[0] * box.half[1])
        result.append(np.where(ahead > 0.05, total * np.float32(radiance), 0).astype(np.float32))
    height = direction @ up.astype(np.float32)
    edge = 0.5 + 0.5 * np.tanh(height / (0.15 + spread))
    result.append((studio.below + (studio.above - studio.below) * edge).astype(np.float32))
    return result


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return vector / np.linalg.norm(vector)


def _frame(towards: NDArray[np.float64], up: NDArray[np.float64]) -> NDArray[np.float64]:
    """Right, up and towards a lamp."""
    right = np.cross(up, towards)
    if np.linalg.norm(right) < 1e-6:
        right = np.cross(np.array([0.31, 0.77, 0.55]), towards)
    right = _unit(right)
    return np.stack([right, np.cross(towards, right), towards])
