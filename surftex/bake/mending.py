"""Pictures mended from file to file: filled, knitted, eroded."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from surftex.bake.texturing import drawn_maps, picture_place, write_maps
from surftex.errors import InputError
from surftex.exemplar.composite import CompositeModel
from surftex.exemplar.erosion import check_steps, erosion_series
from surftex.exemplar.labels import LabelModel
from surftex.exemplar.mending import fill, knit
from surftex.exemplar.model import TextureModel
from surftex.exemplar.store import SUFFIXES, load_model
from surftex.files.exemplars import read_exemplar, read_label_map
from surftex.files.images import png_bytes
from surftex.files.output import write_whole
from surftex.files.reading import printable
from surftex.kernels.pool import PartTick, Tick

_OF_DRAWING = {"sweeps", "seed", "threads"}
"""Options of filling that a given model leaves."""


def fill_file(
    image: str | Path,
    mask: str | Path,
    out: str | Path,
    *,
    model: str | Path | None = None,
    tick: Tick | None = None,
    **options: Any,
) -> list[str]:
    """Replace a part of a picture on disk by the texture around it.

    Parameters
    ----------
    image : path
        PNG or JPEG.
    mask : path
        White where the picture shall be replaced.
    out : path
        A ``.png``; replaced if there.
    model : path, optional
        What to draw there.
    tick : callable, optional
        Told the finished share; may raise to cancel.
    **options : Any
        As for `surftex.fill`.

    Returns
    -------
    files : list of str
        What was written.

    Raises
    ------
    InputError
        If a file or an option is wrong.
    WorkError
        If the picture cannot be written.
    """
    target = picture_place(out)
    known = None if model is None else load_model(model)
    if known is not None and not isinstance(known, TextureModel):
        raise InputError(f"{printable(str(model))}: is no plain texture; a part is filled by one")
    if known is not None and options.keys() - _OF_DRAWING:
        idle = " and ".join(f"--{name}" for name in sorted(options.keys() - _OF_DRAWING))
        raise InputError(f"{idle}: of learning, but the model is given; leave one or the other out")
    hole = read_exemplar(mask)
    hole = hole if hole.ndim == 2 else hole.max(axis=2)
    whole = read_exemplar(image)
    try:
        picture = fill(whole, hole, model=known, tick=tick, **options)
    except InputError as problem:
        raise InputError(f"{printable(str(image))}: {problem}") from None
    write_whole(target, png_bytes(picture))
    return [str(target)]


def knit_files(
    images: Sequence[str | Path],
    out: str | Path,
    *,
    side: Literal["right", "below"] = "right",
    tick: Tick | None = None,
    **options: Any,
) -> list[str]:
    """Join pictures on disk, and draw the borders between them anew.

    Parameters
    ----------
    images : sequence of path
        Two or more, in their order.
    out : path
        A ``.png``; replaced if there.
    side : {"right", "below"}
        Where each lies from the one before.
    tick : callable, optional
        Told the finished share; may raise to cancel.
    **options : Any
        As for `surftex.knit`.

    Returns
    -------
    files : list of str
        What was written.

    Raises
    ------
    InputError
        If a file or an option is wrong.
    WorkError
        If the picture cannot be written.
    """
    target = picture_place(out)
    if len(images) < 2:
        raise InputError("knitting takes two pictures or more")
    pictures = [read_exemplar(each) for each in images]
    whole: NDArray[Any] = pictures[0]
    for number, picture in enumerate(pictures[1:]):
        part = PartTick(tick, number / (len(pictures) - 1), (number + 1) / (len(pictures) - 1))
        try:
            whole = knit(whole, picture, side=side, tick=part, **options)
        except InputError as problem:
            raise InputError(f"{printable(str(images[number + 1]))}: {problem}") from None
    write_whole(target, png_bytes(np.asarray(whole)))
    return [str(target)]


def erode_file(
    subject: str | Path,
    out: str | Path,
    *,
    shrink: int = 1,
    grow: int = 3,
    size: tuple[int, int] | None = None,
    seed: int = 0,
    threads: int | None = None,
    tick: Tick | None = None,
) -> list[str]:
    """Write a series of ages: of a mask, of a layout, or of a composite that something lies over.

    Parameters
    ----------
    subject : path
        A mask (white is worn), or a model.
    out : path
        A ``.png``; the files are called ``<out>_0.png`` and so on, from the youngest to the oldest.
    shrink : int
        Steps back.
    grow : int
        Steps on.
    size : (int, int), optional
        Width and height of what is drawn from a model; 512 x 512 without it.
    seed : int
        Of what is drawn from a model.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share; may raise to cancel.

    Returns
    -------
    files : list of str
        What was written.

    Raises
    ------
    InputError
        If a file or an option is wrong, or the model has nothing that grows.
    WorkError
        If a picture cannot be written.
    """
    target = picture_place(out)
    check_steps(shrink, grow)
    width, height = size or (512, 512)
    series: list[dict[str, NDArray[np.uint8]]]
    model = load_model(subject) if Path(subject).suffix.lower() in SUFFIXES else None
    if isinstance(model, CompositeModel):
        if model.over is None:
            raise InputError(
                f"{printable(str(subject))}: no label of this model lies over the others; learn it with one that "
                "does (over)"
            )
        ages = range(-shrink, grow + 1)
        series = [
            drawn_maps(
                model, width, height, seed, age=age, threads=threads,
                tick=PartTick(tick, number / len(ages), (number + 1) / len(ages)),
            )
            for number, age in enumerate(ages)
        ]  # fmt: skip
    else:
        if model is None:
            worn = read_label_map(subject)
        elif isinstance(model, LabelModel):
            worn = model.synthesize(width, height, seed, threads=threads, tick=tick)
        else:
            raise InputError(
                f"{printable(str(subject))}: is one texture; masks, layouts and composites are worn"
            )
        if worn.max() != 1:
            raise InputError(
                f"{printable(str(subject))}: has labels up to number {int(worn.max())}; what is worn is a mask of two, 0 and 1"
            )
        masks = erosion_series(worn, shrink=shrink, grow=grow, wrap=model is not None)
        series = [{"picture": np.where(each, 255, 0).astype(np.uint8)} for each in masks]
    files = []
    for number, maps in enumerate(series):
        files += write_maps(target.with_name(f"{target.stem}_{number}{target.suffix}"), maps)
    return files
