"""`Skin`: what can be said about a skin. Lengths are millimetres walked on the surface."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, field_validator

from surftex.fields.splines import Profile
from surftex.materials.checked import Checked
from surftex.materials.parameters import (
    Amount,
    AmountRange,
    Color,
    Finite,
    Length,
    LengthDraw,
    LengthRange,
    NumberField,
    PositiveLength,
    Share,
)
from surftex.optics.tissue import PARAMETERS
from surftex.surface.surface import Surface

if TYPE_CHECKING:
    from surftex.materials.limits import Expected
    from surftex.materials.skin.pattern import SkinPattern

Count = int
Mask = Finite | str


def _field(default: Any, group: str, text: str, **limits: Any) -> Any:
    return Field(default, description=text, json_schema_extra={"group": group}, **limits)


def _biology(name: str, default: Any, text: str) -> Any:
    """Describe a parameter of the bare skin, with the range that looks are known for."""
    known = PARAMETERS[name]
    scale, unit = (10, " mm") if name.endswith("_cm") else (1, "")
    return _field(default, "baseline", f"{text}: {scale * known.low:g} to {scale * known.high:g}{unit}.")


def _count(group: str, what: str) -> Any:
    return _field(0, group, f"Number of {what}, wherever `{group}_where` allows them.", ge=0)


def _density(group: str, what: str) -> Any:
    return _field(0.0, group, f"Further {what}, per mm^2.")


def _where(group: str, what: str) -> Any:
    return _field(1.0, group, f"How likely {what} are: 0 to 1, or an expression over the recipe's fields.")


class Skin(Checked):
    """Human skin: pigments and blood of every point, and the features that change them.

    Cysts, moles, follicles, freckles, lips and wrinkles follow a procedural model of skin; microrelief, pores, pock marks,
    scars, vessels, goose bumps and sebum go beyond it. A radius is given as (mean, standard deviation) of a normal
    draw, whose absolute value counts; heights and strengths as (least, greatest) of a uniform one.
    """

    files: ClassVar[tuple[str, ...]] = ("table",)
    """Parameters that name files."""

    kind: Literal["skin"] = "skin"

    melanin: NumberField = _biology("melanin", 0.022, "Melanosomes per volume of the epidermis")
    pheomelanin: NumberField = _biology("pheomelanin", 0.12, "Share of red-yellow melanin")
    blood: NumberField = _biology("blood", 0.014, "Whole blood per volume of the dermis")
    oxygenation: NumberField = _biology("oxygenation", 0.78, "Share of the blood that carries oxygen")
    stratum_corneum: Length = _biology("stratum_corneum_cm", 0.015, "Thickness of the horny layer")
    epidermis: Length = _biology("epidermis_cm", 0.08, "Thickness of the living epidermis")
    table: str | None = _field(
        None, "baseline", "Looks by biology, an .npz of `surftex match`; those of the package without it."
    )
    variation: Share = _field(
        0.006, "baseline", "Noise of every parameter, as a share of its plausible range."
    )
    variation_size: PositiveLength = _field(0.9, "baseline", "Wavelength of that noise.")
    mottle: Share = _field(0.18, "baseline", "How much blood and melanin vary in patches.")
    mottle_size: PositiveLength = _field(7.0, "baseline", "Size of the patches.")
    drift: Share = _field(0.22, "baseline", "How much blood and melanin vary over the whole.")
    drift_size: PositiveLength = _field(55.0, "baseline", "Wavelength of that variation.")
    flush: Amount = _field(0.9, "baseline", "How much redder what stands out is: nose, ears, knuckles.")
    flush_radius: PositiveLength = _field(14.0, "baseline", "Radius at which it stands out fully.")
    flush_where: Mask = _field(1.0, "baseline", "Where it flushes, such as 'cheeks'; may go beyond 1.")
    tan: Amount = _field(0.25, "baseline", "How much browner what faces up is.")
    up: tuple[float, float, float] = _field(
        (0.0, 1.0, 0.0), "baseline", "Up, in the axes of the file.", validate_default=True
    )

    lips_where: Mask = _field(0.0, "lips", "Mask of the lips.")
    lips_blood: Share = _field(0.06, "lips", "Blood of the lips.")
    lips_pheomelanin: Share = _field(0.25, "lips", "Pheomelanin of the lips.")
    lips_epidermis: Length = _field(0.06, "lips", "Thickness of the epidermis of the lips.")

    cyst_count: Count = _count("cyst", "small bumps without pigment")
    cyst_density: Amount = _density("cyst", "bumps")
    cyst_where: Mask = _where("cyst", "bumps")
    cyst_radius: LengthDraw = _field((0.35, 0.15), "cyst", "Radius of a bump.")
    cyst_height: LengthRange = _field((0.0, 0.06), "cyst", "Rise of a bump.")
    cyst_profile: Profile = _field("sigmoid", "cyst", "Shape of a bump.")

    mole_count: Count = _count("mole", "moles")
    mole_density: Amount = _density("mole", "moles")
    mole_where: Mask = _where("mole", "moles")
    mole_points: str | None = _field(
        None, "mole", "Field of the recipe that is the distance to places of a file: there is a mole at each."
    )
    mole_radius: LengthDraw = _field((0.9, 0.5), "mole", "Radius of a mole.")
    mole_melanin: AmountRange = _field((0.12, 0.4), "mole", "Melanosomes that the middle of a mole adds.")
    mole_height: LengthRange = _field((0.2, 1.0), "mole", "Rise of a mole, times the melanosomes it adds.")
    mole_irregularity: Share = _field(0.3, "mole", "How uneven the outline of a mole is.")
    mole_profile: Profile = _field("plateau", "mole", "How a mole fades to its rim.")

    freckle_count: Count = _count("freckle", "freckles")
    freckle_density: Amount = _density("freckle", "freckles")
    freckle_where: Mask = _where("freckle", "freckles")
    freckle_gather: float = _field(
        1.0,
        "freckle",
        "Power of that likelihood: above 1 gathers freckles, below 1 spreads them.",
        gt=0,
        le=20,
    )
    freckle_radius: LengthDraw = _field((0.8, 0.45), "freckle", "Radius of a freckle.")
    freckle_melanin: AmountRange = _field((0.0, 0.05), "freckle", "Melanosomes that its middle adds.")
    freckle_pheomelanin: Share = _field(
        0.3, "freckle", "Pheomelanin that it adds, times its melanosomes and a random share."
    )
    freckle_irregularity: Share = _field(0.5, "freckle", "How uneven the outline of a freckle is.")
    freckle_profile: Profile = _field("cone", "freckle", "How a freckle fades to its rim.")

    follicle_count: Count = _count("follicle", "hairs")
    follicle_density: Amount = _density("follicle", "hairs")
    follicle_where: Mask = _where("follicle", "hairs")
    follicle_shaft: Length = _field(0.045, "follicle", "Radius of the shaft where it leaves the skin.")
    follicle_radius: Length = _field(0.16, "follicle", "Radius to which the shaft shows through the skin.")
    follicle_lean: float = _field(
        1.5, "follicle", "Length of the disc over its width, as the shaft leans.", ge=1, le=10
    )
    follicle_direction: str | None = _field(
        None, "follicle", "Direction field that hair lies along; smoothest without it."
    )
    follicle_color: Color = _field("#3b2a20", "follicle", "Of the hair.", validate_default=True)
    follicle_cover: Share = _field(0.9, "follicle", "How much of the skin's colour the shaft hides.")
    follicle_height: Length = _field(0.01, "follicle", "Rise of the cut shaft.")
    follicle_blood: Share = _field(0.35, "follicle", "Share of the blood that a follicle takes the room of.")

    pore_count: Count = _count("pore", "pores")
    pore_density: Amount = _field(0.9, "pore", "Further pores, per mm^2.")
    pore_where: Mask = _where("pore", "pores")
    pore_radius: LengthDraw = _field((0.13, 0.035), "pore", "Radius of a pore.")
    pore_depth: LengthRange = _field((0.02, 0.09), "pore", "Depth of a pore.")
    pore_lean: float = _field(
        1.35, "pore", "Length of a pore over its width, along the furrows.", ge=1, le=10
    )
    pore_shade: Share = _field(0.012, "pore", "Melanosomes that its plug adds.")
    pore_sebum: Share = _field(0.3, "pore", "Oil around it.")
    pore_profile: Profile = _field("valley", "pore", "Shape of a pore.")

    pock_count: Count = _count("pock", "pock marks")
    pock_density: Amount = _density("pock", "pock marks")
    pock_where: Mask = _where("pock", "pock marks")
    pock_radius: LengthDraw = _field((0.8, 0.35), "pock", "Radius of a pock mark.")
    pock_depth: LengthRange = _field((0.08, 0.3), "pock", "Depth of a pock mark.")
    pock_irregularity: Share = _field(0.35, "pock", "How uneven its outline is.")
    pock_profile: Profile = _field("crater", "pock", "Shape of a pock mark.")

    scar_count: Count = _count("scar", "scars")
    scar_density: Amount = _density("scar", "scars")
    scar_where: Mask = _where("scar", "scars")
    scar_radius: LengthDraw = _field((3.0, 1.5), "scar", "Radius of a disc as large as a scar.")
    scar_lean: float = _field(6.0, "scar", "Length of a scar over its width.", ge=1, le=20)
    scar_depth: LengthRange = _field((0.05, 0.15), "scar", "Depth of a scar.")
    scar_pallor: Share = _field(0.55, "scar", "Share of melanin and blood that it lacks.")
    scar_irregularity: Share = _field(0.3, "scar", "How uneven its outline is.")
    scar_profile: Profile = _field("plateau", "scar", "Shape of a scar.")

    goose_count: Count = _count("goose", "goose bumps")
    goose_density: Amount = _density("goose", "goose bumps")
    goose_where: Mask = _where("goose", "goose bumps")
    goose_radius: LengthDraw = _field((0.9, 0.15), "goose", "Radius of a goose bump.")
    goose_height: LengthRange = _field((0.1, 0.3), "goose", "Rise of a goose bump.")
    goose_profile: Profile = _field("dome", "goose", "Shape of a goose bump.")

    vessel_count: Count = _field(0, "vessel", "Number of small vessels that show through.", ge=0)
    vessel_density: Amount = _field(0.0, "vessel", "Further vessels, per 1000 mm^2.")
    vessel_where: Mask = _where("vessel", "vessels")
    vessel_length: Length = _field(9.0, "vessel", "Of each trunk.")
    vessel_width: Length = _field(0.22, "vessel", "From the middle of a vessel to where it stops showing.")
    vessel_blood: Share = _field(0.03, "vessel", "Blood that it adds above its middle.")
    vessel_oxygenation: Share = _field(0.75, "vessel", "Of that blood: a vein is blue below 0.6.")
    vessel_branches: int = _field(2, "vessel", "Times that a vessel forks.", ge=0, le=5)
    vessel_wander: float = _field(25.0, "vessel", "Degrees by which it turns at each step.", ge=0, le=90)

    wrinkle_count: Count = _field(0, "wrinkle", "Number of wrinkles.", ge=0)
    wrinkle_density: Amount = _field(0.0, "wrinkle", "Further wrinkles, per 1000 mm^2.")
    wrinkle_curves: str | None = _field(
        None, "wrinkle", "Curves of the recipe that are wrinkles, such as strokes or lines of the face."
    )
    wrinkle_where: Mask = _where("wrinkle", "wrinkles")
    wrinkle_direction: str | None = _field(
        None, "wrinkle", "Direction field that they grow along; smoothest without it."
    )
    wrinkle_vectors: str | None = _field(
        None,
        "wrinkle",
        "Field of vectors that says where to and how long they grow, before direction and length; none grows where it is 0.",
    )
    wrinkle_length: LengthRange = _field((8.0, 22.0), "wrinkle", "Length of a wrinkle.")
    wrinkle_width: LengthRange = _field(
        (0.3, 0.8), "wrinkle", "From its middle to its rim, where it is widest."
    )
    wrinkle_depth: LengthRange = _field((0.05, 0.2), "wrinkle", "Depth of a wrinkle.")
    wrinkle_fold: Share = _field(0.25, "wrinkle", "Rise of its one side, as a share of the depth.")
    wrinkle_fade: float = _field(
        1.0, "wrinkle", "How its depth follows its width to its ends: 0 stays, 1 in proportion.", ge=0, le=4
    )
    wrinkle_profile: Profile = _field("valley", "wrinkle", "Shape of a wrinkle, from its floor to its rim.")

    relief_spacing: PositiveLength = _field(0.85, "relief", "Between primary furrows.")
    relief_depth: Length = _field(0.045, "relief", "Of primary furrows.")
    relief_width: Length = _field(0.11, "relief", "From the middle of a primary furrow to its rim.")
    relief_secondary: Length = _field(0.02, "relief", "Depth of the secondary furrows that part its fields.")
    relief_swell: Length = _field(0.012, "relief", "Rise of a field from its border to its middle.")
    relief_tension: Share = _field(0.55, "relief", "How much deeper furrows along the lines of tension are.")
    relief_direction: str | None = _field(
        None, "relief", "Direction field of the lines of tension; where it bends least without it."
    )
    relief_where: Mask = _where("relief", "furrows")

    sebum: Share = _field(0.25, "sebum", "Oil on the skin: it fills and polishes.")
    sebum_where: Mask = _field(1.0, "sebum", "Where it is oily, such as 'forehead + nose'.")
    sebum_polish: Share = _field(0.4, "sebum", "Share of the roughness that oil takes off.")

    order: tuple[str, ...] = _field(
        ("scar", "cyst", "goose", "pock", "mole", "freckle", "pore", "follicle"),
        "blend",
        "Kinds of points from the first to the last: the later see what the earlier left.",
        validate_default=True,
    )

    @field_validator("up")
    @classmethod
    def _some_way(cls, value: tuple[float, float, float]) -> tuple[float, float, float]:
        if not 0 < float(np.linalg.norm(value)) < np.inf:
            raise ValueError(f"{list(value)} is no direction; write three numbers such as [0, 1, 0]")
        return value

    @staticmethod
    def preset(name: str, **changes: Any) -> "Skin":
        """Take a skin from the shelf.

        Parameters
        ----------
        name : str
            See `Skin.presets`.
        **changes : Any
            Parameters to set otherwise.

        Returns
        -------
        skin : Skin
            With all parameters written out.

        Raises
        ------
        RecipeError
            If there is no such preset; the message names the nearest.

        Examples
        --------
        >>> Skin.preset("thesis", cyst_count=10).freckle_count
        3000
        """
        from surftex.materials.presets import preset

        return preset(Skin, name, changes)

    @staticmethod
    def presets() -> dict[str, str]:
        """List the shelf.

        Returns
        -------
        presets : dict of str to str
            What each preset looks like, by name.
        """
        from surftex.materials.presets import captions

        return captions("skin")

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels that its patterns answer with."""
        from surftex.materials.skin.pattern import CHANNELS

        return CHANNELS

    def wavelengths_mm(self) -> dict[str, float]:
        """Tell how large features are.

        Returns
        -------
        wavelengths : dict of str to float
            Of each kind that there is, mm.
        """
        sizes = {"furrows": self.relief_spacing} if self.relief_depth > 0 or self.relief_swell > 0 else {}
        for kind in self.order:
            if kind == "freckle":
                continue  # colour alone
            if getattr(self, f"{kind}_count") or getattr(self, f"{kind}_density"):
                radius = self.follicle_radius if kind == "follicle" else getattr(self, f"{kind}_radius")[0]
                sizes[f"{kind}s" if kind != "goose" else "goose bumps"] = 2 * radius
        if self.wrinkle_count or self.wrinkle_density:
            sizes["wrinkles"] = 2 * self.wrinkle_width[1]
        if self.vessel_count or self.vessel_density:
            sizes["vessels"] = 2 * self.vessel_width
        return sizes

    def placing(self) -> dict[str, Any]:
        """Tell what decides where its features lie; two that tell the same have the same.

        Returns
        -------
        placing : dict of str to Any
            Parameters by name.
        """
        from surftex.materials.skin.pattern import KEPT

        return {key: getattr(self, key) for key in Skin.model_fields if key not in KEPT}

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
        from surftex.materials.skin.placing import expected_features

        return expected_features(self, surface, fields or FieldSet(surface))

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
    ) -> "SkinPattern":
        """Place every feature on a surface.

        Parameters
        ----------
        surface : Surface
            Where the skin lies.
        seed : int
            Same seed, surface and parameters: same features, whatever the unwrap or resolution.
        fields : FieldSet, optional
            The recipe's named fields, for masks and directions.
        features : mapping of str to structured array, optional
            Take these, from an earlier `SkinPattern.features`, and place nothing anew.
        max_features : int
            Refuse beyond it.
        threads : int, optional
            None means every core; cannot change the result.
        tick : callable, optional
            Told the finished share; may raise to cancel.

        Returns
        -------
        pattern : SkinPattern
            Answers at any sample.

        Raises
        ------
        RecipeError
            If the surface would hold more than `max_features`, or an expression does not fit.
        """
        from surftex.fields.fieldset import FieldSet
        from surftex.materials.skin.pattern import SkinPattern
        from surftex.materials.skin.placing import place

        names = fields or FieldSet(surface)
        if features is None:
            features = place(
                self, surface, seed, fields=names, max_features=max_features, threads=threads, tick=tick
            )
        return SkinPattern.build(self, surface, seed, features, names, threads)
