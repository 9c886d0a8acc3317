"""What skin is made of: six parameters of biology that vary over a face, and what stays fixed around them.

Lengths are centimetres and coefficients 1/cm, as in the tables that they come from. Layers, from outside:
stratum corneum, epidermis, papillary dermis, reticular dermis, on a base that throws part of the light back.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked_number
from surftex.errors import InputError
from surftex.optics.spectra import chromophore
from surftex.words import sort_of

_LN10 = np.log(10.0)


@dataclass(frozen=True)
class Parameter:
    """A parameter of biology.

    Attributes
    ----------
    low, high : float
        Range that tables cover.
    usual : float
        What it is where nothing is said.
    even : bool
        Whether equal steps matter equally; else equal ratios do.
    meaning : str
        In a few words, with the unit.
    """

    low: float
    high: float
    usual: float
    even: bool
    meaning: str


PARAMETERS = {
    "pheomelanin": Parameter(0.0, 1.0, 0.13, True, "share of pheomelanin in the melanin"),
    "melanin": Parameter(0.002, 0.45, 0.02, False, "melanosomes, share of the epidermis' volume"),
    "epidermis_cm": Parameter(0.006, 0.02, 0.010, False, "thickness of the living epidermis, cm"),
    "stratum_corneum_cm": Parameter(0.001, 0.004, 0.001, False, "thickness of the stratum corneum, cm"),
    "blood": Parameter(0.002, 0.15, 0.012, False, "whole blood, share of the papillary dermis' volume"),
    "oxygenation": Parameter(0.3, 1.0, 0.75, True, "share of the haemoglobin that carries oxygen"),
}
"""The six parameters, in the order of the tables' axes."""


def checked_biology(biology: dict[str, Any]) -> dict[str, float]:
    """Fill in what is not said, and refuse what no table covers.

    Parameters
    ----------
    biology : dict of str to float
        Some of `PARAMETERS`.

    Returns
    -------
    biology : dict of str to float
        All of them.

    Raises
    ------
    InputError
        Naming the known parameters, or the range.
    """
    check_names(biology)
    filled = {}
    for name, parameter in PARAMETERS.items():
        value = biology.get(name, parameter.usual)
        filled[name] = checked_number(value, name, parameter.low, parameter.high)
    return filled


def check_names(biology: Mapping[str, Any]) -> None:
    """Refuse a parameter that skin does not have.

    Parameters
    ----------
    biology : mapping
        By name.

    Raises
    ------
    InputError
        Listing the known names.
    """
    if not isinstance(biology, Mapping):
        raise InputError(
            f"parameters of skin come by name, such as {{'melanin': 0.02}}; this is {sort_of(biology)}"
        )
    for name in biology:
        if name not in PARAMETERS:
            raise InputError(f"skin has no parameter {name!r}; known are {', '.join(PARAMETERS)}")


_LIMITS = {
    "index": (1.0, 3.0),
    "papillary_cm": (0.001, 1.0),
    "reticular_cm": (0.001, 10.0),
    "melanin_g_per_l": (0.0, 1500.0),
    "haemoglobin_g_per_l": (0.0, 400.0),
    "bilirubin_g_per_l": (0.0, 5.0),
    "reticular_blood": (0.0, 5.0),
    "carotene_epidermis_g_per_l": (0.0, 1.0),
    "carotene_dermis_g_per_l": (0.0, 1.0),
    "collagen_index": (1.0, 3.0),
    "collagen_radius_cm": (1e-7, 1e-4),
    "collagen_volume": (0.01, 0.74),
    "base_albedo": (0.0, 1.0),
    "fold": (0.0, 0.9),
}


@dataclass(frozen=True)
class Tissue:
    """What is the same all over a body. Defaults: Krishnaswamy and Baranoski 2004 [1]_, unless said otherwise.

    Attributes
    ----------
    index : tuple of float
        Refractive index of the four layers.
    papillary_cm, reticular_cm : float
        Thickness of the two layers of the dermis.
    melanin_g_per_l : float
        Mass of melanin in the volume of melanosomes.
    melanin_spectrum : str
        ``"sarna"``: the measured spectra of eu- and pheomelanin; ``"melanosome"``: the pigment in place,
        519 (nm/500)^-3 per cm whatever its kind (Jacques 2013).
    haemoglobin_g_per_l, bilirubin_g_per_l : float
        In whole blood.
    reticular_blood : float
        Blood of the reticular dermis as a share of that of the papillary.
    carotene_epidermis_g_per_l, carotene_dermis_g_per_l : float
        Beta-carotene in stratum corneum and epidermis, and in the dermis.
    collagen_index, collagen_radius_cm, collagen_volume : float
        Of the fibres that scatter by Rayleigh's law in the dermis of the crossing walk.
    base_albedo : float
        What the base below the dermis throws back: 1 in the thesis, 0.4 to 0.6 fits measured skin.
    fold : float
        Oblateness of the surface's folds, the width of GGX: 0.1 mirror-like, 0.9 matt.
    facets : str
        ``"ggx"``, or ``"biospec"`` for the cubed denominator of the thesis.

    References
    ----------
    .. [1] A. Krishnaswamy, G. Baranoski. A Biophysically-Based Spectral Model of Light Interaction with Human
       Skin. Computer Graphics Forum 23 (2004).
    """

    index: tuple[float, float, float, float] = (1.55, 1.40, 1.36, 1.38)
    papillary_cm: float = 0.020
    reticular_cm: float = 0.180
    melanin_g_per_l: float = 92.0
    melanin_spectrum: Literal["sarna", "melanosome"] = "sarna"
    haemoglobin_g_per_l: float = 150.0
    bilirubin_g_per_l: float = 0.005
    reticular_blood: float = 0.76
    carotene_epidermis_g_per_l: float = 2.1e-4
    carotene_dermis_g_per_l: float = 7.0e-5
    collagen_index: float = 1.5
    collagen_radius_cm: float = 25e-7
    collagen_volume: float = 0.21
    base_albedo: float = 0.5
    fold: float = 0.35
    facets: Literal["ggx", "biospec"] = "ggx"

    def __post_init__(self) -> None:
        for name, (low, high) in _LIMITS.items():
            for value in np.atleast_1d(getattr(self, name)).tolist():
                checked_number(value, name, low, high)
        if len(self.index) != 4:
            raise InputError(f"index holds {len(self.index)} numbers; it takes one for each of 4 layers")
        for name, known in (("facets", ("ggx", "biospec")), ("melanin_spectrum", ("sarna", "melanosome"))):
            if getattr(self, name) not in known:
                raise InputError(f"{name} is {getattr(self, name)!r}; known are {', '.join(known)}")

    def parameters(self) -> dict[str, Any]:
        """Write out all attributes.

        Returns
        -------
        parameters : dict
            ``Tissue(**parameters)`` is this tissue again.
        """
        return asdict(self)


