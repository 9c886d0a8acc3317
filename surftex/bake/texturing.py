"""Textures from file to file: learn a model from pictures, draw pictures from a model, and say how alike they are."""

import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.exemplar.learn import learn_texture
from surftex.exemplar.metrics import metrics
from surftex.exemplar.model import TextureModel
from surftex.exemplar.store import SUFFIXES, load_model
from surftex.files.exemplars import read_exemplar
from surftex.files.images import png_bytes
from surftex.files.output import write_whole
from surftex.files.reading import printable
from surftex.kernels.pool import Tick

ALIGNED = ("mask", "height", "roughness")
"""Pictures that may lie beside the one to learn from."""


def learn_file(
    image: str | Path,
    out: str | Path,
    *,
    shrink: int = 1,
    aligned: dict[str, str | Path | None] | None = None,
    tick: Tick | None = None,
    **options: Any,
) -> dict[str, Any]:
    """Learn a model from a picture on disk and write it.

    Parameters
    ----------
    image : path
        PNG or JPEG.
    out : path
        ``.stex`` or ``.json``; replaced if there.
    shrink : int
        Pixels of each side that become one, by their mean.
    aligned : dict of str to path, optional
        Files of `ALIGNED`.
    tick : callable, optional
        Told the finished share; may raise to cancel.
    **options : Any
        As for `surftex.learn_texture`.

    Returns
    -------
    report : dict
        What was learnt, and what it took.

    Raises
    ------
    InputError
        If a picture or an option is wrong; the message names the file.
    WorkError
        If the model cannot be written.
    """
    target = _model_place(out)
    if not 1 <= shrink <= 64:
        raise InputError(f"shrink is {shrink}; it takes 1 to 64")
    wall, processor = time.perf_counter(), time.process_time()
    picture = _shrunk(read_exemplar(image), shrink)
    beside = {
        name: _shrunk(_grey(read_exemplar(file)), shrink)
        for name, file in (aligned or {}).items()
        if file is not None
    }
    try:
        model = learn_texture(picture, tick=tick, **beside, **options)
    except InputError as problem:
        raise InputError(f"{printable(str(image))}: {problem}") from None
    model.save(target)
    return {
        "model": str(target),
        "bytes": model.nbytes,
        "exemplar": [picture.shape[1], picture.shape[0]],
        **described(model),
        "wall_s": round(time.perf_counter() - wall, 3),
        "cpu_s": round(time.process_time() - processor, 3),
    }


def synthesize_file(
    path: str | Path,
    out: str | Path,
    *,
    size: tuple[int, int] = (512, 512),
    seed: int = 0,
    sweeps: int | None = None,
    compare: str | Path | None = None,
    threads: int | None = None,
    tick: Tick | None = None,
) -> dict[str, Any]:
    """Draw a picture from a model on disk and write it, with its maps beside it.

    Parameters
    ----------
    path : path
        Of the model.
    out : path
        A ``.png``; replaced if there. Maps are called ``<out>_height.png`` and so on.
    size : (int, int)
        Width and height.
    seed : int
        Same seed, same bytes.
    sweeps : int, optional
        As for `TextureModel.synthesize`.
    compare : path, optional
        A picture to measure the result against.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share; may raise to cancel.

    Returns
    -------
    report : dict
        Files, what it took, and the metrics where there is something to compare with.

    Raises
    ------
    InputError
        If a file or an option is wrong.
    WorkError
        If a picture cannot be written.
    """
    target = picture_place(out)
    reference = None if compare is None else read_exemplar(compare)
    model = load_model(path)
    wall, processor = time.perf_counter(), time.process_time()
    maps = model.maps(*size, seed, sweeps=sweeps, threads=threads, tick=tick)
    wall, processor = time.perf_counter() - wall, time.process_time() - processor
    report = {
        "model": str(path),
        "size": list(size),
        "seed": seed,
        "files": write_maps(target, maps),
        "wall_s": round(wall, 3),
        "cpu_s": round(processor, 3),
        "cpu_s_per_megapixel": round(1e6 * processor / (size[0] * size[1]), 2),
    }
    if reference is not None:
        scale = 257 if reference.dtype == np.uint16 else 1
        report["metrics"] = metrics(maps["picture"], reference // scale)
    return report


def write_maps(target: Path, maps: dict[str, NDArray[np.uint8]]) -> list[str]:
    """Write a picture and the maps beside it.

    Parameters
    ----------
    target : Path
        Of the picture.
    maps : dict of str to uint8 array
        ``picture`` and others.

    Returns
    -------
    files : list of str
        What was written.
    """
    files = []
    for name, pixels in maps.items():
        place = target if name == "picture" else target.with_name(f"{target.stem}_{name}{target.suffix}")
        write_whole(place, png_bytes(pixels))
        files.append(str(place))
    return files


def picture_place(out: str | Path) -> Path:
    """Refuse, before any work, a name that no picture can have.

    Parameters
    ----------
    out : path
        Where a picture shall appear.

    Returns
    -------
    place : Path
        As given.

    Raises
    ------
    InputError
        If it is no ``.png`` in a folder that is there.
    """
    return _place(out, (".png",), "a picture is written as .png")


def described(model: TextureModel) -> dict[str, Any]:
    """Count what a model holds.

    Parameters
    ----------
    model : TextureModel
        Any.

    Returns
    -------
    counts : dict
        ``bands``, ``pairs``, ``quads``.
    """
    return {
        "bands": list(model.bands.names),
        "pairs": len(model.target.pair_type),
        "quads": len(model.target.quad_band),
    }


def _model_place(out: str | Path) -> Path:
    return _place(out, SUFFIXES, f"a model is written as {' or '.join(SUFFIXES)}")


def _place(out: str | Path, suffixes: tuple[str, ...], what: str) -> Path:
    target = Path(out)
    shown = printable(str(out))
    if target.suffix.lower() not in suffixes:
        raise InputError(f"{shown}: {what}")
    if target.is_dir():
        raise InputError(f"{shown} is a folder; name a file")
    if not target.absolute().parent.is_dir():
        raise InputError(f"{shown}: there is no folder {printable(str(target.parent))}; make it first")
    return target


def _grey(picture: NDArray[Any]) -> NDArray[Any]:
    return picture if picture.ndim == 2 else picture[..., 0]


def _shrunk(picture: NDArray[Any], by: int) -> NDArray[Any]:
    """Mean of each square of pixels; what is left over at the right and below is cut off."""
    if by == 1:
        return picture
    rows, columns = (length // by for length in picture.shape[:2])
    cut = picture[: rows * by, : columns * by].reshape(rows, by, columns, by, -1)
    mean = cut.mean(axis=(1, 3)).round().astype(picture.dtype)
    return mean if picture.ndim == 3 else mean[..., 0]
