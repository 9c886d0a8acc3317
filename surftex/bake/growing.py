"""A growth that is kept: gone on from where it was, written when it is done or cut off, and seen on its way."""

import hashlib
import io
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.bake.stack import layer_cover
from surftex.bake.stages import Stages, StageTick
from surftex.errors import InputError
from surftex.fields.fieldset import FieldSet
from surftex.files.features import load_features, save_features
from surftex.files.output import check_place, write_whole
from surftex.recipe.model import Recipe
from surftex.surface.surface import Surface

GROWS = ("cells",)
"""Materials that grow."""

MOST_FRAMES = 2000
"""As many as a growth may have generations."""

_KIND = "growth"
_PARTICLE = "particle"
_GROUPS = ("growth", "field")
_MORE_KEYS = ("kind", "cell_size", "cell_ratio", "direction")
_FREE_KEYS = ("generations",)
_CREASE_KEYS = (
    "stress",
    "wrinkle_count",
    "wrinkle_density",
    "wrinkle_length",
    "wrinkle_angle",
    "wrinkle_potential",
)
"""Of wrinkles that drive the growth."""


class Growth:
    """The growth of a bake.

    Parameters
    ----------
    path : path, optional
        File to go on from where it is there, and to be written; kept nowhere without it.
    frames : int
        How many states to remember on the way, the last of which is the end.

    Raises
    ------
    InputError
        If the file could not be written, or there are not 0 to `MOST_FRAMES` frames.
    """

    def __init__(self, path: str | Path | None = None, frames: int = 0) -> None:
        self.path = None if path is None else Path(path)
        if not 0 <= frames <= MOST_FRAMES:
            raise InputError(
                f"frames is {frames}; it takes 0 to {MOST_FRAMES}, one for each generation at the most"
            )
        if self.path is not None and (self.path.is_dir() or not self.path.absolute().parent.is_dir()):
            raise InputError(f"{self.path}: the growth needs the name of a file in a folder that is there")
        if self.path is not None:
            check_place(self.path)
        self.frames = frames
        self.seen: list[tuple[int, Mapping[str, NDArray]]] = []
        self.generation = 0
        self._told: dict[str, Any] = {}
        self._latest: Callable[[], Mapping[str, NDArray]] | None = None
        self._done: dict[str, NDArray] = {}

    def begun(self, recipe: Recipe, ground: str) -> Mapping[str, NDArray] | None:
        """Read what has grown before.

        Parameters
        ----------
        recipe : Recipe
            What grows now.
        ground : str
            What tells the ground, such as the hash of a mesh.

        Returns
        -------
        begun : mapping of str to structured array, or None
            For `surftex.bake.stack.place_stack`.

        Raises
        ------
        InputError
            If no layer grows, or the file holds no growth, or one of something else.
        """
        if not any(layer.kind in GROWS for layer in recipe.layer):
            raise InputError(f"no layer grows; growth and frames are of the material {', '.join(GROWS)}")
        told = {"ground": ground, "seed": recipe.seed, **_grown_by(recipe)}
        self._told = json.loads(json.dumps(told))
        if self.path is None or not self.path.exists():
            return None
        try:
            features = load_features(self.path)
        except InputError as problem:
            raise InputError(
                f"{problem}; a growth is written by --growth: name another file, or delete this one to begin anew"
            ) from None
        if _KIND not in features or "told" not in (features[_KIND].dtype.names or ()):
            raise InputError(
                f"{self.path}: holds features of a bake, but no growth that could go on; --features takes those"
            )
        try:
            told = json.loads(features[_KIND]["told"].tobytes())
        except ValueError:
            raise InputError(f"{self.path}: its growth cannot be read; delete it to begin anew") from None
        other = sorted(key for key in {*told, *self._told} if told.get(key) != self._told.get(key))
        if other:
            raise InputError(
                f"{self.path}: {_differing(other)}; name another file, or delete this one to begin anew"
            )
        self._done = {kind: table for kind, table in features.items() if kind != _KIND}
        return self._done

    @property
    def states(self) -> list[tuple[int, Mapping[str, NDArray]]]:
        """States of the lowest layer that grows, as generation and particles, by that layer's own names."""
        kinds = [next(iter(features)) for _, features in self.seen]
        return [
            (generation, {_PARTICLE: features[kinds[0]]})
            for (generation, features), kind in zip(self.seen, kinds, strict=True)
            if kind == kinds[0]
        ]

    @contextmanager
    def kept(self, stages: Stages, name: str) -> Iterator[StageTick]:
        """Lend the tick of the stage in which it grows; however the block ends, the file is written.

        Parameters
        ----------
        stages : Stages
            Of the bake.
        name : str
            Of the stage.

        Yields
        ------
        tick : StageTick
            That is offered what has grown.

        Raises
        ------
        KeyboardInterrupt
            Where that ended the block; it says how to go on.
        """
        try:
            yield _GrowthTick(stages, name, self)
        except KeyboardInterrupt:
            if not self.write():
                raise
            raise KeyboardInterrupt(
                f"interrupted in generation {self.generation}; the same command goes on from {self.path}"
            ) from None
        except BaseException:
            self.write()
            raise
        self.write()

    def offered(self, generation: int, last: int, make: Callable[[], Mapping[str, NDArray]]) -> None:
        """Take note of a generation.

        Parameters
        ----------
        generation : int
            How many have passed.
        last : int
            At which it ends.
        make : callable
            Gives the particles.
        """
        self.generation, self._latest = generation, make
        wanted = {-(-last * number // self.frames) for number in range(1, self.frames + 1)}
        if generation in wanted:
            self.seen.append((generation, make()))
        if generation == last:
            self._done.update(make())
            self._latest = None

    def write(self) -> bool:
        """Write the file, if there is one, with what has grown so far.

        Returns
        -------
        written : bool
            Whether there was anything to write.

        Raises
        ------
        WorkError
            If the disk does not take it.
        """
        if self.path is None:
            return False
        grown = dict(self._done)
        if self._latest is not None:
            grown.update(self._latest())
        if not grown:
            return False
        text = json.dumps(self._told, sort_keys=True).encode()
        row = np.zeros(1, [("face", "i4"), ("barycentric", "f8", 3), ("told", "u1", (len(text),))])
        row["barycentric"][0, 0], row["told"][0] = 1, np.frombuffer(text, np.uint8)
        memory = io.BytesIO()
        save_features(memory, {**grown, _KIND: row})
        write_whole(self.path, memory.getvalue())
        return True


def _differing(keys: list[str]) -> str:
    """Say in what a saved growth differs from the one that was asked for."""
    found = (
        ["grew on another mesh, on other bodies of it, or on a tile of another side"]
        if "ground" in keys
        else []
    )
    if settings := [key for key in keys if key != "ground"]:
        found.append(f"grew with other values of {', '.join(settings)}")
    return " and ".join(found)


def grown_on(recipe: Recipe, surface: Surface, fields: FieldSet) -> tuple[NDArray[np.bool_], ...]:
    """Tell on which bodies each layer grows.

    Parameters
    ----------
    recipe : Recipe
        The layers.
    surface : Surface
        With c components.
    fields : FieldSet
        The recipe's fields on it.

    Returns
    -------
    covered : tuple of (c,) bool
        Of the layers that grow.
    """
    return tuple(
        layer_cover(recipe, i, surface, fields) for i, layer in enumerate(recipe.layer) if layer.kind in GROWS
    )


def ground_key(surface: Surface, covered: Sequence[NDArray[np.bool_]] = ()) -> str:
    """Tell surfaces apart on which the same particles would not fit.

    Parameters
    ----------
    surface : Surface
        Where something grows.
    covered : sequence of (c,) bool
        On which of its components; all of them without it.

    Returns
    -------
    key : str
        In hexadecimal.
    """
    digest = hashlib.sha256(np.ascontiguousarray(surface.vertices).data)
    digest.update(np.ascontiguousarray(surface.faces).data)
    if not all(bodies.all() for bodies in covered):
        digest.update(np.concatenate(covered).tobytes())
    return digest.hexdigest()


class _GrowthTick(StageTick):
    def __init__(self, stages: Stages, name: str, growth: Growth) -> None:
        super().__init__(stages, name)
        self.growth = growth

    def keep(self, generation: int, last: int, make: Callable[[], Mapping[str, NDArray]]) -> None:
        """Hand on what has grown."""
        self.growth.offered(generation, last, make)


def _grown_by(recipe: Recipe) -> dict[str, Any]:
    """Parameters that decide the particles; more generations of the same growth are no other growth."""
    written = recipe.written_out()
    found: dict[str, Any] = {"fields": written["fields"]}
    for number, layer in enumerate(recipe.layer):
        if layer.kind not in GROWS:
            continue
        prefix = "" if len(recipe.layer) == 1 else f"layer[{number + 1}]."
        values = layer.material.model_dump(mode="json")
        for key, info in type(layer.material).model_fields.items():
            extra = info.json_schema_extra
            group = extra.get("group") if isinstance(extra, dict) else None
            driven = key in _CREASE_KEYS and getattr(layer.material, "wrinkle_potential", 0) > 0
            if (group in _GROUPS or key in _MORE_KEYS or driven) and key not in _FREE_KEYS:
                found[f"{prefix}{key}"] = values[key]
    return found
