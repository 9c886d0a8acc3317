"""`surftex analyse`: spectrum, ring, statistics and a cross-section of a height map, as PNG and JSON."""

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.preview.section import Section, flat_section
from surftex.preview.sheet import contact_sheet, written
from surftex.preview.spectrum import Ring, Spectrum, fitted_ring, height_spectrum, statistics

_SIDE = 480

_BEYOND = 4.0
"""How many times longer than the coarsest feature a wavelength is that cannot be the features'."""


def analyse_file(
    path: str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
    section: Sequence[float] | None = None,
    mm_per_texel: float | None = None,
) -> dict[str, Any]:
    """Analyse a height map, and write what was found.

    Parameters
    ----------
    path : path
        Of an EXR of one channel, millimetres.
    out : path, optional
        Stem of the PNG and the JSON, whose folder is made where it is missing; beside the map, ending in ``_analysis``,
        without it.
    section : (4,) float, optional
        Column and row of the start, then of the end, in texels.
    mm_per_texel : float, optional
        Without it, from the `report.json` beside the map: the mean over all charts. Without a report, 1.

    Returns
    -------
    result : dict
        Plain JSON: ``mm_per_texel``, ``size``, ``coverage`` (the share of the map that charts cover, None without a
        report), ``statistics``, ``ring``, ``section``, ``files``, ``warnings``.

    Notes
    -----
    Every texel counts, those in gaps between charts too, which repeat what the nearest chart has. A map of a plane, or of
    a tile, has no gaps.
    """
    source = Path(path)
    files = _places(source, out)
    height = _height(source)
    warnings = []
    reported, coverage = _reported(source.parent / "report.json", height.shape)
    if mm_per_texel is None:
        mm_per_texel = reported
        if mm_per_texel is None:
            mm_per_texel = 1.0
            warnings.append("the size of a texel is not known: lengths along the map are in texels")
        else:
            warnings.append("the size of a texel is the mean over the charts of the bake")
    if section is not None and len(section) != 4:
        raise InputError(f"section is {list(section)}; it takes x0,y0,x1,y1 in texels")
    spectrum = height_spectrum(height, mm_per_texel)
    ring = fitted_ring(spectrum)
    kind, wide_mm = _coarsest(source.parent / "report.json")
    strange = ring.radius > 0 and ring.spacing_mm > _BEYOND * wide_mm
    if strange:
        warnings.append(
            f"what stands out most is {ring.spacing_mm:.4g} mm long, far beyond the {kind} of {wide_mm:.4g} mm: outlines of "
            "charts, a mask or a field; on a larger page, or on a plane, the features may show"
        )
    cut = None if section is None else flat_section(height, section[:2], section[2:], mm_per_texel)
    result = {
        "source": source.name,
        "size": [height.shape[1], height.shape[0]],
        "mm_per_texel": float(mm_per_texel),
        "coverage": coverage,
        "statistics": statistics(height),
        "ring": {
            "cycles_per_mm": ring.radius,
            "axis_ratio": ring.ratio,
            "long_axis_deg": ring.angle_deg,
            "spacing_mm": ring.spacing_mm if np.isfinite(ring.spacing_mm) and not strange else None,
        },
        "section": None
        if cut is None
        else {"along_mm": cut.along_mm.tolist(), "height_mm": cut.height_mm.tolist()},
        "warnings": warnings,
    }
    _write(files, drawn(height, spectrum, ring, cut, section), result)
    return {**result, "files": files}


