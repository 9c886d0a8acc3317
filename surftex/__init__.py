"""surftex: texture features placed on a surface by walking distance, baked to seamless maps.

Names are imported when they are first used, so that ``import surftex`` stays fast.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from surftex import optics
    from surftex.bake.bake import bake
    from surftex.bake.loading import load
    from surftex.errors import (
        InputError,
        MeshFileError,
        RecipeError,
        SurfaceError,
        SurftexError,
        WorkError,
    )
    from surftex.exemplar.composite import CompositeModel, learn_composite
    from surftex.exemplar.erosion import erosion_series
    from surftex.exemplar.labels import LabelModel, learn_labels
    from surftex.exemplar.learn import learn_texture
    from surftex.exemplar.mending import fill, knit
    from surftex.exemplar.metrics import metrics
    from surftex.exemplar.model import TextureModel
    from surftex.exemplar.segments import segment
    from surftex.exemplar.store import load_model
    from surftex.files.features import load_features
    from surftex.geodesics.distance import geodesic_distance
    from surftex.maps.mapset import MapSet
    from surftex.materials.cells.model import Cells
    from surftex.materials.composite.model import Composite
    from surftex.materials.leather.model import Leather
    from surftex.materials.skin.model import Skin
    from surftex.recipe.model import Recipe
    from surftex.surface import shapes
    from surftex.surface.points import Samples, SurfacePoints
    from surftex.surface.surface import Surface

__version__ = "0.1.0"

_HOME = {
    "Cells": "surftex.materials.cells.model",
    "Composite": "surftex.materials.composite.model",
    "CompositeModel": "surftex.exemplar.composite",
    "InputError": "surftex.errors",
    "LabelModel": "surftex.exemplar.labels",
    "Leather": "surftex.materials.leather.model",
    "MapSet": "surftex.maps.mapset",
    "MeshFileError": "surftex.errors",
    "Recipe": "surftex.recipe.model",
    "RecipeError": "surftex.errors",
    "Samples": "surftex.surface.points",
    "Skin": "surftex.materials.skin.model",
    "Surface": "surftex.surface.surface",
    "SurfaceError": "surftex.errors",
    "SurfacePoints": "surftex.surface.points",
    "SurftexError": "surftex.errors",
    "TextureModel": "surftex.exemplar.model",
    "WorkError": "surftex.errors",
    "bake": "surftex.bake.bake",
    "erosion_series": "surftex.exemplar.erosion",
    "fill": "surftex.exemplar.mending",
    "geodesic_distance": "surftex.geodesics.distance",
    "knit": "surftex.exemplar.mending",
    "learn_composite": "surftex.exemplar.composite",
    "learn_labels": "surftex.exemplar.labels",
    "learn_texture": "surftex.exemplar.learn",
    "load": "surftex.bake.loading",
    "load_features": "surftex.files.features",
    "load_model": "surftex.exemplar.store",
    "metrics": "surftex.exemplar.metrics",
    "optics": "surftex",
    "segment": "surftex.exemplar.segments",
    "shapes": "surftex.surface",
}
"""The module that each public name lives in."""

_ROOMS = ("optics", "shapes")
"""Those of them that are modules themselves."""

__all__ = [
    "Cells",
    "Composite",
    "CompositeModel",
    "InputError",
    "LabelModel",
    "Leather",
    "MapSet",
    "MeshFileError",
    "Recipe",
    "RecipeError",
    "Samples",
    "Skin",
    "Surface",
    "SurfaceError",
    "SurfacePoints",
    "SurftexError",
    "TextureModel",
    "WorkError",
    "__version__",
    "bake",
    "erosion_series",
    "fill",
    "geodesic_distance",
    "knit",
    "learn_composite",
    "learn_labels",
    "learn_texture",
    "load",
    "load_features",
    "load_model",
    "metrics",
    "optics",
    "segment",
    "shapes",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'surftex' has no attribute {name!r}")
    home = _HOME[name]
    value = import_module(f"{home}.{name}") if name in _ROOMS else getattr(import_module(home), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