def baseline(nm: ArrayLike) -> NDArray[np.float64]:
    """Absorption of skin without blood and pigment (Jacques, Skin optics, OMLC 1998).

    Parameters
    ----------
    nm : (k,) float
        Wavelengths.

    Returns
    -------
    absorption : (k,) float64
        1/cm.
    """
    return 0.244 + 85.3 * np.exp(-(np.asarray(nm, np.float64) - 154) / 66.2)


def corneum_absorption(tissue: Tissue, nm: ArrayLike) -> NDArray[np.float64]:
    """Absorption of the stratum corneum.

    Parameters
    ----------
    tissue : Tissue
        Its carotene.
    nm : (k,) float
        Wavelengths.

    Returns
    -------
    absorption : (k,) float64
        1/cm.
    """
    return baseline(nm) + tissue.carotene_epidermis_g_per_l * _carotene(nm)


def epidermis_absorption(
    tissue: Tissue, nm: ArrayLike, melanin: ArrayLike, pheomelanin: ArrayLike
) -> NDArray[np.float64]:
    """Absorption of the living epidermis.

    Parameters
    ----------
    tissue : Tissue
        Its carotene, and what its melanin is like.
    nm : (k,) float
        Wavelengths.
    melanin, pheomelanin : (...) float
        As in `PARAMETERS`; broadcast against each other.

    Returns
    -------
    absorption : (..., k) float64
        1/cm.
    """
    melanin, pheomelanin = np.asarray(melanin)[..., None], np.asarray(pheomelanin)[..., None]
    if tissue.melanin_spectrum == "melanosome":
        pigment = 519.0 * (np.asarray(nm, np.float64) / 500) ** -3 + 0 * pheomelanin
    else:
        brown, red = chromophore("eumelanin", nm), chromophore("pheomelanin", nm)
        pigment = tissue.melanin_g_per_l * (brown + pheomelanin * (red - brown))
    return melanin * pigment + (1 - melanin) * corneum_absorption(tissue, nm)


def dermis_absorption(
    tissue: Tissue, nm: ArrayLike, blood: ArrayLike, oxygenation: ArrayLike
) -> NDArray[np.float64]:
    """Absorption of a layer of the dermis.

    Parameters
    ----------
    tissue : Tissue
        Its carotene, and what its blood is like.
    nm : (k,) float
        Wavelengths.
    blood, oxygenation : (...) float
        Share of blood in this layer, and of oxygen in the blood; broadcast against each other.

    Returns
    -------
    absorption : (..., k) float64
        1/cm.
    """
    blood, oxygenation = np.asarray(blood)[..., None], np.asarray(oxygenation)[..., None]
    full, empty = chromophore("oxyhaemoglobin", nm), chromophore("haemoglobin", nm)
    pigment = tissue.haemoglobin_g_per_l / 66500 * _LN10 * (empty + oxygenation * (full - empty))
    pigment = pigment + tissue.bilirubin_g_per_l / 585 * _LN10 * chromophore("bilirubin", nm)
    return blood * pigment + (1 - blood) * (baseline(nm) + tissue.carotene_dermis_g_per_l * _carotene(nm))


def absorption(tissue: Tissue, nm: ArrayLike, biology: dict[str, float]) -> NDArray[np.float64]:
    """Absorption of the four layers.

    Parameters
    ----------
    tissue : Tissue
        What stays fixed.
    nm : (k,) float
        Wavelengths.
    biology : dict of str to float
        All `PARAMETERS`.

    Returns
    -------
    absorption : (4, k) float64
        1/cm.
    """
    blood = np.array([1.0, tissue.reticular_blood]) * biology["blood"]
    upper = (
        corneum_absorption(tissue, nm),
        epidermis_absorption(tissue, nm, biology["melanin"], biology["pheomelanin"]),
    )
    return np.vstack([*upper, dermis_absorption(tissue, nm, blood, biology["oxygenation"])])


def _carotene(nm: ArrayLike) -> NDArray[np.float64]:
    """Absorption of one gram of beta-carotene per litre, 1/cm."""
    return chromophore("carotene", nm) * _LN10 / 537
