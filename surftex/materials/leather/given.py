"""Features of a leather that were placed before: whether they are all there, and belong together."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from surftex.errors import RecipeError
from surftex.features.curves import drawn
from surftex.materials.leather.model import Leather
from surftex.surface.inspect import euler_characteristics
from surftex.surface.surface import Surface
from surftex.words import by_count

_SURELY = 30
"""Where so many are to be expected, or there are so many cells, some are."""

_DOUBLED, _FEW = 0.02, 2
"""Pockets beyond what is to be had, as a share and as a number: where four cells meet, more than two may be found."""


def refuse_lacking(leather: Leather, surface: Surface, features: Mapping[str, NDArray]) -> None:
    """Refuse features in which a kind is missing that the leather surely has, or cells for what hangs between them.

    Parameters
    ----------
    leather : Leather
        What they are for.
    surface : Surface
        Where they lie.
    features : mapping of str to structured array
        From an earlier `place`.

    Raises
    ------
    RecipeError
        Naming the kind, and the parameter or the number of cells.
    """
    density = 0.0 if isinstance(leather.pore_density, str) else leather.pore_density
    for kind, key, expected in (
        ("pore", "pore_density", density * surface.area_mm2 / leather.pore_group > _SURELY),
        ("wrinkle", "wrinkle_count", leather.wrinkle_count > 0 and len(features.get("cell", ())) > _SURELY),
        ("crown", "crown_spacing", leather.crown_spacing > 0),
    ):
        if expected and not len(features.get(kind, ())):
            raise RecipeError(
                f"{key} is {getattr(leather, key):g}, and the features hold no {kind}; were they placed by another recipe?"
            )
    lines = features.get("wrinkle")
    if leather.wrinkle_curves is not None and (lines is None or "width_mm" not in (lines.dtype.names or ())):
        raise RecipeError(
            f"wrinkle_curves is {leather.wrinkle_curves!r}, and the features hold no drawn wrinkle; were they placed by "
            "another recipe?"
        )
    _refuse_uncelled(surface, features)


def _refuse_uncelled(surface: Surface, features: Mapping[str, NDArray]) -> None:
    """Refuse, body by body, pockets and lines that so few cells cannot have between them."""
    count = int(surface.component.max()) + 1

    def on_bodies(kind: str, some: NDArray[np.bool_] | slice = slice(None)) -> NDArray[np.int64]:
        return np.bincount(surface.component[features[kind]["face"][some]], minlength=count)

    cells = on_bodies("cell") if "cell" in features else np.zeros(count, np.int64)
    other = "were cells taken out, or placed by another recipe?"
    for kind in ("crack", "wrinkle"):
        if kind in features:
            bare = np.flatnonzero((on_bodies(kind, drawn(features[kind], "width_mm") == 0) > 0) & (cells < 2))
            if len(bare):
                held = by_count(int(cells[bare[0]]), "there is {} cell", "there are {} cells")
                raise RecipeError(f"a {kind} runs where {held}, and such lines run between two; {other}")
    if not len(features.get("pocket", ())):
        return
    pockets = on_bodies("pocket")
    bare = np.flatnonzero((pockets > 0) & (cells < 3))
    if len(bare):
        lie = by_count(int(pockets[bare[0]]), "{:,} pocket lies", "{:,} pockets lie")
        held = by_count(int(cells[bare[0]]), "there is {} cell", "there are {} cells")
        raise RecipeError(f"{lie} where {held}, and a pocket is where three meet; {other}")
    most = np.maximum(2 * (cells - euler_characteristics(surface)), 0)
    many = np.flatnonzero(pockets > (1 + _DOUBLED) * most + _FEW)
    if len(many):
        held = f"{pockets[many[0]]:,} pockets lie between {cells[many[0]]:,} cells"
        raise RecipeError(f"{held}, which have {most[many[0]]:,} at the most; {other}")
