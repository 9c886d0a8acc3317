"""`Recipe`: everything that decides a bake, as a user writes it in TOML."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    Field,
    PrivateAttr,
    StrictBool,
    StrictInt,
    StrictStr,
    ValidationError,
    field_validator,
    model_validator,
)

from surftex.errors import RecipeError
from surftex.materials.checked import Checked
from surftex.recipe.fields import FieldEntry, PositiveMillimetres
from surftex.recipe.layer import Layer
from surftex.recipe.lines import Places
from surftex.words import sort_of

MAPS = (
    "base_color", "roughness", "metallic", "specular", "subsurface", "subsurface_radius_mm", "normal", "height",
    "ambient_occlusion", "region", "pheomelanin", "blood", "melanin", "oxygenation", "stratum_corneum_mm", "epidermis_mm",
    "hair", "sebum",
)  # fmt: skip
"""Maps that can be asked for."""


MOST_LAYERS = 64
NO_LAYER = "a recipe needs at least one [[layer]] with a material or a preset"
"""What is wrong with a recipe that says nothing."""


class MeshSettings(Checked):
    """Which mesh, and how large it is."""

    path: StrictStr | None = Field(
        default=None, description="Relative to the recipe's folder, which it may not leave."
    )
    units: Literal["mm", "cm", "m", "in"] | None = Field(
        default=None,
        description="Unit of the file's coordinates; without it metres for glTF, else what comments name or a plausible guess.",
    )
    size: PositiveMillimetres | None = Field(
        default=None,
        description='Length that the longest side is scaled to, such as "300 mm"; a bare number is mm. It overrules `units`. '
        "With `part` it is the longest side of the whole file.",
    )
    part: StrictStr | None = Field(
        default=None, description="A material slot, a face group or a node of the file."
    )
    crease: Annotated[float, Field(ge=0, le=180, allow_inf_nan=False)] | None = Field(
        default=None,
        description="Degrees: edges that bend by more are hard, others smooth; without it the file's normals, or smooth ones.",
    )


def _map_list(value: Any) -> Any:
    return [name.strip() for name in value.split(",") if name.strip()] if isinstance(value, str) else value


class BakeSettings(Checked):
    """How the pages come out."""

    resolution: Annotated[StrictInt, Field(ge=16, le=32768)] = Field(
        default=2048, description="Side of the maps in texels."
    )
    maps: Annotated[tuple[StrictStr, ...], BeforeValidator(_map_list)] | None = Field(
        default=None, description="What the materials make, if not given."
    )
    gutter: Annotated[StrictInt, Field(ge=0, le=256)] | None = Field(
        default=None, description="Free texels around each chart; chosen by the resolution if not given."
    )
    unwrapper: Literal["auto", "xatlas", "uvunwrap"] = Field(
        default="auto", description="Who unwraps: xatlas small meshes, uvunwrap large ones."
    )
    uv: Literal["auto", "keep", "unwrap"] = Field(
        default="auto",
        description="The file's own UVs: `auto` keeps them where they pass the gate, `keep` insists, `unwrap` makes new ones.",
    )
    equalise: StrictBool = Field(
        default=False, description="Even out what is left of seams by least squares."
    )
    udim: StrictBool = Field(
        default=False,
        description="Pages of several tiles: those of the file's own UVs, or as many as `texels_per_mm` takes.",
    )
    texels_per_mm: Annotated[float, Field(gt=0, le=1e4)] | None = Field(
        default=None, description="Density of a new unwrap over several tiles; one tile if not given."
    )
    displaced: StrictBool = Field(default=False, description="Write the displaced mesh as well.")
    displaced_format: Literal["glb", "obj", "ply", "stl"] = Field(
        default="glb", description="Of the displaced mesh: GLB in metres, the others in millimetres."
    )
    displaced_edge: PositiveMillimetres | None = Field(
        default=None, description="Longest edge of the displaced mesh; two texels if not given."
    )
    materialx: StrictBool = Field(default=False, description="Write the material as MaterialX as well.")
    usd: StrictBool = Field(
        default=False, description="Write mesh and material as USD as well; it takes the extra `usd`."
    )
    usd_format: Literal["usda", "usdc", "usdz"] = Field(
        default="usda", description="Text, binary, or one file with the pictures inside."
    )
    max_features: Annotated[StrictInt, Field(ge=1)] = Field(
        default=5_000_000, description="A bake that would place more is refused, with the count."
    )

    @property
    def exchange(self) -> dict[str, Any]:
        """What is wanted beside maps and GLB, as `surftex.maps.exchange` takes it."""
        return {"materialx": self.materialx, "usd": self.usd_format if self.usd else None}

    @model_validator(mode="after")
    def _fits_tiles(self) -> "BakeSettings":
        if self.texels_per_mm is not None and not self.udim:
            raise ValueError("texels_per_mm spreads an unwrap over tiles; it takes udim = true (--udim)")
        if self.texels_per_mm is not None and self.uv == "keep":
            raise ValueError("texels_per_mm is the density of a new unwrap; leave it out where uv is keep")
        if self.udim and self.equalise:
            raise ValueError("equalise works on one page; leave it out where udim is true")
        if self.udim and self.usd and self.usd_format == "usdz":
            raise ValueError("a .usdz holds one page; take usda or usdc where udim is true")
        return self

    @field_validator("maps")
    @classmethod
    def _known_maps(cls, names: tuple[str, ...] | None) -> tuple[str, ...] | None:
        from surftex.materials.hints import nearest

        for name in names or ():
            if name not in MAPS:
                raise ValueError(f"unknown map {name!r}{nearest(name, MAPS)}")
        if names is not None and len(names) == 0:
            raise ValueError(f"no maps to bake; known are {', '.join(MAPS)}")
        return None if names is None else tuple(dict.fromkeys(names))


class Recipe(Checked):
    """A mesh, materials in layers, the fields that they use, and how to bake.

    Layers lie over one another in their order: each covers what lies below by its mask.
    """

    surftex: Literal[1] = Field(default=1, description="Version of the format.")
    seed: StrictInt = Field(default=0, description="Of everything random.")
    mesh: MeshSettings = MeshSettings()
    bake: BakeSettings = BakeSettings()
    fields_: dict[str, FieldEntry] = Field(default_factory=dict, alias="fields")
    layer: tuple[Layer, ...]
    _where: Places = PrivateAttr(default_factory=Places)

    @classmethod
    def mistakes(cls, problem: ValidationError, values: Mapping[str, Any]) -> str:
        """Tell what is wrong with a recipe that was made in Python, as of one that was read."""
        from surftex.recipe.mistakes import told_mistakes

        return told_mistakes(problem, dict(values))

    def located(self, where: Places) -> "Recipe":
        """Remember where each key was written, for mistakes that only the mesh brings to light.

        Parameters
        ----------
        where : Places
            Of its keys.

        Returns
        -------
        recipe : Recipe
            Itself.
        """
        self._where = where
        return self

    @property
    def places(self) -> Places:
        """Where its keys were written."""
        return self._where

    def where(self, *path: str | int) -> str:
        """Say where a key was written.

        Parameters
        ----------
        *path : str or int
            Of the key, such as ``"fields", "toe"``.

        Returns
        -------
        text : str
            For the start of a message; empty where nobody knows.
        """
        return self._where(path)

    @field_validator("layer")
    @classmethod
    def _some_layer(cls, layers: tuple[Layer, ...]) -> tuple[Layer, ...]:
        if not layers:
            raise ValueError(NO_LAYER)
        if len(layers) > MOST_LAYERS:
            raise ValueError(f"{len(layers)} layers; a recipe holds at most {MOST_LAYERS}")
        return layers

    @staticmethod
    def load(path: str | Path, *, allow_outside: bool = False, changes: tuple[str, ...] = ()) -> "Recipe":
        """Read a recipe from a TOML file.

        Parameters
        ----------
        path : path
            Of the file.
        allow_outside : bool
            Whether the files it names may lie outside its folder.
        changes : tuple of str
            ``key=value`` lines, as of the command's ``--set``.

        Returns
        -------
        recipe : Recipe
            With the paths it names made absolute.

        Raises
        ------
        RecipeError
            With file, line, key and a hint, in one line.
        """
        from surftex.recipe.read import load_recipe

        return load_recipe(path, allow_outside=allow_outside, changes=changes)

    @staticmethod
    def of(material: "BaseModel | Recipe", **settings: Any) -> "Recipe":
        """Wrap a material that covers everything.

        Parameters
        ----------
        material : Leather or Recipe
            A recipe is handed back, with the settings.
        **settings : Any
            Keys of `BakeSettings`, and ``seed``; None leaves what is there.

        Returns
        -------
        recipe : Recipe
            With one layer, if a material was given.

        Raises
        ------
        RecipeError
            If it is neither, or a setting is wrong.
        """
        from surftex.recipe.mistakes import checked_recipe

        given = {key: value for key, value in settings.items() if value is not None}
        if isinstance(material, Recipe):
            values: dict[str, Any] = material.written_keys()
            where = material._where
        elif isinstance(material, BaseModel) and hasattr(material, "place"):
            values, where = {"layer": (Layer(material=material),)}, Places()
        else:
            mend = "take a Leather, a Recipe, or the name of a preset"
            if isinstance(material, type) and hasattr(material, "place"):
                mend = f"make one of it, such as {material.__name__}()"
            raise RecipeError(f"{sort_of(material)} is no material; {mend}")
        if "seed" in given:
            values["seed"] = given.pop("seed")
        if given:
            bake = values.get("bake", BakeSettings())
            values["bake"] = {**bake.model_dump(), **given}
        return checked_recipe(values).located(where)

    def written_keys(self) -> dict[str, Any]:
        """Take the recipe apart by its keys, to validate it anew with changes.

        Returns
        -------
        values : dict of str to Any
            Without the seed where nobody has said one, so that this is known afterwards too.
        """
        values = {"fields" if key == "fields_" else key: value for key, value in self}
        if "seed" not in self.model_fields_set:
            del values["seed"]
        return values

    def written_out(self) -> dict[str, Any]:
        """Write the recipe out with every default, as reports do.

        Returns
        -------
        recipe : dict
            JSON types; lengths in millimetres.
        """
        return {
            "surftex": self.surftex,
            "seed": self.seed,
            "mesh": self.mesh.model_dump(mode="json"),
            "bake": self.bake.model_dump(mode="json"),
            "fields": {
                name: entry.model_dump(mode="json") if isinstance(entry, BaseModel) else entry
                for name, entry in self.fields_.items()
            },
            "layer": [layer.table() for layer in self.layer],
        }
