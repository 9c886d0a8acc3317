"""Pictures side by side, with a line of text below each."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError


def contact_sheet(
    images: Sequence[NDArray[Any]],
    labels: Sequence[str] = (),
    *,
    columns: int | None = None,
    gap: int = 12,
    background: int = 255,
) -> NDArray[np.uint8]:
    """Lay pictures out in rows.

    Parameters
    ----------
    images : sequence of (h, w, 3) or (h, w) uint8
        Of any sizes; each gets a cell of the largest.
    labels : sequence of str
        One for each picture, or none.
    columns : int, optional
        Pictures in a row; without it about as many as rows.
    gap : int
        Pixels between them.
    background : int
        Grey behind them, 0 to 255.

    Returns
    -------
    sheet : (height, width, 3) uint8
        sRGB codes.

    Raises
    ------
    InputError
        If there are no pictures, or labels for other than all of them.
    """
    if not images or (labels and len(labels) != len(images)):
        raise InputError(
            f"a sheet takes pictures and as many labels; these are {len(images)} and {len(labels)}"
        )
    tiles = [
        np.repeat(image[..., None], 3, axis=2) if image.ndim == 2 else image[..., :3] for image in images
    ]
    columns = columns or int(np.ceil(np.sqrt(len(tiles))))
    rows = -(-len(tiles) // columns)
    high, wide = max(t.shape[0] for t in tiles), max(t.shape[1] for t in tiles)
    text = 30 if labels else 0
    sheet = np.full((rows * (high + text + gap) + gap, columns * (wide + gap) + gap, 3), background, np.uint8)
    for number, tile in enumerate(tiles):
        top = gap + number // columns * (high + text + gap)
        left = gap + number % columns * (wide + gap)
        sheet[top : top + tile.shape[0], left : left + tile.shape[1]] = tile
        if labels:
            ink = written(labels[number], 2)[:, :wide]
            spot = sheet[top + high + 8 : top + high + 8 + ink.shape[0], left : left + ink.shape[1]]
            spot[ink] = 20 if background > 127 else 235
    return sheet


_GLYPHS = [
    "000000000000000",
    "010010010000010",
    "101101000000000",
    "101111101111101",
    "011110011110010",
    "101001010100101",
    "010101010101011",
    "010010000000000",
    "001010010010001",
    "100010010010100",
    "000101010101000",
    "000010111010000",
    "000000000010100",
    "000000111000000",
    "000000000000010",
    "001001010100100",
    "111101101101111",
    "010110010010111",
    "111001111100111",
    "111001111001111",
    "101101111001001",
    "111100111001111",
    "111100111101111",
    "111001010010010",
    "111101111101111",
    "111101111001111",
    "000010000010000",
    "000010000010100",
    "001010100010001",
    "000111000111000",
    "100010001010100",
    "111001011000010",
    "111101101100111",
    "010101111101101",
    "110101110101110",
    "011100100100011",
    "110101101101110",
    "111100110100111",
    "111100110100100",
    "011100101101011",
    "101101111101101",
    "111010010010111",
    "001001001101010",
    "101101110101101",
    "100100100100111",
    "101111111101101",
    "110101101101101",
    "010101101101010",
    "110101110100100",
    "010101101110011",
    "110101110101101",
    "011100010001110",
    "111010010010010",
    "101101101101111",
    "101101101101010",
    "101101111111101",
    "101101010101101",
    "101101010010010",
    "111001010100111",
    "110100100100110",
    "100100010001001",
    "011001001001011",
    "010101000000000",
    "000000000000111",
]


def written(text: str, scale: int = 2) -> NDArray[np.bool_]:
    """Draw a line of text with a tiny built-in alphabet of capitals.

    Parameters
    ----------
    text : str
        Letters become capitals; what the alphabet lacks becomes a question mark.
    scale : int
        Pixels for each dot.

    Returns
    -------
    ink : (5 * scale, 4 * scale * n) bool
        True where there is ink.
    """
    places = [ord(letter) - 32 if 32 <= ord(letter) < 96 else 31 for letter in text.upper()]
    ink = np.zeros((5, 4 * len(places)), bool)
    for number, place in enumerate(places):
        dots = np.array([dot == "1" for dot in _GLYPHS[place]]).reshape(5, 3)
        ink[:, 4 * number : 4 * number + 3] = dots
    return np.kron(ink, np.ones((scale, scale), bool))
