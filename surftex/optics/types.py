"""The six classes of skin by typology angle: what was measured, and the biology that fits it best.

`docs/make_skin_types.py` makes the fits and prints what they leave unexplained.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.optics.spectra import table_rows
from surftex.optics.tissue import PARAMETERS


@dataclass(frozen=True, eq=False)
class SkinType:
    """A class of skin.

    Attributes
    ----------
    name : str
        Of the class, as in `surftex.optics.colour.TYPES`.
    spectra : int
        How many were averaged.
    nm, reflectance : (k,) float64
        The mean, with what the surface reflects (d/8 sphere, specular included).
    biology : dict of str to float
        The fit: all parameters, for ``lookup``.
    rmse : float
        What it leaves unexplained of the reflectance, at most 0.010.
    """

    name: str
    spectra: int
    nm: NDArray[np.float64]
    reflectance: NDArray[np.float64]
    biology: dict[str, float]
    rmse: float


def skin_types() -> dict[str, SkinType]:
    """List the classes.

    Returns
    -------
    types : dict of str to SkinType
        From dark to very light.
    """
    head, *measured = table_rows("skin_types.csv")
    names, *fitted = table_rows("skin_fits.csv")
    nm, types = np.array(head[2:], np.float64), {}
    fits = {row[0]: dict(zip(names[1:], map(float, row[1:]), strict=True)) for row in fitted}
    for name, spectra, *reflectance in measured:
        fit = fits[name]
        biology = {each: fit.get(each, PARAMETERS[each].usual) for each in PARAMETERS}
        types[name] = SkinType(
            name, int(spectra), nm, np.array(reflectance, np.float64), biology, fit["rmse"]
        )
    return types


def skin_type(name: str) -> dict[str, float]:
    """Biology of a class of skin.

    Parameters
    ----------
    name : str
        Such as ``"tan"``.

    Returns
    -------
    biology : dict of str to float
        All parameters; a fit to mean spectra, not a measurement.

    Raises
    ------
    InputError
        Listing the known classes.

    Examples
    --------
    >>> skin_type("dark")["melanin"] > 5 * skin_type("light")["melanin"]
    True
    """
    types = skin_types()
    if not isinstance(name, str) or name not in types:
        raise InputError(f"there is no skin type {name!r}; known are {', '.join(types)}")
    return types[name].biology
