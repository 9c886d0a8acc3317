"""How many samples left their range, over all look-ups of a bake, whatever thread made them."""

from collections import Counter
from collections.abc import Mapping
from threading import Lock


class RangeTally:
    """Adds up how many samples left their range, by parameter; any thread may add.

    Examples
    --------
    >>> from surftex.optics import lookup
    >>> tally = RangeTally()
    >>> for melanin in (0.02, 0.9, 0.8):
    ...     tally.add(lookup({"melanin": melanin}).clamped)
    >>> tally.counts()
    {'melanin': 2}
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._counts: Counter[str] = Counter()

    def add(self, clamped: Mapping[str, int]) -> None:
        """Count some more.

        Parameters
        ----------
        clamped : mapping of str to int
            Such as `SkinAppearance.clamped`.
        """
        with self._lock:
            self._counts.update({name: count for name, count in clamped.items() if count})

    def counts(self) -> dict[str, int]:
        """Tell the counts so far.

        Returns
        -------
        counts : dict of str to int
            Samples moved into their range, by parameter, in order of names; empty where none was.
        """
        with self._lock:
            return dict(sorted(self._counts.items()))
