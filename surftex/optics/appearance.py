"""From biology to what a renderer takes, for any number of texels: one look-up in a table."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import checked, checked_whole
from surftex.errors import InputError
from surftex.kernels.pool import slices
from surftex.optics.table import SkinTable, shipped_table
from surftex.optics.tissue import PARAMETERS, check_names, checked_biology
from surftex.words import sort_of

_SLICE = 65536


@dataclass(frozen=True, eq=False)
class SkinAppearance:
    """Render parameters of n pieces of skin.

    Attributes
    ----------
    base_color : (n, 3) float32
        Linear sRGB, 0 to 1; what the surface reflects is not part of it.
    roughness : (n,) float32
        Square root of the width of the GGX lobe.
    specular : (n,) float32
        Reflectance at normal incidence over 0.08, as principled shaders take it; 0.5 is glass.
    subsurface_weight : (n,) float32
        Share of the diffuse light that has wandered below the surface: all of it.
    subsurface_radius_mm : (n, 3) float32
        Mean free path for red, green and blue, for Christensen and Burley's profile.
    clamped : dict of str to int
        How many samples of each parameter were moved into the range of the table, which is one value where it has one
        node; only those that were.
    """

    base_color: NDArray[np.float32]
    roughness: NDArray[np.float32]
    specular: NDArray[np.float32]
    subsurface_weight: NDArray[np.float32]
    subsurface_radius_mm: NDArray[np.float32]
    clamped: dict[str, int]


def lookup(
    parameters: dict[str, Any], *, table: SkinTable | None = None, threads: int | None = None
) -> SkinAppearance:
    """Look up how skin looks.

    Parameters
    ----------
    parameters : dict of str to (n,) or scalar float
        Some of ``pheomelanin``, ``melanin``, ``epidermis_cm``, ``stratum_corneum_cm``, ``blood``,
        ``oxygenation``; what is missing has its usual value, what leaves its range is moved to the end.
    table : SkinTable, optional
        That of the package without it.
    threads : int, optional
        None means every core.

    Returns
    -------
    appearance : SkinAppearance
        Of as many samples as the longest array; about 5 million in a CPU-second.

    Raises
    ------
    InputError
        For a name that skin does not have, lengths that differ, numbers that are not finite, or what is no table.

    Examples
    --------
    >>> skin = lookup({"melanin": [0.02, 0.3], "blood": 0.02})
    >>> bool((skin.base_color[0] > skin.base_color[1]).all()), skin.base_color.shape
    (True, (2, 3))
    """
    from surftex.kernels.skintable import read_table

    check_names(parameters)
    table = shipped_table() if table is None else table
    if not isinstance(table, SkinTable):
        raise InputError(f"table is {sort_of(table)}; it takes what load_table has read")
    if threads is not None:
        threads = checked_whole(threads, "threads", 1)
    with np.errstate(over="ignore"):  # infinite as float32: beyond the range, and counted so
        given = {name: checked(value, name, _shape(value), np.float32) for name, value in parameters.items()}
    lengths = {name: len(value) for name, value in given.items() if value.ndim}
    count = next(iter(lengths.values()), 1)
    for name, length in lengths.items():
        if length != count:
            raise InputError(f"{name} holds {length} samples where {next(iter(lengths))} holds {count}")
    value = np.zeros((len(PARAMETERS), count), np.float32)
    for row, (name, parameter) in zip(value, PARAMETERS.items(), strict=True):
        row[:] = given.get(name, np.float32(parameter.usual))
    out, grid = np.zeros((count, 8), np.float32), table.grid
    size = np.array(grid.shape[:-1])

    def work(first: int, last: int) -> NDArray[np.int64]:
        beyond = np.zeros(len(PARAMETERS), np.int64)
        read_table(grid.ravel(), size, table.bounds, value[:, first:last], out[first:last], beyond)
        return beyond

    beyond = np.sum(slices(work, count, size=_SLICE, threads=threads) or np.zeros((1, 6), np.int64), axis=0)
    clamped = {name: int(n) for name, n in zip(PARAMETERS, beyond, strict=True) if n}
    whole = np.ones(count, np.float32)
    return SkinAppearance(out[:, :3], out[:, 3], out[:, 4], whole, out[:, 5:], clamped)


def _shape(value: Any) -> tuple[None, ...]:
    """Shape that one parameter may have: (n,), or that of one number."""
    return (None,) if isinstance(value, (list, tuple)) or np.ndim(value) else ()


def skin_color(**biology: float) -> NDArray[np.float64]:
    """Colour of skin of a given biology, in daylight.

    Parameters
    ----------
    **biology : float
        Some of ``melanin``, ``blood``, ``pheomelanin``, ``oxygenation``, ``stratum_corneum_cm``, ``epidermis_cm``.

    Returns
    -------
    color : (3,) float64
        Linear sRGB, without what the surface reflects.

    Raises
    ------
    InputError
        For an unknown name, or a value outside its range.

    Examples
    --------
    >>> pale, dark = skin_color(melanin=0.01), skin_color(melanin=0.3)
    >>> bool((pale > dark).all())
    True
    """
    return lookup(dict(checked_biology(biology)), threads=1).base_color[0].astype(np.float64)
