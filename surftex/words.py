"""Numbers as a reader likes them, the words that go with one, and what to call a value of Python."""

import math


def by_count(count: int, one: str, many: str) -> str:
    """Say how many, in the singular where it is one.

    Parameters
    ----------
    count : int
        How many.
    one : str
        What is said of one; ``{}`` stands for the number, ``{:,}`` parts its thousands.
    many : str
        What is said of none, and of several.

    Returns
    -------
    text : str
        With the number.

    Examples
    --------
    >>> by_count(1, "{} vertex was split", "{} vertices were split")
    '1 vertex was split'
    >>> by_count(1200, "{:,} vertex was split", "{:,} vertices were split")
    '1,200 vertices were split'
    """
    return (one if count == 1 else many).format(count)


def plain(number: float, digits: int = 3) -> str:
    """Write a number without a power of ten, unless it is tiny.

    Parameters
    ----------
    number : float
        Finite.
    digits : int
        How many count.

    Returns
    -------
    text : str
        Thousands are parted by commas.

    Examples
    --------
    >>> plain(2254.3), plain(0.65, 4), plain(40.0), plain(1.5e-7)
    ('2,250', '0.65', '40', '1.5e-07')
    """
    if abs(number) < 1e-4:
        return f"{number:.{digits}g}"
    places = digits - 1 - math.floor(math.log10(abs(number)))
    text = f"{round(number, places):,.{max(places, 0)}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def sort_of(value: object) -> str:
    """Say what sort of thing was given, where another was wanted.

    Parameters
    ----------
    value : object
        Whatever it is.

    Returns
    -------
    text : str
        Its type, with an article.

    Examples
    --------
    >>> sort_of(3), sort_of([]), sort_of(None), sort_of(dict)
    ('an int', 'a list', 'None', 'the class dict')
    """
    if value is None or isinstance(value, type):
        return "None" if value is None else f"the class {value.__name__}"
    name = {"ndarray": "array", "str": "string"}.get(type(value).__name__, type(value).__name__)
    return f"{'an' if name[0] in 'aeiouAEIOU' else 'a'} {name}"
