"""What a bake need not do twice: the unwrap of a surface, and the placing of features, known by their content."""

import dataclasses
import hashlib
import importlib.metadata
import json
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.charts.atlas import Atlas
from surftex.files import shelf
from surftex.recipe.model import BakeSettings, Recipe
from surftex.recipe.read import recipe_files
from surftex.surface.surface import Surface

_LIBRARIES = ("numpy", "numba", "scipy", "xatlas", "uvunwrap", "potpourri3d", "libigl")


def remembered_unwrap(
    surface: Surface, settings: BakeSettings, work: Callable[[], Atlas], waiting: Callable[[], None]
) -> Atlas:
    """Unwrap, or take the unwrap of an earlier run, or of one that is at it.

    Parameters
    ----------
    surface : Surface
        What to unwrap.
    settings : BakeSettings
        How.
    work : callable
        Unwraps.
    waiting : callable
        Called while another process unwraps the same; may raise to cancel.

    Returns
    -------
    atlas : Atlas
        The same bytes either way. An unwrap that fell back for want of time is not kept.
    """
    how = ["unwrap", settings.unwrapper, settings.resolution, settings.gutter, settings.texels_per_mm]
    key = _key(how, surface)
    atlas = _kept_unwrap(key, surface)
    if atlas is not None:
        return atlas
    with shelf.alone(key, waiting):
        atlas = _kept_unwrap(key, surface)
        if atlas is None:
            atlas = work()
            if not any("took over" in note for note in atlas.notes):
                _keep_unwrap(key, atlas)
    return atlas


def _kept_unwrap(key: str, surface: Surface) -> Atlas | None:
    found = shelf.kept(key)
    if found is None:
        return None
    told = json.loads(found["told"].tobytes())
    return Atlas.of(surface, found["corner_uv"], **{**told, "notes": tuple(told["notes"])})


def _keep_unwrap(key: str, atlas: Atlas) -> None:
    told = {
        "unwrapper": atlas.unwrapper,
        "resolution": atlas.resolution,
        "gutter_px": atlas.gutter_px,
        "notes": atlas.notes,
    }
    shelf.keep(
        key, {"corner_uv": atlas.corner_uv, "told": np.frombuffer(json.dumps(told).encode(), np.uint8)}
    )


def features_key(recipe: Recipe, surface: Surface) -> str:
    """Tell what decides which features are placed.

    Parameters
    ----------
    recipe : Recipe
        Its layers, fields and seed.
    surface : Surface
        Where.

    Returns
    -------
    key : str
        In hexadecimal.
    """
    written = recipe.written_out()
    how = ["features", written["seed"], written["fields"], written["layer"]]
    return _key(how, surface, *(path.read_bytes() for path in recipe_files(recipe) if path.is_file()))


def remembered_features(key: str) -> Mapping[str, NDArray[Any]] | None:
    """Take the features that an earlier run placed.

    Parameters
    ----------
    key : str
        From `features_key`.

    Returns
    -------
    features : mapping of str to structured array, or None
        By kind.
    """
    return shelf.kept(key)


def remember_features(key: str, features: Mapping[str, NDArray[Any]]) -> None:
    """Keep features for later runs.

    Parameters
    ----------
    key : str
        From `features_key`.
    features : mapping of str to structured array
        By kind.
    """
    shelf.keep(key, features)


def _key(how: list[Any], surface: Surface, *more: bytes) -> str:
    digest = hashlib.sha256(json.dumps([_version(), how], sort_keys=True).encode())
    for field in dataclasses.fields(surface):
        digest.update(f"\0{field.name}\0".encode())
        _add(digest, getattr(surface, field.name))
    for data in more:
        digest.update(hashlib.sha256(data).digest())
    return digest.hexdigest()


def _add(digest: Any, value: Any) -> None:
    """Hash arrays by their bytes, mappings by their items, everything else by what it prints as."""
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).data)
    elif isinstance(value, Mapping):
        for name, each in value.items():
            digest.update(f"\0{name}\0".encode())
            _add(digest, each)
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            _add(digest, getattr(value, field.name))
    else:
        digest.update(repr(value).encode())


@cache
def _version() -> str:
    """Hash of the sources of surftex and the versions of what it stands on."""
    root = Path(__file__).resolve().parent.parent
    digest = hashlib.sha256(repr([importlib.metadata.version(name) for name in _LIBRARIES]).encode())
    for source in sorted(root.rglob("*.py")):
        digest.update(str(source.relative_to(root)).encode() + source.read_bytes())
    return digest.hexdigest()
