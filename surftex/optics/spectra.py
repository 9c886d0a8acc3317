"""Tables of the package: what absorbs light in skin, and what light of each wavelength gives to a colour."""

from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, frozen
from surftex.errors import InputError

SHORTEST_NM, LONGEST_NM = 380.0, 780.0


def table_rows(name: str) -> list[list[str]]:
    """Read a table of the package.

    Parameters
    ----------
    name : str
        Of the file.

    Returns
    -------
    rows : list of list of str
        The first holds the names of the columns; lines that start with # tell where the rest comes from.
    """
    text = files("surftex.optics").joinpath("data", name).read_text("utf-8")
    return [line.split(",") for line in text.splitlines() if not line.startswith("#")]


@cache
def _table(name: str) -> tuple[list[str], NDArray[np.float64]]:
    names, *rows = table_rows(name)
    return names, frozen(np.array(rows, np.float64))


def chromophore(name: str, nm: ArrayLike) -> NDArray[np.float64]:
    """Read how strongly a pigment takes up light; linear between the table's 10 nm.

    Parameters
    ----------
    name : str
        ``oxyhaemoglobin``, ``haemoglobin``, ``bilirubin``, ``carotene``: 1/(cm M); ``eumelanin``,
        ``pheomelanin``: L/(g cm).
    nm : (k,) float
        Wavelengths, 380 to 780.

    Returns
    -------
    extinction : (k,) float64
        Sources are in ``data/chromophores.csv``.
    """
    names, rows = _table("chromophores.csv")
    return np.interp(np.asarray(nm, np.float64), rows[:, 0], rows[:, names.index(name)])


def rgb_weights(nm: ArrayLike) -> NDArray[np.float64]:
    """Weigh reflectances at some wavelengths to linear sRGB in daylight.

    Parameters
    ----------
    nm : (k,) float
        Ascending, 380 to 780; at least one.

    Returns
    -------
    weights : (k, 3) float64
        ``reflectance @ weights`` is the colour of a reflectance that is linear between the wavelengths and
        constant outside; each column sums to 1, so that white is (1, 1, 1).

    Raises
    ------
    InputError
        If the wavelengths do not ascend within the tables.
    """
    nm = checked(nm, "nm", (None,), np.float64)
    if not len(nm) or (np.diff(nm) <= 0).any() or nm[0] < SHORTEST_NM or nm[-1] > LONGEST_NM:
        raise InputError(f"nm must ascend from {SHORTEST_NM:g} to {LONGEST_NM:g} at most; got {nm}")
    _, rows = _table("colour_weights.csv")
    hats = np.stack([np.interp(rows[:, 0], nm, one) for one in np.eye(len(nm))])
    weights = hats @ rows[:, 1:]
    return weights / weights.sum(0)
