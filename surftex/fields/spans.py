"""Spans: the least and the greatest value that a field can have on each face, by interval arithmetic [1]_.

A span may be wider than what the field really does; it is never narrower. Points are drawn below a span's
upper end and then thinned, so a wide span costs darts and never density.

References
----------
.. [1] Moore, Kearfott, Cloud. Introduction to Interval Analysis. SIAM (2009).
"""

import itertools
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Span = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Lower and upper ends, (m,) or () each, never NaN; an end may be infinite."""

_SMALL_PX = 0.5
"""Size of pieces that are not cut any further."""

SpanRule = Callable[..., Span]
"""From the spans of some arguments to the span of a function of them."""


def constant(value: float) -> Span:
    """Give the span of a number.

    Parameters
    ----------
    value : float
        Finite.

    Returns
    -------
    span : Span
        Both ends are it.
    """
    number = np.asarray(value, np.float64)
    return number, number


def at_corners(function: Callable[..., NDArray]) -> SpanRule:
    """Make the rule of a function that only rises or only falls with each of its arguments.

    Parameters
    ----------
    function : callable
        Of arrays; its extremes over a box are at the corners of the box.

    Returns
    -------
    rule : SpanRule
        Its span. Where a corner has no value, nothing is known.
    """

    def rule(*spans: Span) -> Span:
        values = [np.asarray(function(*corner), np.float64) for corner in itertools.product(*spans)]
        unknown = np.any([np.isnan(value) for value in values], axis=0)
        low = np.where(unknown, -np.inf, np.minimum.reduce(np.broadcast_arrays(*values)))
        high = np.where(unknown, np.inf, np.maximum.reduce(np.broadcast_arrays(*values)))
        return low, high

    return rule


def multiply(a: Span, b: Span) -> Span:
    """Span of a product; 0 times what has no end is 0, as no value is infinite.

    Parameters
    ----------
    a : Span
        One factor.
    b : Span
        The other.

    Returns
    -------
    span : Span
        Of a times b.
    """

    def product(x: NDArray, y: NDArray) -> NDArray:
        return np.where((x == 0) | (y == 0), 0.0, x * y)

    return at_corners(product)(a, b)


def divide(a: Span, b: Span) -> Span:
    """Span of a quotient; without ends where the divisor may be 0.

    Parameters
    ----------
    a : Span
        What is divided.
    b : Span
        The divisor.

    Returns
    -------
    span : Span
        Of a / b.
    """
    through = (b[0] <= 0) & (b[1] >= 0)
    low, high = at_corners(np.divide)(a, tuple(np.where(through, 1.0, end) for end in b))
    return np.where(through, -np.inf, low), np.where(through, np.inf, high)


def power(a: Span, b: Span) -> Span:
    """Span of a power.

    Parameters
    ----------
    a : Span
        The base.
    b : Span
        The exponent.

    Returns
    -------
    span : Span
        Of a ** b; without ends for bases below 0, except under one whole exponent.
    """
    whole = (b[0] == b[1]) & (np.floor(b[0]) == b[0]) & (b[0] >= 0)
    low, high = at_corners(np.power)(a, b)
    even = whole & (np.mod(np.where(np.isfinite(b[0]), b[0], 1.0), 2) == 0) & (a[0] < 0) & (a[1] > 0)
    low = np.where(even, np.where(b[0] == 0, 1.0, 0.0), low)
    unknown = (a[0] < 0) & ~whole
    zero = (a[0] <= 0) & (b[0] < 0)
    return np.where(unknown | zero, -np.inf, low), np.where(unknown | zero, np.inf, high)


def equal(a: Span, b: Span) -> Span:
    """Span of a comparison for equality.

    Parameters
    ----------
    a : Span
        One side.
    b : Span
        The other.

    Returns
    -------
    span : Span
        0 where the two cannot meet, 1 where both are one and the same number, else 0 to 1.
    """
    sure = (a[0] == a[1]) & (b[0] == b[1]) & (a[0] == b[0])
    apart = (a[1] < b[0]) | (b[1] < a[0])
    return np.where(sure, 1.0, 0.0), np.where(apart, 0.0, 1.0)


def negated(a: Span) -> Span:
    """Span of 1 where there is 0, and 0 elsewhere.

    Parameters
    ----------
    a : Span
        Of a truth.

    Returns
    -------
    span : Span
        Of its opposite.
    """
    low, high = truth(a)
    return 1 - high, 1 - low


def truth(a: Span) -> Span:
    """Span of 0 where there is 0, and 1 elsewhere.

    Parameters
    ----------
    a : Span
        Of any number.

    Returns
    -------
    span : Span
        Of its truth.
    """
    never, always = (a[0] == 0) & (a[1] == 0), (a[0] > 0) | (a[1] < 0)
    return np.where(always, 1.0, 0.0), np.where(never, 0.0, 1.0)


def chosen(condition: Span, a: Span, b: Span) -> Span:
    """Span of one of two.

    Parameters
    ----------
    condition : Span
        Of the truth that decides.
    a : Span
        Where it holds.
    b : Span
        Where it does not.

    Returns
    -------
    span : Span
        Of what is chosen.
    """
    low, high = truth(condition)
    first, second = high == 1, low == 0
    return (
        np.where(first & second, np.minimum(a[0], b[0]), np.where(first, a[0], b[0])),
        np.where(first & second, np.maximum(a[1], b[1]), np.where(first, a[1], b[1])),
    )


def absolute(a: Span) -> Span:
    """Span of a size.

    Parameters
    ----------
    a : Span
        Of any number.

    Returns
    -------
    span : Span
        From 0 on.
    """
    low, high = np.abs(a[0]), np.abs(a[1])
    return np.where((a[0] <= 0) & (a[1] >= 0), 0.0, np.minimum(low, high)), np.maximum(low, high)


def wave(a: Span) -> Span:
    """Span of a sine or a cosine.

    Parameters
    ----------
    a : Span
        Of the angle.

    Returns
    -------
    span : Span
        -1 to 1.
    """
    return np.full(np.shape(a[0]), -1.0), np.full(np.shape(a[0]), 1.0)


def root(a: Span) -> Span:
    """Span of a square root; bases below 0 have none and are refused where they occur.

    Parameters
    ----------
    a : Span
        Under the root.

    Returns
    -------
    span : Span
        From 0 on.
    """
    return np.sqrt(np.maximum(a[0], 0)), np.sqrt(np.maximum(a[1], 0))


def stepped(step: Callable[..., NDArray]) -> SpanRule:
    """Make the rule of a smooth step.

    Parameters
    ----------
    step : callable
        Of where it begins, where it ends, and the value.

    Returns
    -------
    rule : SpanRule
        0 to 1 where begin and end may meet.
    """

    def rule(low: Span, high: Span, value: Span) -> Span:
        meets = (low[0] <= high[1]) & (high[0] <= low[1]) & ~((low[0] == low[1]) & (high[0] == high[1]))
        least, most = at_corners(step)(low, high, value)
        return np.where(meets, 0.0, np.clip(least, 0, 1)), np.where(meets, 1.0, np.clip(most, 0, 1))

    return rule


def mixed(a: Span, b: Span, share: Span) -> Span:
    """Span of a mix of two.

    Parameters
    ----------
    a : Span
        Where the share is 0.
    b : Span
        Where it is 1.
    share : Span
        Any number.

    Returns
    -------
    span : Span
        Of a + (b - a) share.
    """
    return at_corners(lambda x, y, t: x + (y - x) * t)(a, b, share)


def over_corners(values: NDArray[np.float64]) -> Span:
    """Give the span of what is linear inside faces.

    Parameters
    ----------
    values : (m, 3) float64
        At the corners of each face.

    Returns
    -------
    span : Span
        Of each face.
    """
    return values.min(axis=1), values.max(axis=1)


class Pixels:
    """A picture, read bilinearly and repeated, with its extremes over blocks of 1, 2, 4, ... pixels.

    Parameters
    ----------
    pixels : (h, w) float64
        Row 0 on top.
    """

    def __init__(self, pixels: NDArray[np.float64]) -> None:
        self.shape = pixels.shape
        self._levels = [(pixels, pixels)]

    def over(self, corner_uv: NDArray[np.float64]) -> Span:
        """Give the span inside the triangles of an unwrap.

        Parameters
        ----------
        corner_uv : (m, 3, 2) float64
            v up.

        Returns
        -------
        span : Span
            Of every pixel in and around each triangle's box, or more.
        """
        height, width = self.shape
        first_column, last_column = _reached(corner_uv[..., 0] * width - 0.5, width)
        first_row, last_row = _reached((1 - corner_uv[..., 1]) * height - 0.5, height)
        size = np.maximum(last_column - first_column, last_row - first_row) + 1
        level = np.ceil(np.log2(np.maximum(size, 1))).astype(np.int64)
        low, high = np.full(len(corner_uv), np.inf), np.full(len(corner_uv), -np.inf)
        for each in range(int(level.max(initial=-1)) + 1):
            rows = np.flatnonzero(level == each)
            least, most = self._level(each)
            i, j = first_row[rows] >> each, first_column[rows] >> each
            for down, across in itertools.product((0, 1), (0, 1)):
                r = np.minimum(i + down, last_row[rows] >> each)
                c = np.minimum(j + across, last_column[rows] >> each)
                low[rows] = np.minimum(low[rows], least[r, c])
                high[rows] = np.maximum(high[rows], most[r, c])
        return low, high

    def within(self, corner_uv: NDArray[np.float64], most_pieces: int = 1 << 19) -> Span:
        """Give the span inside triangles, of the pixels along their sides and not of all in their boxes.

        Parameters
        ----------
        corner_uv : (m, 3, 2) float64
            v up.
        most_pieces : int
            Pieces of triangles that are looked at in a round; where there would be more, their boxes count.

        Returns
        -------
        span : Span
            At most as wide as that of `over`.
        """
        low, high = self.over(corner_uv)
        face = np.flatnonzero(low < high)
        piece = corner_uv[face]
        low[face], high[face] = np.inf, -np.inf
        while len(face):
            least, most = self.over(piece)
            size = np.ptp(piece, axis=1) * self.shape[::-1]
            cut = (least < most) & (size > _SMALL_PX).any(axis=1)
            if 4 * np.count_nonzero(cut) > most_pieces:
                cut[:] = False
            small = np.flatnonzero(~cut & (size <= _SMALL_PX).all(axis=1))
            least[small], most[small] = self._around(piece[small])
            np.minimum.at(low, face[~cut], least[~cut])
            np.maximum.at(high, face[~cut], most[~cut])
            whole, face = piece[cut], np.repeat(face[cut], 4)
            middle = (whole + np.roll(whole, -1, axis=1)) / 2
            corners = [np.stack([whole[:, i], middle[:, i], middle[:, i - 1]], axis=1) for i in range(3)]
            piece = np.stack([*corners, middle], axis=1).reshape(-1, 3, 2)
        return low, high

    def _around(self, corner_uv: NDArray[np.float64]) -> Span:
        """Extremes of the three by three pixels, at the most, that triangles of less than a pixel read."""
        height, width = self.shape
        pixels = self._levels[0][0]
        column = np.floor(corner_uv[..., 0] * width - 0.5).astype(np.int64)
        row = np.floor((1 - corner_uv[..., 1]) * height - 0.5).astype(np.int64)
        steps = itertools.product(range(3), range(3))
        read = [
            pixels[
                np.minimum(row.min(axis=1) + down, row.max(axis=1) + 1) % height,
                np.minimum(column.min(axis=1) + across, column.max(axis=1) + 1) % width,
            ]
            for down, across in steps
        ]
        return np.min(read, axis=0), np.max(read, axis=0)

    def _level(self, number: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        while len(self._levels) <= number:
            least, most = self._levels[-1]
            self._levels.append((_halved(least, np.minimum), _halved(most, np.maximum)))
        return self._levels[number]


def _reached(place: NDArray[np.float64], count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First and last pixel that are read; all of them where the picture's edge is crossed."""
    first = np.floor(place.min(axis=1)).astype(np.int64)
    last = np.floor(place.max(axis=1)).astype(np.int64) + 1
    shift = first // count * count
    crossed = last - shift >= count
    return np.where(crossed, 0, first - shift), np.where(crossed, count - 1, last - shift)


def _halved(pixels: NDArray[np.float64], combine: np.ufunc) -> NDArray[np.float64]:
    """Combine blocks of two by two; an odd row or column stands for itself."""
    pixels = combine(pixels[::2], np.concatenate([pixels[1::2], pixels[-1:]])[: len(pixels[::2])])
    other = np.concatenate([pixels[:, 1::2], pixels[:, -1:]], axis=1)[:, : pixels[:, ::2].shape[1]]
    return combine(pixels[:, ::2], other)
