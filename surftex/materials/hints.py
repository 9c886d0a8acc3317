"""Hints for a mistyped name."""

from collections.abc import Iterable
from difflib import SequenceMatcher, get_close_matches


def nearest(name: str, known: Iterable[str]) -> str:
    """Suggest what a wrong name may have meant.

    Parameters
    ----------
    name : str
        As typed.
    known : iterable of str
        What would have been right.

    Returns
    -------
    hint : str
        To append to a message: the nearest names, or the list when it is short and none is near.

    Examples
    --------
    >>> nearest("claf", ["calf", "goat"])
    '; did you mean calf?'
    """
    names = list(known)
    near = get_close_matches(name, names, 3, 0.6)
    if near and SequenceMatcher(None, name, near[0]).ratio() > 0.8:
        return f"; did you mean {near[0]}?"
    if near:
        return f"; did you mean {' or '.join(near)}?"
    return f"; known are {', '.join(names)}" if 0 < len(names) <= 24 else ""
