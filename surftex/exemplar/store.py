"""Model files: a JSON head that describes arrays, and their bytes; nothing in them is ever executed.

``.stex`` is the head and the bytes, deflated; ``.json`` holds the bytes as text. Histograms are kept as roots in
8 bits, scaled by the largest entry of each row: small shares matter, large ones need no more.
"""

import base64
import json
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.exemplar.bands import Bands
from surftex.exemplar.composite import CompositeModel, Layout
from surftex.exemplar.labels import MOST_LABELS, LabelModel
from surftex.exemplar.model import TextureModel
from surftex.exemplar.target import Target, quarters

VERSION = 1
"""Of the format."""

LARGEST_FILE, LARGEST_CONTENT = 16 * 2**20, 64 * 2**20
"""Bytes of a file, and of what it may unfold to."""

SUFFIXES = (".stex", ".json")
"""Ends of the names of model files."""

_MAGIC = b"STEX\x01"
_MOST_CLIQUES = 4096
_BYTES = {"int8": 1, "uint8": 1}

Model = TextureModel | LabelModel | CompositeModel


def save_model(model: Model, path: str | Path) -> None:
    """Write a model.

    Parameters
    ----------
    model : TextureModel
        What to write.
    path : path
        Ends in ``.stex`` or ``.json``.

    Raises
    ------
    InputError
        If it ends otherwise.
    WorkError
        If the file cannot be written.
    """
    from surftex.files.output import write_whole

    file = Path(path)
    if file.suffix.lower() not in SUFFIXES:
        raise InputError(f"{file.name}: a model is written as .stex or .json")
    write_whole(file, packed(model) if file.suffix.lower() == ".stex" else as_json(model).encode())


def load_model(path: str | Path) -> Model:
    """Read a model.

    Parameters
    ----------
    path : path
        What `save_model` wrote.

    Returns
    -------
    model : TextureModel
        Checked as far as numbers can be.

    Raises
    ------
    InputError
        If there is no such file, or it holds no model.
    """
    from surftex.files.reading import printable, read_bytes

    return unpacked(read_bytes(path, purpose="texture model"), printable(str(path)))


def packed(model: Model) -> bytes:
    """Pack a model.

    Parameters
    ----------
    model : TextureModel
        What to pack.

    Returns
    -------
    data : bytes
        Of a ``.stex`` file. The same model gives the same bytes.
    """
    head, body = _split(_written(model))
    text = json.dumps(head, separators=(",", ":")).encode()
    return _MAGIC + zlib.compress(len(text).to_bytes(4, "little") + text + body, 9)


def as_json(model: Model) -> str:
    """Write a model as text.

    Parameters
    ----------
    model : TextureModel
        What to write.

    Returns
    -------
    text : str
        One JSON object.
    """
    head, body = _split(_written(model))
    return json.dumps({**head, "data": base64.b64encode(zlib.compress(body, 9)).decode()}, indent=1)


def unpacked(data: bytes, name: str = "the model") -> Model:
    """Take a model out of the bytes of a file.

    Parameters
    ----------
    data : bytes
        From ``.stex`` or ``.json``.
    name : str
        What messages call it.

    Returns
    -------
    model : TextureModel
        Checked.

    Raises
    ------
    InputError
        If they hold no model, one of another version, or one that is absurdly large.
    """
    if len(data) > LARGEST_FILE:
        raise InputError(f"{name}: holds {len(data)} bytes; a texture model has at most {LARGEST_FILE}")
    try:
        if data.startswith(_MAGIC[:4]):
            if data[4:5] != _MAGIC[4:]:
                raise InputError(f"{name}: is of format {data[4]}; this surftex reads format {VERSION}")
            content = _inflated(data[len(_MAGIC) :])
            length = int.from_bytes(content[:4], "little")
            head, body = json.loads(content[4 : 4 + length]), content[4 + length :]
        elif data.lstrip()[:1] == b"{":
            head = json.loads(data)
            body = _inflated(base64.b64decode(head.pop("data"), validate=True))
        else:
            raise InputError(f"{name}: is no texture model; surftex learn writes one")
        if head.get("surftex_texture") != VERSION:
            raise InputError(
                f"{name}: is of format {head.get('surftex_texture')!r}; this surftex reads {VERSION}"
            )
        return _read(_joined(head, body))
    except InputError:
        raise
    except (
        ValueError,
        KeyError,
        TypeError,
        IndexError,
        AttributeError,
        OverflowError,
        zlib.error,
        RecursionError,
    ) as problem:
        reason = str(problem).splitlines()[0] if str(problem) else type(problem).__name__
        raise InputError(f"{name}: is a damaged texture model ({reason}); learn it anew") from None


