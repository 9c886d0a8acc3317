"""`Cells`: what can be said about a leather that is grown. Lengths are millimetres, or shares of the cell size."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from pydantic import Field

from surftex.features.growth_law import GrowthLaw
from surftex.materials.checked import Checked
from surftex.materials.parameters import (
    Amount,
    AspectField,
    Color,
    Length,
    LengthField,
    NumberField,
    PositiveLength,
    Share,
)
from surftex.surface.surface import Surface

if TYPE_CHECKING:
    from surftex.materials.cells.pattern import CellsPattern
    from surftex.materials.cells.tile import CellsTile
    from surftex.materials.limits import Expected


def _field(default: Any, group: str, text: str, **limits: Any) -> Any:
    return Field(default, description=text, json_schema_extra={"group": group}, **limits)


class Cells(Checked):
    """Leather grown from particles: cells with three and four sides, parted by grooves, carved like pebbles.

    Particles are born on the surface, grow, push each other and rise until they lie packed under a ceiling; the mesh that
    joins their centres parts the cells, and each is rounded, tapered, domed and dotted with metaballs. After a
    Japanese report on leather texture from particle simulation and metaballs; wrinkles, waver and colour go beyond it.
    """

    kind: Literal["cells"] = "cells"

    cell_size: LengthField = _field(
        1.6, "cells", "Diameter of the largest particles; cells come out a little smaller."
    )
    cell_ratio: AspectField = _field(
        1.0, "cells", "Length of particles over their width, 0.2 to 5; 1 is round."
    )
    direction: str | None = _field(
        None, "cells", "Direction field that cells are long in; smoothest without it."
    )
    quads: Share = _field(0.6, "cells", "Share of the triangles that are paired into cells with four sides.")
    squareness: float = _field(
        40.0,
        "cells",
        "Degrees by which the angles of a cell with four sides may differ from 90.",
        ge=0,
        le=60,
    )

    generations: int = _field(140, "growth", "After which the growth ends.", ge=1, le=2000)
    births: float = _field(
        0.048, "growth", "Rate of births at first, per generation and square of the cell size.", gt=0, le=10
    )
    births_end: float = _field(
        45.0, "growth", "Generation at which that rate has fallen to 1 / e.", gt=0, le=1000
    )
    ageing: float = _field(0.12, "growth", "How fast it falls then, per generation.", gt=0, le=10)
    smallest: Share = _field(0.5, "growth", "Final size of the last born, as a share of the first born's.")
    size_variation: Share = _field(0.15, "growth", "How much particles of one age differ in size.")
    growth: float = _field(
        0.08, "growth", "Rate at which particles reach their size, per generation.", gt=0, le=10
    )
    life: int = _field(
        200, "growth", "Generations that a particle lives; fewer than the growth leaves large cells.", ge=1
    )
    damping: float = _field(0.7, "growth", "Share of the critical damping.", ge=0.05, le=5)
    attraction: Share = _field(0.0, "growth", "How much particles apart pull each other together.")
    rise: float = _field(0.025, "growth", "Force that lifts particles, in cell sizes.", ge=0, le=0.5)
    ceiling: float = _field(
        1.2, "growth", "Height of the layer, in cell sizes; it makes the layer closed.", ge=0.8, le=5
    )

    potential: NumberField | None = _field(
        None, "field", "Expression from 0 to 1; particles are driven from where it is high."
    )
    potential_height: Amount = _field(
        4.0, "field", "Height that 1 stands for, in cell sizes; its slopes drive particles."
    )
    potential_force: float = _field(
        0.02, "field", "Force on a steep slope, in cell sizes; beyond 0.06 places empty.", ge=0, le=0.5
    )
    drift: str | None = _field(None, "field", "Direction field that drives all particles.")
    drift_force: float = _field(0.0, "field", "Force of that, in cell sizes.", ge=0, le=0.5)

    relief: float = _field(0.14, "shape", "Rise of a cell, in cell sizes.", ge=0, le=2)
    relief_variation: Share = _field(0.15, "shape", "How much cells differ in height.")
    leanness: Share = _field(0.75, "shape", "How much less small and narrow cells rise than broad ones.")
    gap: float = _field(0.02, "shape", "Width of the floor of grooves, in cell sizes.", ge=0, le=0.5)
    rounding: float = _field(
        0.34, "shape", "Share of a side, from either end, that goes into a rounded corner.", gt=0, lt=0.5
    )
    taper: float = _field(0.6, "shape", "How far the side of a cell reaches up to its middle.", gt=0, le=1)
    dome: Amount = _field(
        0.4, "shape", "Rise of the middle over the rim of the top, as a share of the relief."
    )
    shoulder: float = _field(
        0.0, "shape", "Slope at the upper end of the side; 0 is a soft shoulder.", ge=-4, le=4
    )
    groove: float = _field(
        -1.5,
        "shape",
        "Slope at the lower end of the side; 0 is a round groove, -1.5 a sharp one.",
        ge=-4,
        le=4,
    )
    waviness: Share = _field(0.06, "shape", "How far sides waver, as a share of the cell size.")
    shallows: Share = _field(
        0.35, "shape", "How much of the depth of grooves is lost where they are shallow."
    )

    blob_density: Amount = _field(48.0, "blobs", "Metaballs per square of the cell size, on tops.")
    blob_size: float = _field(0.055, "blobs", "Radius of metaballs, in cell sizes.", gt=0, le=0.5)
    blob_variation: Share = _field(0.3, "blobs", "How much they differ in size.")
    blob_threshold: float = _field(0.35, "blobs", "Where they melt together; lower melts more.", gt=0, lt=1)
    blob_height: Amount = _field(0.06, "blobs", "Their rise, as a share of the relief.")

    stress: str | None = _field(None, "wrinkles", "Direction field that wrinkles follow.")
    wrinkle_count: int = _field(0, "wrinkles", "Number of wrinkles.", ge=0)
    wrinkle_density: Amount = _field(0.0, "wrinkles", "Further wrinkles, per 1000 mm^2.")
    wrinkle_length: Length = _field(20.0, "wrinkles", "Of each wrinkle.")
    wrinkle_angle: float = _field(
        75.0, "wrinkles", "Degrees to the stress beyond which a wrinkle ends.", ge=0, le=180
    )
    wrinkle_depth: Length = _field(0.1, "wrinkles", "Added to that of the groove beneath.")
    wrinkle_width: Length = _field(0.9, "wrinkles", "From the middle of a wrinkle to its rim.")
    wrinkle_curves: str | None = _field(
        None, "wrinkles", "Curves of the recipe to draw as wrinkles, with their own width and depth."
    )
    wrinkle_potential: Share = _field(
        0.0,
        "wrinkles",
        "Potential on wrinkles; above 0 they are laid before the growth, as on leather, and drive particles off.",
    )
    wrinkle_taper: Length = _field(6.0, "wrinkles", "Length over which a wrinkle runs out at its ends.")

    grain_height: Length = _field(0.004, "grain", "Rise of the finest bumps.")
    grain_size: PositiveLength = _field(0.22, "grain", "Wavelength of the finest bumps.")

    color: Color = _field("#7d4526", "colour", "Of the cells.", validate_default=True)
    furrow_color: Color = _field(
        "#3a1b0c", "colour", "Of the dye that pools in grooves.", validate_default=True
    )
    crest_color: Color = _field("#a9713f", "colour", "Of worn crests.", validate_default=True)
    dye: Share = _field(0.6, "colour", "How much dye the grooves hold.")
    wear: Share = _field(0.15, "colour", "How far crests are worn.")
    mottle: Share = _field(0.06, "colour", "How much the tone drifts over the hide.")
    mottle_size: PositiveLength = _field(16.0, "colour", "Wavelength of that drift.")
    cell_tone: Share = _field(0.05, "colour", "How much cells differ in tone.")

    roughness: Share = _field(0.44, "finish", "Of the cells.")
    furrow_roughness: Share = _field(0.62, "finish", "Of the grooves.")
    crest_roughness: Share = _field(0.36, "finish", "Of polished crests.")
    specular: Share = _field(0.5, "finish", "Strength of the reflection; 0.5 is 4 % face on.")

    @property
    def law(self) -> GrowthLaw:
        """How particles are born, grow and push."""
        return GrowthLaw(
            generations=self.generations, births=self.births, births_end=self.births_end, ageing=self.ageing,
            smallest=self.smallest, variation=self.size_variation, growth=self.growth, life=self.life,
            damping=self.damping, attraction=self.attraction, rise=self.rise, ceiling=self.ceiling,
        )  # fmt: skip

    @staticmethod
    def preset(name: str, **changes: Any) -> "Cells":
        """Take a grown leather from the shelf.

        Parameters
        ----------
        name : str
            See `Cells.presets`.
        **changes : Any
            Parameters to set otherwise.

        Returns
        -------
        cells : Cells
            With all parameters written out.

        Raises
        ------
        RecipeError
            If there is no such preset; the message names the nearest.

        Examples
        --------
        >>> Cells.preset("even", cell_size="2 mm").cell_size
        2.0
        """
        from surftex.materials.presets import preset

        return preset(Cells, name, changes)

    @staticmethod
    def presets() -> dict[str, str]:
        """List the shelf.

        Returns
        -------
        presets : dict of str to str
            What each preset looks like, by name.
        """
        from surftex.materials.presets import captions

        return captions("cells")

    def roomy(self, times: float) -> "Cells":
        """Make wrinkles wider, so that they are flooded far enough to be widened later.

        Parameters
        ----------
        times : float
            How much wider.

        Returns
        -------
        cells : Cells
            Grown like these.
        """
        return self.model_copy(update={"wrinkle_width": times * self.wrinkle_width})

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels that its patterns answer with."""
        from surftex.materials.cells.pattern import CHANNELS

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
        return sizes

    def placing(self) -> dict[str, Any]:
        """Tell what decides where its features lie; two that tell the same have the same.

        Returns
        -------
        placing : dict of str to Any
            Parameters by name.
        """
        from surftex.materials.cells.pattern import KEPT

        return {key: getattr(self, key) for key in Cells.model_fields if key not in KEPT}

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
        from surftex.materials.cells.skeleton import expected_features

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
        tick: Callable[..., None] | None = None,
    ) -> "CellsPattern":
        """Grow cells on a surface.

        Parameters
        ----------
        surface : Surface
            Where the leather lies.
        seed : int
            Same seed, surface and parameters: same features, whatever the unwrap or resolution.
        fields : FieldSet, optional
            The recipe's named fields, for parameters that are expressions and for directions.
        features : mapping of str to structured array, optional
            Take these, from an earlier `CellsPattern.features`, and place nothing anew. With nothing but particles, as
            a growth that was saved on its way, the growth goes on from them.
        max_features : int
            Refuse beyond it.
        threads : int, optional
            None means every core; cannot change the result.
        tick : callable, optional
            Told the finished share, and, where it has a method `detail`, the count of particles; may raise to cancel.

        Returns
        -------
        pattern : CellsPattern
            Answers at any sample.

        Raises
        ------
        RecipeError
            If there would be more than `max_features` particles, or an expression does not fit.
        """
        from surftex.materials.cells.pattern import CellsPattern
        from surftex.materials.cells.skeleton import place

        if features is None or "cell" not in features:
            features = place(
                self,
                surface,
                seed,
                fields=fields,
                features=features,
                max_features=max_features,
                threads=threads,
                tick=tick,
            )
        return CellsPattern.build(self, surface, seed, features, threads)

    def tile(
        self,
        side_mm: float,
        seed: int = 0,
        *,
        fields: Any = None,
        features: Mapping[str, np.ndarray] | None = None,
        max_features: int = 5_000_000,
        threads: int | None = None,
        tick: Callable[..., None] | None = None,
    ) -> "CellsTile":
        """Grow cells on a square that repeats.

        Parameters
        ----------
        side_mm : float
            Of the square.
        seed : int
            Same seed and parameters: same tile.
        fields : FieldSet, optional
            Named numbers and directions, on `surftex.materials.cells.tile.sheet_of` the square; they should repeat.
        features : mapping of str to structured array, optional
            As for `place`.
        max_features : int
            Refuse beyond it.
        threads : int, optional
            None means every core; cannot change the result.
        tick : callable, optional
            As for `place`.

        Returns
        -------
        tile : CellsTile
            Answers at any place, and gives whole pages.

        Raises
        ------
        RecipeError
            If the square is too small for its cells, a parameter needs a surface, or there is no such field.
        """
        from surftex.materials.cells.tile import make_tile

        return make_tile(
            self, side_mm, seed, fields=fields, features=features, max_features=max_features, threads=threads,
            tick=tick,
        )  # fmt: skip
