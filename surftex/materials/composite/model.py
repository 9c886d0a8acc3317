"""`Composite`: what can be said about a texture that was learnt from a picture. Lengths are millimetres."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from surftex.materials.checked import Checked
from surftex.materials.parameters import Length, NumberField, PositiveLength, Share
from surftex.surface.surface import Surface

if TYPE_CHECKING:
    from surftex.materials.composite.pattern import CompositePattern
    from surftex.materials.limits import Expected


def _field(default: Any, group: str, text: str, **limits: Any) -> Any:
    return Field(default, description=text, json_schema_extra={"group": group}, **limits)


class Composite(Checked):
    """A texture learnt from a photograph, drawn anew on the surface, across its seams.

    The model (``surftex learn``) holds statistics of pairs and fours of pixels; no pixel of the photograph is copied. The
    surface gets pixels of its own, as large everywhere, and each is drawn by its neighbours on the surface.
    After Zalesny, Auf der Maur and Van Gool, Composite Textures (2001); fours, surfaces and maps beside colour go beyond it.
    """

    files: ClassVar[tuple[str, ...]] = ("model",)
    """Parameters that name files."""

    kind: Literal["composite"] = "composite"

    model: str = _field(
        ..., "texture", "File of the model, from ``surftex learn``; or the name of one on the shelf."
    )
    pixel_size: PositiveLength = _field(1.0, "texture", "Side of a pixel of the exemplar on the surface.")
    direction: str | None = _field(
        None, "texture", "Direction field that the picture's upright follows; smoothest without it."
    )
    sweeps: int | None = _field(
        None,
        "texture",
        "How often each pixel is drawn; 40 for pairs and 80 for fours without it.",
        ge=1,
        le=1000,
    )

    labels: tuple[str, ...] | None = _field(
        None,
        "labels",
        "For a composite: a mask (expression) for each label, or for all but the first; the greatest counts. Without it "
        "the layout that was learnt is drawn.",
    )
    age: NumberField = _field(
        0.0,
        "labels",
        "Millimetres, or an expression, by which what lies over a composite, such as cracks, has grown; below 0 it is "
        "smaller.",
    )

    relief: Length = _field(
        0.0, "relief", "Rise over the range of the height that was learnt; of the brightness where none was."
    )
    roughness: Share = _field(0.8, "finish", "Where none was learnt.")
    specular: Share = _field(0.5, "finish", "Strength of the reflection; 0.5 is 4 % face on.")

    @staticmethod
    def preset(name: str, **changes: Any) -> "Composite":
        """Take a learnt texture from the shelf.

        Parameters
        ----------
        name : str
            See `Composite.presets`.
        **changes : Any
            Parameters to set otherwise.

        Returns
        -------
        composite : Composite
            With all parameters written out.

        Raises
        ------
        RecipeError
            If there is no such preset; the message names the nearest.

        Examples
        --------
        >>> Composite.preset("gravel", pixel_size="2 mm").pixel_size
        2.0
        """
        from surftex.materials.presets import preset

        return preset(Composite, name, changes)

    @staticmethod
    def presets() -> dict[str, str]:
        """List the shelf.

        Returns
        -------
        presets : dict of str to str
            What each preset looks like, by name.
        """
        from surftex.materials.presets import captions

        return captions("composite")

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels that its patterns answer with."""
        from surftex.exemplar.composite import CompositeModel
        from surftex.materials.composite.drawing import named_model

        height = ("height_mm",) if self.relief > 0 else ()
        region = ("region",) if isinstance(named_model(self.model), CompositeModel) else ()
        return ("base_color", *height, "roughness", "specular", *region)

    def wavelengths_mm(self) -> dict[str, float]:
        """Tell how large features are.

        Returns
        -------
        wavelengths : dict of str to float
            Two pixels, mm, where there is relief.
        """
        return {"pixels": 2.0 * self.pixel_size} if self.relief > 0 else {}

    def placing(self) -> dict[str, Any]:
        """Tell what decides where its features lie; two that tell the same have the same.

        Returns
        -------
        placing : dict of str to Any
            Parameters by name.
        """
        kept = ("relief", "roughness", "specular")
        return {key: getattr(self, key) for key in Composite.model_fields if key not in kept}

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
        from surftex.materials.composite.drawing import expected_features, named_model

        return expected_features(self, named_model(self.model), surface)

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
    ) -> "CompositePattern":
        """Draw the texture on a surface.

        Parameters
        ----------
        surface : Surface
            Where.
        seed : int
            Same seed, surface and parameters: same pixels, whatever the unwrap or resolution.
        fields : FieldSet, optional
            The recipe's named fields, for directions and masks.
        features : mapping of str to structured array, optional
            Take these, from an earlier `CompositePattern.features`, and draw nothing anew.
        max_features : int
            Refuse beyond so many pixels.
        threads : int, optional
            None means every core; cannot change the result.
        tick : callable, optional
            Told the finished share; may raise to cancel.

        Returns
        -------
        pattern : CompositePattern
            Answers at any sample.

        Raises
        ------
        InputError
            If the model cannot be read.
        RecipeError
            If there would be more than `max_features` pixels, or a field does not fit.
        """
        from surftex.materials.composite.drawing import place

        return place(
            self,
            surface,
            seed,
            fields=fields,
            features=features,
            max_features=max_features,
            threads=threads,
            tick=tick,
        )