def _inflated(data: bytes) -> bytes:
    unfold = zlib.decompressobj()
    content = unfold.decompress(data, LARGEST_CONTENT)
    if unfold.unconsumed_tail or not unfold.eof:
        raise ValueError("it is cut off or unfolds to too much")
    return content


def _split(document: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
    """Take the arrays out of a document; in their places stay types and shapes."""
    body = bytearray()

    def without(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            body.extend(np.ascontiguousarray(value).tobytes())
            return {"array": value.dtype.name, "shape": list(value.shape)}
        if isinstance(value, dict):
            return {key: without(each) for key, each in value.items()}
        return [without(each) for each in value] if isinstance(value, (list, tuple)) else value

    return {"surftex_texture": VERSION, **without(document)}, bytes(body)


def _joined(head: Any, body: bytes) -> Any:
    """Put the arrays back, in the order in which they were taken out."""
    at = 0

    def with_arrays(value: Any) -> Any:
        nonlocal at
        if isinstance(value, dict) and "array" in value:
            shape = [int(length) for length in value["shape"]]
            if any(length < 0 for length in shape) or len(shape) > 4:
                raise ValueError(f"an array of shape {shape}")
            size = _BYTES[value["array"]]
            for length in shape:
                size *= length
            if size > len(body) - at:
                raise ValueError("an array is cut off")
            at += size
            return np.frombuffer(body, value["array"], size, at - size).reshape(shape).copy()
        if isinstance(value, dict):
            return {key: with_arrays(each) for key, each in value.items()}
        return [with_arrays(each) for each in value] if isinstance(value, list) else value

    return with_arrays(head)


def _written(model: Model) -> dict[str, Any]:
    if isinstance(model, LabelModel):
        return {"kind": "labels", "targets": [_target_written(each) for each in model.targets]}
    if isinstance(model, CompositeModel):
        return {
            "kind": "composite",
            "bands": _bands_written(model.bands),
            "target": _target_written(model.target),
            "layout": _layout_written(model.layout),
            "over": None if model.over is None else [_target_written(each) for each in model.over.targets],
        }
    return {"kind": "texture", "bands": _bands_written(model.bands), "target": _target_written(model.target)}


def _read(document: dict[str, Any]) -> Model:
    kinds: dict[str, Callable[[dict[str, Any]], Model]] = {
        "texture": _texture_read,
        "labels": _labels_read,
        "composite": _composite_read,
    }
    if document["kind"] not in kinds:
        raise ValueError(f"it is a {document['kind']!r}")
    return kinds[document["kind"]](document)


def _texture_read(document: dict[str, Any]) -> TextureModel:
    bands, target = _bands_read(document["bands"]), _target_read(document["target"])
    if target.joint or target.groups != 1 or len(bands.curve) != 1 or len(bands.names) != target.bands:
        raise ValueError("bands that do not fit")
    return TextureModel(bands, target)


def _labels_read(document: dict[str, Any]) -> LabelModel:
    targets = tuple(_target_read(each) for each in document["targets"])
    sound = 1 <= len(targets) <= 8 and all(
        each.joint and each.levels == targets[0].levels for each in targets
    )
    if not sound or any((each.groups, each.bands) != (1, 1) for each in targets):
        raise ValueError("labels that do not fit one another")
    return LabelModel(targets)


def _layout_written(layout: Layout) -> dict[str, Any]:
    return {
        "targets": [_target_written(each) for each in layout.model.targets],
        "parts": [None if part is None else _layout_written(part) for part in layout.parts],
    }


def _composite_read(document: dict[str, Any]) -> CompositeModel:
    bands, target = _bands_read(document["bands"]), _target_read(document["target"])
    layout = _layout_read(document["layout"])
    over = None if document["over"] is None else _labels_read({"targets": document["over"]})
    labels = layout.leaves + (over is not None)
    fitting = len(bands.names) == target.bands and len(bands.curve) in (1, labels)
    if target.joint or labels != target.groups or not fitting:
        raise ValueError("textures and layout that do not fit")
    return CompositeModel(bands, target, layout, over)


def _layout_read(document: dict[str, Any], depth: int = 0) -> Layout:
    model = _labels_read(document)
    if depth >= MOST_LABELS or len(document["parts"]) != model.labels:
        raise ValueError("labels that are not parted as they should be")
    parts = (None if part is None else _layout_read(part, depth + 1) for part in document["parts"])
    return Layout(model, tuple(parts))


def _bands_written(bands: Bands) -> dict[str, Any]:
    axes = [] if not bands.colored else [round(float(each), 6) for each in bands.axes.ravel()]
    step = round(float(np.abs(bands.curve).max()) / 127, 6)
    curve = np.rint(bands.curve[:, 1:] / max(step, 1e-6)).clip(-127, 127).astype(np.int8)
    return {
        "names": list(bands.names),
        "low": [round(float(each), 3) for each in bands.low],
        "high": [round(float(each), 3) for each in bands.high],
        "axes": axes,
        "levels": bands.levels,
        "curve": curve,
        "step": step,
    }


def _bands_read(written: dict[str, Any]) -> Bands:
    names = tuple(str(name) for name in written["names"])
    colored = names[:3] == ("red", "green", "blue")
    rest = names[3:] if colored else names[1:]
    if not (colored or names[0] in ("grey", "label")) or not set(rest) <= {"height", "roughness"}:
        raise ValueError(f"bands called {names}")
    low, high = (np.array(written[key], np.float64) for key in ("low", "high"))
    axes = np.array(written["axes"], np.float64).reshape(3, 3) if colored else np.eye(3)
    levels = int(written["levels"])
    curve = np.zeros((1, len(names), levels))
    if "curve" in written:
        curve = np.pad(float(written["step"]) * written["curve"], ((0, 0), (1, 0), (0, 0)))
    sound = low.shape == high.shape == (len(names),) and (high > low).all() and 2 <= levels <= 32
    sound = sound and curve.shape[1:] == (len(names), levels) and 1 <= len(curve) <= MOST_LABELS
    if not sound or not all(np.isfinite(each).all() for each in (low, high, axes, curve)):
        raise ValueError("ranges of bands that do not fit")
    return Bands(names, low, high, axes, levels, curve)


def _target_written(target: Target) -> dict[str, Any]:
    pair_bins = 64 if target.joint else 63
    return {
        "levels": target.levels,
        "joint": target.joint,
        "single": _roots(target.single),
        "pair_type": target.pair_type.astype(np.int8),
        "pair": _roots(target.pair[target.pair_used][:, :pair_bins]),
        "pair_used": np.packbits(target.pair_used, axis=1),
        "quad_band": target.quad_band.astype(np.uint8),
        "quad_shape": target.quad_shape.astype(np.int8),
        "quad": _roots(target.quad[target.quad_used]),
        "quad_used": np.packbits(target.quad_used, axis=1),
    }


def _target_read(written: dict[str, Any]) -> Target:
    single = _shares(written["single"])
    groups, bands, levels = single.shape
    joint = bool(written["joint"])
    pair_type, quad_band, quad_shape = (
        written[key].astype(np.int32) for key in ("pair_type", "quad_band", "quad_shape")
    )
    kinds, fours = len(pair_type), len(quad_band)
    if not (1 <= groups <= 8 and 1 <= bands <= 5 and (1 if joint else 2) <= levels <= (8 if joint else 32)):
        raise ValueError(f"{groups} groups of {bands} bands with {levels} levels")
    if max(kinds, fours) > _MOST_CLIQUES or levels != written["levels"]:
        raise ValueError(f"{kinds} pairs and {fours} quads")
    pair_used = np.unpackbits(written["pair_used"], axis=1, count=kinds).astype(bool)
    quad_used = np.unpackbits(written["quad_used"], axis=1, count=fours).astype(bool)
    pair, quad = np.zeros((groups + 1, kinds, 64), np.float32), np.zeros((groups, fours, 256), np.float32)
    pair[pair_used] = np.pad(_shares(written["pair"]), ((0, 0), (0, 0 if joint else 1)))
    quad[quad_used] = _shares(written["quad"])
    sound = pair_type.shape == (kinds, 4) and quad_shape.shape == (fours, 4, 2)
    if (
        not sound
        or (pair_type[:, :2] < 0).any()
        or max(pair_type[:, :2].max(initial=0), quad_band.max(initial=0)) >= bands
    ):
        raise ValueError("cliques of bands that are not there")
    quarter = np.stack([quarters(each, joint=joint) for each in single])
    return Target(
        levels, joint, single, pair_type, pair, quad_band, quad_shape, quad, quarter, pair_used, quad_used
    )


def _roots(share: NDArray[np.floating]) -> NDArray[np.uint8]:
    largest = np.maximum(share.max(axis=-1, keepdims=True, initial=0.0), 1e-12)
    return np.rint(255 * np.sqrt(share / largest)).astype(np.uint8)


def _shares(root: NDArray[np.uint8]) -> NDArray[np.float32]:
    square = root.astype(np.float64) ** 2
    return (square / np.maximum(square.sum(axis=-1, keepdims=True), 1e-12)).astype(np.float32)
