"""Words that go with a number."""


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