def drawn(
    height_mm: NDArray[np.floating],
    spectrum: Spectrum,
    ring: Ring,
    cut: Section | None = None,
    section: Sequence[float] | None = None,
) -> NDArray[np.uint8]:
    """Draw an analysis.

    Parameters
    ----------
    height_mm : (h, w) float
        The map.
    spectrum : Spectrum
        Its spectrum; 60 dB are shown.
    ring : Ring
        Its ring.
    cut : Section, optional
        A cross-section.
    section : (4,) float, optional
        Where it runs.

    Returns
    -------
    picture : (height, width, 3) uint8
        Map, spectrum with the ring, and section side by side.
    """
    low, high = np.percentile(height_mm, (0.5, 99.5))
    grey = np.clip((height_mm - low) / max(high - low, 1e-12), 0, 1)
    share, rows, columns = _fitted(grey)
    picture = np.repeat((255 * share).astype(np.uint8)[..., None], 3, axis=2)
    if section is not None:
        x0, y0, x1, y1 = section
        t = np.linspace(0, 1, 2 * _SIDE)
        r = np.clip((y0 + (y1 - y0) * t) / height_mm.shape[0] * rows, 0, rows - 1).astype(int)
        c = np.clip((x0 + (x1 - x0) * t) / height_mm.shape[1] * columns, 0, columns - 1).astype(int)
        picture[r, c] = (230, 60, 40)
    panels, labels = [picture], [f"HEIGHT {low:.4g} TO {high:.4g} MM"]
    panels.append(_spectrum_panel(spectrum, ring))
    labels.append(f"60 DB; RING {ring.radius:.3g}/MM, RATIO {ring.ratio:.3g} AT {ring.angle_deg:.0f} DEG")
    if cut is not None:
        panels.append(_section_panel(cut))
        labels.append(
            f"{cut.along_mm[-1]:.4g} MM LONG; {cut.height_mm.min():.4g} TO {cut.height_mm.max():.4g} MM"
        )
    return contact_sheet(panels, labels, columns=len(panels))


