"""Text mesh files as arrays of bytes: lines, first words and numbers, without a loop over lines."""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from surftex.errors import MeshFileError
from surftex.files.reading import printable


class TextLines:
    r"""The lines of a text file; comments from ``#`` are blank, and a ``\`` at a line's end joins the next.

    Parameters
    ----------
    data : bytes
        The file.
    where : str
        Its name for messages.
    """

    def __init__(self, data: bytes, where: str) -> None:
        self.where = where
        if data[:2] in (b"\xff\xfe", b"\xfe\xff") or b"\0" in data:
            kind = "UTF-16 text" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "binary data"
            raise MeshFileError(f"{where}: holds {kind}; save it as plain (ASCII or UTF-8) text")
        if data[:3] == b"\xef\xbb\xbf":
            data = b"   " + data[3:]
        if b"\n" not in data:
            data = data.replace(b"\r", b"\n")
        if b"\\\n" in data or b"\\\r\n" in data:
            data = _joined(data)
        if not data.endswith(b"\n"):
            data += b"\n"
        self.data = data
        text = np.frombuffer(data, np.uint8)
        breaks = text == 10
        self.end = np.flatnonzero(breaks)
        self.start = np.concatenate([[0], self.end[:-1] + 1])
        if b"#" in data:
            text = self._without_comments(text)
        self.text = text
        self.blank = (text == 32) | ((text >= 9) & (text <= 13))

    def __len__(self) -> int:
        return len(self.end)

    def _without_comments(self, text: NDArray[np.uint8]) -> NDArray[np.uint8]:
        marks = np.flatnonzero(text == 35)
        line = np.searchsorted(self.end, marks)
        first = np.concatenate([[True], line[1:] != line[:-1]])
        step = np.zeros(len(text) + 1, np.int8)
        step[marks[first]] = 1
        step[self.end[line[first]]] -= 1
        return np.where(np.cumsum(step[:-1], dtype=np.int8) > 0, np.uint8(32), text)

    @cached_property
    def token(self) -> NDArray[np.int64]:
        """Offsets where words begin."""
        begins = ~self.blank
        begins[1:] &= self.blank[:-1]
        return np.flatnonzero(begins)

    @cached_property
    def token_start(self) -> NDArray[np.int64]:
        """(lines+1,) index into `token` of each line's first word."""
        return np.append(np.searchsorted(self.token, self.start), len(self.token))

    @cached_property
    def tokens(self) -> NDArray[np.int64]:
        """(lines,) number of words."""
        return np.diff(self.token_start)

    @cached_property
    def first(self) -> NDArray[np.int64]:
        """(lines,) offset of the first word; the line's end where it has none."""
        padded = np.append(self.token, len(self.text) - 1)
        return np.where(self.tokens > 0, padded[self.token_start[:-1]], self.end)

    def starting(self, word: bytes) -> NDArray[np.int64]:
        """Lines whose first word is `word`.

        Parameters
        ----------
        word : bytes
            Such as ``b"v"``.

        Returns
        -------
        lines : (k,) int64
            Their indices, from 0.
        """
        last = len(self.text) - 1
        match = self.tokens > 0
        for k, byte in enumerate(word):
            match &= self.text[np.minimum(self.first + k, last)] == byte
        return np.flatnonzero(match & self.blank[np.minimum(self.first + len(word), last)])

    def content(self, line: int) -> str:
        """Words of a line, as they stand in the file.

        Parameters
        ----------
        line : int
            From 0.

        Returns
        -------
        text : str
            Stripped; may hold anything.
        """
        return self.data[self.start[line] : self.end[line]].decode("utf-8", "replace").strip()

    def bytes_of(self, lines: NDArray[np.int64], skip: int) -> NDArray[np.uint8]:
        """Text of some lines after their first word.

        Parameters
        ----------
        lines : (k,) int
            Ascending.
        skip : int
            Bytes of the first word, to be passed over.

        Returns
        -------
        text : (b,) uint8
            Comments blank, each line closed by a line feed.
        """
        first = self.first[lines] + skip
        length = np.maximum(self.end[lines] + 1 - first, 0)
        offset = np.arange(int(length.sum())) - np.repeat(np.cumsum(length) - length, length)
        return self.text[np.repeat(first, length) + offset]

    def numbers(
        self, lines: NDArray[np.int64], skip: int, least: int, what: str
    ) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Read the numbers of some lines.

        Parameters
        ----------
        lines : (k,) int
            Ascending.
        skip : int
            Bytes of the first word, to be passed over.
        least : int
            Numbers that each line must have.
        what : str
            What a line holds, for messages.

        Returns
        -------
        values : (c,) float64
            All of them in a row.
        start : (k+1,) int64
            Where each line's begin.

        Raises
        ------
        MeshFileError
            Naming the first line that has too few, or a word that is no number.
        """
        counts = self.tokens[lines] - (1 if skip else 0)
        start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        short = np.flatnonzero(counts < least)
        values = parse_floats(self.bytes_of(lines, skip).tobytes(), int(start[-1]))
        if values is None:
            raise self._not_a_number(lines, 1 if skip else 0, what)
        if len(short):
            line = int(lines[short[0]])
            raise MeshFileError(
                f"{self.where}: line {line + 1} has {int(counts[short[0]])} numbers, a {what} needs {least}"
            )
        return values, start

    def _not_a_number(self, lines: NDArray[np.int64], skip: int, what: str) -> MeshFileError:
        for line in lines.tolist():
            words = bytes(self.text[self.start[line] : self.end[line]]).split()[skip:]
            for word in words:
                if parse_floats(word, 1) is None:
                    shown = printable(word.decode("utf-8", "replace"), longest=40)
                    return MeshFileError(
                        f"{self.where}: line {line + 1}: {shown!r} is not a number (in a {what})"
                    )
        return MeshFileError(f"{self.where}: a {what} does not read as numbers")


def parse_floats(text: bytes, count: int) -> NDArray[np.float64] | None:
    """Read numbers parted by white space.

    Parameters
    ----------
    text : bytes
        ASCII.
    count : int
        Words in it.

    Returns
    -------
    values : (count,) float64 or None
        None if any word is no number.
    """
    if count == 0:
        return np.zeros(0)
    try:
        values = np.fromstring(text, sep=" ")
    except (ValueError, DeprecationWarning):
        return None
    return values if len(values) == count else None


def columns(values: NDArray[np.float64], start: NDArray[np.int64], width: int) -> NDArray[np.float64]:
    """First numbers of each run.

    Parameters
    ----------
    values : (c,) float64
        Runs one after another.
    start : (k+1,) int64
        Where they begin; each run has at least `width` numbers.
    width : int
        Numbers to keep.

    Returns
    -------
    table : (k, width) float64
        A row for each run.
    """
    if len(values) == width * (len(start) - 1):
        return values.reshape(-1, width)
    return values[start[:-1, None] + np.arange(width)]


def _joined(data: bytes) -> bytes:
    r"""Join lines that end in ``\`` with the next; empty ones take their place, so that line numbers hold."""
    result, held, empty = [], [], 0
    for line in data.replace(b"\r\n", b"\n").split(b"\n"):
        if line.endswith(b"\\"):
            held.append(line[:-1])
            empty += 1
            continue
        result.append(b" ".join([*held, line]))
        result.extend([b""] * empty)
        held, empty = [], 0
    result.append(b" ".join(held))
    return b"\n".join(result)
