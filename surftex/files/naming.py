"""Names for nodes and prims: letters, digits and underscores, each once."""

from itertools import count


def own_identifier(name: str, taken: set[str]) -> str:
    """Turn a name into one that every format takes and that nobody has yet, and take it.

    Parameters
    ----------
    name : str
        Of a part or a file: anything.
    taken : set of str
        Names that are taken; the new one is added.

    Returns
    -------
    identifier : str
        ASCII; begins with no digit; with a number behind where it was taken.

    Examples
    --------
    >>> taken = set()
    >>> own_identifier("2nd sole", taken), own_identifier("2nd-sole", taken)
    ('_2nd_sole', '_2nd_sole_1')
    """
    plain = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in name)
    plain = plain if plain and not plain[0].isdigit() else f"_{plain}"
    free = next(each for k in count() if (each := f"{plain}_{k}" if k else plain) not in taken)
    taken.add(free)
    return free