def _fitted(image: NDArray[np.floating]) -> tuple[NDArray[np.floating], int, int]:
    """Resize so that the longer side fills a panel, averaging what is finer."""
    step = max(1, max(image.shape) // _SIDE)
    trimmed = image[: image.shape[0] // step * step, : image.shape[1] // step * step]
    small = trimmed.reshape(trimmed.shape[0] // step, step, -1, step).mean(axis=(1, 3))
    scale = _SIDE / max(small.shape)
    rows, columns = (max(1, round(length * scale)) for length in small.shape)
    at_row, at_column = (
        np.minimum((np.arange(count) + 0.5) * length / count, length - 1).astype(int)
        for count, length in zip((rows, columns), small.shape, strict=True)
    )
    return small[at_row][:, at_column], rows, columns


def _spectrum_panel(spectrum: Spectrum, ring: Ring) -> NDArray[np.uint8]:
    """Decibels around the ring, with the ellipse dotted over them."""
    reach = min(spectrum.across[-1], spectrum.along[-1])
    reach = min(reach, 3.2 * ring.radius * np.sqrt(ring.ratio)) if ring.radius > 0 else reach
    place = (np.arange(_SIDE) + 0.5) / _SIDE * 2 - 1
    fx, fy = np.meshgrid(place * reach, -place * reach)
    c = np.clip(
        np.rint((fx - spectrum.across[0]) / (spectrum.across[1] - spectrum.across[0])),
        0,
        len(spectrum.across) - 1,
    )
    r = np.clip(
        np.rint((fy - spectrum.along[0]) / (spectrum.along[1] - spectrum.along[0])),
        0,
        len(spectrum.along) - 1,
    )
    share = np.clip(1 + spectrum.decibels[r.astype(int), c.astype(int)] / 60, 0, 1)[..., None]
    stops = np.array([[12, 10, 30], [70, 30, 110], [190, 60, 80], [250, 160, 60], [255, 250, 200]], float)
    at = share[..., 0] * (len(stops) - 1)
    panel = np.stack([np.interp(at, np.arange(len(stops)), stops[:, k]) for k in range(3)], axis=2).astype(
        np.uint8
    )
    if ring.radius > 0:
        turn = np.linspace(0, 2 * np.pi, 72, endpoint=False)
        long, short = ring.radius * np.sqrt(ring.ratio), ring.radius / np.sqrt(ring.ratio)
        spin = np.radians(ring.angle_deg)
        x = long * np.cos(turn) * np.cos(spin) - short * np.sin(turn) * np.sin(spin)
        y = long * np.cos(turn) * np.sin(spin) + short * np.sin(turn) * np.cos(spin)
        column = ((x / reach + 1) / 2 * _SIDE).astype(int)
        row = ((1 - y / reach) / 2 * _SIDE).astype(int)
        for down, right in ((0, 0), (0, 1), (1, 0), (1, 1)):
            r, c = row + down, column + right
            inside = (c >= 0) & (c < _SIDE) & (r >= 0) & (r < _SIDE)
            panel[r[inside], c[inside]] = (20, 100, 255)
    return panel


def _section_panel(cut: Section) -> NDArray[np.uint8]:
    """Draw the relief as a line, with zero and the extremes marked."""
    panel = np.full((_SIDE, _SIDE, 3), 250, np.uint8)
    low, high = min(float(cut.height_mm.min()), 0.0), max(float(cut.height_mm.max()), 0.0)
    pad = 0.08 * max(high - low, 1e-9)
    low, high = low - pad, high + pad

    def row(values: NDArray[np.float64]) -> NDArray[np.int64]:
        return np.clip((high - values) / (high - low) * (_SIDE - 1), 0, _SIDE - 1).astype(int)

    panel[int(row(np.zeros(1))[0])] = (190, 190, 190)
    fine = np.linspace(0, cut.along_mm[-1], _SIDE * 4)
    rows = row(np.interp(fine, cut.along_mm, cut.height_mm))
    columns = np.arange(_SIDE * 4) // 4
    for first, last, column in zip(rows[:-1], rows[1:], columns[1:], strict=True):
        panel[min(first, last) : max(first, last) + 2, column] = (30, 60, 140)
    for value, at in ((cut.height_mm.max(), 4), (cut.height_mm.min(), _SIDE - 16)):
        ink = written(f"{value:.4g}", 2)
        panel[at : at + ink.shape[0], 4 : 4 + ink.shape[1]][ink] = 90
    return panel


def _height(path: Path) -> NDArray[np.float64]:
    """Read the one channel of an EXR."""
    from surftex.files.images import read_exr

    if path.suffix.lower() != ".exr" and path.is_file():
        raise InputError(
            f"{path}: is no EXR; analyse takes the height that a bake writes, such as shoe_height.exr"
        )
    channels = read_exr(path)
    flat = {name: values for name, values in channels.items() if values.ndim == 2}
    if len(flat) != 1:
        raise InputError(f"{path}: holds {', '.join(channels)}; a height map has one channel")
    height = next(iter(flat.values())).astype(np.float64)
    wrong = int((~np.isfinite(height)).sum())
    if wrong:
        raise InputError(f"{path}: holds {wrong} values that are not finite")
    return height


def _reported(path: Path, shape: tuple[int, ...]) -> tuple[float | None, float | None]:
    """Mean size of a texel and the share that charts cover, by the report of the bake."""
    try:
        report = json.loads(path.read_text("utf-8"))
        if report["resolution"] != shape[1]:
            return None, None
        coverage = float(report["coverage"])
        size = float(report["mesh"]["area_mm2"]) / (coverage * shape[0] * shape[1])
    except (OSError, ValueError, KeyError, TypeError, ZeroDivisionError):
        return None, None
    return (float(np.sqrt(size)), coverage) if 0 < size < np.inf and 0 < coverage <= 1 else (None, None)


def _coarsest(path: Path) -> tuple[str, float]:
    """Kind and size of the coarsest features that the report of the bake tells; inf where it tells of no cells."""
    try:
        sizes = json.loads(path.read_text("utf-8"))["scales"]["features_mm"]
        kind = max(sizes, key=sizes.__getitem__)
        return kind, float(sizes[kind]) if "cells" in sizes else np.inf
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return "features", np.inf


def _places(source: Path, out: str | os.PathLike[str] | None) -> list[str]:
    """Name both files, and check before any work that they can be written."""
    from surftex.files.output import check_room

    stem = Path(out) if out is not None else source.with_name(f"{source.stem}_analysis")
    stem = stem.with_suffix("") if stem.suffix.lower() in (".png", ".json") else stem
    check_room(stem.parent)
    files = [str(stem) + suffix for suffix in (".png", ".json")]
    for name in files:
        if Path(name).is_dir():
            raise InputError(f"{name} is a folder; name another stem with --out")
    return files


def _write(files: list[str], picture: NDArray[np.uint8], result: dict[str, Any]) -> None:
    """Write both files, each whole."""
    from surftex.files.images import png_bytes
    from surftex.files.output import write_whole

    text = json.dumps(result, indent=1) + "\n"
    for name, data in zip(files, (png_bytes(picture), text.encode("utf-8")), strict=True):
        write_whole(name, data, parents=True)
