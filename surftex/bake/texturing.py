"""Textures from file to file: learn a model from pictures, draw pictures from a model, and say how alike they are."""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.bake.comparing import read_reference
from surftex.errors import InputError
from surftex.exemplar.composite import CompositeModel, learn_composite
from surftex.exemplar.labels import LabelModel, learn_labels
from surftex.exemplar.learn import learn_texture
from surftex.exemplar.metrics import metrics
from surftex.exemplar.picture import shrunk, spread
from surftex.exemplar.segments import segment
from surftex.exemplar.store import SUFFIXES, Model, load_model
from surftex.files.exemplars import read_exemplar, read_label_map
from surftex.files.images import png_bytes
from surftex.files.output import check_place, write_whole
from surftex.files.reading import printable
from surftex.kernels.pool import Tick

ALIGNED = ("mask", "height", "roughness")
"""Pictures that may lie beside the one to learn from."""


def learn_file(
    image: str | Path,
    out: str | Path,
    *,
    shrink: int = 1,
    aligned: Mapping[str, str | Path | None] | None = None,
    labels: str | Path | None = None,
    within: Mapping[int, str | Path] | None = None,
    over: bool = False,
    as_labels: bool = False,
    segments: int | None = None,
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
    aligned : mapping of str to path, optional
        Files of `ALIGNED`.
    labels : path, optional
        A label map: learn a composite of several textures.
    within : mapping of int to path, optional
        Label maps that part labels.
    over : bool
        Whether the last label lies over the others.
    as_labels : bool
        The picture itself is a label map: learn a layout.
    segments : int, optional
        Part the picture into so many labels by itself, and learn a composite.
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
    if (labels is not None) + (segments is not None) + as_labels > 1:
        raise InputError(
            "a label map, segments, and a picture that is a label map exclude one another; choose one"
        )
    beside = {name: file for name, file in (aligned or {}).items() if file is not None}
    composite = labels is not None or segments is not None
    asked = {*beside, *options} | ({"over"} if over else set()) | ({"within"} if within else set())
    _check_asked(asked, as_labels=as_labels, composite=composite)
    _check_shrink(shrink)
    wall, processor = time.perf_counter(), time.process_time()
    maps: dict[str, Any] = {name: shrunk(_grey(read_exemplar(file)), shrink) for name, file in beside.items()}
    if as_labels:
        maps["picture"] = read_label_map(image)[::shrink, ::shrink]
    else:
        maps["picture"] = shrunk(read_exemplar(image), shrink)
    if labels is not None:
        maps["labels"] = read_label_map(labels)[::shrink, ::shrink]
    if composite:
        parts = {label: read_label_map(file)[::shrink, ::shrink] for label, file in (within or {}).items()}
        options["within"] = parts
    picture = maps.pop("picture")
    try:
        if segments is not None:
            maps["labels"] = segment(picture, segments)
        if as_labels:
            mask = maps.get("mask")
            model: Model = learn_labels(picture, mask=None if mask is None else mask > 0.5 * mask.max())
        elif "labels" in maps:
            model = learn_composite(picture, over=over, tick=tick, **maps, **options)
        else:
            model = learn_texture(picture, tick=tick, **maps, **options)
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
    size: tuple[int, int] | None = None,
    seed: int = 0,
    sweeps: int | None = None,
    compare: str | Path | None = None,
    shrink: int = 1,
    labels: str | Path | None = None,
    age: int = 0,
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
    size : (int, int), optional
        Width and height; 512 x 512, or those of the label map, without it.
    seed : int
        Same seed, same bytes.
    sweeps : int, optional
        As for `TextureModel.synthesize`.
    compare : path, optional
        A picture to measure the result against, as grey; a label map for a layout.
    shrink : int
        Pixels of each side of that picture that become one first, as when the model was learnt.
    labels : path, optional
        A layout for a composite: a label map; the picture gets its size.
    age : int
        Steps by which what lies over a composite, such as cracks, has grown.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share; may raise to cancel.

    Returns
    -------
    report : dict
        Files, what it took, warnings, and the metrics where there is something to compare with.

    Raises
    ------
    InputError
        If a file or an option is wrong.
    WorkError
        If a picture cannot be written.
    """
    target = picture_place(out)
    _check_shrink(shrink)
    if compare is None and shrink > 1:
        raise InputError(f"shrink is {shrink}, of a picture to compare with; name that as well (--compare)")
    model, layout = load_model(path), None if labels is None else read_label_map(labels)
    width, height = size or ((512, 512) if layout is None else (layout.shape[1], layout.shape[0]))
    reference, warnings = None, []
    if compare is not None:
        reference, warnings = read_reference(compare, model, (width, height), shrink)
    wall, processor = time.perf_counter(), time.process_time()
    maps = drawn_maps(
        model, width, height, seed, labels=layout, age=age, sweeps=sweeps, threads=threads, tick=tick
    )
    wall, processor = time.perf_counter() - wall, time.process_time() - processor
    report = {
        "model": str(path),
        "size": [width, height],
        "seed": seed,
        "files": write_maps(target, maps),
        "wall_s": round(wall, 3),
        "cpu_s": round(processor, 3),
        "cpu_s_per_megapixel": round(1e6 * processor / (width * height), 2),
        "warnings": warnings,
    }
    if reference is not None:
        report["metrics"] = metrics(maps["picture"], reference)
    return report


def drawn_maps(
    model: Model,
    width: int,
    height: int,
    seed: int,
    *,
    labels: NDArray[np.uint8] | None = None,
    age: int = 0,
    sweeps: int | None = None,
    threads: int | None = None,
    tick: Tick | None = None,
) -> dict[str, NDArray[np.uint8]]:
    """Draw whatever a model holds.

    Parameters
    ----------
    model : TextureModel, CompositeModel or LabelModel
        What to draw.
    width : int
        Columns.
    height : int
        Rows.
    seed : int
        Same seed, same bytes.
    labels : (height, width) uint8, optional
        For a composite.
    age : int
        For a composite.
    sweeps : int, optional
        As for `TextureModel.synthesize`.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    maps : dict of str to uint8 arrays
        ``picture`` and what lies beside it; labels are spread over 0 to 255, so that they can be seen.

    Raises
    ------
    InputError
        If a layout or an age is given for what has none.
    """
    if not isinstance(model, CompositeModel) and (labels is not None or age):
        raise InputError("the model is no composite; it takes neither a label map nor an age")
    if isinstance(model, LabelModel):
        if sweeps is not None:
            raise InputError("the model is a layout, which is drawn at several scales; it takes no sweeps")
        label = model.synthesize(width, height, seed, threads=threads, tick=tick)
        return {"picture": spread(label, model.labels)}
    if isinstance(model, CompositeModel):
        maps = model.maps(
            width, height, seed, labels=labels, age=age, sweeps=sweeps, threads=threads, tick=tick
        )
        return {**maps, "labels": spread(maps["labels"], model.labels)}
    return model.maps(width, height, seed, sweeps=sweeps, threads=threads, tick=tick)


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
        If it is no ``.png`` in a folder that is there and can be written to.
    """
    return _place(out, (".png",), "a picture is written as .png")


def described(model: Model) -> dict[str, Any]:
    """Count what a model holds.

    Parameters
    ----------
    model : TextureModel, CompositeModel or LabelModel
        Any.

    Returns
    -------
    counts : dict
        ``pairs``, ``quads``, and ``bands`` or ``labels``.
    """
    if isinstance(model, LabelModel):
        target = model.targets[-1]
        counts: dict[str, Any] = {"labels": model.labels, "scales": len(model.targets)}
    else:
        target = model.target
        counts = {"bands": list(model.bands.names)}
        counts |= {"labels": model.labels} if isinstance(model, CompositeModel) else {}
    return {**counts, "pairs": len(target.pair_type), "quads": len(target.quad_band)}


def _check_asked(asked: set[str], *, as_labels: bool, composite: bool) -> None:
    """Refuse what would have no effect on the kind of model that is learnt."""
    if as_labels:
        idle, why = asked - {"mask", "seed", "threads"}, "a layout alone (--as-labels)"
    elif composite:
        idle, why = asked & {"mask"}, "a composite, which is learnt from the whole picture"
    else:
        idle, why = asked & {"over", "within"}, "one texture; labels come from --labels or --segment"
    if idle:
        named = " and ".join(f"--{name}" for name in sorted(idle))
        raise InputError(f"{named}: no use for {why}; leave {'it' if len(idle) == 1 else 'them'} out")


def _check_shrink(shrink: int) -> None:
    if not 1 <= shrink <= 64:
        raise InputError(f"shrink is {shrink}; it takes 1 to 64")


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
    check_place(target)
    return target


def _grey(picture: NDArray[Any]) -> NDArray[Any]:
    return picture if picture.ndim == 2 else picture[..., 0]
