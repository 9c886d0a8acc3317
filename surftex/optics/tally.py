"""How many samples left their range, over all look-ups of a bake, whatever thread made them."""

from collections import Counter
from threading import Lock

from surftex.optics.appearance import SkinAppearance


class RangeTally:
    """Adds up `SkinAppearance.clamped`.

    Examples
    --------
    >>> from surftex.optics import lookup
    >>> tally = RangeTally()
    >>> for melanin in (0.02, 0.9, 0.8):
    ...     tally.add(lookup({"melanin": melanin}))
    >>> tally.counts()
    {'melanin': 2}
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._counts: Counter[str] = Counter()

    def add(self, skin: SkinAppearance) -> None:
        """Count what a look-up has moved.

        Parameters
        ----------
        skin : SkinAppearance
            Of one look-up.
        """
        if skin.clamped:
            with self._lock:
                self._counts.update(skin.clamped)

    def counts(self) -> dict[str, int]:
        """Tell the counts so far.

        Returns
        -------
        counts : dict of str to int
            Samples moved into their range, by parameter, in order of names; empty where none was.
        """
        with self._lock:
            return dict(sorted(self._counts.items()))
