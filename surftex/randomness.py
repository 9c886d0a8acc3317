"""One seed, a named stream per use: adding hairs never moves the pores.

Every draw is a pure function of (seed, name, index), so neither threads, nor tiles, nor the order of a
batch can change it. Kernels take the stream's `key` and count for themselves (`surftex.kernels.random`).
"""

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Stream:
    """Random numbers by counter: draw `index` of a stream never depends on the draws before it."""

    key: int

    def uniform(self, count: int, columns: int = 1, *, first: int = 0) -> NDArray[np.float64]:
        """Draw rows of numbers in [0, 1).

        Parameters
        ----------
        count : int
            Rows.
        columns : int
            Numbers in a row; it is part of the stream's layout, so keep it fixed for one use.
        first : int
            Index of the first row.

        Returns
        -------
        numbers : (count, columns) float64
            Row i is the stream's row first + i, whatever was drawn before.
        """
        return self.at(np.arange(first * columns, (first + count) * columns)).reshape(count, columns)

    def at(self, counter: NDArray[np.integer]) -> NDArray[np.float64]:
        """Draw the numbers of some counters, in any order.

        Parameters
        ----------
        counter : (n,) int
            From 0 on.

        Returns
        -------
        numbers : (n,) float64
            In [0, 1).
        """
        counter = counter.astype(np.uint64)
        with np.errstate(over="ignore"):
            mixed = np.uint64(self.key) + (counter + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
            mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
            mixed = mixed ^ (mixed >> np.uint64(31))
        return (mixed >> np.uint64(11)).astype(np.float64) * 2.0**-53


def stream(seed: int, *names: str | int) -> Stream:
    """Open the stream of one use.

    Parameters
    ----------
    seed : int
        The user's seed; any whole number.
    *names : str or int
        What the numbers are for, from the general to the particular: ``"leather", "pores"``.

    Returns
    -------
    stream : Stream
        Its 64-bit key is a hash of seed and names.

    Examples
    --------
    >>> stream(7, "pores") == stream(7, "pores"), stream(7, "pores") == stream(7, "hairs")
    (True, False)
    """
    text = "\x1f".join([str(int(seed)), *map(str, names)])
    return Stream(int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "little"))
