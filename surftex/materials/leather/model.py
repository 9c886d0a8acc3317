"""`Leather`: what can be said about a leather. Lengths are millimetres walked on the surface."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from pydantic import Field

from surftex.materials.checked import Checked
from surftex.materials.parameters import (
    Amount,
    AmountField,
    Color,
    Length,
    LengthField,
    LongField,
    PositiveLength,
    Share,
)
from surftex.surface.surface import Surface

if TYPE_CHECKING:
    from surftex.materials.leather.pattern import LeatherPattern
    from surftex.materials.limits import Expected


def _field(default: Any, group: str, text: str, **limits: Any) -> Any:
    return Field(default, description=text, json_schema_extra={"group": group}, **limits)


class Leather(Checked):
    """Full-grain leather: convex plates (cristae) parted by furrows (sulci), wrinkles, pockets, pores.

    The five structural elements, their skeletons and profiles follow Sakurai, Miyata, Kawai and Matsufuji,
    "Procedural Modeling of Leather Texture with Structural Elements"; crowns, scales and colour go beyond it.
    """

    kind: Literal["leather"] = "leather"

    cell_size: LengthField = _field(0.85, "cells", "Least distance between neighbour cells.")
    size_variation: Share = _field(0.0, "cells", "How much cells differ in size, in patches of a few cells.")
    cell_ratio: LongField = _field(1.0, "cells", "Length of cells over their width, from 1, which is round.")
    direction: str | None = _field(
        None, "cells", "Direction field that cells are long in; smoothest without it."
    )
    cell_shape: Literal["round", "ellipse", "box"] = _field(
        "round",
        "cells",
        "What parts the cells: walking distance, distance in the ellipse of each, or in a box.",
    )
    regularity: int = _field(
        0, "cells", "Rounds of evening out the cells; 0 is hide, 4 is scales.", ge=0, le=20
    )
    waviness: Share = _field(0.0, "cells", "How far borders waver, as a share of the cell size.")
    rounding: Share = _field(0.0, "cells", "Radius of the corners of cells, as a share of the cell size.")
    variation: Share = _field(0.0, "cells", "How much cells differ in height.")

    crista_height: Length = _field(0.05, "cristae", "Rise of a plate from its border to its middle.")
    crista_exponent: float = _field(
        3.0, "cristae", "2 is a dome, larger is flatter with a steeper rim.", gt=0, le=32
    )
    crista_shape: Literal["soft", "polygon", "inscribed"] = _field(
        "soft", "cristae", "Rounded plates; cut gems; round pebbles on a floor."
    )

    sulcus_depth: Length = _field(0.03, "sulci", "Of the furrows between plates.")
    sulcus_width: Length = _field(0.17, "sulci", "From the middle of a furrow to its rim.")
    sulcus_variation: Share = _field(0.0, "sulci", "How much furrows differ in depth and width.")

    invasion: AmountField = _field(
        0.0, "cracks", "Length by which a furrow along the stress cracks the next plate."
    )
    invasion_mode: Literal["length", "relative"] = _field(
        "length", "cracks", "Whether `invasion` is millimetres, or a factor of the furrow's half length."
    )
    crack_taper: bool = _field(True, "cracks", "Whether cracks run out to nothing over their outer half.")

    stress: str | None = _field(None, "wrinkles", "Direction field that wrinkles and cracks follow.")
    wrinkle_count: int = _field(0, "wrinkles", "Number of wrinkles.", ge=0)
    wrinkle_density: Amount = _field(0.0, "wrinkles", "Further wrinkles, per 1000 mm^2.")
    wrinkle_length: Length = _field(10.0, "wrinkles", "Of each wrinkle.")
    wrinkle_angle: float = _field(
        30.0, "wrinkles", "Degrees to the stress beyond which a wrinkle cuts across a plate.", ge=0, le=180
    )
    wrinkle_depth: Length = _field(0.05, "wrinkles", "Added to that of the furrow beneath.")
    wrinkle_width: Length = _field(0.3, "wrinkles", "From the middle of a wrinkle to its rim.")
    wrinkle_taper: Length = _field(0.0, "wrinkles", "Length over which a wrinkle runs out at its ends.")
    wrinkle_curves: str | None = _field(
        None, "wrinkles", "Curves of the recipe to draw as wrinkles, with their own width and depth."
    )
    wrinkle_fold: Share = _field(0.0, "wrinkles", "How far one side of a wrinkle overhangs like a fold.")

    pocket_depth: Length = _field(0.0, "pockets", "Where three furrows meet.")
    pocket_width: Length = _field(0.15, "pockets", "From the middle of a pocket to its rim.")

    pore_density: Amount | str = _field(0.0, "pores", "Pores per mm^2; an expression may mask them.")
    pore_group: int = _field(
        1,
        "pores",
        "Pores that stand together: 1, or 3 as on pig, then in groups that keep apart.",
        ge=1,
        le=7,
    )
    pore_spread: Length = _field(0.3, "pores", "From the middle of a group to its pores.")
    pore_depth: Length = _field(0.03, "pores", "Of a pore.")
    pore_width: Length = _field(0.07, "pores", "From the middle of a pore to its rim.")

    crown_spacing: Length = _field(0.0, "crowns", "Least distance between crowns (ostrich); 0 for none.")
    crown_height: Length = _field(0.5, "crowns", "Rise of a crown.")
    crown_width: Length = _field(2.2, "crowns", "From the middle of a crown to its rim.")
    crown_pit_depth: Length = _field(0.3, "crowns", "Of the quill's pit.")
    crown_pit_width: Length = _field(0.4, "crowns", "From the middle of the pit to its rim.")

    scale_overlap: Share = _field(
        0.0, "scales", "How far plates tilt to overlap like tiles along the direction."
    )

    grain_height: Length = _field(0.004, "grain", "Rise of the finest bumps.")
    grain_size: PositiveLength = _field(0.25, "grain", "Wavelength of the finest bumps.")

    color: Color = _field("#a0602f", "colour", "Of the plates.", validate_default=True)
    furrow_color: Color = _field(
        "#5a2e14", "colour", "Of the dye that pools in furrows.", validate_default=True
    )
    crest_color: Color = _field("#c08850", "colour", "Of worn crests.", validate_default=True)
    dye: Share = _field(0.6, "colour", "How much dye the furrows hold.")
    pore_dye: Share = _field(0.5, "colour", "How much dye the pores hold.")
    wear: Share = _field(0.15, "colour", "How far crests are worn.")
    mottle: Share = _field(0.06, "colour", "How much the tone drifts over the hide.")
    mottle_size: PositiveLength = _field(14.0, "colour", "Wavelength of that drift.")
    cell_tone: Share = _field(0.05, "colour", "How much cells differ in tone.")

    roughness: Share = _field(0.42, "finish", "Of the plates.")
    furrow_roughness: Share = _field(0.6, "finish", "Of the furrows.")
    crest_roughness: Share = _field(0.34, "finish", "Of polished crests.")
    specular: Share = _field(0.5, "finish", "Strength of the reflection; 0.5 is 4 % face on.")

    @staticmethod
    def preset(name: str, **changes: Any) -> "Leather":
        """Take a leather from the shelf.

        Parameters
        ----------
        name : str
            See `Leather.presets`.
        **changes : Any
            Parameters to set otherwise.

        Returns
        -------
        leather : Leather
            With all parameters written out.

        Raises
        ------
        RecipeError
            If there is no such preset; the message names the nearest.

        Examples
        --------
        >>> Leather.preset("calf", cell_size="1.2 mm").cell_size
        1.2
        """
        from surftex.materials.presets import preset

        return preset(Leather, name, changes)

    @staticmethod
    def presets() -> dict[str, str]:
        """List the shelf.

        Returns
        -------
        presets : dict of str to str
            What each preset looks like, by name.
        """
        from surftex.materials.presets import captions

        return captions("leather")

    def roomy(self, times: float) -> "Leather":
        """Make every element wider, so that it is flooded far enough to be widened later.

        Parameters
        ----------
        times : float
            How much wider.

        Returns
        -------
        leather : Leather
            Its elements lie where they lay.
        """
        widths = ("sulcus_width", "wrinkle_width", "pocket_width", "pore_width", "crown_width")
        return self.model_copy(update={key: times * getattr(self, key) for key in widths})

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels that its patterns answer with."""
        from surftex.materials.leather.pattern import CHANNELS

        return CHANNELS

    def wavelengths_mm(self) -> dict[str, float]:
        """Tell how large features are.

        Returns
        -------
        wavelengths : dict of str to float
            Of each kind that there is, mm; cells whose size is an expression are left out.
        """
        sizes = {} if isinstance(self.cell_size, str) else {"cells": float(self.cell_size)}
        if self.wrinkle_count or self.wrinkle_density or self.wrinkle_curves:
            sizes["wrinkles"] = 2 * self.wrinkle_width
        if self.pore_density != 0:
            sizes["pores"] = 2 * self.pore_width
        if self.crown_spacing > 0:
            sizes["crowns"] = 2 * self.crown_width
        return sizes

    def placing(self) -> dict[str, Any]:
        """Tell what decides where its features lie; two that tell the same have the same.

        Returns
        -------
        placing : dict of str to Any
            Parameters by name.
        """
        from surftex.materials.leather.pattern import PLACING

        values = {key: getattr(self, key) for key in PLACING}
        for key in ("pocket_depth", "scale_overlap"):
            values[key] = "above 0" if getattr(self, key) else "0"
        return values

    def expected_features(
        self, surface: Surface, seed: int = 0, *, fields: Any = None
    ) -> "tuple[Expected, ...]":
        """Tell about how many features `place` would lay; nothing is placed.

        Parameters
        ----------
        surface : Surface
            As for `place`.
        seed : int
            As for `place`.
        fields : FieldSet, optional
            As for `place`.

        Returns
        -------
        expected : tuple of Expected
            Of each kind: what ``max_features`` bounds.

        Raises
        ------
        RecipeError
            If an expression does not fit.
        """
        from surftex.fields.fieldset import FieldSet
        from surftex.materials.leather.skeleton import expected_features

        return expected_features(self, surface, seed, fields or FieldSet(surface))

    def place(
        self,
        surface: Surface,
        seed: int = 0,
        *,
        fields: Any = None,
        features: Mapping[str, np.ndarray] | None = None,
        max_features: int = 5_000_000,
        threads: int | None = None,
        tick: Callable[[float], None] | None = None,
    ) -> "LeatherPattern":
        """Place every element on a surface.

        Parameters
        ----------
        surface : Surface
            Where the leather lies.
        seed : int
            Same seed, surface and parameters: same features, whatever the unwrap or resolution.
        fields : FieldSet, optional
            The recipe's named fields, for parameters that are expressions and for directions.
        features : mapping of str to structured array, optional
            Take these, from an earlier `LeatherPattern.features`, and place nothing anew.
        max_features : int
            Refuse beyond it.
        threads : int, optional
            None means every core; cannot change the result.
        tick : callable, optional
            Told the finished share; may raise to cancel.

        Returns
        -------
        pattern : LeatherPattern
            Answers at any sample.

        Raises
        ------
        RecipeError
            If the surface would hold more than `max_features`, an expression does not fit, or `features` lack a kind.
        """
        from surftex.materials.leather.given import refuse_lacking
        from surftex.materials.leather.pattern import LeatherPattern
        from surftex.materials.leather.skeleton import place

        records = None
        if features is None:
            features, records = place(
                self, surface, seed, fields=fields, max_features=max_features, threads=threads, tick=tick
            )
        else:
            refuse_lacking(self, surface, features)
        return LeatherPattern.build(self, surface, seed, features, records, threads)
